//! Loops that are closed where the bodies are at the start.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Error, Grid, Mechanics, Settings, Solver, Start};
use num_dual::Dual2_64;

use super::build::build;
use super::derivatives::{Mixed, compare_derivatives};
use super::plan::{Scope, plan};
use super::{TREES, Tally, cases, chain, compare_mechanics, controls, inputs, seeds};

pub const LOOPS: Scope = Scope { loops: true, ..TREES };

fn close_one(tally: &mut Tally, seed: u64) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let plan = plan(&mut random, LOOPS);
    let mut built = build(&plan, &mut random);
    built.cost(|| Mixed { reads_accelerations: false });
    let system = built.scene.clone().compile()?;
    if system.m() == 0 || system.n() <= system.m() {
        tally.count("locked or without loops");
        return Ok(());
    }
    let mut inputs = inputs(&system, &built, Grid::uniform(8, 0.005));
    inputs.start = Start::assembled(&system).hold(&built.simple[..random.below(2).min(built.simple.len())]);
    // A guess that is a little off.
    let guess = built.q.iter().map(|q| q + 1e-3 * random.uniform(-1.0, 1.0));
    inputs.start.q_mut().iter_mut().zip(guess).for_each(|(q, guess)| *q = guess);
    inputs.start.rate_mut().copy_from_slice(&built.v);
    let u = controls(system.k());
    let here = Mechanics::at_start(&system, &inputs)?;
    let assembled = Solver::new(&system, Settings::default()).assemble(&inputs)?;
    let state = [assembled.start.q().as_slice(), assembled.start.rate().as_slice()];
    let chain = chain(&plan, &built, (&plan.designs, &u));
    let is_dependent = here.phi_q().rank(1e-7) < system.m();
    for phi in chain.phi(&|i| Dual2_64::new(state[0][i], state[1][i], 0.0)) {
        tally.note("loops are closed", phi.re.abs(), if is_dependent { 1e-9 } else { 1e-12 });
        tally.note("loops stay closed", phi.v1.abs() / (1.0 + crate::common::largest(state[1])), 1e-9);
    }
    compare_mechanics(tally, &here, &chain, &built, state)?;
    compare_derivatives(tally, &system, &inputs, false)?;
    tally.count(if is_dependent { "compared, dependent" } else { "compared" });
    Ok(())
}

#[test]
fn random_loops_are_closed_and_their_derivatives_exact() {
    let mut tally = Tally::default();
    for seed in seeds(3000, cases()) {
        tally.begin(seed);
        if let Err(error) = close_one(&mut tally, seed) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("random loops");
    assert!(tally.of("compared") as f64 >= 0.25 * cases() as f64);
}
