//! [`Argmin`]: an adapter from a problem to argmin's traits.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Gradient, Hessian};
use hamiltonian_adjoint::Error as MotionError;
use hamiltonian_adjoint::optimize::{Interval, Problem};

use crate::{Failure, finite};

/// A problem without bounds and constraints for argmin's solvers. A point that cannot be evaluated is infinitely costly, and its gradient returns the error;
/// if a callback stops a simulation, the run ends with that error.
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

/// The problem and the point of its last evaluation, with the value or the error.
struct Asked<'p, P> {
    problem: &'p mut P,
    at: Option<Vec<f64>>,
    value: Result<f64, MotionError>,
    c: Vec<f64>,
}

impl<'p, P: Problem> Argmin<'p, P> {
    /// # Errors
    /// The problem has bounds or constraints.
    pub fn new(problem: &'p mut P) -> Result<Self, Failure> {
        let constraints = problem.constraints();
        if problem.bounds().iter().chain(&constraints).any(|of| *of != Interval::FREE) {
            return Err(Failure::Constrained);
        }
        let value = Ok(f64::NAN);
        Ok(Argmin(RefCell::new(Asked { problem, at: None, value, c: vec![0.0; constraints.len()] })))
    }
}

impl<P: Problem> Asked<'_, P> {
    fn evaluate(&mut self, x: &[f64]) -> Result<f64, MotionError> {
        let (expected, found) = (self.problem.variables(), x.len());
        if found != expected {
            return Err(MotionError::Size { what: "the variables", expected, found });
        }
        if self.at.as_deref() != Some(x) {
            self.value = self
                .problem
                .evaluate(x, &mut self.c)
                .and_then(|value| finite("the value of the cost", &[value]).map(|()| value));
            self.at = Some(x.to_vec());
        }
        self.value.clone()
    }

    /// Infinite at a point that cannot be evaluated, except that wrong sizes and stopped simulations are errors.
    fn cost(&mut self, x: &[f64]) -> Result<f64, MotionError> {
        match self.evaluate(x) {
            Err(error @ (MotionError::Size { .. } | MotionError::Interrupted { .. })) => Err(error),
            other => Ok(other.unwrap_or(f64::INFINITY)),
        }
    }

    fn gradient(&mut self, x: &[f64]) -> Result<Vec<f64>, MotionError> {
        self.evaluate(x)?;
        let mut gradient = vec![0.0; x.len()];
        self.problem.gradient(1.0, &vec![0.0; self.c.len()], &mut gradient)?;
        finite("a derivative of the cost", &gradient)?;
        Ok(gradient)
    }

    fn row(&mut self, i: usize, len: usize) -> Result<Vec<f64>, MotionError> {
        let (mut unit, mut row) = (vec![0.0; len], vec![0.0; len]);
        unit[i] = 1.0;
        self.problem.product(&unit, &mut row)?;
        finite("a second derivative", &row)?;
        Ok(row)
    }
}

impl<P: Problem> CostFunction for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0.borrow_mut().cost(x)?)
    }
}

impl<P: Problem> Gradient for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.0.borrow_mut().gradient(x)?)
    }
}

impl<P: Problem> Hessian for Argmin<'_, P> {
    type Param = Vec<f64>;
    type Hessian = Vec<Vec<f64>>;

    /// The Hessian, computed product by product.
    fn hessian(&self, x: &Vec<f64>) -> Result<Vec<Vec<f64>>, Error> {
        let mut asked = self.0.borrow_mut();
        asked.gradient(x)?;
        (0..x.len()).map(|i| Ok(asked.row(i, x.len())?)).collect()
    }
}
