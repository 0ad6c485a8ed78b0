//! Run times on one thread with allocated memory and warm caches: the median over turns of the shortest call in a turn.

use std::time::{Duration, Instant};

use hamiltonian_adjoint::{Error, Inputs, Settings, Solver, System};

use crate::statistics::median;

/// A job whose run time is measured repeatedly.
pub type Job<'a> = Box<dyn FnMut() -> Result<(), Error> + 'a>;

/// One simulation.
pub fn simulation<'a>(system: &System, inputs: &'a Inputs) -> Job<'a> {
    let mut solver = Solver::new(system, Settings::default());
    Box::new(move || solver.simulate(inputs).map(|_| ()))
}

/// One simulation and its gradient by the adjoint.
pub fn value_and_gradient<'a>(system: &System, inputs: &'a Inputs) -> Job<'a> {
    let mut solver = Solver::new(system, Settings::default());
    Box::new(move || {
        solver.simulate(inputs)?;
        solver.gradient().map(|_| ())
    })
}

/// Number and duration of the turns.
///
/// The jobs take turns, so that a temporarily busy machine affects all of them alike. The shortest call of a turn is the one least
/// interrupted by other programs.
#[derive(Clone, Copy, Debug)]
pub struct Repeats {
    pub turns: usize,
    /// A turn is one call that is not timed, followed by at least one timed call until this time has passed.
    pub turn: Duration,
}

impl Repeats {
    /// The median over turns of the shortest call of each job, s.
    pub fn times(self, jobs: &mut [Job]) -> Result<Vec<f64>, Error> {
        let mut times = vec![Vec::new(); jobs.len()];
        for _ in 0..self.turns {
            for (job, times) in jobs.iter_mut().zip(&mut times) {
                job()?;
                let begin = Instant::now();
                let mut shortest = Duration::MAX;
                while shortest == Duration::MAX || begin.elapsed() < self.turn {
                    let start = Instant::now();
                    job()?;
                    shortest = shortest.min(start.elapsed());
                }
                times.push(shortest.as_secs_f64());
            }
        }
        Ok(times.iter().map(|times| median(times)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_take_turns_and_errors_are_handed_on() {
        let repeats = Repeats { turns: 3, turn: Duration::ZERO };
        let calls = std::cell::RefCell::new(String::new());
        let job = |name: char| -> Job {
            let calls = &calls;
            Box::new(move || {
                calls.borrow_mut().push(name);
                std::thread::sleep(Duration::from_micros(1));
                Ok(())
            })
        };
        let times = repeats.times(&mut [job('a'), job('b')]);
        assert!(times.is_ok_and(|times| times.len() == 2 && times.iter().all(|time| *time > 0.0)));
        assert_eq!(*calls.borrow(), "aabbaabbaabb");
        let failing: Job = Box::new(|| Err(Error::TimeStep { step: 1, length: 0.0 }));
        assert!(repeats.times(&mut [failing]).is_err());
    }
}
