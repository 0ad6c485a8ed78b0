//! Gradients and products with the Hessian beside complex step and hyper-dual numbers.

use hamiltonian_adjoint::check::{Input, Random};
use hamiltonian_adjoint::spatial::{MarkerFunction, MarkerPoint};
use hamiltonian_adjoint::{
    Cx, Error, Gradient, Grid, Hyper, Inputs, LiftedSolver, LongSolver, Mechanics, Real, Scalar, Settings, Solver, System,
    Warning,
};
use nalgebra::DMatrix;

use super::build::build;
use super::plan::plan;
use super::{TREES, Tally, cases, inputs, seeds};

/// Sums of derivatives of one kind that are smaller than this share of all together are compared with it.
const SHARE: f64 = 1e-2;
/// Rounding along a motion may exceed the largest change by some changes of the last digits at its start by this factor …
const SPREAD: f64 = 4.0;
/// … of this number.
const TRIALS: u64 = 12;
/// Step of the complex step.
const STEP: f64 = 1e-30;

/// A function of everything a marker has; also of its accelerations if it reads them.
pub struct Mixed {
    pub reads_accelerations: bool,
}

impl MarkerFunction for Mixed {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        let of = &at.markers[0];
        let dot = |a: [S; 3], b: [S; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let controls = at.u.iter().fold(S::from(0.0), |sum, u| sum + *u * *u * at.t);
        let smooth = dot(of.position, of.position) * 0.5
            + dot(of.velocity, of.angular_velocity)
            + of.axes[0][1] * of.axes[1][2]
            + dot(of.velocity, of.axes[2])
            + controls;
        match self.reads_accelerations {
            true => smooth + dot(of.acceleration, of.position) * 0.1 + dot(of.angular_acceleration, of.axes[1]) * 0.1,
            false => smooth,
        }
    }
}

type Belongs = fn(&Input) -> bool;

/// The kinds of input, which a direction moves together.
const KINDS: [(&str, Belongs); 5] = [
    ("controls", |input| matches!(input, Input::Control { .. })),
    ("design variables", |input| matches!(input, Input::Design(_))),
    ("q0", |input| matches!(input, Input::Coordinate(_))),
    ("v0", |input| matches!(input, Input::Rate(_))),
    ("step lengths", |input| matches!(input, Input::Step(_))),
];

/// A derivative along a direction, that by complex step or hyper-dual numbers, and the size of its terms.
struct Pair {
    name: &'static str,
    ours: f64,
    other: f64,
    size: f64,
    bound: f64,
}

impl Pair {
    fn error(&self) -> f64 {
        if self.ours == self.other { 0.0 } else { (self.ours - self.other).abs() / self.size }
    }
}

/// The directions of derivatives, and whether they include products with the Hessian.
struct Directions {
    all: Vec<Input>,
    along: [Inputs; 2],
    products: bool,
}

impl Directions {
    /// Sum of g·d over inputs, and of the sizes of its terms.
    fn sum(&mut self, gradient: &Gradient, which: usize, belongs: Belongs) -> (f64, f64) {
        let Directions { all, along, .. } = self;
        let terms = all.iter().filter(|input| belongs(input));
        terms.map(|input| input.in_gradient(gradient) * *input.of(&mut along[which])).fold(
            (0.0, 0.0),
            |(sum, size), term| {
                let (sum, size): (f64, f64) = (sum, size);
                (sum + term, size + term.abs())
            },
        )
    }

