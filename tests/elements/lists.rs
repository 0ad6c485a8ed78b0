//! Elements of lists: the same formulas as with fixed lengths, and lengths that are known only at run time.

use hamiltonian_adjoint::check::{Input, complex_step};
use hamiltonian_adjoint::{
    Constraint, Coordinate, Cost, CostPoint, Error, Force, ForcePoint, Gradient, Grid, Inputs, KineticEnergy,
    ListConstraint, ListCost, ListForce, ListForcePoint, ListKineticEnergy, ListPoint, ListPotentialEnergy, Param,
    PotentialEnergy, Scalar, Scene, Settings, Sum, System, gradient,
};
use nalgebra::SVector;

use crate::scenes::relative;

const N: usize = 5;

/// A chain of coupled pendulums; `branches` makes its force depend on a sign.
#[derive(Clone, Copy)]
struct Chain {
    branches: bool,
}

impl ListKineticEnergy for Chain {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        let coupled = (1..q.len()).map(|i| (q[i] - q[i - 1]).cos() * v[i] * v[i - 1] * b[1]).sum::<S>();
        v.iter().map(|v| *v * *v * b[0]).sum::<S>() * 0.5 + coupled
    }
}

impl ListPotentialEnergy for Chain {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], t: S) -> S {
        q.iter().map(|q| -q.cos() * b[0] + *q * t.sin() * 0.1).sum()
    }
}

impl ListForce for Chain {
    fn force<S: Scalar>(&self, at: &ListForcePoint<S>, b: &[S], force: &mut [S]) {
        for (i, force) in force.iter_mut().enumerate() {
            let is_stiff = self.branches && at.q[i].re() > 0.0;
            *force = -at.v[i] * b[0] - if is_stiff { at.q[i] * at.q[i] } else { S::zero() };
        }
        force[0] += at.u[0] * at.q[1].cos() + at.u[1] * at.t;
    }
}

impl ListConstraint for Chain {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], t: S, phi: &mut [S]) {
        phi[0] = q.iter().map(|q| q.cos()).sum::<S>() - b[0] * q.len() as f64;
        phi[1] = q[1] - q[0] + (t * t) * 0.02;
    }
}

impl ListCost for Chain {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.q.iter().map(|q| q.sin().powi(2)).sum::<S>() + at.u[0].powi(2) * at.b[0]
    }
}

impl KineticEnergy<N, 2> for Chain {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, b: &SVector<S, 2>) -> S {
        ListKineticEnergy::kinetic_energy(self, q.as_slice(), v.as_slice(), b.as_slice())
    }
}

impl PotentialEnergy<N, 1> for Chain {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, 1>, t: S) -> S {
        ListPotentialEnergy::potential_energy(self, q.as_slice(), b.as_slice(), t)
    }
}

impl Force<N, 2, 1> for Chain {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, N, 2>, b: &SVector<S, 1>) -> SVector<S, N> {
        let mut force = SVector::<S, N>::zeros();
        let at = ListForcePoint { q: at.q.as_slice(), v: at.v.as_slice(), u: at.u.as_slice(), t: at.t };
        ListForce::force(self, &at, b.as_slice(), force.as_mut_slice());
        force
    }
}

impl Constraint<N, 2, 1> for Chain {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, b: &SVector<S, 1>, t: S) -> SVector<S, 2> {
        let mut phi = SVector::<S, 2>::zeros();
        ListConstraint::phi(self, q.as_slice(), b.as_slice(), t, phi.as_mut_slice());
        phi
    }
}

impl Cost<N, 0, 1, 1> for Chain {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, N, 0, 1>, b: &SVector<S, 1>) -> S {
        at.q.iter().map(|q| q.sin().powi(2)).sum::<S>() + at.u[0].powi(2) * b[0]
    }
}

/// Coordinates q0, q1, … with these initial values.
fn coordinates(scene: &mut Scene, count: usize, initial: impl Fn(usize) -> f64) -> Vec<Coordinate> {
    let names: Vec<String> = (0..count).map(|i| format!("q{i}")).collect();
    let q = scene.list_coordinates("chain", &names.iter().map(String::as_str).collect::<Vec<_>>());
    q.iter().enumerate().for_each(|(i, q)| scene.place(*q, initial(i)));
    q
}

