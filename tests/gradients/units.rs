//! Motions in other units are the same motions: powers of two as factors change no digit.

use crate::common::bench::number;
use hamiltonian_adjoint::planar::{Body, ConstantSpeed, Harmonic};
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Grid, Inputs, KineticEnergy, Report, Scalar, Scene, Settings, Solver, Start, Sum, System,
};
use nalgebra::{DMatrix, DVector, SVector, Vector3};

/// The units of mass and length, in parts of which all numbers are given.
#[derive(Clone, Copy, Debug)]
struct Units {
    mass: f64,
    length: f64,
}

const SI: Units = Units { mass: 1.0, length: 1.0 };
/// About 1e±9 and 1e±3.
const OTHERS: [Units; 5] = [
    Units { mass: 1.0 / (1u64 << 30) as f64, ..SI },
    Units { mass: (1u64 << 30) as f64, ..SI },
    Units { length: 1.0 / 1024.0, ..SI },
    Units { length: 1024.0, ..SI },
    Units { mass: (1u64 << 30) as f64, length: 1.0 / 1024.0 },
];

impl Units {
    /// The unit of moments of inertia, and of torques.
    fn inertia(self) -> f64 {
        self.mass * self.length * self.length
    }

    fn force(self) -> f64 {
        self.mass * self.length
    }

    fn scene(self) -> Scene {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81 * self.length);
        scene
    }

    fn body(self, scene: &mut Scene, name: &str, mass: f64, [x, y, angle]: [f64; 3]) -> Body {
        scene.body(name, mass * self.mass, 0.1 * mass * self.inertia(), [x * self.length, y * self.length, angle])
    }

    fn hinge(self, scene: &mut Scene, name: &str, a: Option<Body>, b: Body, at: [f64; 2]) {
        let [x, y] = at.map(|x| x * self.length);
        let a = a.map_or(scene.at_world(Body::GROUND, x, y), |a| scene.at_world(a, x, y));
        let b = scene.at_world(b, x, y);
        scene.revolute(name, a, b);
    }

    /// Rows of planar bodies in these units, divided by them; `of` is the unit of their first two rows over that of the third.
    fn plain(self, rows: &DMatrix<f64>, unit: f64) -> Vec<f64> {
        let of = |row: usize| if row % 3 == 2 { unit / self.length } else { unit };
        (0..rows.nrows()).flat_map(|row| rows.row(row).iter().map(|x| x / of(row)).collect::<Vec<_>>()).collect()
    }
}

/// Velocities and what a run took, for a motion that succeeds, or the text of the error without its numbers.
type Outcome = Result<(Vec<f64>, [usize; 3], f64), String>;

fn outcome(units: Units, system: &System, inputs: &Inputs, settings: Settings) -> Outcome {
    let mut solver = Solver::new(system, settings);
    let v = solver.simulate(inputs).map(|motion| units.plain(&motion.v, units.length)).map_err(|error| named(&error))?;
    let Report { newton_iterations, factorisations, restarts, worst_pivot, .. } = *solver.report();
    Ok((v, [newton_iterations, factorisations, restarts], worst_pivot))
}

/// The kind of an error and what it names.
fn named(error: &Error) -> String {
    match error {
        Error::Newton { step, equation, .. } => format!("Newton, step {step}: {equation}"),
        Error::LinearEnergy { coordinate, step, .. } => format!("linear energy, step {step}: {coordinate}"),
        Error::UndeterminedReaction { equation, .. } => format!("undetermined: {equation}"),
        Error::ContradictoryConstraints { equations, .. } => format!("contradictory: {}", equations.join(", ")),
        other => format!("{other}"),
    }
}

fn assert_same(run: impl Fn(Units) -> Outcome) -> Outcome {
    let plain = run(SI);
    OTHERS.into_iter().for_each(|units| assert_eq!(run(units), plain, "{units:?}"));
    plain
}

