//! The gradient with respect to 101 controls by several methods, compared with 128-bit floats: errors and costs.

use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::{Cx, Error, Inputs, LiftedSolver, Real, Settings, Solver, System, gradient};
use num_dual::Dual64;
use serde::Serialize;

use super::METHODS;
use super::reference::{FORCE, Reference};
use crate::stopwatch::{Repeats, simulation, value_and_gradient};

/// Steps of the trapezoidal rule, as in the paper.
const STEPS: usize = 100;
/// The step size of timed runs, N; run times hardly depend on it.
const USUAL: f64 = 1e-6;
/// A step size of complex step that causes no truncation error, N.
const TINY: f64 = 1e-30;

/// dJ/dx for one input x; not every method uses the step size.
type Derivative<'a> = Box<dyn FnMut(Input, f64) -> Result<f64, Error> + 'a>;

/// Results of all methods.
#[derive(Clone, Debug, Serialize)]
pub struct Methods {
    /// Time of one simulation, s: the unit of costs.
    pub simulation_s: f64,
    pub exact: Vec<Exact>,
    pub stepped: Vec<Stepped>,
}

/// A method without a step size.
#[derive(Clone, Debug, Serialize)]
pub struct Exact {
    pub name: &'static str,
    /// Relative error of the gradient, in the maximum norm.
    pub error: f64,
    /// Time, in simulations.
    pub cost: f64,
}

/// A method with a step size.
#[derive(Clone, Debug, Serialize)]
pub struct Stepped {
    pub name: &'static str,
    /// (step size in N, relative error of the gradient), from large to small step sizes.
    pub errors: Vec<(f64, f64)>,
    /// Time, in simulations.
    pub cost: f64,
}

impl Stepped {
    /// The step with the least error, and that error.
    pub fn best(&self) -> (f64, f64) {
        self.errors.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((f64::NAN, f64::NAN))
    }
}

/// The example at its constant force.
struct Example<'s> {
    system: &'s System,
    inputs: Inputs,
    controls: Vec<Input>,
}

/// Measures all methods, those with a step size for the given step sizes in N.
pub fn measure(system: &System, sizes: &[f64], repeats: Repeats) -> Result<Methods, Error> {
    let inputs = METHODS[0].constant_force(system, STEPS);
    let controls = (0..=STEPS).map(|node| Input::Control { channel: 0, node }).collect();
    let example = Example { system, inputs, controls };
    let mut direct = example.lifted(|_| Dual64::new(0.0, 1.0), |j, _| j.eps)?;
    let mut complex = example.lifted(|size| Cx::new(0.0, size), |j, size| j.0.im / size)?;
    let mut forward = example.forward_differences()?;
    let mut central = example.central_differences();
    let times = example.times([&mut direct, &mut complex, &mut forward, &mut central], repeats)?;
    let [simulation_s, adjoint_s, each @ ..] = times;

    let reference = Reference::discrete();
    let error = |derivative: &mut Derivative, size| -> Result<f64, Error> {
        let gradient: Result<Vec<f64>, Error> = example.controls.iter().map(|&input| derivative(input, size)).collect();
        Ok(reference.gradient_error(&gradient?))
    };
    let adjoint = gradient(system, &example.inputs, Settings::default())?;
    // One simulation for each control; forward differences need one more.
    let all = |each: f64, more: f64| each / simulation_s * example.controls.len() as f64 + more;
    let [direct_cost, complex_cost, forward_cost, central_cost] =
        [all(each[0], 0.0), all(each[1], 0.0), all(each[2], 1.0), all(each[3], 0.0)];
    let exact = vec![
        Exact {
            name: "adjoint",
            error: reference.gradient_error(adjoint.controls.as_slice()),
            cost: adjoint_s / simulation_s,
        },
        Exact { name: "direct differentiation", error: error(&mut direct, TINY)?, cost: direct_cost },
        Exact { name: "complex step of 1e-30", error: error(&mut complex, TINY)?, cost: complex_cost },
    ];
    let stepped = |name, derivative: &mut Derivative, cost| -> Result<Stepped, Error> {
        let errors = sizes.iter().map(|&size| Ok((size, error(derivative, size)?))).collect::<Result<_, Error>>()?;
        Ok(Stepped { name, errors, cost })
    };
    let stepped = vec![
        stepped("forward differences", &mut forward, forward_cost)?,
        stepped("central differences", &mut central, central_cost)?,
        stepped("complex step", &mut complex, complex_cost)?,
    ];
    Ok(Methods { simulation_s, exact, stepped })
}

