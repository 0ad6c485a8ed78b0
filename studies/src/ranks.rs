//! A study over the ranks of MPI: rank 0 hands out starts and keeps the file, the others compute.
//!
//! A worker requests work by sending its finished outcome (at first an empty message); the answer is the number of its next start, or the message that
//! none is left. Outcomes therefore do not depend on the number of ranks. A line of the file is one outcome; an interrupted run loses only the starts
//! being computed, and the next run continues with the rest.

use hamiltonian_adjoint::optimize::{Outcome, Problem};
use hamiltonian_adjoint::{Error, Finished, Study};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, Destination, Source};

/// Answer to a worker if no start is left.
const NO_MORE: u64 = u64::MAX;

/// The work of rank 0. A single rank also computes the starts itself.
///
/// # Errors
/// The file cannot be written, or a message is not an outcome; the workers are stopped first.
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

/// The work of every other rank.
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
