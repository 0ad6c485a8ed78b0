//! [`Argmin`]: a problem as argmin wants it.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Gradient, Hessian};
use hamiltonian_adjoint::optimize::{Interval, Problem};

use crate::Failure;

/// A problem without bounds and constraints for argmin's solvers; a point without a value is infinitely costly.
///
/// ```
/// use argmin::core::{Executor, State};
/// use argmin::solver::{linesearch::MoreThuenteLineSearch, quasinewton::LBFGS};
/// use hamiltonian_adjoint::optimize::{Free, MotionProblem, Variables};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
/// use optimisers::Argmin;
///
/// let scene = CartPendulum::with_links(1).scene();
/// let force = scene.control_named("force on the cart").expect("its only control");
/// let system = scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
/// let variables = Variables::new(&system, &inputs, vec![Free::control(force)])?;
/// let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
/// let start = vec![10.0; 41];
/// let solver = LBFGS::new(MoreThuenteLineSearch::new(), 30);
/// let argmin = Argmin::new(&mut problem)?;
/// let run = Executor::new(argmin, solver).configure(|state| state.param(start).max_iters(200).target_cost(1e-10)).run()?;
/// assert!(run.state().get_best_cost() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Argmin<'p, P>(RefCell<Asked<'p, P>>);

/// The problem and where it was evaluated last.
struct Asked<'p, P> {
    problem: &'p mut P,
    at: Vec<f64>,
    value: f64,
    c: Vec<f64>,
}

impl<'p, P: Problem> Argmin<'p, P> {
    /// # Errors
    /// Bounds, or constraints that ask for anything.
    pub fn new(problem: &'p mut P) -> Result<Self, Failure> {
        let constraints = problem.constraints();
        if problem.bounds().iter().chain(&constraints).any(|of| *of != Interval::FREE) {
            return Err(Failure::Constrained);
        }
        Ok(Argmin(RefCell::new(Asked { problem, at: Vec::new(), value: f64::NAN, c: vec![0.0; constraints.len()] })))
    }
}

impl<P: Problem> Asked<'_, P> {
    fn evaluate(&mut self, x: &[f64]) -> f64 {
        if self.at != x {
            self.at = x.to_vec();
            let value = self.problem.evaluate(x, &mut self.c).ok().filter(|value| value.is_finite());
            self.value = value.unwrap_or(f64::INFINITY);
        }
        self.value
    }

    fn gradient(&mut self, x: &[f64]) -> Result<Vec<f64>, Error> {
        self.evaluate(x);
        let mut gradient = vec![0.0; x.len()];
        self.problem.gradient(1.0, &vec![0.0; self.c.len()], &mut gradient)?;
        Ok(gradient)
    }
}

impl<P: Problem> CostFunction for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0.borrow_mut().evaluate(x))
    }
}

impl<P: Problem> Gradient for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        self.0.borrow_mut().gradient(x)
    }
}

impl<P: Problem> Hessian for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    /// Product by product.
    fn hessian(&self, x: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let mut asked = self.0.borrow_mut();
        asked.gradient(x)?;
        let row = |i| {
            let (mut unit, mut row) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            unit[i] = 1.0;
            asked.problem.product(&unit, &mut row)?;
            Ok(row)
        };
        (0..x.len()).map(row).collect()
    }
}