/// A chain of n pendulums by lists, or of [`N`] by fixed lengths.
fn scene(n: usize, by_lists: bool, branches: bool) -> Scene {
    let (mut scene, chain) = (Scene::new(), Chain { branches });
    let q = coordinates(&mut scene, n, |_| 0.3);
    let u = [scene.control("first"), scene.control("second")];
    let [mass, coupling, level] = [("mass", 2.0), ("coupling", 0.4), ("level", 0.3f64.cos())]
        .map(|(name, value)| Param::from(scene.design(name, value)));
    if by_lists {
        scene.list_kinetic_energy("T", chain, &q, &[mass, coupling]);
        scene.list_potential_energy("V", chain, &q, &[mass]);
        scene.list_force("Q", chain, &q, &u, &[coupling]);
        let multipliers = scene.list_constraint("phi", chain, 2, &q, &[level]);
        assert_eq!(multipliers.len(), 2);
        scene.list_cost("h", chain, Sum::Integral, &q, &[], &u[..1], &[mass]);
    } else {
        let q: [_; N] = q.try_into().expect("N coordinates");
        scene.kinetic_energy("T", chain, q, [mass, coupling]);
        scene.potential_energy("V", chain, q, [mass]);
        scene.force("Q", chain, q, u, [coupling]);
        let _: [_; 2] = scene.constraint("phi", chain, q, [level]);
        scene.cost("h", chain, Sum::Integral, q, [], [u[0]], [mass]);
    }
    scene
}

fn inputs(system: &System) -> Inputs<f64> {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(30, 0.01));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = (i as f64).sin());
    inputs
}

fn gradient_of(system: &System) -> Result<Gradient, Error> {
    gradient(system, &inputs(system), Settings::default())
}

#[test]
fn lists_are_the_same_formulas_as_fixed_lengths() -> Result<(), Error> {
    for compile in [Scene::compile, Scene::compile_without_programs] {
        for branches in [false, true] {
            let [lists, fixed] =
                [true, false].map(|by_lists| gradient_of(&compile(scene(N, by_lists, branches)).expect("a scene")));
            let (lists, fixed) = (lists?, fixed?);
            assert_eq!((lists.value, &lists.controls, &lists.design), (fixed.value, &fixed.controls, &fixed.design));
        }
    }
    Ok(())
}

#[test]
fn gradients_of_lists_are_those_of_complex_step_for_any_length() -> Result<(), Error> {
    for n in [2, 3, 4, 6, 9, 17] {
        for compile in [Scene::compile, Scene::compile_without_programs] {
            for branches in [false, true] {
                let system = compile(scene(n, true, branches))?;
                let found = gradient_of(&system)?;
                let inputs = inputs(&system);
                let some = [
                    Input::Control { channel: 0, node: 3 },
                    Input::Control { channel: 1, node: 20 },
                    Input::Design(0),
                    Input::Design(1),
                    Input::Design(2),
                ];
                for (input, expected) in some.iter().zip(complex_step(&system, &inputs, Settings::default(), &some)?) {
                    let difference = (input.in_gradient(&found) - expected).abs();
                    assert!(difference < 1e-10 * expected.abs().max(1e-3), "{n} {branches} {input:?}: {difference}");
                }
            }
        }
    }
    Ok(())
}

#[test]
fn a_tree_of_bodies_as_one_energy_is_the_sum_of_its_bodies() -> Result<(), Error> {
    let [one, many] = [true, false].map(|is_one| gradient_of(&relative::tree(30, is_one).compile().expect("a scene")));
    let (one, many) = (one?, many?);
    assert!((one.value - many.value).abs() < 1e-11 * one.value, "{} {}", one.value, many.value);
    assert!((&one.design - &many.design).norm() < 1e-9 * one.design.norm(), "{} {}", one.design, many.design);
    Ok(())
}

#[test]
fn a_spatial_arm_is_the_same_by_lists_and_by_a_fixed_length() -> Result<(), Error> {
    let [lists, fixed] = [true, false].map(|by_lists| relative::arm(by_lists).compile().expect("a scene"));
    let (found, same) = (gradient_of(&lists)?, gradient_of(&fixed)?);
    assert_eq!((found.value, &found.controls, &found.start), (same.value, &same.controls, &same.start));
    let some = [Input::Control { channel: 0, node: 3 }, Input::Control { channel: 6, node: 20 }, Input::Coordinate(2)];
    for (input, expected) in some.iter().zip(complex_step(&lists, &inputs(&lists), Settings::default(), &some)?) {
        let difference = (input.in_gradient(&found) - expected).abs();
        assert!(difference < 1e-10 * expected.abs().max(1e-3), "{input:?}: {difference}");
    }
    Ok(())
}

/// Reads a constant that it does not have.
struct TooFar;

impl ListPotentialEnergy for TooFar {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], _t: S) -> S {
        q[0] * b[7]
    }
}

#[test]
fn a_formula_that_panics_is_named_before_a_motion_begins() -> Result<(), Error> {
    for compile in [Scene::compile, Scene::compile_without_programs] {
        let mut scene = scene(3, true, false);
        let q = scene.list_coordinates("more", &["x"]);
        scene.list_kinetic_energy("more", Chain { branches: false }, &q, &[1.0.into(), 0.0.into()]);
        scene.list_potential_energy("index too large", TooFar, &q, &[1.0.into()]);
        let error = gradient_of(&compile(scene)?).expect_err("a panic");
        assert!(matches!(&error, Error::Panics { element, .. } if element == "index too large"), "{error}");
    }
    Ok(())
}