    /// All derivatives of a motion.
    fn pairs(&mut self, system: &System, inputs: &Inputs) -> Result<Vec<Pair>, Error> {
        let settings = Settings::default();
        let mut solver = Solver::new(system, settings);
        solver.simulate(inputs)?;
        let gradient = solver.gradient()?.clone();
        let (_, whole) = self.sum(&gradient, 0, |_| true);
        let mut lifted = LiftedSolver::<Cx>::new(system, inputs, settings)?;
        let mut pairs = Vec::new();
        for (name, belongs) in KINDS {
            let (mut moved, (ours, size)) = (inputs.lift::<Cx>(), self.sum(&gradient, 0, belongs));
            for input in self.all.iter().filter(|input| belongs(input)) {
                *input.of(&mut moved) += Cx::new(0.0, *input.of(&mut self.along[0]) * STEP);
            }
            lifted.simulate(&moved)?;
            let size = size.max(SHARE * whole);
            pairs.push(Pair { name, ours, other: lifted.cost()?.0.im / STEP, size, bound: 1e-11 });
        }
        if self.products {
            let product = solver.hessian_product(&self.along[0])?.clone();
            let mut lifted = LiftedSolver::<Hyper>::new(system, inputs, settings)?;
            let mut moved = inputs.lift::<Hyper>();
            for (part, direction) in (1..).zip(&mut self.along) {
                self.all.iter().for_each(|input| input.of(&mut moved).add_to_part(part, *input.of(direction)));
            }
            lifted.simulate(&moved)?;
            let (ours, size) = self.sum(&product, 1, |_| true);
            let (other, size) = (lifted.cost()?.part(3), size.max(1e-3));
            pairs.push(Pair { name: "product with the Hessian", ours, other, size, bound: 1e-10 });
        }
        Ok(pairs)
    }

    /// The most by which each difference changes if coordinates and velocities at the start change in their last digit.
    fn noise(&mut self, system: &System, inputs: &Inputs, pairs: &[Pair]) -> Result<Vec<f64>, Error> {
        let mut noise = vec![0.0f64; pairs.len()];
        for seed in 0..TRIALS {
            let (mut random, mut moved) = (Random::new(seed), inputs.clone());
            for input in self.all.iter().filter(|input| matches!(input, Input::Coordinate(_) | Input::Rate(_))) {
                *input.of(&mut moved) *= 1.0 + (random.below(3) as f64 - 1.0) * f64::EPSILON;
            }
            for ((noise, before), now) in noise.iter_mut().zip(pairs).zip(self.pairs(system, &moved)?) {
                *noise = noise.max(((now.ours - before.ours).abs() + (now.other - before.other).abs()) / before.size);
            }
        }
        Ok(noise)
    }
}

/// The smallest eigenvalue, at any node of a motion, of the mass matrix on the velocities that constraints allow, in units in which its diagonal is 1.
pub fn least_inertia(system: &System, inputs: &Inputs) -> Result<f64, Error> {
    let mut solver = Solver::new(system, Settings::default());
    solver.simulate(inputs)?;
    let mut least = 1.0f64;
    for node in 0..solver.trajectory().computed {
        let here = Mechanics::at_node(system, solver.inputs(), solver.trajectory(), node)?;
        let (mass, phi_q, n) = (here.mass(), here.phi_q(), system.n());
        let unit: Vec<f64> = (0..n).map(|i| if mass[(i, i)] > 0.0 { mass[(i, i)].sqrt().recip() } else { 1.0 }).collect();
        let rows = DMatrix::from_fn(system.m().max(n), n, |j, i| if j < system.m() { phi_q[(j, i)] * unit[i] } else { 0.0 });
        let svd = rows.svd(false, true);
        let Some(directions) = svd.v_t else { continue };
        let largest = svd.singular_values.max();
        let free: Vec<usize> = (0..n).filter(|&k| svd.singular_values[k] <= 1e-7 * largest).collect();
        let free = directions.select_rows(&free).transpose();
        let scaled = DMatrix::from_fn(n, n, |i, j| mass[(i, j)] * unit[i] * unit[j]);
        least = least.min((free.transpose() * scaled * free).symmetric_eigenvalues().min());
    }
    Ok(least)
}

/// What rounding makes of the smallest inertia.
pub fn rounding_of(inertia: f64) -> f64 {
    f64::EPSILON / (inertia * SHARE)
}

