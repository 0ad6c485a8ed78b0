//! Many motions of one system: initial guesses, parameter sets, starts.
//!
//! With the feature `rayon` they are distributed over all cores; each thread reuses one [`Solver`], whose steps allocate nothing after its
//! first motion.

use crate::{Error, Gradient, Inputs, Settings, Solver, System};

/// J and its derivatives for each of the given inputs, in their order. A motion that fails does not stop the others.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, gradients, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let at_rest = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
/// let pushed = |force: f64| {
///     let mut inputs = at_rest.clone();
///     inputs.controls.fill(force);
///     inputs
/// };
/// let guesses: Vec<Inputs> = [5.0, 10.0, 20.0].map(pushed).into();
/// let costs: Vec<f64> = gradients(&system, &guesses, Settings::default()).into_iter().map(|g| g.map(|g| g.value)).collect::<Result<_, _>>()?;
/// assert_eq!(costs.len(), 3);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn gradients(system: &System, inputs: &[Inputs], settings: Settings) -> Vec<Result<Gradient, Error>> {
    let solver = || Solver::new(system, settings);
    let one = |solver: &mut Solver, inputs: &Inputs| {
        solver.simulate(inputs)?;
        solver.gradient().cloned()
    };
    each(inputs, solver, one)
}

/// One worker per thread, created on first use, repeatedly processes the next item, because motions may differ in length.
#[cfg(feature = "rayon")]
pub(crate) fn each<I: Sync, W, T: Send>(
    items: &[I],
    new_worker: impl Fn() -> W + Sync,
    one: impl Fn(&mut W, &I) -> T + Sync,
) -> Vec<T> {
    use rayon::prelude::*;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    let next = AtomicUsize::new(0);
    let take = || Some(next.fetch_add(1, Relaxed)).filter(|&i| i < items.len());
    let work = |_| {
        let mut worker = None;
        let done = std::iter::from_fn(|| take().map(|i| (i, one(worker.get_or_insert_with(&new_worker), &items[i]))));
        done.collect::<Vec<_>>()
    };
    let workers = rayon::current_num_threads().min(items.len());
    let mut done: Vec<(usize, T)> = (0..workers).into_par_iter().with_max_len(1).flat_map_iter(work).collect();
    done.sort_unstable_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(not(feature = "rayon"))]
pub(crate) fn each<I, W, T>(items: &[I], new_worker: impl Fn() -> W, one: impl Fn(&mut W, &I) -> T) -> Vec<T> {
    let mut worker = new_worker();
    items.iter().map(|item| one(&mut worker, item)).collect()
}

/// The results of a function of the index and the item for all items; with the feature `rayon` on all cores.
///
/// # Errors
/// The first error that the function returns; with the feature `rayon`, an interruption rather than any other error.
#[cfg(feature = "rayon")]
pub(crate) fn each_mut<I: Send, T: Send>(
    items: &mut [I],
    one: impl Fn(usize, &mut I) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    use rayon::prelude::*;
    use std::sync::OnceLock;

    // After an interruption, no further item is begun; other errors do not stop the items before.
    let interruption = OnceLock::new();
    let unless_interrupted = |(k, item): (usize, &mut I)| {
        let result = interruption.get().map_or_else(|| one(k, item), |error: &Error| Err(error.clone()));
        if let Err(error @ Error::Interrupted { .. }) = &result {
            interruption.get_or_init(|| error.clone());
        }
        result
    };
    let all: Vec<Result<T, Error>> = items.par_iter_mut().enumerate().map(unless_interrupted).collect();
    interruption.into_inner().map_or_else(|| all.into_iter().collect(), Err)
}

#[cfg(not(feature = "rayon"))]
pub(crate) fn each_mut<I, T>(items: &mut [I], one: impl Fn(usize, &mut I) -> Result<T, Error>) -> Result<Vec<T>, Error> {
    items.iter_mut().enumerate().map(|(k, item)| one(k, item)).collect()
}

#[cfg(all(test, feature = "rayon"))]
mod tests {
    use super::*;
    use crate::{Grid, scenes::CartPendulum};
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
    use std::time::{Duration, Instant};

    #[test]
    fn each_thread_makes_one_solver_and_results_come_in_order() {
        let system = CartPendulum::default().scene().compile().unwrap();
        let motions: Vec<Inputs> = (0..100).map(|i| Inputs::at_rest(&system, Grid::uniform(i % 7, 0.01))).collect();
        let made = AtomicUsize::new(0);
        let new_solver = || {
            made.fetch_add(1, Relaxed);
            Solver::new(&system, Settings::default())
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let steps = pool.install(|| each(&motions, new_solver, |_, inputs| inputs.grid.steps.len()));
        assert_eq!(steps, (0..100).map(|i| i % 7).collect::<Vec<_>>());
        assert!((1..=3).contains(&made.into_inner()));
        assert!(
            pool.install(|| each(&[] as &[Inputs], || Solver::new(&system, Settings::default()), |_: &mut Solver, _| ()))
                .is_empty()
        );
    }

    #[test]
    fn all_threads_work() {
        let system = CartPendulum::default().scene().compile().unwrap();
        let motions = vec![Inputs::at_rest(&system, Grid::uniform(1, 0.01)); 3];
        let at_work = AtomicUsize::new(0);
        // Each thread waits for the others, but not for ever.
        let wait = |_: &mut Solver, _: &Inputs| {
            at_work.fetch_add(1, Relaxed);
            let start = Instant::now();
            while at_work.load(Relaxed) < 3 && start.elapsed() < Duration::from_secs(20) {
                std::thread::yield_now();
            }
            at_work.load(Relaxed)
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let seen = pool.install(|| each(&motions, || Solver::new(&system, Settings::default()), wait));
        assert_eq!(seen, [3; 3]);
    }
}
