//! Formulas of many thousand operations within each other: nothing overflows a stack that is much smaller than they are deep.

use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Sum,
};
use nalgebra::SVector;

const DEPTH: usize = 20_000;
/// In bytes: some 25 for each operation.
const STACK: usize = 1 << 19;

struct Masses;
impl KineticEnergy<2> for Masses {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
        v.dot(v) * 0.5
    }
}

#[derive(Clone, Copy, Debug)]
enum Deep {
    /// Σ sin(x + k/1000) − Σ sin(k/1000).
    Sines,
    /// sin(x + 1/1000 + 2/1000 + …) − sin(1/1000 + …).
    Angle,
    /// sin(sin(… x)).
    Nested,
    /// x (1 + x/10⁶) (1 + x/10⁶) ….
    Product,
}

impl Deep {
    fn of<S: Scalar>(self, x: S) -> S {
        let each = |k: usize| k as f64 * 1e-3;
        let all = 0..DEPTH;
        match self {
            Deep::Sines => all.fold(S::zero(), |sum, k| sum + (x + each(k)).sin() - each(k).sin()),
            Deep::Angle => {
                let sum = (0..DEPTH).map(each).fold(0.0, |sum, x| sum + x);
                all.fold(x, |sum, k| sum + each(k)).sin() - sum.sin()
            }
            Deep::Nested => all.fold(x, |y, _| y.sin()),
            Deep::Product => all.fold(x, |y, _| y * (x * 1e-6 + 1.0)),
        }
    }
}

impl Constraint<2, 1> for Deep {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, _b: &SVector<S, 0>, _t: S) -> SVector<S, 1> {
        SVector::from([self.of(q[0]) * 1e-3 + q[1]])
    }
}

impl Force<2> for Deep {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, _b: &SVector<S, 0>) -> SVector<S, 2> {
        SVector::from([self.of(at.q[0]), S::zero()])
    }
}

impl Cost<2> for Deep {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        self.of(at.q[0])
    }
}

/// Compiles a scene, moves it by a step and differentiates the motion.
fn differentiate(deep: Deep, add: fn(&mut Scene, Deep, [hamiltonian_adjoint::Coordinate; 2])) {
    let run = move || {
        let mut scene = Scene::new();
        let q = scene.coordinates("masses", ["x", "y"]);
        scene.kinetic_energy("masses", Masses, q, []);
        add(&mut scene, deep, q);
        let system = scene.compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(1, 1e-3));
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).unwrap_or_else(|error| panic!("{deep:?}: {error}"));
        solver.gradient().unwrap_or_else(|error| panic!("{deep:?}: {error}"));
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(run).expect("a thread");
    thread.join().unwrap_or_else(|_| panic!("{deep:?}"));
}

#[test]
fn formulas_that_are_deeper_than_the_stack_compile_and_have_derivatives() {
    for deep in [Deep::Sines, Deep::Angle] {
        differentiate(deep, |scene, deep, q| {
            scene.constraint("deep", deep, q, []);
        });
    }
    for deep in [Deep::Sines, Deep::Nested, Deep::Product] {
        differentiate(deep, |scene, deep, q| scene.force("deep", deep, q, [], []));
        differentiate(deep, |scene, deep, q| scene.cost("deep", deep, Sum::Terminal, q, [], [], []));
    }
}
