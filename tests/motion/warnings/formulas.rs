//! Formulas that look a value up in a table, with its slope and without.

use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings,
    Sum, Warning, gradient,
};
use nalgebra::SVector;

/// Values of −sin at every tenth, and lines in between; without their slopes if they are lost.
fn look_up<S: Scalar>(x: S, is_lost: bool) -> S {
    let from = (x.re() * 10.0).floor() / 10.0;
    let (low, high) = (-from.sin(), -(from + 0.1).sin());
    let slope = (high - low) / 0.1;
    if is_lost { S::from(low + slope * (x.re() - from)) } else { (x - from) * slope + low }
}

/// ½ (v₁² + v₂²).
struct Masses;
impl KineticEnergy<2> for Masses {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

/// A table of the velocity, of the place or of the control.
struct Tabled {
    of: usize,
    is_lost: bool,
}
impl Force<1, 1, 1> for Tabled {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        let x = [at.v[0], at.q[0], at.u[0], at.t][self.of];
        SVector::from([look_up(x, self.is_lost) * b[0] + at.u[0]])
    }
}

/// A table of an energy, of a track and of a cost.
struct Of {
    is_lost: bool,
}
impl PotentialEnergy<1> for Of {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, _t: S) -> S {
        look_up(q[0], self.is_lost)
    }
}
impl Constraint<2, 1> for Of {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([q[1] - look_up(q[0], self.is_lost)])
    }
}
impl Cost<1> for Of {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        look_up(at.q[0], self.is_lost)
    }
}

/// −k x beyond the gap, and waves shorter than any difference: both branch, and lose nothing.
struct Stop;
impl Force<1, 1, 1> for Stop {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([if at.q[0].re() > 0.1 { (at.q[0] - 0.1) * b[0] * -1e3 } else { at.u[0] * 0.0 }])
    }
}
struct Waves;
impl Force<1, 1, 1> for Waves {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([if at.q[0].re() > -9.0 { (at.q[0] * 3e6).sin() * b[0] * 1e-6 } else { at.u[0] }])
    }
}

/// What a short motion with one of these warns of.
fn lost(which: usize, is_lost: bool) -> Vec<(String, String)> {
    let mut scene = Scene::new();
    let [x, y] = ["x", "y"].map(|name| scene.coordinates(name, [name])[0]);
    let (u, b) = (scene.control("push"), scene.design("gain", 0.7));
    scene.kinetic_energy("masses", Masses, [x, y], []);
    scene.force("plain", Tabled { of: 0, is_lost: false }, [y], [u], [b.into()]);
    match which {
        0..4 => scene.force("table", Tabled { of: which, is_lost }, [x], [u], [b.into()]),
        4 => scene.potential_energy("table", Of { is_lost }, [x], []),
        5 => drop(scene.constraint("table", Of { is_lost }, [x, y], [])),
        7 => scene.force("stop", Stop, [x], [u], [b.into()]),
        8 => scene.force("waves", Waves, [x], [u], [b.into()]),
        _ => scene.cost("table", Of { is_lost }, Sum::Terminal, [x], [], [], []),
    }
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
    inputs.controls.fill(0.3);
    let warnings = gradient(&system, &inputs, Settings::default()).expect("a motion").warnings;
    let of = |warning: Warning| match warning {
        Warning::LostDerivative { element, argument, .. } => Some((element, argument)),
        _ => None,
    };
    warnings.into_iter().filter_map(of).collect()
}

/// A table that is looked up by `re()` gave gradients that were wrong, without a word.
#[test]
fn a_table_without_slopes_is_named() {
    let arguments = ["the velocity of `x.x`", "`x.x`", "`push`", "t", "`x.x`", "`x.x`", "`x.x`"];
    for (which, argument) in arguments.into_iter().enumerate() {
        assert_eq!(lost(which, true), [("table".to_string(), argument.to_string())], "{which}");
        assert_eq!(lost(which, false), [], "{which}");
    }
    for which in [7, 8] {
        assert_eq!(lost(which, false), [], "{which}");
    }
}
