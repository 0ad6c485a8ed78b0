//! Energy, momentum and angular momentum of motions without losses.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Error, Grid, Mechanics, Scheme, Settings, Solver, System, Warning};
use nalgebra::Vector3;

use super::build::{Built, build};
use super::chain::Chain;
use super::plan::{Scope, plan};
use super::{TREES, Tally, cases, chain, inputs, seeds};

/// Errors of energy, momentum and angular momentum at the end of a motion, relative to their sizes.
///
/// None if the library warns that the steps are too long: light bodies may spin up to any speed.
fn drift(
    system: &System,
    built: &Built,
    chain: &Chain,
    (steps, scheme): (usize, Scheme),
) -> Result<Option<[f64; 3]>, Error> {
    let inputs = inputs(system, built, Grid::uniform(steps, 0.2 / steps as f64));
    let mut solver = Solver::new(system, Settings { scheme, ..Settings::default() });
    solver.simulate(&inputs)?;
    if solver.report().warnings.iter().any(|warning| matches!(warning, Warning::Rough { .. })) {
        return Ok(None);
    }
    let motion = solver.trajectory();
    let at = |node: usize| -> Result<(f64, [Vector3<f64>; 2]), Error> {
        let column = |of: &nalgebra::DMatrix<f64>| of.column(node).iter().copied().collect::<Vec<f64>>();
        let here = Mechanics::at_node(system, &inputs, motion, node)?;
        Ok((here.energy(), chain.momenta([&column(&motion.q), &column(&motion.v)])))
    };
    let ((energy, first), (end, last)) = (at(0)?, at(motion.last())?);
    let of = |k: usize| (last[k] - first[k]).norm() / (1.0 + first[k].norm());
    Ok(Some([(end - energy).abs() / (1.0 + energy.abs()), of(0), of(1)]))
}

fn conserve_one(tally: &mut Tally, seed: u64, afloat: bool) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let plan = plan(&mut random, Scope { conservative: true, afloat, ..TREES });
    let built = build(&plan, &mut random);
    let system = built.scene.clone().compile()?;
    let chain = chain(&plan, &built, (&plan.designs, &[]));
    let of = |steps, scheme| drift(&system, &built, &chain, (steps, scheme));
    let [Some(coarse), Some(fine), Some(exact)] =
        [of(100, Scheme::TRAPEZOIDAL)?, of(200, Scheme::TRAPEZOIDAL)?, of(200, Scheme::ESDIRK5)?]
    else {
        tally.count("with too long steps, as warned");
        return Ok(());
    };
    for (k, name) in ["energy", "momentum", "angular momentum"].into_iter().enumerate().take(if afloat { 3 } else { 1 }) {
        tally.note(&format!("{name}, order 5"), exact[k], 1e-6);
        if exact[k] < 1e-9 && fine[k] > 1e-9 {
            let order = (coarse[k] / fine[k]).log2();
            tally.note(&format!("{name}: 2 less the order of the trapezoidal rule"), 2.0 - order, 1.0);
            tally.count(&format!("orders of {name}"));
        }
    }
    tally.count("compared");
    Ok(())
}

#[test]
fn energy_and_momenta_of_random_trees_are_conserved() {
    let mut tally = Tally::default();
    for seed in seeds(2000, cases() / 2) {
        tally.begin(seed);
        if let Err(error) = conserve_one(&mut tally, seed, seed % 2 == 0) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("conservation of random trees");
    assert!(tally.of("compared") as f64 >= 0.45 * cases() as f64);
}
