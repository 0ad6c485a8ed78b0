//! Coefficients that are exactly zero, saturated, or no number at the design that a scene is compiled with, and not at the one it runs with.

use super::*;

/// A smooth function of a design variable that rounds to 0 far below 2, or is undefined there.
#[derive(Clone, Copy, Debug)]
enum Switch {
    Tanh,
    Sigmoid,
    Softplus,
    Root,
    Logarithm,
}

const SWITCHES: [Switch; 5] = [Switch::Tanh, Switch::Sigmoid, Switch::Softplus, Switch::Root, Switch::Logarithm];

impl Switch {
    fn at<S: Scalar>(self, b: S) -> S {
        match self {
            Switch::Tanh => ((b - 2.0) * 20.0).tanh() + 1.0,
            Switch::Sigmoid => ((-(b - 2.0) * 400.0).exp() + 1.0).recip(),
            Switch::Softplus => ((b - 2.0) * 30.0).exp().ln_1p() * 0.05,
            Switch::Root => (b - 2.0).sqrt(),
            Switch::Logarithm => (b - 2.0).ln() + 1.5,
        }
    }
}

/// V = ½ c (y − x)²: a spring.
struct Spring(Switch);
impl PotentialEnergy<2, 1> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, _t: S) -> S {
        let d = q[1] - q[0];
        d * d * self.0.at(b[0]) * 2.0
    }
}

/// Q = −c (ẋ − ẏ) on both: a damper.
struct Damper(Switch);
impl Force<2, 0, 1> for Damper {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let force = (at.v[1] - at.v[0]) * self.0.at(b[0]);
        SVector::from([force, -force])
    }
}

/// T = 0.2 c ẋ ẏ: masses that share.
struct Coupling(Switch);
impl KineticEnergy<2, 1> for Coupling {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 1>) -> S {
        v[0] * v[1] * self.0.at(b[0]) * 0.2
    }
}

/// Φ = z − c y + ½ x: a gear.
struct Gear(Switch);
impl Constraint<3, 1, 1> for Gear {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[2] - q[1] * self.0.at(b[0]) + q[0] * 0.5])
    }
}

/// Φ = z − c y + x²: a constraint with linear columns.
struct Curve(Switch);
impl Constraint<3, 1, 1> for Curve {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[2] - q[1] * self.0.at(b[0]) + q[0] * q[0]])
    }
}

/// Φ = z − c sin y + x.
struct Wave(Switch);
impl Constraint<3, 1, 1> for Wave {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[2] - q[1].sin() * self.0.at(b[0]) + q[0]])
    }
}

const KINDS: [&str; 6] = ["spring", "damper", "coupling", "gear", "curve", "wave"];

/// Three masses and an element of one kind, compiled with one design and run with b = 2.3.
fn motion(kind: &str, switch: Switch, opaque: bool, compiled: f64) -> Gradient {
    let mut s = Scene::new();
    let [x] = s.coordinates("a", ["x"]);
    let [y] = s.coordinates("b", ["y"]);
    let [z] = s.coordinates("c", ["z"]);
    for (name, q, mass) in [("mx", x, 1.0), ("my", y, 1.3), ("mz", z, 0.8)] {
        s.kinetic_energy(name, Mass, [q], [mass.into()]);
    }
    let b = [s.design("b", compiled).into()];
    match (kind, opaque) {
        ("spring", false) => s.potential_energy(kind, Spring(switch), [x, y], b),
        ("spring", true) => s.potential_energy(kind, Opaque(Spring(switch)), [x, y], b),
        ("damper", false) => s.force(kind, Damper(switch), [x, y], [], b),
        ("damper", true) => s.force(kind, Opaque(Damper(switch)), [x, y], [], b),
        ("coupling", false) => s.kinetic_energy(kind, Coupling(switch), [x, y], b),
        ("coupling", true) => s.kinetic_energy(kind, Opaque(Coupling(switch)), [x, y], b),
        ("gear", false) => _ = s.constraint(kind, Gear(switch), [x, y, z], b),
        ("gear", true) => _ = s.constraint(kind, Opaque(Gear(switch)), [x, y, z], b),
        ("curve", false) => _ = s.constraint(kind, Curve(switch), [x, y, z], b),
        ("curve", true) => _ = s.constraint(kind, Opaque(Curve(switch)), [x, y, z], b),
        ("wave", false) => _ = s.constraint(kind, Wave(switch), [x, y, z], b),
        _ => _ = s.constraint(kind, Opaque(Wave(switch)), [x, y, z], b),
    }
    s.cost("squares", Squares, Sum::Trapezoidal, [x, y, z], [], [], []);
    let constrained = s_is_constrained(kind);
    let result = run(s, |inputs| {
        inputs.design[0] = 2.3;
        if !constrained {
            inputs.start.q_mut()[0] = 1.0;
        }
        let c: f64 = switch.at(2.3);
        let slope = if kind == "gear" { c - 0.5 * 0.4 } else { c };
        // At q = 0 the rates of all constraints are linear.
        let rates = match kind {
            "gear" => [0.4, 1.0, slope],
            "curve" => [0.4, 1.0, c],
            "wave" => [0.4, 1.0, c - 0.4],
            _ => [0.4, 1.0, 0.3],
        };
        inputs.start.rate_mut().copy_from_slice(&rates);
    });
    result.unwrap_or_else(|error| panic!("{kind}, {switch:?}, opaque {opaque}, compiled at {compiled}: {error}"))
}

fn s_is_constrained(kind: &str) -> bool {
    ["gear", "curve", "wave"].contains(&kind)
}

#[test]
fn a_coefficient_may_be_zero_or_undefined_where_the_scene_is_compiled() {
    for kind in KINDS {
        for switch in SWITCHES {
            let opaque = motion(kind, switch, true, 2.5);
            for compiled in [-1.0, 0.0, 2.5] {
                let traced = motion(kind, switch, false, compiled);
                let error = distance(&traced, &opaque);
                assert!(error < 1e-12, "{kind}, {switch:?}, compiled at {compiled}: {error:e}");
            }
        }
    }
}