/// The equation that is named is that of which most is left in units of its own.
#[test]
fn a_step_without_a_solution_names_the_same_equation() {
    let run = |units: Units| {
        let mut scene = units.scene();
        let arm = units.body(&mut scene, "arm", 1.0, [0.5, -0.2, 0.3]);
        let tip = units.body(&mut scene, "tip", 0.01, [1.1, 0.4, -0.7]);
        units.hinge(&mut scene, "shoulder", None, arm, [0.0, 0.0]);
        units.hinge(&mut scene, "elbow", Some(arm), tip, [0.9, 0.1]);
        let system = scene.compile().expect("a scene");
        let settings = Settings { max_iterations: 3, max_halvings: 0, ..Settings::default() };
        outcome(units, &system, &Inputs::at_rest(&system, Grid::uniform(20, 1.5)), settings)
    };
    let error = assert_same(run).expect_err("steps are far too long");
    assert!(error.starts_with("Newton"), "{error}");
}

/// T = ½ m (ẋ² + ẏ² + k² φ̇²) + c (φ ẋ + (x/10) φ̇); b = [m, k, c].
struct Gyroscope;
impl KineticEnergy<3, 3> for Gyroscope {
    fn kinetic_energy<S: Scalar>(&self, q: &Vector3<S>, v: &Vector3<S>, b: &Vector3<S>) -> S {
        let quadratic = v[0] * v[0] + v[1] * v[1] + b[1] * b[1] * v[2] * v[2];
        b[0] * quadratic * 0.5 + b[2] * (q[2] * v[0] + q[0] * v[2] * 0.1)
    }
}

#[test]
fn a_projection_with_a_linear_energy_names_the_same_coordinate() {
    let run = |units: Units| {
        let mut scene = units.scene();
        let body = units.body(&mut scene, "body", 1.0, [0.6, 0.0, 0.4]);
        scene.distance("rod", Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0), 0.6 * units.length);
        let constants = [units.mass, 0.3 * units.length, 0.2 * units.force()].map(Into::into);
        scene.kinetic_energy("gyroscope", Gyroscope, body.coordinates, constants);
        let system = scene.compile().expect("a scene");
        let settings = Settings { drift_bound: 0.0, ..Settings::default() };
        outcome(units, &system, &Inputs::at_rest(&system, Grid::uniform(5, 0.02)), settings)
    };
    let error = assert_same(run).expect_err("no projection knows such an energy");
    assert!(error.starts_with("linear energy"), "{error}");
}

/// h = (a λ₀ + λ₁/ℓ)²; b = [a, ℓ, the unit of force].
struct Reactions;
impl Cost<0, 2, 0, 3> for Reactions {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 2, 0>, b: &SVector<S, 3>) -> S {
        ((b[0] * at.lambda[0] + at.lambda[1] / b[1]) / b[2]).powi(2)
    }
}

/// A thousandth of a reaction that is not determined beside one that is.
#[test]
fn a_reaction_that_is_not_determined_is_refused() {
    let run = |units: Units| {
        let mut scene = units.scene();
        let arm = units.body(&mut scene, "arm", 1.0, [0.5, -0.2, 0.3]);
        let tip = units.body(&mut scene, "tip", 0.6, [1.1, 0.4, -0.7]);
        let at = |scene: &Scene, body: Body, at: [f64; 2]| scene.at_world(body, at[0] * units.length, at[1] * units.length);
        let [a, b] = [arm, tip].map(|body| at(&scene, body, [0.9, 0.1]));
        let base = at(&scene, arm, [0.0, 0.0]);
        scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), base);
        let [undetermined, _] = scene.revolute("hinge", a, b);
        scene.revolute("again", a, b);
        let [torque] = scene.driven_angle("drive", Body::GROUND, arm, ConstantSpeed, [0.3.into(), 0.0.into()]);
        let constants = [1e-4, units.length, units.force()].map(Into::into);
        scene.cost("reactions", Reactions, Sum::Plain, [], [undetermined, torque], [], constants);
        let system = scene.compile().expect("a scene");
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&Inputs::at_rest(&system, Grid::uniform(5, 0.02))).expect("a motion");
        solver.gradient().map(|gradient| (vec![gradient.value], [0; 3], 0.0)).map_err(|error| named(&error))
    };
    let error = assert_same(run).expect_err("either hinge may carry the load");
    assert!(error.starts_with("undetermined"), "{error}");
}

