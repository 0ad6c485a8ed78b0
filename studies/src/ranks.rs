//! A study over the ranks of MPI: rank 0 hands out starts and keeps the file, the others compute.
//!
//! A worker asks by sending what it has finished (an empty message at first); the answer is the number of its next start, or that there is none. So
//! ranks take work as they get free, and what is found does not depend on how many there are. A line of the file is one outcome; a run that
//! is lost loses the starts that were being computed, and the next run goes on with the rest.

use hamiltonian_adjoint::optimize::{Outcome, Problem};
use hamiltonian_adjoint::{Error, Finished, Study};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Source};

/// What a worker is told when there is nothing left.
const NO_MORE: u64 = u64::MAX;

/// What rank 0 does. With a single rank it computes by itself.
///
/// # Errors
/// A file that cannot be written any more, a message that is no outcome; the workers are told to end first.
pub fn lead<P: Problem>(
    world: &SimpleCommunicator,
    study: &mut Study,
    problem: impl Fn() -> Result<P, Error> + Sync,
    method: impl Fn(&mut P, &[f64]) -> Result<Outcome, Error> + Sync,
) -> Result<(), Error> {
    if world.size() == 1 {
        return study.run(problem, method);
    }
    let missing: Vec<usize> = study.missing().collect();
    let (mut next, mut working, mut wrong) = (missing.into_iter(), world.size() - 1, Ok(()));
    while working > 0 {
        let (message, status) = world.any_process().receive_vec::<u8>();
        if !message.is_empty() && wrong.is_ok() {
            let finished = String::from_utf8_lossy(&message);
            wrong = Finished::from_json(&finished).and_then(|of| study.add(of));
        }
        let start = if wrong.is_ok() { next.next() } else { None };
        working -= i32::from(start.is_none());
        let told = start.map_or(NO_MORE, |start| start as u64);
        world.process_at_rank(status.source_rank()).send(&told);
    }
    wrong
}

/// What every other rank does.
pub fn follow<P: Problem>(
    world: &SimpleCommunicator,
    starts: &[Vec<f64>],
    problem: impl Fn() -> Result<P, Error>,
    method: impl Fn(&mut P, &[f64]) -> Result<Outcome, Error>,
) {
    let (leader, mut own, mut message) = (world.process_at_rank(0), None, Vec::new());
    loop {
        leader.send(&message[..]);
        let (start, _) = leader.receive::<u64>();
        let Some(at) = usize::try_from(start).ok().and_then(|start| starts.get(start)) else { return };
        let made = own.take().map_or_else(&problem, Ok);
        let outcome = made.and_then(|mut made| {
            let outcome = method(&mut made, at);
            own = Some(made);
            outcome
        });
        message = Finished::new(start as usize, &outcome).to_json().into_bytes();
    }
}
