//! Elements on many coordinates fit into the stack of a thread, with a program or without.

use super::Squares;
use hamiltonian_adjoint::{
    Constraint, Coordinate, Gradient, Grid, Inputs, KineticEnergy, PotentialEnergy, Scalar, Scene, Settings, Solver, Sum,
    System,
};
use nalgebra::SVector;

const N: usize = 64;

/// A ring of masses whose springs stiffen as they turn, on a sphere of N dimensions.
struct Ring;

impl KineticEnergy<N, 0> for Ring {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, N>, v: &SVector<S, N>, _: &SVector<S, 0>) -> S {
        (0..N).map(|i| v[i] * v[i] * (q[(i + 1) % N].cos() * 0.3 + 1.0) * 0.5).sum()
    }
}

impl PotentialEnergy<N, 0> for Ring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, N>, _: &SVector<S, 0>, _: S) -> S {
        let stretch = |i: usize| q[i] - q[(i + 1) % N] - 0.1;
        (0..N).map(|i| stretch(i) * stretch(i) * (q[i].sin() * 0.1 + 1.0)).sum()
    }
}

impl Constraint<N, 1, 0> for Ring {
    fn phi<S: Scalar>(&self, q: &SVector<S, N>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([(0..N).map(|i| q[i] * q[i]).sum::<S>() - 0.04 * N as f64])
    }
}

#[test]
fn an_element_on_64_coordinates_fits_into_the_stack_of_a_thread() {
    let found = [Scene::compile, Scene::compile_without_programs].map(|compile| {
        let mut scene = Scene::new();
        let names: [String; N] = std::array::from_fn(|i| format!("x{i}"));
        let all: [Coordinate; N] = scene.coordinates("ring", std::array::from_fn(|i| names[i].as_str()));
        all.iter().for_each(|q| scene.place(*q, 0.2));
        scene.kinetic_energy("masses", Ring, all, []);
        scene.potential_energy("springs", Ring, all, []);
        scene.constraint("sphere", Ring, all, []);
        scene.cost("place", Squares, Sum::Terminal, [all[0]], [], [], []);
        let system: System = compile(scene).expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(2, 0.02));
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        let gradient = solver.gradient().expect("a gradient").clone();
        let mut push = inputs.no_change();
        push.start.rate_mut().fill(0.1);
        (gradient, solver.hessian_product(&push).expect("a product").clone())
    });
    let [(with, product), (without, expected)] = found;
    let difference = |a: &Gradient, b: &Gradient| (a.start.q() - b.start.q()).amax() / b.start.q().amax();
    assert!(difference(&with, &without) < 1e-11 && difference(&product, &expected) < 1e-10);
}