/// Two sliders with the same speed at the start, and other ones later, beside a wheel that spins.
#[test]
fn constraints_that_come_to_contradict_each_other_are_refused() {
    let run = |units: Units| {
        let mut scene = Scene::new();
        let cart = units.body(&mut scene, "cart", 1.0, [0.0; 3]);
        let wheel = units.body(&mut scene, "wheel", 1.0, [0.0; 3]);
        units.hinge(&mut scene, "axle", None, wheel, [0.0, 0.0]);
        let (origin, point) = (Body::GROUND.at(0.0, 0.0), cart.at(0.0, 0.0));
        scene.prismatic("rail", origin, 0.0, point, 0.0);
        let steady = [0.0.into(), units.length.into()];
        let swinging = [0.0.into(), (10.0 * units.length).into(), 0.1.into(), 0.0.into()];
        scene.driven_slider("steady", (origin, 0.0), point, ConstantSpeed, steady);
        scene.driven_slider("swinging", (origin, 0.0), point, Harmonic, swinging);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
        let v = DVector::from_vec(vec![units.length, 0.0, 0.0, 0.0, 0.0, 1.0]);
        inputs.start = Start::Velocity { q: system.initial_coordinates(), v };
        outcome(units, &system, &inputs, Settings::default())
    };
    let error = assert_same(run).expect_err("one cart has two speeds");
    assert!(error.starts_with("contradictory"), "{error}");
}

/// A rod that swings in steps so long that Φ drifts by a part of its length, and a projection takes many corrections.
#[test]
fn slow_projections_converge() {
    let run = |units: Units| {
        let mut scene = units.scene();
        let body = units.body(&mut scene, "body", 1.0, [0.0; 3]);
        let [a, b] = [[0.9, 0.2], [0.5, -0.4]].map(|at| at.map(|x| x * units.length));
        let length = 0.4f64.hypot(0.6) * units.length;
        scene.distance("rod", Body::GROUND.at(a[0], a[1]), body.at(b[0], b[1]), length);
        let system = scene.compile().expect("a scene");
        let settings = Settings { drift_bound: 0.0, ..Settings::default() };
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
        let p_star = DVector::from_vec(vec![1.0 * units.force(), 1.5 * units.force(), 0.5 * units.inertia()]);
        inputs.start = Start::Momentum { q: system.initial_coordinates(), p_star };
        outcome(units, &system, &inputs, settings)
    };
    assert!(assert_same(run).is_ok());
}

/// Guesses so far off that the way from them decides where they lead to, if anywhere.
#[test]
fn starts_are_assembled_the_same() {
    let run = |units: Units, k: usize| {
        let mut scene = units.scene();
        let [x, y, angle] = [0, 1, 2].map(|i| number(7 * k + i));
        let body = units.body(&mut scene, "body", 1.0, [x, y, 3.0 * angle]);
        let [a, b] = [3, 5].map(|i| body.at(number(7 * k + i) * units.length, number(7 * k + i + 1) * units.length));
        scene.distance("rod", Body::GROUND.at(0.0, 0.0), a, units.length);
        scene.prismatic("slider", Body::GROUND.at(0.3 * units.length, 0.2 * units.length), 0.5, b, 0.7);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.01));
        inputs.start = Start::assembled(&system);
        let settings = Settings { position_tolerance: 1e-9 * units.length.min(1.0), ..Settings::default() };
        let start = Solver::new(&system, settings).assemble(&inputs);
        let place = |q: &DVector<f64>| units.plain(&DMatrix::from_column_slice(3, 1, q.as_slice()), units.length);
        start.map(|inputs| place(inputs.start.q())).map_err(|error| matches!(error, Error::Assembly { .. }))
    };
    let mut assembled = 0;
    for k in 0..60 {
        let plain = run(SI, k);
        assembled += usize::from(plain.is_ok());
        for units in OTHERS {
            let found = run(units, k);
            let is_same = match (&found, &plain) {
                (Ok(found), Ok(plain)) => found.iter().zip(plain).all(|(x, of)| (x - of).abs() < 1e-12),
                _ => found == plain,
            };
            assert!(is_same, "{k}: {units:?}: {found:?} is not {plain:?}");
        }
    }
    assert!(assembled > 30, "{assembled}");
}
