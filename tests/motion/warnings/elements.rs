//! Elements that change over a distance, a velocity or a time of any size.

use hamiltonian_adjoint::{
    Constraint, Control, Coordinate, Cost, CostPoint, Force, ForcePoint, KineticEnergy, Param, PotentialEnergy, Scalar,
    Scene, Sum,
};
use nalgebra::SVector;

/// ½ m v².
struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

/// u.
struct Drive;
impl Force<1, 1> for Drive {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        at.u
    }
}

/// ½ k x² + ¼ c x⁴ of the distance between two coordinates.
struct Spring;
impl PotentialEnergy<2, 2> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 2>, _t: S) -> S {
        let square = (q[1] - q[0]) * (q[1] - q[0]);
        square * b[0] * 0.5 + square * square * b[1] * 0.25
    }
}

/// The same of one.
struct Anchor;
impl PotentialEnergy<1, 2> for Anchor {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
        let square = q[0] * q[0];
        square * b[0] * 0.5 + square * square * b[1] * 0.25
    }
}

/// −μ tanh(v/ε).
struct Friction;
impl Force<1, 0, 2> for Friction {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::from([-(at.v[0] / b[1]).tanh() * b[0]])
    }
}

/// The same of two coordinates that slide on each other.
struct Sliding;
impl Force<2, 0, 2> for Sliding {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let force = ((at.v[1] - at.v[0]) / b[1]).tanh() * b[0];
        SVector::from([force, -force])
    }
}

/// −k (x − gap) beyond the gap.
struct Stop;
impl Force<1, 0, 2> for Stop {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 2>) -> SVector<S, 1> {
        let depth = at.q[0] - b[1];
        SVector::from([if depth.re() > 0.0 { -depth * b[0] } else { S::zero() }])
    }
}

/// −k (x − gap)^1.5 beyond the gap.
struct Hertz;
impl Force<1, 0, 2> for Hertz {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 2>) -> SVector<S, 1> {
        let depth = at.q[0] - b[1];
        SVector::from([if depth.re() > 0.0 { -depth * depth.sqrt() * b[0] } else { S::zero() }])
    }
}

/// −d exp(−((x − x₀)/w)²).
struct Well;
impl PotentialEnergy<1, 3> for Well {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 3>, _t: S) -> S {
        let x = (q[0] - b[1]) / b[2];
        -b[0] * (-x * x).exp()
    }
}

/// f exp(−((t − t₀)/τ)²).
struct Pulse;
impl Force<1, 0, 3> for Pulse {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 3>) -> SVector<S, 1> {
        let x = (at.t - b[1]) / b[2];
        SVector::from([b[0] * (-x * x).exp()])
    }
}

/// −c v − d v³.
struct Drag;
impl Force<1, 0, 2> for Drag {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 2>) -> SVector<S, 1> {
        let v = at.v[0];
        SVector::from([-v * b[0] - v * v * v * b[1]])
    }
}

/// y = r ε tanh(x/ε) + c x.
struct Gear;
impl Constraint<2, 1, 3> for Gear {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 3>, _t: S) -> SVector<S, 1> {
        SVector::from([q[1] - (q[0] / b[1]).tanh() * b[1] * b[0] - q[0] * b[2]])
    }
}

/// x = a (τ ln cosh((t − t₀)/τ) − τ ln cosh(t₀/τ)): from velocity −a to a within τ.
struct Driven;
impl Constraint<1, 1, 3> for Driven {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 3>, t: S) -> SVector<S, 1> {
        let ln_cosh = |x: S| {
            let size = if x.re() < 0.0 { -x } else { x };
            size + ((size * -2.0).exp() + S::one()).ln()
        };
        SVector::from([q[0] - b[0] * b[2] * (ln_cosh((t - b[1]) / b[2]) - ln_cosh(b[1] / b[2]))])
    }
}

/// (x − x₁)².
struct Aim;
impl Cost<1, 0, 0, 1> for Aim {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        (at.q[0] - b[0]) * (at.q[0] - b[0])
    }
}

/// What a scene may hold besides masses and springs.
#[derive(Clone, Copy, Debug)]
pub enum Element {
    Friction { force: f64, speed: f64 },
    Sliding { force: f64, speed: f64 },
    Stop { stiffness: f64, gap: f64 },
    Hertz { stiffness: f64, gap: f64 },
    Well { depth: f64, at: f64, width: f64 },
    Pulse { impulse: f64, at: f64, width: f64 },
    Drag { linear: f64, cubic: f64 },
    Gear { ratio: f64, width: f64 },
    Driven { speed: f64, at: f64, width: f64 },
}

/// A coordinate with a mass.
pub fn mass(scene: &mut Scene, name: &str, mass: Param, x: f64) -> Coordinate {
    let [coordinate] = scene.coordinates(name, ["x"]);
    scene.place(coordinate, x);
    scene.kinetic_energy(&format!("T of {name}"), Mass, [coordinate], [mass]);
    coordinate
}

pub fn drive(scene: &mut Scene, x: Coordinate, u: Control) {
    scene.force("drive", Drive, [x], [u], []);
}

pub fn anchor(scene: &mut Scene, x: Coordinate, b: [Param; 2]) {
    scene.potential_energy("anchor", Anchor, [x], b);
}

pub fn spring(scene: &mut Scene, name: &str, x: [Coordinate; 2], b: [Param; 2]) {
    scene.potential_energy(name, Spring, x, b);
}

pub fn aim(scene: &mut Scene, name: &str, sum: Sum, x: Coordinate, at: f64) {
    scene.cost(name, Aim, sum, [x], [], [], [at.into()]);
}

impl Element {
    /// Adds it between the last two of these coordinates, or to the last.
    pub fn add(self, scene: &mut Scene, name: &str, x: &[Coordinate], start: f64) {
        let last = x[x.len() - 1];
        match self {
            Element::Friction { force, speed } => scene.force(name, Friction, [last], [], [force, speed].map(Param::from)),
            Element::Sliding { force, speed } => match *x {
                [.., before, last] => scene.force(name, Sliding, [before, last], [], [force, speed].map(Param::from)),
                _ => scene.force(name, Friction, [last], [], [force, speed].map(Param::from)),
            },
            Element::Stop { stiffness, gap } => scene.force(name, Stop, [last], [], [stiffness, gap].map(Param::from)),
            Element::Hertz { stiffness, gap } => scene.force(name, Hertz, [last], [], [stiffness, gap].map(Param::from)),
            Element::Well { depth, at, width } => {
                scene.potential_energy(name, Well, [last], [depth, at, width].map(Param::from))
            }
            Element::Pulse { impulse, at, width } => {
                scene.force(name, Pulse, [last], [], [impulse / width, at, width].map(Param::from));
            }
            Element::Drag { linear, cubic } => scene.force(name, Drag, [last], [], [linear, cubic].map(Param::from)),
            Element::Gear { ratio, width } => {
                let wheel = mass(scene, "wheel", 0.3.into(), ratio * width * (start / width).tanh() + 0.5 * start);
                scene.constraint(name, Gear, [last, wheel], [ratio, width, 0.5].map(Param::from));
            }
            Element::Driven { speed, at, width } => {
                let slide = mass(scene, "slide", 1.0.into(), 0.0);
                scene.constraint(name, Driven, [slide], [speed, at, width].map(Param::from));
                spring(scene, "link", [last, slide], [20.0.into(), 5.0.into()]);
            }
        }
    }

    /// Whether a start with any velocities fits.
    pub fn is_free(self) -> bool {
        !matches!(self, Element::Gear { .. } | Element::Driven { .. })
    }
}
