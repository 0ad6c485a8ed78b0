//! The least effort that brings the cart's links upright, from many random starts, over many processes:
//!
//! `mpirun -n 4 target/release/studies FILE [STARTS]`
//!
//! If it is run again with the same file, it continues an interrupted run.

mod ranks;

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::time::Instant;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::optimize::{Free, Interval, MotionProblem, Options, Variables, interior_point, silent};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Settings, Study};
use mpi::traits::Communicator;

const STEPS: usize = 100;
/// N.
const FORCE: f64 = 15.0;

/// Forces that are linear between five random ones.
fn starts(count: usize) -> Vec<Vec<f64>> {
    let mut random = Random::new(7);
    let mut knots = || [(); 5].map(|()| random.uniform(-FORCE, FORCE));
    let line = |knots: [f64; 5]| {
        let at = |i: usize| {
            let place = 4.0 * i as f64 / STEPS as f64;
            let left = (place as usize).min(3);
            knots[left] + (place - left as f64) * (knots[left + 1] - knots[left])
        };
        (0..=STEPS).map(at).collect()
    };
    (0..count).map(|_| line(knots())).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let universe = mpi::initialize().ok_or("MPI has been initialised before")?;
    let world = universe.world();
    let arguments: Vec<String> = std::env::args().collect();
    let count = arguments.get(2).map_or(Ok(40), |text| text.parse::<usize>())?;
    let (file, starts) = (arguments.get(1).ok_or("the first argument must be a file for the outcomes")?, starts(count));

    let mut cart = CartPendulum::default().mechanism();
    let (force, angles) = (cart.force, cart.links.iter().map(|link| link.coordinates[2]).collect::<Vec<_>>());
    let upright: Vec<_> = angles.into_iter().map(|angle| cart.scene.end_state(angle).position).collect();
    cart.scene.effort("effort", force, 1e-4);
    let system = cart.scene.compile()?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, 0.02));
    let problem = || {
        let variables = Variables::new(&system, &inputs, vec![Free::control(force)])?;
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs.clone(), variables)?;
        upright.iter().for_each(|output| problem.constrain(*output, Interval::equal(FRAC_PI_2)));
        Ok(problem)
    };
    let options = Options { stationarity: 1e-5, iterations: 500, ..Options::default() };
    let method = |problem: &mut MotionProblem, start: &[f64]| interior_point(problem, start, &options, &mut silent);

    if world.rank() > 0 {
        ranks::follow(&world, &starts, problem, method);
        return Ok(());
    }
    let begin = Instant::now();
    let run = Study::open(Path::new(file), "upright", &starts).and_then(|mut study| {
        let before = study.finished().count();
        ranks::lead(&world, &mut study, problem, method)?;
        Ok((study, before))
    });
    let (study, before) = match run {
        Ok(run) => run,
        // The other ranks wait for work and cannot be notified.
        Err(error) => {
            eprintln!("error: {error}");
            world.abort(1)
        }
    };
    let (time, converged) = (begin.elapsed().as_secs_f64(), study.finished().filter(|of| of.converged).count());
    let best = study.lowest(1e-9).and_then(|of| of.value).unwrap_or(f64::NAN);
    println!(
        "{} ranks: {} of {count} starts computed in {time:.2} s, {converged} of all converged, the best value is {best:.6}",
        world.size(),
        study.finished().count() - before
    );
    Ok(())
}
