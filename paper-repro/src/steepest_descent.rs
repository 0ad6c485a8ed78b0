//! Steepest descent u ← u − α ∇J(u) with a backtracking line search (section 4; Nocedal and Wright, Algorithm 3.1).

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::Problem;

use crate::flags::{positive, share, shortening};
use crate::statistics::largest;

/// Line search: the step length is the first of α, ρα, ρ²α, … with J(u − αg) ≤ J(u) − c α gᵀg.
#[derive(clap::Args, Clone, Copy, Debug, PartialEq)]
pub struct LineSearch {
    /// First step length α that each line search tries (assumed)
    #[arg(long = "alpha", value_name = "ALPHA", default_value_t = Self::USUAL.first, value_parser = positive, allow_hyphen_values = true)]
    pub first: f64,
    /// Fraction c of the decrease predicted by the slope that a step must achieve, J(u − αg) ≤ J(u) − c α gᵀg (assumed)
    #[arg(long, value_name = "SHARE", default_value_t = Self::USUAL.armijo, value_parser = share, allow_hyphen_values = true)]
    pub armijo: f64,
    /// Factor by which a rejected step is shortened, at most 0.99 (assumed)
    #[arg(long = "backtrack", value_name = "FACTOR", default_value_t = Self::USUAL.shorten, value_parser = shortening, allow_hyphen_values = true)]
    pub shorten: f64,
}

impl LineSearch {
    /// The default, found by trial: with many other values the descent ends in a valley in which J does not reach 0.
    pub const USUAL: Self = LineSearch { first: 2000.0, armijo: 1e-4, shorten: 0.5 };
}

/// The line search ends at steps shorter than this fraction of the first one: J has no lower value within rounding.
const SHORTEST: f64 = 1e-18;

/// One point of the descent.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    pub u: Vec<f64>,
    pub cost: f64,
    /// ‖∇J‖∞.
    pub gradient: f64,
    /// The step length that led to this point; 0 at the start.
    pub step: f64,
    /// Number of values of J that the line search evaluated for this point.
    pub trials: usize,
}

/// Performs the given number of iterations, or fewer if the line search finds no lower value; returns the start and all iterates.
///
/// A trial that cannot be evaluated counts as infinitely costly. `progress` is called with every iterate.
pub fn minimise(
    problem: &mut impl Problem,
    start: Vec<f64>,
    search: &LineSearch,
    iterations: usize,
    mut progress: impl FnMut(&Iterate),
) -> Result<Vec<Iterate>, Error> {
    let mut history: Vec<Iterate> = Vec::with_capacity(iterations + 1);
    let (cost, mut gradient) = (problem.evaluate(&start, &mut [])?, vec![0.0; start.len()]);
    let mut found = Some(Iterate { cost, u: start, gradient: f64::NAN, step: 0.0, trials: 1 });
    while let Some(mut iterate) = found {
        problem.gradient(1.0, &[], &mut gradient)?;
        iterate.gradient = largest(&gradient);
        progress(&iterate);
        found = if history.len() < iterations { backtrack(problem, &iterate, &gradient, search) } else { None };
        history.push(iterate);
    }
    Ok(history)
}

/// The first point with sufficient decrease, without its gradient; the problem was last evaluated at this point.
fn backtrack(problem: &mut impl Problem, from: &Iterate, gradient: &[f64], search: &LineSearch) -> Option<Iterate> {
    let slope: f64 = gradient.iter().map(|g| g * g).sum();
    let (mut step, mut trials) = (search.first, 0);
    // For a very short first step this limit underflows to 0, and the rounded steps stop shrinking before they reach it.
    while step > (search.first * SHORTEST).max(f64::MIN_POSITIVE) {
        let u: Vec<f64> = from.u.iter().zip(gradient).map(|(u, g)| u - g * step).collect();
        let cost = problem.evaluate(&u, &mut []).unwrap_or(f64::INFINITY);
        trials += 1;
        if cost < from.cost && cost <= from.cost - search.armijo * step * slope {
            return Some(Iterate { u, cost, gradient: f64::NAN, step, trials });
        }
        step *= search.shorten;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// J = ½ Σ w_i (u_i − 1)², undefined beyond |u_i| = 5.
    #[derive(Default)]
    struct Quadratic {
        at: Vec<f64>,
    }

    const WEIGHTS: [f64; 2] = [1.0, 10.0];

    impl Problem for Quadratic {
        fn variables(&self) -> usize {
            WEIGHTS.len()
        }

        fn evaluate(&mut self, u: &[f64], _: &mut [f64]) -> Result<f64, Error> {
            self.at = u.to_vec();
            if u.iter().any(|u| u.abs() > 5.0) {
                return Err(Error::EmptyScene);
            }
            Ok(WEIGHTS.iter().zip(u).map(|(w, u)| 0.5 * w * (u - 1.0) * (u - 1.0)).sum())
        }

        fn gradient(&mut self, _: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
            (0..2).for_each(|i| gradient[i] = WEIGHTS[i] * (self.at[i] - 1.0));
            Ok(())
        }
    }

    const SEARCH: LineSearch = LineSearch { first: 64.0, armijo: 1e-4, shorten: 0.5 };

    fn minimised(start: f64, iterations: usize) -> Result<Vec<Iterate>, Error> {
        minimise(&mut Quadratic::default(), vec![start; 2], &SEARCH, iterations, |_| {})
    }

    #[test]
    fn quadratic_is_minimised() {
        let history = minimised(-3.0, 200).unwrap();
        let last = history.last().unwrap();
        assert!(last.cost < 1e-20 && last.u.iter().all(|u| (u - 1.0).abs() < 1e-9), "{last:?}");
        assert_eq!(history[0].cost, 88.0);
        assert_eq!(history[0].gradient, 40.0);
    }

    #[test]
    fn every_step_decreases_enough() {
        let mut seen = 0;
        let history = minimise(&mut Quadratic::default(), vec![-3.0; 2], &SEARCH, 20, |_| seen += 1).unwrap();
        assert_eq!((seen, history.len()), (21, 21));
        for pair in history.windows(2) {
            let slope: f64 = WEIGHTS.iter().zip(&pair[0].u).map(|(w, u)| (w * (u - 1.0)).powi(2)).sum();
            assert!(pair[1].cost <= pair[0].cost - SEARCH.armijo * pair[1].step * slope);
            // The preceding step, twice as long, was rejected.
            assert_eq!(pair[1].step, SEARCH.first * 0.5f64.powi(pair[1].trials as i32 - 1));
        }
    }

    #[test]
    fn descent_ends_where_nothing_is_lower() {
        assert_eq!(minimised(1.0, 20).unwrap().len(), 1);
        assert_eq!(minimised(9.0, 20), Err(Error::EmptyScene));
    }

    #[test]
    fn the_shortest_first_steps_are_given_up_too() {
        let search = LineSearch { first: 1e-305, shorten: 0.9, ..SEARCH };
        let history = minimise(&mut Quadratic::default(), vec![-3.0; 2], &search, 20, |_| {}).unwrap();
        assert_eq!(history.len(), 1);
    }
}
