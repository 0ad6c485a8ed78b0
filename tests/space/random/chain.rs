//! The same scenes by chains of transforms, differentiated along curves: q(s) = q + s v + ½ s² v̇.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use num_dual::{Dual2_64, DualNum};

use super::plan::{At, Axes, Closed, FLAT, Kind, Load, Number, Plan, values};

type Turn = [[Dual2_64; 3]; 3];
type Place = [Dual2_64; 3];

/// A frame in the inertial frame.
#[derive(Clone, Copy)]
pub struct Pose {
    turn: Turn,
    origin: Place,
}

fn number(x: f64) -> Dual2_64 {
    Dual2_64::from(x)
}

impl Pose {
    fn ground() -> Self {
        Pose::fixed(&Matrix3::identity(), [0.0; 3])
    }

    fn fixed(turn: &Matrix3<f64>, origin: [f64; 3]) -> Self {
        Pose { turn: std::array::from_fn(|i| std::array::from_fn(|j| number(turn[(i, j)]))), origin: origin.map(number) }
    }

    fn of(turn: Turn) -> Self {
        Pose { turn, origin: [number(0.0); 3] }
    }

    fn at(&self, x: Place) -> Place {
        let turned = |i: usize| self.turn[i][0] * x[0] + self.turn[i][1] * x[1] + self.turn[i][2] * x[2];
        std::array::from_fn(|i| self.origin[i] + turned(i))
    }

    fn then(&self, inner: &Pose) -> Pose {
        let entry = |i: usize, j: usize| (0..3).fold(number(0.0), |sum, k| sum + self.turn[i][k] * inner.turn[k][j]);
        let turn = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        Pose { turn, origin: self.at(inner.origin) }
    }

    fn back(&self) -> Pose {
        let turn = std::array::from_fn(|i| std::array::from_fn(|j| self.turn[j][i]));
        let back = Pose::of(turn).at(self.origin);
        Pose { turn, origin: back.map(|x| -x) }
    }

    pub fn axis(&self, k: usize) -> Place {
        std::array::from_fn(|i| self.turn[i][k])
    }

    /// Position, velocity and acceleration of the origin, axes, and angular velocity and acceleration.
    pub fn motion(&self) -> Motion {
        let [place, velocity, acceleration] = parts(self.origin);
        let of = |part: fn(&Dual2_64) -> f64| Matrix3::from_fn(|i, j| part(&self.turn[i][j]));
        let [turn, first, second] = [of(|x| x.re), of(|x| x.v1), of(|x| x.v2)];
        let spin = |skew: Matrix3<f64>| {
            Vector3::new(skew[(2, 1)] - skew[(1, 2)], skew[(0, 2)] - skew[(2, 0)], skew[(1, 0)] - skew[(0, 1)]) * 0.5
        };
        Motion {
            place,
            velocity,
            acceleration,
            turn,
            spin: spin(first * turn.transpose()),
            faster: spin(second * turn.transpose() + first * first.transpose()),
        }
    }
}

pub struct Motion {
    pub place: Vector3<f64>,
    pub velocity: Vector3<f64>,
    pub acceleration: Vector3<f64>,
    pub turn: Matrix3<f64>,
    pub spin: Vector3<f64>,
    pub faster: Vector3<f64>,
}

fn parts(x: Place) -> [Vector3<f64>; 3] {
    [x.map(|x| x.re), x.map(|x| x.v1), x.map(|x| x.v2)].map(Vector3::from)
}

fn about(axis: usize, angle: Dual2_64) -> Pose {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turn = Pose::ground().turn;
    (turn[j][j], turn[k][k], turn[k][j], turn[j][k]) = (angle.cos(), angle.cos(), angle.sin(), -angle.sin());
    Pose::of(turn)
}

fn along(axis: usize, by: Dual2_64) -> Pose {
    let mut pose = Pose::ground();
    pose.origin[axis] = by;
    pose
}

fn quaternion([w, x, y, z]: [Dual2_64; 4]) -> Pose {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    let [w, x, y, z] = [w, x, y, z].map(|x| x / length);
    let two = |a: Dual2_64| a * 2.0;
    Pose::of([
        [w * w + x * x - y * y - z * z, two(x * y - w * z), two(x * z + w * y)],
        [two(x * y + w * z), w * w - x * x + y * y - z * z, two(y * z - w * x)],
        [two(x * z - w * y), two(y * z + w * x), w * w - x * x - y * y + z * z],
    ])
}

