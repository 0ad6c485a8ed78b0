//! Elements of a user's own whose formulas are at the edge of where they are defined, or at a kink, when a motion begins: what needs no derivative
//! there is refused no motion, and no gradient.

use hamiltonian_adjoint::check::{Input, complex_step, tangent};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Force, ForcePoint, Grid, Held, Inputs, KineticEnergy, Scalar, Scene, Settings, Start, Sum,
    System, gradient, simulate,
};
use nalgebra::SVector;

/// T = ½ v².
struct Mass;
impl KineticEnergy<1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

/// A function of q, v, t as a force or a cost.
struct Own<F>(F);
trait Formula: Send + Sync + 'static {
    fn at<S: Scalar>(&self, q: S, v: S, t: S) -> S;
}
impl<F: Formula> Force<1> for Own<F> {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([self.0.at(at.q[0], at.v[0], at.t)])
    }
}
impl<F: Formula> Cost<1> for Own<F> {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        self.0.at(at.q[0], at.v[0], at.t)
    }
}

/// A mass of 1 kg on a line, with what `add` adds to it.
fn sled(add: impl FnOnce(&mut Scene, Coordinate)) -> System {
    let mut scene = Scene::new();
    let [x] = scene.coordinates("sled", ["x"]);
    scene.kinetic_energy("mass", Mass, [x], []);
    add(&mut scene, x);
    scene.compile().expect("scene")
}

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
    let root = sled(|scene, x| {
        scene.force("pull", Own(RootOfTime), [x], [], []);
        scene.cost("end", Own(Both), Sum::Terminal, [x], [], [], []);
        scene.cost("way", Own(RootOfTime), Sum::Trapezoidal, [x], [], [], []);
    });
    let friction = sled(|scene, x| {
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
    let system = sled(|scene, x| scene.force("brake", Own(RootOfVelocity), [x], [], []));
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
    let system = sled(|scene, x| scene.force("kink", Own(Kink), [x], [], []));
    simulate(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1)), Settings::default()).expect("a motion");
}