impl Example<'_> {
    /// Times of a simulation, of one with the adjoint, and of one derivative by each of the methods, s.
    fn times(&self, methods: [&mut Derivative; 4], repeats: Repeats) -> Result<[f64; 6], Error> {
        let mut jobs = vec![simulation(self.system, &self.inputs), value_and_gradient(self.system, &self.inputs)];
        for derivative in methods {
            let mut controls = self.controls.iter().cycle();
            jobs.push(Box::new(move || controls.next().map_or(Ok(()), |&input| derivative(input, USUAL).map(|_| ()))));
        }
        let times = repeats.times(&mut jobs)?;
        Ok(std::array::from_fn(|job| times[job]))
    }

    /// The part of J(x + unit) that contains the derivative, with complex or dual numbers.
    fn lifted<'a, R: Real + 'a>(
        &'a self,
        unit: impl Fn(f64) -> R + 'a,
        part: impl Fn(R, f64) -> f64 + 'a,
    ) -> Result<Derivative<'a>, Error> {
        let mut solver = LiftedSolver::new(self.system, &self.inputs, Settings::default())?;
        let mut inputs = self.inputs.lift::<R>();
        Ok(Box::new(move |input, size| {
            let real = *input.of(&mut inputs);
            *input.of(&mut inputs) = real + unit(size);
            let result = solver.simulate(&inputs).map(|_| ());
            *input.of(&mut inputs) = real;
            result.and_then(|()| Ok(part(solver.cost()?, size)))
        }))
    }

    /// (J(x + s) − J(x))/s.
    fn forward_differences(&self) -> Result<Derivative<'_>, Error> {
        let mut cost = self.cost_with();
        let here = cost(self.controls[0], 0.0)?;
        Ok(Box::new(move |input, size| Ok((cost(input, size)? - here) / moved_by(FORCE, size))))
    }

    /// (J(x + s) − J(x − s))/2s.
    fn central_differences(&self) -> Derivative<'_> {
        let mut cost = self.cost_with();
        Box::new(move |input, size| {
            let distance = moved_by(FORCE, size) - moved_by(FORCE, -size);
            Ok((cost(input, size)? - cost(input, -size)?) / distance)
        })
    }

    /// J with one input changed.
    fn cost_with(&self) -> Derivative<'_> {
        let mut solver = Solver::new(self.system, Settings::default());
        let mut inputs = self.inputs.clone();
        Box::new(move |input, change| {
            let here = *input.of(&mut inputs);
            *input.of(&mut inputs) = here + change;
            let result = solver.simulate(&inputs).map(|_| ());
            *input.of(&mut inputs) = here;
            result.and_then(|()| solver.cost())
        })
    }
}

/// Difference between x + change and x in floating point.
fn moved_by(x: f64, change: f64) -> f64 {
    (x + change) - x
}

#[cfg(test)]
mod tests {
    use super::*;
    use hamiltonian_adjoint::scenes::CartPendulum;
    use std::time::Duration;

    #[test]
    fn exact_methods_are_exact_and_differences_have_their_orders() {
        let system = CartPendulum::default().scene().compile().unwrap();
        let repeats = Repeats { turns: 1, turn: Duration::ZERO };
        let methods = measure(&system, &[1e-1, 1e-2], repeats).unwrap();
        assert!(methods.exact.iter().all(|method| method.error < 1e-12));
        assert!(methods.exact.iter().map(|method| method.cost).chain([methods.simulation_s]).all(|time| time > 0.0));
        for (method, order) in methods.stepped.iter().zip([1.0, 2.0, 2.0]) {
            let observed = (method.errors[0].1 / method.errors[1].1).log10();
            assert!((observed - order).abs() < 0.1, "{}: {observed}", method.name);
            assert_eq!(method.best(), method.errors[1]);
        }
    }
}