/// R_z(yaw) R_y(pitch) R_x(roll).
pub fn turned([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    let [x, y, z] = [about(0, number(roll)), about(1, number(pitch)), about(2, number(yaw))];
    z.then(&y).then(&x).motion().turn
}

/// The shortest rotation from a unit vector to another, by half the angle.
fn shortest(from: Vector3<f64>, to: Vector3<f64>) -> Matrix3<f64> {
    let axis = from.cross(&to);
    quaternion([1.0 + from.dot(&to), axis.x, axis.y, axis.z].map(number)).motion().turn
}

/// The place of a body's frame among all.
fn slot(body: Option<usize>) -> usize {
    body.map_or(0, |body| if body == FLAT { 1 } else { body + 2 })
}

/// A scene at values of its design variables.
pub struct Chain<'a> {
    pub plan: &'a Plan,
    pub designs: &'a [f64],
    /// The numbers of the coordinates of each link's joint, and of a body in the plane.
    pub of_links: &'a [Vec<usize>],
    pub of_flat: &'a [usize],
    /// The second markers of the closings, and the distances.
    pub others: &'a [(At, f64)],
    pub u: &'a [f64],
}

/// Coordinates along a curve.
pub type Curve<'a> = &'a dyn Fn(usize) -> Dual2_64;

