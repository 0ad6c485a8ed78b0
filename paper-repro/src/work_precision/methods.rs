//! The gradient with respect to 101 controls by different methods, against 128-bit floats: errors and costs.

use hamiltonian_adjoint::check::{Input, complex_step, tangent};
use hamiltonian_adjoint::{Composition, Cx, Error, Inputs, LiftedSolver, Settings, Solver, System};
use serde::Serialize;

use super::convergence::constant_force;
use super::reference::Reference;
use super::stopwatch::{Job, Repeats};

/// Steps of the trapezoidal rule, as in the paper.
const STEPS: usize = 100;
/// The step size of timed runs, N; the time hardly depends on it.
const USUAL: f64 = 1e-6;

/// Gives dJ/du at all nodes.
type Gradient<'a> = Box<dyn FnMut() -> Result<Vec<f64>, Error> + 'a>;
/// The same with a step size in N.
type SteppedGradient<'a> = Box<dyn FnMut(f64) -> Result<Vec<f64>, Error> + 'a>;

/// All methods.
#[derive(Clone, Debug, Serialize)]
pub struct Methods {
    /// Time of one simulation, s: the unit of costs.
    pub simulation_s: f64,
    /// Methods without a step size.
    pub exact: Vec<Exact>,
    /// Methods with a step size.
    pub stepped: Vec<Stepped>,
}

/// A method without a step size to choose.
#[derive(Clone, Debug, Serialize)]
pub struct Exact {
    /// Its name.
    pub name: &'static str,
    /// Relative error of the gradient, in the maximum norm.
    pub error: f64,
    /// Time, in simulations.
    pub cost: f64,
}

/// A method with a step size.
#[derive(Clone, Debug, Serialize)]
pub struct Stepped {
    /// Its name.
    pub name: &'static str,
    /// (step size in N, relative error of the gradient), large to small.
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

/// Measures all methods, stepped ones at the given step sizes in N.
///
/// # Errors
/// A simulation without a solution.
pub fn measure(system: &System, sizes: &[f64], repeats: Repeats) -> Result<Methods, Error> {
    let inputs = constant_force(system, STEPS, Composition::Trapezoidal);
    let controls = (0..=STEPS).map(|node| Input::Control { channel: 0, node }).collect();
    let example = Example { system, inputs, controls };
    let mut solver = Solver::new(system, Settings::default());
    let simulation: Job = Box::new(|| solver.simulate(&example.inputs).map(|_| ()));
    let mut exact = example.exact();
    let mut stepped = example.stepped()?;
    let mut jobs = vec![simulation];
    jobs.extend(exact.iter_mut().map(|(_, gradient)| -> Job { Box::new(|| gradient().map(|_| ())) }));
    jobs.extend(stepped.iter_mut().map(|(_, gradient)| -> Job { Box::new(|| gradient(USUAL).map(|_| ())) }));
    let times = repeats.times(&mut jobs)?;
    drop(jobs);
    let (simulation_s, mut costs) = (times[0], times[1..].iter().map(|time| time / times[0]));

    let reference = Reference::discrete();
    let mut cost = || costs.next().unwrap_or(f64::NAN);
    let mut measured = Methods { simulation_s, exact: Vec::new(), stepped: Vec::new() };
    for (name, gradient) in &mut exact {
        let error = reference.gradient_error(&gradient()?);
        measured.exact.push(Exact { name, error, cost: cost() });
    }
    for (name, gradient) in &mut stepped {
        let one = |&size: &f64| Ok((size, reference.gradient_error(&gradient(size)?)));
        let errors = sizes.iter().map(one).collect::<Result<_, Error>>()?;
        measured.stepped.push(Stepped { name, errors, cost: cost() });
    }
    Ok(measured)
}

impl Example<'_> {
    /// The methods without a step size.
    fn exact(&self) -> [(&'static str, Gradient<'_>); 3] {
        let (settings, mut solver) = (Settings::default(), Solver::new(self.system, Settings::default()));
        let adjoint = move || {
            solver.simulate(&self.inputs)?;
            Ok(solver.gradient()?.controls.as_slice().to_vec())
        };
        [
            ("adjoint", Box::new(adjoint)),
            ("direct differentiation", Box::new(move || tangent(self.system, &self.inputs, settings, &self.controls))),
            ("complex step, 1e-30", Box::new(move || complex_step(self.system, &self.inputs, settings, &self.controls))),
        ]
    }

    /// The methods with a step size.
    fn stepped(&self) -> Result<[(&'static str, SteppedGradient<'_>); 3], Error> {
        let mut lifted = LiftedSolver::new(self.system, &self.inputs, Settings::default())?;
        Ok([
            ("forward differences", Box::new(|size| self.forward_differences(size))),
            ("central differences", Box::new(|size| self.central_differences(size))),
            ("complex step", Box::new(move |size| self.complex_steps(&mut lifted, size))),
        ])
    }

    /// (J(u + s) − J(u))/s for each control, one simulation more than controls.
    fn forward_differences(&self, size: f64) -> Result<Vec<f64>, Error> {
        let mut solver = Solver::new(self.system, Settings::default());
        solver.simulate(&self.inputs)?;
        let here = solver.cost();
        self.each(|inputs, input, u| {
            let ahead = moved(&mut solver, inputs, input, u + size)?;
            Ok((ahead - here) / ((u + size) - u))
        })
    }

    /// (J(u + s) − J(u − s))/2s for each control, two simulations a control.
    fn central_differences(&self, size: f64) -> Result<Vec<f64>, Error> {
        let mut solver = Solver::new(self.system, Settings::default());
        self.each(|inputs, input, u| {
            let ahead = moved(&mut solver, inputs, input, u + size)?;
            let behind = moved(&mut solver, inputs, input, u - size)?;
            Ok((ahead - behind) / ((u + size) - (u - size)))
        })
    }

    /// Im J(u + i s)/s for each control.
    fn complex_steps(&self, solver: &mut LiftedSolver<Cx>, size: f64) -> Result<Vec<f64>, Error> {
        let mut inputs = self.inputs.lift::<Cx>();
        let one = |input: &Input| {
            let real = *input.of(&mut inputs);
            *input.of(&mut inputs) = real + Cx::new(0.0, size);
            solver.simulate(&inputs)?;
            *input.of(&mut inputs) = real;
            Ok(solver.cost().0.im / size)
        };
        self.controls.iter().map(one).collect()
    }

    /// A derivative for each control, of which it is given the value.
    fn each(&self, mut derivative: impl FnMut(&mut Inputs, Input, f64) -> Result<f64, Error>) -> Result<Vec<f64>, Error> {
        let mut inputs = self.inputs.clone();
        let one = |&input: &Input| {
            let u = *input.of(&mut inputs);
            let result = derivative(&mut inputs, input, u);
            *input.of(&mut inputs) = u;
            result
        };
        self.controls.iter().map(one).collect()
    }
}

/// J with another value of one input.
fn moved(solver: &mut Solver, inputs: &mut Inputs, input: Input, value: f64) -> Result<f64, Error> {
    *input.of(inputs) = value;
    solver.simulate(inputs)?;
    Ok(solver.cost())
}
