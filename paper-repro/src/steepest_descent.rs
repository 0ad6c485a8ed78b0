//! Steepest descent u ← u − α ∇J(u) with a backtracking line search (section 4; Nocedal and Wright, Algorithm 3.1).

use hamiltonian_adjoint::{Error, Inputs, Solver};
use nalgebra::DMatrix;

/// How the step length is found: the first of α, ρα, ρ²α, … with J(u − αg) ≤ J(u) − c α gᵀg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSearch {
    /// The α that every iteration tries first.
    pub first: f64,
    /// c.
    pub armijo: f64,
    /// ρ.
    pub shorten: f64,
}

/// Steps shorter than this share of the first one are given up: J has no lower value within rounding.
const SHORTEST: f64 = 1e-18;

/// What is minimised.
pub trait Objective {
    /// Why a value could not be had.
    type Error;

    fn value(&mut self, u: &DMatrix<f64>) -> Result<f64, Self::Error>;

    /// ∇J at the u whose value was asked for last.
    fn gradient(&mut self) -> Result<DMatrix<f64>, Self::Error>;
}

/// J as a function of the controls of a motion.
pub struct ControlObjective<'a, 's> {
    /// The solver, which keeps the motion of the last value for its gradient.
    pub solver: &'a mut Solver<'s>,
    /// All inputs; the controls are replaced.
    pub inputs: Inputs,
}

impl Objective for ControlObjective<'_, '_> {
    type Error = Error;

    fn value(&mut self, u: &DMatrix<f64>) -> Result<f64, Error> {
        self.inputs.controls.copy_from(u);
        self.solver.simulate(&self.inputs)?;
        self.solver.cost()
    }

    fn gradient(&mut self) -> Result<DMatrix<f64>, Error> {
        Ok(self.solver.gradient()?.controls.clone())
    }
}

/// One point of the descent.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    pub u: DMatrix<f64>,
    pub cost: f64,
    pub gradient: f64,
    /// The step length that led here, 0 at the start.
    pub step: f64,
    /// The values of J that the line search took to get here.
    pub trials: usize,
}

/// Makes so many iterations, or fewer if the line search finds no lower value, and returns the start and all that follows.
///
/// A trial that cannot be evaluated counts as infinitely costly. `progress` sees every iterate.
pub fn minimise<O: Objective>(
    objective: &mut O,
    start: DMatrix<f64>,
    search: &LineSearch,
    iterations: usize,
    mut progress: impl FnMut(&Iterate),
) -> Result<Vec<Iterate>, O::Error> {
    let mut history: Vec<Iterate> = Vec::with_capacity(iterations + 1);
    let mut found = Some(Iterate { cost: objective.value(&start)?, u: start, gradient: f64::NAN, step: 0.0, trials: 1 });
    while let Some(mut iterate) = found {
        let gradient = objective.gradient()?;
        iterate.gradient = gradient.amax();
        progress(&iterate);
        found = if history.len() < iterations { backtrack(objective, &iterate, &gradient, search) } else { None };
        history.push(iterate);
    }
    Ok(history)
}

/// The first point of sufficient decrease, its gradient not known yet; the objective is left there.
fn backtrack<O: Objective>(
    objective: &mut O,
    from: &Iterate,
    gradient: &DMatrix<f64>,
    search: &LineSearch,
) -> Option<Iterate> {
    let slope = gradient.norm_squared();
    let (mut step, mut trials) = (search.first, 0);
    while step > search.first * SHORTEST {
        let u = &from.u - gradient * step;
        let cost = objective.value(&u).unwrap_or(f64::INFINITY);
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
    struct Quadratic {
        weights: [f64; 2],
        at: DMatrix<f64>,
    }

    impl Objective for Quadratic {
        type Error = &'static str;

        fn value(&mut self, u: &DMatrix<f64>) -> Result<f64, Self::Error> {
            self.at = u.clone();
            if u.amax() > 5.0 {
                return Err("out of range");
            }
            Ok(self.weights.iter().zip(u).map(|(w, u)| 0.5 * w * (u - 1.0) * (u - 1.0)).sum())
        }

        fn gradient(&mut self) -> Result<DMatrix<f64>, Self::Error> {
            Ok(DMatrix::from_fn(1, 2, |_, i| self.weights[i] * (self.at[i] - 1.0)))
        }
    }

    fn quadratic() -> Quadratic {
        Quadratic { weights: [1.0, 10.0], at: DMatrix::zeros(1, 2) }
    }

    const SEARCH: LineSearch = LineSearch { first: 64.0, armijo: 1e-4, shorten: 0.5 };

    #[test]
    fn quadratic_is_minimised() {
        let history = minimise(&mut quadratic(), DMatrix::from_element(1, 2, -3.0), &SEARCH, 200, |_| {}).unwrap();
        let last = history.last().unwrap();
        assert!(last.cost < 1e-20 && (&last.u - DMatrix::from_element(1, 2, 1.0)).amax() < 1e-9, "{last:?}");
        assert_eq!(history[0].cost, 88.0);
        assert_eq!(history[0].gradient, 40.0);
    }

    #[test]
    fn every_step_decreases_enough() {
        let mut seen = 0;
        let history = minimise(&mut quadratic(), DMatrix::from_element(1, 2, -3.0), &SEARCH, 20, |_| seen += 1).unwrap();
        assert_eq!((seen, history.len()), (21, 21));
        for pair in history.windows(2) {
            let slope = quadratic_slope(&pair[0].u);
            assert!(pair[1].cost <= pair[0].cost - SEARCH.armijo * pair[1].step * slope);
            // The step before it, twice as long, was refused.
            assert_eq!(pair[1].step, SEARCH.first * 0.5f64.powi(pair[1].trials as i32 - 1));
        }
    }

    fn quadratic_slope(u: &DMatrix<f64>) -> f64 {
        let mut objective = quadratic();
        objective.value(u).unwrap();
        objective.gradient().unwrap().norm_squared()
    }

    #[test]
    fn descent_ends_where_nothing_is_lower() {
        let history = minimise(&mut quadratic(), DMatrix::from_element(1, 2, 1.0), &SEARCH, 20, |_| {}).unwrap();
        assert_eq!(history.len(), 1);
        let outside = minimise(&mut quadratic(), DMatrix::from_element(1, 2, 9.0), &SEARCH, 20, |_| {});
        assert_eq!(outside, Err("out of range"));
    }
}
