//! Elements of a user's own whose formulas are at the edge of where they are defined, or at a kink, when a motion begins: what needs no derivative
//! there is refused no motion, and no gradient.

use crate::scenes::sled::{Formula, Own, sled};
use hamiltonian_adjoint::check::{Input, complex_step, tangent};
use hamiltonian_adjoint::{Grid, Held, Inputs, Scalar, Settings, Start, Sum, gradient, simulate};

/// √t.
struct RootOfTime;
impl Formula for RootOfTime {
    fn at<S: Scalar>(&self, _q: S, _v: S, t: S) -> S {
        t.sqrt()
    }
}

/// −√v.
struct RootOfVelocity;
impl Formula for RootOfVelocity {
    fn at<S: Scalar>(&self, _q: S, v: S, _t: S) -> S {
        -v.sqrt()
    }
}

/// 1 − |v|^1.5 sign v.
struct Friction;
impl Formula for Friction {
    fn at<S: Scalar>(&self, _q: S, v: S, _t: S) -> S {
        let size = v.abs().powf(1.5);
        S::one() - if v.re() < 0.0 { -size } else { size }
    }
}

/// q v.
struct Both;
impl Formula for Both {
    fn at<S: Scalar>(&self, q: S, v: S, _t: S) -> S {
        q * v
    }
}

#[test]
fn what_grows_like_a_root_of_time_or_brakes_with_a_power_of_velocity_may_begin_at_zero() {
    let root = sled(1.0, |scene, x| {
        scene.force("pull", Own(RootOfTime), [x], [], []);
        scene.cost("end", Own(Both), Sum::Terminal, [x], [], [], []);
        scene.cost("way", Own(RootOfTime), Sum::Trapezoidal, [x], [], [], []);
    });
    let friction = sled(1.0, |scene, x| {
        scene.force("friction", Own(Friction), [x], [], []);
        scene.cost("end", Own(Both), Sum::Terminal, [x], [], [], []);
    });
    for system in [root, friction] {
        let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.1));
        let with = [Input::Coordinate(0), Input::Rate(0), Input::Step(2), Input::Step(5)];
        let gradient = gradient(&system, &inputs, Settings::default()).expect("a gradient");
        let reference = complex_step(&system, &inputs, Settings::default(), &with).expect("derivatives");
        let tangents = tangent(&system, &inputs, Settings::default(), &with).expect("derivatives");
        for (input, (reference, tangent)) in with.iter().zip(reference.into_iter().zip(tangents)) {
            let ours = input.in_gradient(&gradient);
            assert!((ours - reference).abs() < 1e-13 && (ours - tangent).abs() < 1e-13, "{input:?}: {ours}, {reference}");
        }
    }
}

#[test]
fn an_assembled_start_asks_no_force_where_the_motion_does_not_begin() {
    let system = sled(1.0, |scene, x| scene.force("brake", Own(RootOfVelocity), [x], [], []));
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.1));
    inputs.start.rate_mut()[0] = 1.0;
    let given = simulate(&system, &inputs, Settings::default()).expect("a motion");
    inputs.start = Start::Assembled { q: inputs.start.q().clone(), v: inputs.start.rate().clone(), held: Held::default() };
    assert_eq!(simulate(&system, &inputs, Settings::default()).expect("a motion").q, given.q);
}

/// −|t/2|.
struct Kink;
impl Formula for Kink {
    fn at<S: Scalar>(&self, _q: S, _v: S, t: S) -> S {
        -(t * -0.5).abs()
    }
}

#[test]
fn a_kink_where_a_scene_is_compiled_is_no_disagreement() {
    let system = sled(1.0, |scene, x| scene.force("kink", Own(Kink), [x], [], []));
    simulate(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1)), Settings::default()).expect("a motion");
}
