//! Gradients and products with the Hessian beside complex step and hyper-dual numbers.

use hamiltonian_adjoint::check::{Input, Random};
use hamiltonian_adjoint::spatial::{MarkerFunction, MarkerPoint};
use hamiltonian_adjoint::{
    Cx, Error, Gradient, Grid, Hyper, Inputs, LiftedSolver, LongSolver, Real, Scalar, Settings, Solver, System,
};

use super::build::build;
use super::plan::plan;
use super::{TREES, Tally, cases, inputs};

/// Sums of derivatives of one kind that are smaller than this share of all together are compared with it.
const SHARE: f64 = 1e-2;
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

/// Asserts that gradients are those of complex step and of a motion with checkpoints, and products with the Hessian those of hyper-dual numbers.
pub fn compare_derivatives(
    tally: &mut Tally,
    system: &System,
    inputs: &Inputs,
    reads_accelerations: bool,
) -> Result<(), Error> {
    let settings = Settings::default();
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    let gradient = solver.gradient()?.clone();
    tally.allow_for(solver.report());
    // Derivatives that are small are compared with this share of all.
    tally.rounding /= SHARE;
    let all = Input::all(inputs);
    let mut random = Random::new(tally.seed);
    let mut directions = [inputs.no_change(), inputs.no_change()];
    for direction in &mut directions {
        for input in &all {
            *input.of(direction) = random.away_from_zero(if matches!(input, Input::Step(_)) { 0.01 } else { 1.0 });
        }
    }
    let along = |gradient: &Gradient, direction: &mut Inputs, belongs: &dyn Fn(&Input) -> bool| {
        let terms =
            all.iter().filter(|input| belongs(input)).map(|input| input.in_gradient(gradient) * *input.of(direction));
        terms.fold((0.0, 0.0), |(sum, size): (f64, f64), term| (sum + term, size + term.abs()))
    };
    let (_, whole) = along(&gradient, &mut directions[0], &|_| true);
    let mut lifted = LiftedSolver::<Cx>::new(system, inputs, settings)?;
    for (name, belongs) in KINDS {
        let mut moved = inputs.lift::<Cx>();
        for input in all.iter().filter(|input| belongs(input)) {
            *input.of(&mut moved) += Cx::new(0.0, *input.of(&mut directions[0]) * STEP);
        }
        lifted.simulate(&moved)?;
        let (sum, size) = along(&gradient, &mut directions[0], &belongs);
        let error = (sum - lifted.cost()?.0.im / STEP).abs() / size.max(SHARE * whole);
        tally.note(&format!("gradient, {name}"), if size == 0.0 { 0.0 } else { error }, 1e-11);
    }
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
    if reads_accelerations {
        return Ok(());
    }
    let product = solver.hessian_product(&directions[0])?.clone();
    let mut lifted = LiftedSolver::<Hyper>::new(system, inputs, settings)?;
    let mut moved = inputs.lift::<Hyper>();
    for (part, direction) in (1..).zip(&mut directions) {
        all.iter().for_each(|input| input.of(&mut moved).add_to_part(part, *input.of(direction)));
    }
    lifted.simulate(&moved)?;
    let (sum, size) = along(&product, &mut directions[1], &|_| true);
    tally.note("product with the Hessian", (sum - lifted.cost()?.part(3)).abs() / size.max(1e-3), 1e-10);
    tally.count("products");
    Ok(())
}

fn differentiate_one(tally: &mut Tally, seed: u64) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let plan = plan(&mut random, TREES);
    let mut built = build(&plan, &mut random);
    let reads_accelerations = seed.is_multiple_of(3);
    built.cost(|| Mixed { reads_accelerations });
    let system = built.scene.clone().compile()?;
    compare_derivatives(tally, &system, &inputs(&system, &built, Grid::uniform(8, 0.01)), reads_accelerations)?;
    tally.count("compared");
    Ok(())
}

#[test]
fn derivatives_of_random_trees_are_exact() {
    let mut tally = Tally::default();
    for seed in 1000..1000 + cases() / 2 {
        tally.begin(seed);
        if let Err(error) = differentiate_one(&mut tally, seed) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("derivatives of random trees");
    assert!(tally.of("compared") as f64 >= 0.45 * cases() as f64);
}
