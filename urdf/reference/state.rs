//! States and accelerations in the convention of Pinocchio: the velocities of a moving frame are in its own axes, and quaternions are (x, y, z, w).

use hamiltonian_adjoint::{Control, Mechanics, Scene, System};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;
use urdf::{Options, Robot};

pub type Failure = Box<dyn std::error::Error>;

/// The numbers of a JSON list.
pub fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

/// A compiled robot and the joints of reference values.
pub struct Compared {
    pub system: System,
    /// The coordinates of the joints in the order of the reference values.
    joints: Vec<Vec<usize>>,
    /// The joints of the controls, by their numbers in the order of the reference velocities.
    controls: Vec<(usize, Control)>,
}

impl Compared {
    /// # Errors
    /// A robot that cannot be added, or joints that are not those of the reference values.
    pub fn new(robot: &Robot, options: &Options, reference: &Value) -> Result<Option<Self>, Failure> {
        let mut scene = Scene::new();
        scene.spatial().gravity([0.0, 0.0, -9.81]);
        let added = robot.add_to(&mut scene, options)?;
        let controls = added.drive(&mut scene);
        let names = reference["joints"].as_array().into_iter().flatten().filter_map(|joint| joint[0].as_str());
        let base = |_| added.base.map(|base| [&base.position[..], &base.orientation].concat());
        let of = |name: &str| {
            added.joint(name).map(|joint| joint.coordinates.clone()).or_else(|| base(())).ok_or_else(|| name.to_string())
        };
        let joints: Vec<_> = names.map(of).collect::<Result<_, _>>().map_err(|name| format!("`{name}` does not move"))?;
        let count = added.joints.len() + usize::from(added.base.is_some());
        if count != joints.len() {
            return Err(format!("{count} joints move instead of {}", joints.len()).into());
        }
        if count == 0 {
            return Ok(None);
        }
        let joints: Vec<Vec<usize>> = joints.iter().map(|joint| joint.iter().map(|q| q.index()).collect()).collect();
        let mut first = 0;
        let places: Vec<(usize, usize)> = joints
            .iter()
            .map(|joint| {
                let place = first;
                first += if joint.len() == 7 { 6 } else { joint.len() };
                (joint[0], place)
            })
            .collect();
        let place = |q: usize| places.iter().find(|(known, _)| *known == q).map_or(0, |(_, place)| *place);
        let controls = added.drivable().zip(controls).map(|((_, q), control)| (place(q.index()), control)).collect();
        Ok(Some(Compared { system: scene.compile()?, joints, controls }))
    }

    /// The largest difference to the reference accelerations of one state, relative to the largest of them, and, if the state contains m and r, the largest
    /// residual of m a = r, relative to the sum of the absolute values of its terms.
    ///
    /// # Errors
    /// A state without accelerations.
    pub fn difference(&self, state: &Value) -> Result<(f64, Option<f64>), Failure> {
        let [q, v, tau, a] = ["q", "v", "tau", "a"].map(|name| numbers(&state[name]));
        let (mut own_q, mut own_v) = (vec![0.0; self.system.n()], vec![0.0; self.system.n()]);
        let (mut at_q, mut at_v) = (0, 0);
        for joint in &self.joints {
            let (q, v) = (&q[at_q..], &v[at_v..]);
            let (place, rates) = match joint.len() {
                7 => of_free(q, v),
                3 => of_plane(q, v),
                _ => (vec![q[0]], vec![v[0]]),
            };
            joint.iter().zip(place).for_each(|(i, value)| own_q[*i] = value);
            joint.iter().zip(rates).for_each(|(i, value)| own_v[*i] = value);
            at_q += joint.len();
            at_v += if joint.len() == 7 { 6 } else { joint.len() };
        }
        let mut u = vec![0.0; self.system.k()];
        self.controls.iter().for_each(|(place, control)| u[control.index()] = tau[*place]);
        let (own, _) = Mechanics::new(&self.system, &own_q, &own_v)?.with_controls(&u)?.accelerations()?;
        let (mut found, mut at_v) = (Vec::new(), 0);
        for joint in &self.joints {
            let part: Vec<f64> = joint.iter().map(|i| own[*i]).collect();
            let place: Vec<f64> = joint.iter().map(|i| own_q[*i]).collect();
            found.extend(match joint.len() {
                7 => to_free(&place, &v[at_v..], &part),
                3 => to_plane(&place, &v[at_v..], &part),
                _ => part,
            });
            at_v = found.len();
        }
        let largest = a.iter().fold(0.0f64, |largest, a| largest.max(a.abs()));
        let worst = found.iter().zip(&a).fold(0.0f64, |worst, (own, a)| worst.max((own - a).abs()));
        if found.len() != a.len() || !found.iter().chain(&a).all(|a| a.is_finite()) {
            return Err("accelerations are missing or not finite".into());
        }
        let (m, r) = (state["m"].as_array(), numbers(&state["r"]));
        let residual =
            m.map(|m| m.iter().zip(r).fold(0.0f64, |worst, (row, r)| worst.max(residual(&numbers(row), &found, r))));
        Ok((worst / largest, residual))
    }
}

/// |row a − r|, relative to the sum of the absolute values of its terms.
fn residual(row: &[f64], a: &[f64], r: f64) -> f64 {
    let (sum, size) = row.iter().zip(a).fold((-r, r.abs()), |(sum, size), (m, a)| (sum + m * a, size + (m * a).abs()));
    sum.abs() / size
}

fn vector(of: &[f64]) -> Vector3<f64> {
    Vector3::new(of[0], of[1], of[2])
}

/// ṗ = R v, ė = ½ e ω.
fn of_free(q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let e = Quaternion::new(q[6], q[3], q[4], q[5]);
    let (rate, turning) = (UnitQuaternion::new_unchecked(e) * vector(v), e * Quaternion::from_imag(vector(&v[3..])) * 0.5);
    let place = [&q[..3], &[e.w, e.i, e.j, e.k]].concat();
    (place, [rate.as_slice(), &[turning.w, turning.i, turning.j, turning.k]].concat())
}

/// Rᵀ p̈ − ω × v, and ω̇ = 2 ē ë.
fn to_free(q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let [e, second] = [q, a].map(|of| Quaternion::new(of[3], of[4], of[5], of[6]));
    let turning = (e.conjugate() * second).imag() * 2.0;
    let along = UnitQuaternion::new_unchecked(e).inverse() * vector(a) - vector(&v[3..]).cross(&vector(v));
    [along.as_slice(), turning.as_slice()].concat()
}

fn of_plane(q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (sin, cos) = q[2].sin_cos();
    (q[..3].to_vec(), vec![cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]])
}

fn to_plane(q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let (sin, cos) = q[2].sin_cos();
    vec![cos * a[0] + sin * a[1] + v[2] * v[1], cos * a[1] - sin * a[0] - v[2] * v[0], a[2]]
}
