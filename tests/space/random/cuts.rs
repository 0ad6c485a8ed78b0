//! Trees that are cut at one body beside whole ones.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Error, Grid, Inputs, Mechanics, Settings, Solver};

use super::build::{Built, build};
use super::derivatives::{least_inertia, rounding_of};
use super::plan::{Plan, plan};
use super::{TREES, Tally, cases, controls, relative, seeds};

/// Of all coordinates but those of the cut.
struct Moved {
    accelerations: Vec<f64>,
    /// After a few steps.
    velocities: Vec<f64>,
    least_inertia: f64,
}

fn move_from_rest(plan: &Plan, place: &Built) -> Result<Moved, Error> {
    let mut built = build(plan, &mut Random::new(0));
    for (own, of) in built.own.iter().zip(&place.own) {
        built.scene.place(*own, place.q[of.index()]);
    }
    let system = built.scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4, 1e-4));
    let u = controls(system.k());
    inputs.controls.column_iter_mut().for_each(|mut column| column.copy_from_slice(&u));
    let at_rest = Mechanics::at_start(&system, &inputs)?.accelerations()?.0;
    let mut solver = Solver::new(&system, Settings::default());
    let last = solver.simulate(&inputs)?.v.column(4).into_owned();
    let of_own = |all: &[f64]| built.own.iter().map(|own| all[own.index()]).collect();
    let least_inertia = least_inertia(&system, &inputs)?;
    Ok(Moved { accelerations: of_own(at_rest.as_slice()), velocities: of_own(last.as_slice()), least_inertia })
}

fn compare_one(tally: &mut Tally, seed: u64) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let mut plan = plan(&mut random, TREES);
    let place = build(&plan, &mut random);
    let whole = move_from_rest(&plan, &place)?;
    plan.cuts = vec![random.below(plan.links.len())];
    let cut = move_from_rest(&plan, &place)?;
    let bound = rounding_of(whole.least_inertia).max(1e-11);
    tally.note("accelerations", relative(&cut.accelerations, &whole.accelerations), bound);
    // The motions differ by the error of the scheme.
    tally.note("velocities", relative(&cut.velocities, &whole.velocities), 1e-6);
    tally.count("compared");
    Ok(())
}

#[test]
fn random_trees_that_are_cut_move_like_whole_ones() {
    let mut tally = Tally::default();
    for seed in seeds(5000, cases()) {
        tally.begin(seed);
        if let Err(error) = compare_one(&mut tally, seed) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("random trees that are cut");
    assert!(tally.of("compared") as f64 >= 0.7 * cases() as f64);
}