impl Chain<'_> {
    fn numbers<const N: usize>(&self, numbers: [Number; N]) -> [f64; N] {
        values(numbers, self.designs)
    }

    fn axes(&self, axes: Axes) -> Matrix3<f64> {
        match axes {
            Axes::OfBody => Matrix3::identity(),
            Axes::Turned(angles) => turned(self.numbers(angles)),
            Axes::Along(z) => {
                let is_below = super::is_below(values(z, &self.plan.designs));
                let n = Vector3::from(self.numbers(z)).normalize();
                match is_below {
                    false => shortest(Vector3::z(), n),
                    true => shortest(-Vector3::z(), n) * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
                }
            }
            Axes::Toward(z, x) => {
                let (z, x) = (Vector3::from(self.numbers(z)).normalize(), Vector3::from(self.numbers(x)));
                let x = (x - z * z.dot(&x)).normalize();
                Matrix3::from_columns(&[x, z.cross(&x), z])
            }
        }
    }

    /// The frames of the ground, of the body in the plane, and of all bodies.
    pub fn poses(&self, q: Curve) -> Vec<Pose> {
        let flat = match *self.of_flat {
            [x, y, angle] => along(0, q(x)).then(&along(1, q(y))).then(&about(2, q(angle))),
            _ => Pose::ground(),
        };
        let mut poses = vec![Pose::ground(), flat];
        for (link, of) in self.plan.links.iter().zip(self.of_links) {
            let [outer, inner] = [link.outer, link.inner].map(|at| Pose::fixed(&self.axes(at.axes), self.numbers(at.at)));
            let base = poses[slot(link.outer.body)];
            let own = |k: usize| q(of[k]);
            let follows = || {
                let [factor, offset] = self.numbers(link.follows.1);
                q(of[0]) * factor + offset
            };
            let ball = |first: usize| quaternion([0, 1, 2, 3].map(|k| own(first + k)));
            let joint = match link.kind {
                // There was nothing to follow.
                _ if of.is_empty() => Pose::ground(),
                Kind::Revolute => about(2, own(0)),
                Kind::Prismatic => along(2, own(0)),
                Kind::Universal => about(0, own(0)).then(&about(1, own(1))),
                Kind::Cylindrical => along(2, own(0)).then(&about(2, own(1))),
                Kind::Planar => along(0, own(0)).then(&along(1, own(1))).then(&about(2, own(2))),
                Kind::Ball => ball(0),
                Kind::Free => along(0, own(0)).then(&along(1, own(1))).then(&along(2, own(2))).then(&ball(3)),
                Kind::Fixed => Pose::ground(),
                Kind::DependentRevolute => about(2, follows()),
                Kind::DependentPrismatic => along(2, follows()),
            };
            poses.push(base.then(&outer).then(&joint).then(&inner.back()));
        }
        poses
    }

    pub fn marker(&self, poses: &[Pose], at: At) -> Pose {
        poses[slot(at.body)].then(&Pose::fixed(&self.axes(at.axes), self.numbers(at.at)))
    }

    /// The centres of mass, with the axes of the bodies.
    fn centres(&self, poses: &[Pose]) -> Vec<Motion> {
        let of = |(link, pose): (&super::plan::Link, &Pose)| {
            pose.then(&Pose::fixed(&Matrix3::identity(), self.numbers(link.centre))).motion()
        };
        self.plan.links.iter().zip(&poses[2..]).map(of).collect()
    }

    fn inertia(&self, link: usize, turn: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
        let [xx, yy, zz, xy, xz, yz] = self.numbers(self.plan.links[link].tensor);
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        (self.plan.links[link].mass.value(self.designs), turn * tensor * turn.transpose())
    }

    pub fn mass(&self, q: &[f64]) -> DMatrix<f64> {
        let n = q.len();
        let columns: Vec<Vec<Motion>> = (0..n).map(|j| self.centres(&self.poses(&unit(q, j)))).collect();
        DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (&columns[i], &columns[j]);
            let of = |k: usize| {
                let (mass, tensor) = self.inertia(k, &a[k].turn);
                mass * a[k].velocity.dot(&b[k].velocity) + a[k].spin.dot(&(tensor * b[k].spin))
            };
            let flat = self.plan.flat.filter(|_| i == j).map_or(0.0, |[mass, moment]| {
                let which = self.of_flat.iter().position(|q| *q == i);
                which.map_or(0.0, |which| if which == 2 { moment } else { mass })
            });
            (0..a.len()).map(of).sum::<f64>() + flat
        })
    }

    fn moves(&self, body: Option<usize>) -> bool {
        body.is_some_and(|body| {
            body == FLAT || !self.of_links[body].is_empty() || self.moves(self.plan.links[body].outer.body)
        })
    }

    fn gravity(&self) -> Vector3<f64> {
        Vector3::from(self.numbers(self.plan.gravity))
    }

    /// V of gravity and springs.
    pub fn potential(&self, q: &[f64]) -> f64 {
        let poses = self.poses(&|i| number(q[i]));
        let (centres, g) = (self.centres(&poses), self.gravity());
        // The weight of what is fixed to the ground does not count.
        let moving = centres.iter().enumerate().filter(|(k, _)| self.moves(Some(*k)));
        let weights = moving.map(|(k, centre)| -self.inertia(k, &centre.turn).0 * g.dot(&centre.place));
        let springs = self.plan.loads.iter().map(|load| match load {
            Load::SpringDamper(a, b, numbers) => {
                let [stiffness, length, _] = self.numbers(*numbers);
                let between = self.marker(&poses, *b).motion().place - self.marker(&poses, *a).motion().place;
                0.5 * stiffness * (between.norm() - length).powi(2)
            }
            _ => 0.0,
        });
        let flat = self.plan.flat.map_or(0.0, |[mass, _]| -mass * (g.x * q[self.of_flat[0]] + g.y * q[self.of_flat[1]]));
        weights.chain(springs).sum::<f64>() + flat
    }

    /// Momentum, and angular momentum about the origin.
    pub fn momenta(&self, [q, v]: [&[f64]; 2]) -> [Vector3<f64>; 2] {
        let centres = self.centres(&self.poses(&|i| Dual2_64::new(q[i], v[i], 0.0)));
        centres.iter().enumerate().fold([Vector3::zeros(); 2], |[p, h], (k, at)| {
            let (mass, tensor) = self.inertia(k, &at.turn);
            let own = at.velocity * mass;
            [p + own, h + at.place.cross(&own) + tensor * at.spin]
        })
    }

    /// Forces and torques: marker, force at it, torque on its body.
    fn wrenches(&self, poses: &[Pose]) -> Vec<(At, Vector3<f64>, Vector3<f64>)> {
        let mut all = Vec::new();
        let (zero, mut u) = (Vector3::zeros(), self.u.iter());
        let mut control = || *u.next().expect("a control");
        for load in &self.plan.loads {
            let at = |marker: At| self.marker(poses, marker).motion();
            let halves = |six: [f64; 6]| (Vector3::from_column_slice(&six[..3]), Vector3::from_column_slice(&six[3..]));
            match *load {
                Load::SpringDamper(a, b, numbers) => {
                    let [stiffness, length, damping] = self.numbers(numbers);
                    let (from, to) = (at(a), at(b));
                    let between = to.place - from.place;
                    let along = between.normalize();
                    let pull = stiffness * (between.norm() - length) + damping * along.dot(&(to.velocity - from.velocity));
                    all.extend([(a, along * pull, zero), (b, along * -pull, zero)]);
                }
                Load::InSpace(a, six) => {
                    let (force, torque) = halves(self.numbers(six));
                    all.push((a, force, torque));
                }
                Load::OnBody(a, six) => {
                    let (force, torque) = halves(self.numbers(six));
                    let turn = at(a).turn;
                    all.push((a, turn * force, turn * torque));
                }
                Load::Thrust(a) => all.push((a, at(a).turn.column(2) * control(), zero)),
                Load::Torque(a, b) => {
                    let torque = at(b).turn.column(2) * control();
                    all.extend([(b, zero, torque), (a, zero, -torque)]);
                }
                Load::Actuator(a, b) => {
                    let push = (at(b).place - at(a).place).normalize() * control();
                    all.extend([(a, -push, zero), (b, push, zero)]);
                }
            }
        }
        all
    }

    /// Φ of the closings along a curve.
    pub fn phi(&self, q: Curve) -> Vec<Dual2_64> {
        let poses = self.poses(q);
        let dot = |a: Place, b: Place| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut all = Vec::new();
        for (closing, (other, length)) in self.plan.closings.iter().zip(self.others) {
            let (a, b) = (self.marker(&poses, closing.a), self.marker(&poses, *other));
            let between: Place = std::array::from_fn(|i| b.origin[i] - a.origin[i]);
            let point = |k: usize| dot(a.axis(k), between);
            let axis = |k: usize| dot(a.axis(k), b.axis(2));
            let turn = dot(a.axis(0), b.axis(1));
            match closing.kind {
                Closed::Ball => all.extend([point(0), point(1), point(2)]),
                Closed::Parallel => all.extend([axis(0), axis(1)]),
                Closed::Revolute => all.extend([point(0), point(1), point(2), axis(0), axis(1)]),
                Closed::Cylindrical => all.extend([point(0), point(1), axis(0), axis(1)]),
                Closed::Prismatic => all.extend([point(0), point(1), axis(0), axis(1), turn]),
                Closed::Fixed => all.extend([point(0), point(1), point(2), axis(0), axis(1), turn]),
                Closed::Plane => all.push(point(2)),
                Closed::Line => all.extend([point(0), point(1)]),
                Closed::Distance => all.push((dot(between, between) - length * length) / (2.0 * length)),
            }
        }
        all
    }

    /// The first numbers of the quaternions.
    pub fn quaternions(&self) -> Vec<usize> {
        let first = |(link, of): (&super::plan::Link, &Vec<usize>)| match link.kind {
            Kind::Ball => Some(of[0]),
            Kind::Free => Some(of[3]),
            _ => None,
        };
        self.plan.links.iter().zip(self.of_links).filter_map(first).collect()
    }

    /// What is left of d'Alembert's principle Σ m (c̈ − g)·∂c/∂q_j + (J ω̇ + ω × J ω)·∂ω/∂q̇_j − Q_j + Φ_qᵀ λ, without its part along quaternions,
    /// relative to the sum of the sizes of its terms, to which accelerations and reactions contribute |M| |v̇| and Σ |λ|; `lambda` are the multipliers of
    /// the closings.
    ///
    /// Where axes of massless bodies are nearly parallel, accelerations of 1e6 may cancel in every body, with the rounding of 1e6; where a row of Φ_q
    /// nearly vanishes, reactions of 1e16 have the rounding of the row.
    pub fn imbalance(&self, [q, v, v_dot]: [&[f64]; 3], lambda: &[f64]) -> f64 {
        let curve = |i: usize| Dual2_64::new(q[i], v[i], v_dot[i]);
        let poses = self.poses(&curve);
        let (centres, wrenches, g) = (self.centres(&poses), self.wrenches(&poses), self.gravity());
        let mass = self.mass(q);
        let (mut left, mut size) = (DVector::zeros(q.len()), lambda.iter().map(|lambda| lambda.abs()).sum::<f64>());
        for j in 0..q.len() {
            let unit = unit(q, j);
            let moved = self.poses(&unit);
            let mut terms = Vec::new();
            for (k, (at, by)) in centres.iter().zip(self.centres(&moved)).enumerate() {
                let (mass, tensor) = self.inertia(k, &at.turn);
                terms.extend([mass * at.acceleration.dot(&by.velocity), -mass * g.dot(&by.velocity)]);
                terms.extend([by.spin.dot(&(tensor * at.faster)), by.spin.dot(&at.spin.cross(&(tensor * at.spin)))]);
            }
            for (at, force, torque) in &wrenches {
                let by = self.marker(&moved, *at).motion();
                terms.extend([-force.dot(&by.velocity), -torque.dot(&by.spin)]);
            }
            if let (Some([mass, moment]), Some(which)) = (self.plan.flat, self.of_flat.iter().position(|q| *q == j)) {
                terms.push(if which == 2 { moment * v_dot[j] } else { mass * v_dot[j] });
                terms.push(if which == 2 { 0.0 } else { -mass * g[which] });
            }
            terms.extend(self.phi(&unit).iter().zip(lambda).map(|(phi, lambda)| phi.v1 * lambda));
            left[j] = terms.iter().sum::<f64>();
            size = terms.iter().fold(size, |size, term| size.max(term.abs()));
            size = size.max((0..q.len()).map(|i| (mass[(j, i)] * v_dot[i]).abs()).sum());
        }
        for first in self.quaternions() {
            let e = DVector::from_column_slice(&q[first..first + 4]).normalize();
            let along = left.rows(first, 4).dot(&e);
            left.rows_mut(first, 4).axpy(-along, &e, 1.0);
        }
        if size == 0.0 { 0.0 } else { left.amax() / size }
    }
}

/// q + s e_j.
fn unit(q: &[f64], j: usize) -> impl Fn(usize) -> Dual2_64 {
    move |i| Dual2_64::new(q[i], f64::from(i == j), 0.0)
}