/// Asserts that gradients are those of complex step and of a motion with checkpoints, and products with the Hessian those of hyper-dual numbers, without
/// the design variables of which a change makes dependent constraints contradict each other, as the library warns.
///
/// Differences beyond the usual rounding must be within what one change of the last digit at the start makes of them, and within what rounding makes of the
/// smallest inertia λ of the scene, ε/λ: in the mass matrix AᵀA of rates A it is a difference of terms of order 1.
pub fn compare_derivatives(
    tally: &mut Tally,
    system: &System,
    inputs: &Inputs,
    reads_accelerations: bool,
) -> Result<(), Error> {
    let settings = Settings::default();
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    let broken = |input: &Input| match input {
        Input::Design(b) => solver.report().warnings.iter().any(|warning| match warning {
            Warning::BrokenDependence { designs, .. } => designs.iter().any(|name| name == system.design_name(*b)),
            _ => false,
        }),
        _ => false,
    };
    let all: Vec<Input> = Input::all(inputs).into_iter().filter(|input| !broken(input)).collect();
    let mut random = Random::new(tally.seed);
    let mut along = [inputs.no_change(), inputs.no_change()];
    for direction in &mut along {
        for input in &all {
            *input.of(direction) = random.away_from_zero(if matches!(input, Input::Step(_)) { 0.01 } else { 1.0 });
        }
    }
    let mut directions = Directions { all, along, products: !reads_accelerations };
    let pairs = directions.pairs(system, inputs)?;
    let mut bounds: Vec<f64> = pairs.iter().map(|pair| pair.bound).collect();
    if pairs.iter().any(|pair| pair.error() > pair.bound) {
        let (noise, inertia) = (directions.noise(system, inputs, &pairs)?, least_inertia(system, inputs)?);
        let of_inertia = rounding_of(inertia);
        for ((pair, bound), noise) in pairs.iter().zip(&mut bounds).zip(noise) {
            *bound = bound.max(of_inertia.min(SPREAD * noise));
            let (seed, name, error) = (tally.seed, pair.name, pair.error());
            println!("seed {seed}: {name}: {error:.1e}, noise {noise:.1e}, ε/λ {:.1e}", f64::EPSILON / inertia);
        }
        tally.count("with less exact derivatives, because of the smallest inertia");
    }
    for (pair, bound) in pairs.iter().zip(bounds) {
        tally.note(&format!("derivative, {}", pair.name), pair.error(), bound);
    }
    let gradient = solver.gradient()?.clone();
    let nodes = inputs.grid.nodes();
    let most = nodes * (system.bytes_per_node(&settings) + 16 * (1 + system.k()) + 60);
    for bytes in [most / 2, most, 4 * most] {
        match LongSolver::new(system, settings, bytes).gradient(inputs) {
            Ok(long) => {
                assert!(*long == gradient, "seed {}: another gradient within {bytes} bytes", tally.seed);
                tally.count("from checkpoints");
            }
            Err(Error::Memory { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    if !reads_accelerations {
        tally.count("products");
    }
    Ok(())
}

/// Inputs for the longest of some steps that resolves the motion.
///
/// A torque on a massless body whose axes differ by 1e-3 turns it with 1e4 rad/s²: there, as the library warns, steps of 0.01 s are too long.
fn resolved(tally: &mut Tally, system: &System, inputs: impl Fn(f64) -> Inputs) -> Result<Inputs, Error> {
    let mut solver = Solver::new(system, Settings::default());
    for length in [1e-2, 1e-3, 1e-4] {
        let inputs = inputs(length);
        match solver.simulate(&inputs).map(|_| ()) {
            Ok(()) => return Ok(inputs),
            Err(Error::Newton { .. }) if solver.report().warnings.iter().any(|w| matches!(w, Warning::Rough { .. })) => {
                tally.count("shorter steps, as warned");
            }
            Err(error) => return Err(error),
        }
    }
    Ok(inputs(1e-5))
}

fn differentiate_one(tally: &mut Tally, seed: u64) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let plan = plan(&mut random, TREES);
    let mut built = build(&plan, &mut random);
    let reads_accelerations = seed.is_multiple_of(3);
    built.cost(|| Mixed { reads_accelerations });
    let system = built.scene.clone().compile()?;
    let inputs = resolved(tally, &system, |length| inputs(&system, &built, Grid::uniform(8, length)))?;
    compare_derivatives(tally, &system, &inputs, reads_accelerations)?;
    tally.count("compared");
    Ok(())
}

#[test]
fn derivatives_of_random_trees_are_exact() {
    let mut tally = Tally::default();
    for seed in seeds(1000, cases() / 2) {
        tally.begin(seed);
        if let Err(error) = differentiate_one(&mut tally, seed) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("derivatives of random trees");
    assert!(tally.of("compared") as f64 >= 0.45 * cases() as f64);
}
