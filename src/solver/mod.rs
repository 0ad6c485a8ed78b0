//! [`Solver`]: a system with all the memory that simulations and gradients need, for repeated use.

mod ends;
mod lifted;
mod located;
mod long;
mod many;
mod mechanics;
mod phases;
mod size;
mod stopped;
mod work;

pub(crate) use ends::Asked;
pub use lifted::LiftedSolver;
pub use long::{LongSolver, State};
pub use many::gradients;
pub(crate) use many::{each, each_mut};
pub use mechanics::Mechanics;
pub use stopped::Stopped;

use nalgebra::DVector;

use crate::adjoint::{AdjointSweep, AdjointVariables, Gradient, GridPhase, Located, SecondOrderSweep};
use crate::forward::ForwardSweep;
use crate::motion::Motion;
use std::ops::ControlFlow;

use crate::motion::Refinement;
use crate::motion::{Progress, Report, Watch};
use crate::system::CostFactors;
use crate::{Error, Inputs, Scheme, Settings, System, Trajectory};

/// A solver of one system for many inputs. After the first call with a grid of some length, further calls with grids of this length
/// allocate no memory in the steps. The solver contains a clone of the system, which shares its data.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes};
///
/// let system = scenes::CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
/// inputs.controls.fill(10.0);
///
/// let mut solver = Solver::new(&system, Settings::default());
/// solver.simulate(&inputs)?;
/// let gradient = solver.gradient()?;
/// assert!((gradient.value - 15.18353832472497).abs() < 1e-12);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct Solver {
    system: System,
    settings: Settings,
    forward: ForwardSweep,
    /// The sweep for J, and those of its kinks.
    sweeps: Vec<AdjointSweep>,
    phase: GridPhase,
    /// One sweep for each requested output.
    rows: Vec<AdjointSweep>,
    products: Option<Box<SecondOrderSweep>>,
    /// The derivatives of the functions of events, after they have been needed.
    located: Option<Located>,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solver").field("system", &self.system).field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Solver {
    /// A solver for a system.
    pub fn new(system: &System, settings: Settings) -> Self {
        Solver {
            system: system.clone(),
            settings,
            forward: ForwardSweep::new(system, settings.scheme),
            sweeps: vec![AdjointSweep::new(system, settings.scheme)],
            phase: GridPhase::default(),
            rows: Vec::new(),
            products: None,
            located: None,
        }
    }

    /// The system.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Discards the results that belong to another motion.
    fn forget(&mut self) {
        self.sweeps[0].forget();
        self.products.iter_mut().for_each(|products| products.forget());
        self.located = None;
    }

    /// Discards the motion.
    pub(crate) fn drop_motion(&mut self) {
        self.forget();
        self.forward.motion.trajectory.computed = 0;
    }

    /// Computes the motion for these inputs.
    ///
    /// # Errors
    /// Inputs of wrong size or not finite, an inconsistent start, or a step without a solution. The nodes before a failed step remain in
    /// [`Solver::trajectory`].
    pub fn simulate(&mut self, inputs: &Inputs) -> Result<&Trajectory, Error> {
        self.forget();
        self.system.check_events(inputs.events.len())?;
        self.forward.run(&self.system, inputs, &self.settings)?;
        Ok(&self.forward.motion.trajectory)
    }

    /// The same inputs on an adaptive grid, on which the estimated error of every step is below the tolerance. The tolerance is absolute,
    /// in m or rad, or relative for coordinates and velocities larger than 1. An error of a velocity is measured by the change of the
    /// coordinate that it causes within the step.
    ///
    /// The given grid determines the beginning and end of the motion, the kinks of controls and the events, which are located on it first; these nodes
    /// are kept, and controls remain the same functions of time. Schemes of even order need two simulations. The first determines step lengths from the error estimates alone. The
    /// second uses a compromise between these lengths and equal ones, because errors cancel better with equal steps. The new grid is then
    /// fixed like any other grid, and the gradient on it is exact. A cost summed over nodes ([`Sum::Plain`](crate::Sum::Plain),
    /// [`Sum::AllNodes`](crate::Sum::AllNodes)) has another meaning on it; use [`Sum::Integral`](crate::Sum::Integral) for integrals.
    /// Derivatives with respect to step lengths refer to the new steps.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Scheme, Settings, Solver, scenes::CartPendulum};
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 2.0));
    /// inputs.controls.fill(10.0);
    /// let mut solver = Solver::new(&system, Settings { scheme: Scheme::ESDIRK5, ..Settings::default() });
    /// let adapted = solver.adapt(&inputs, 1e-9)?;
    /// let motion = solver.simulate(&adapted)?;
    /// let last = motion.last();
    /// assert!((motion.times[last] - 2.0).abs() < 1e-12);
    /// assert!((motion.q[(0, last)] - 8.5244826).abs() < 1e-3);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate); a tolerance that is not positive, that no step satisfies, or that is below the rounding error of
    /// coordinates; steps of both signs, or a composed grid; a cost at a single node ([`Sum::Node`](crate::Sum::Node)), which cannot be
    /// transferred to another grid.
    pub fn adapt(&mut self, inputs: &Inputs, tolerance: f64) -> Result<Inputs, Error> {
        self.drop_motion();
        self.forward.adapt(&self.system, inputs, &self.settings, tolerance)
    }

    /// The same inputs with the consistent start assembled from a guess ([`Start::Assembled`](crate::Start::Assembled)). No motion is
    /// computed. Other starts are unchanged.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Solver, Start, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let length = scene.design("length", 0.5);
    /// let bob = scene.body("bob", 1.0, 0.1, [0.3, -0.5, 0.0]); // somewhere near
    /// scene.distance("rod", Body::GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), length);
    /// let system = scene.compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
    /// inputs.start = Start::assembled(&system).hold(&bob.coordinates[..1]); // x = 0.3 m, at rest
    /// let start = Solver::new(&system, Settings::default()).assemble(&inputs)?.start;
    /// assert!((start.q()[1] + 0.4).abs() < 1e-14);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// Inputs of wrong size or not finite, no consistent start near the guess, or a coordinate that cannot be held.
    pub fn assemble(&mut self, inputs: &Inputs) -> Result<Inputs, Error> {
        self.drop_motion();
        self.settings.check()?;
        inputs.check(&self.system)?;
        self.forward.take(&self.system, inputs, &self.settings)?;
        Ok(self.forward.motion.inputs.clone())
    }

    /// Sets a progress callback for all motions and gradients, called about a hundred times for each. If it returns `Break`, the
    /// computation stops with [`Error::Interrupted`], and the nodes computed so far remain in [`trajectory`](Self::trajectory). During
    /// [`adapt`](Self::adapt) the number of all nodes is extrapolated from the previous steps, and at least every hundredth step is
    /// reported.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Progress, Settings, Solver, Task, scenes::CartPendulum};
    /// use std::ops::ControlFlow;
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let inputs = Inputs::at_rest(&system, Grid::uniform(1000, 0.002));
    /// let mut solver = Solver::new(&system, Settings::default());
    /// solver.watch(|Progress { task, done, of }| {
    ///     if task == Task::Simulation {
    ///         eprint!("\r{} %", 100 * done / of);
    ///     }
    ///     ControlFlow::Continue(())
    /// });
    /// solver.simulate(&inputs)?;
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn watch(&mut self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) {
        self.forward.watch = Watch::new(callback);
    }

    /// The last motion, up to the last computed node.
    pub fn trajectory(&self) -> &Trajectory {
        &self.forward.motion.trajectory
    }

    /// The inputs of the last motion, on the grid that was used, including the nodes of [`Trajectory::inserted`]. Its
    /// [`Grid::stages`](crate::Grid::stages) and the nodes of its events are those of the given grid, without the inserted nodes.
    pub fn inputs(&self) -> &Inputs {
        &self.forward.motion.inputs
    }

    /// J of the last motion.
    ///
    /// # Errors
    /// No complete motion; a cost that is not finite.
    pub fn cost(&self) -> Result<f64, Error> {
        let Motion { trajectory, inputs, .. } = &self.forward.motion;
        trajectory.check_complete(inputs)?;
        trajectory.cost(&self.system, inputs)
    }

    /// J of the last motion and its derivatives with respect to all inputs, by the discrete adjoint (Eq. 9–12).
    ///
    /// # Errors
    /// No complete motion; a cost that is not finite; a singular tangent matrix.
    pub fn gradient(&mut self) -> Result<&Gradient, Error> {
        self.differentiate(|_| ())
    }

    fn differentiate(&mut self, choose: impl Fn(&mut CostFactors)) -> Result<&Gradient, Error> {
        if self.has_events() {
            self.differentiate_located(choose)?;
            return Ok(&self.sweeps[0].gradient);
        }
        let Solver { system, settings, forward, sweeps, phase, .. } = self;
        phase.run(sweeps, system, &mut forward.solved(), settings, choose)?;
        Ok(&sweeps[0].gradient)
    }

    /// The values of all outputs of the last motion ([`Scene::output`](crate::Scene::output)).
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub fn outputs(&self) -> Result<DVector<f64>, Error> {
        let Motion { trajectory, inputs, .. } = &self.forward.motion;
        trajectory.check_complete(inputs)?;
        trajectory.outputs(&self.system, inputs)
    }

    /// The gradients of all outputs of the last motion, by one backward sweep with a right-hand side for each. It does not change the
    /// function whose Hessian [`hessian_product`](Self::hessian_product) uses.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn jacobian(&mut self) -> Result<Vec<Gradient>, Error> {
        let all: Vec<Asked> = (0..self.system.outputs()).map(Asked::Output).collect();
        Ok(self.gradients_of_all(&all)?.cloned().collect())
    }

    /// J (`which` = 0) or an output (`which` from 1 on).
    pub(crate) fn value_of(&self, which: usize) -> Result<f64, Error> {
        if which == 0 { self.cost() } else { Ok(self.outputs()?[which - 1]) }
    }

    /// The gradient of J (`which` = 0) or of an output (`which` from 1 on).
    pub(crate) fn gradient_of(&mut self, which: usize) -> Result<&Gradient, Error> {
        self.differentiate(|factors| factors.choose(which))
    }

    /// The gradient of Σ w_k r_k over the outputs r, by one backward sweep: (∂r)ᵀ w.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient); a number of weights that differs from that of the outputs, or a weight that is not finite.
    pub fn pull_back(&mut self, weights: &[f64]) -> Result<&Gradient, Error> {
        self.weighted_gradient(0.0, weights)
    }

    /// The gradient of w₀ J + Σ w_k r_k over the outputs r, by one backward sweep, for example the gradient of the Lagrangian of an
    /// optimisation problem.
    ///
    /// # Errors
    /// As [`pull_back`](Self::pull_back).
    pub fn weighted_gradient(&mut self, of_cost: f64, of_outputs: &[f64]) -> Result<&Gradient, Error> {
        check_weights(&self.system, of_cost, of_outputs)?;
        self.differentiate(|factors| factors.weigh(of_cost, of_outputs))
    }

    /// As [`weighted_gradient`](Self::weighted_gradient), without the gradient at frozen grid phase, and with weights of (q, v, p\*) at the last
    /// node, if there are any.
    pub(crate) fn discrete_gradient(
        &mut self,
        of_cost: f64,
        of_outputs: &[f64],
        of_end: &[f64],
    ) -> Result<&Gradient, Error> {
        check_weights(&self.system, of_cost, of_outputs)?;
        let choose = |factors: &mut CostFactors| {
            factors.weigh(of_cost, of_outputs);
            factors.weigh_end(of_end);
        };
        if self.has_events() {
            return self.differentiate(choose);
        }
        let Solver { system, settings, forward, sweeps, .. } = self;
        AdjointSweep::run(&mut sweeps[..1], system, &mut forward.solved(), settings, |_, factors| choose(factors))?;
        Ok(&sweeps[0].gradient)
    }

    /// Exact derivative of all outputs along a direction of the inputs, ∂r · d: one forward sweep for any number of outputs.
    ///
    /// As [`hessian_product`](Self::hessian_product), except that costs on accelerations and reactions are supported also if formulas have
    /// no programs ([`System::without_programs`](crate::System::without_programs)).
    pub fn push_forward(&mut self, direction: &Inputs) -> Result<DVector<f64>, Error> {
        let taken = if self.has_events() { Some(self.along_located(direction)?) } else { None };
        let Solver { system, settings, forward, products, .. } = self;
        let products = workspace(products, system, settings.scheme);
        products.outputs(system, forward.solved(), taken.as_ref().unwrap_or(direction))
    }

    /// Exact product of the Hessian with a direction of the inputs ([`Inputs::no_change`]), at about the cost of a gradient. The Hessian is
    /// that of the function differentiated last by [`gradient`](Self::gradient) or [`weighted_gradient`](Self::weighted_gradient); if there
    /// was none, it is that of J. The field `value` of the result is the derivative of this function along the direction.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
    /// inputs.controls.fill(10.0);
    /// let mut solver = Solver::new(&system, Settings::default());
    /// solver.simulate(&inputs)?;
    /// let mut push = inputs.no_change();
    /// push.controls[(0, 3)] = 1.0;
    /// let column = solver.hessian_product(&push)?.controls.clone();
    /// push.controls.fill(0.0);
    /// push.controls[(0, 7)] = 1.0;
    /// assert!((solver.hessian_product(&push)?.controls[(0, 3)] - column[(0, 7)]).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient), or a direction of wrong size or with numbers that are not finite.
    pub fn hessian_product(&mut self, direction: &Inputs) -> Result<&Gradient, Error> {
        if self.has_events() {
            return self.product_located(direction);
        }
        let Solver { system, settings, forward, sweeps, products, .. } = self;
        let products = workspace(products, system, settings.scheme);
        products.run(system, (forward.solved(), &mut sweeps[0]), settings, direction)
    }

    /// Begins the Hessian along a number of directions, of the function that [`hessian_product`](Self::hessian_product) uses. Events need products.
    pub(crate) fn begin_hessian(&mut self, directions: usize) -> Result<(), Error> {
        let Solver { system, settings, forward, sweeps, products, .. } = self;
        let products = workspace(products, system, settings.scheme);
        products.begin_hessian(system, (forward.solved(), &mut sweeps[0]), settings, directions)
    }

    /// The next row of the Hessian, along a direction of controls, or of the start if momenta are given, which changes nothing before a node: what the
    /// controls contribute directly, and the products of the changes of the motion with those along the directions up to this one.
    pub(crate) fn hessian_along(&mut self, direction: &Inputs, node: usize) -> Result<(&Gradient, &[f64]), Error> {
        let Solver { system, settings, forward, sweeps, products, .. } = self;
        let products = workspace(products, system, settings.scheme);
        products.hessian_along(system, (forward.solved(), &mut sweeps[0]), settings, (direction, node))
    }

    /// The adjoint variables of the last gradient, if [`Settings::keep_adjoint`] is set.
    pub fn adjoint_variables(&self) -> Option<&AdjointVariables> {
        self.sweeps[0].variables()
    }

    /// The work of the last simulation.
    pub fn report(&self) -> &Report {
        &self.forward.monitor.report
    }

    /// The work of the last adjoint sweep, for all right-hand sides.
    pub fn adjoint_report(&self) -> &Report {
        &self.sweeps[0].report
    }

    /// True if both motions have the same steps and restarts.
    pub(crate) fn moves_like(&self, other: &Solver) -> bool {
        self.forward.motion.is_like(&other.forward.motion)
    }

    pub(crate) fn settings(&self) -> Settings {
        self.settings
    }

    /// Sets whether adjoint variables are stored, and returns whether they were.
    pub(crate) fn keep_adjoint(&mut self, keep: bool) -> bool {
        std::mem::replace(&mut self.settings.keep_adjoint, keep)
    }

    pub(crate) fn refinement(&self) -> Refinement {
        self.forward.motion.refinement()
    }

    pub(crate) fn forward(&self) -> &ForwardSweep {
        &self.forward
    }

    pub(crate) fn forward_mut(&mut self) -> &mut ForwardSweep {
        &mut self.forward
    }
}

/// The workspace for products, created when it is first needed.
fn workspace<'a>(of: &'a mut Option<Box<SecondOrderSweep>>, system: &System, scheme: Scheme) -> &'a mut SecondOrderSweep {
    of.get_or_insert_with(|| Box::new(SecondOrderSweep::new(system, scheme)))
}

/// # Errors
/// A number of weights that differs from that of the outputs, or a weight that is not finite.
fn check_weights(system: &System, of_cost: f64, of_outputs: &[f64]) -> Result<(), Error> {
    let count = system.outputs();
    if of_outputs.len() != count {
        return Err(Error::Size { what: "weights of the outputs", expected: count, found: of_outputs.len() });
    }
    let of_output = |k: usize| format!("the weight of output `{}`", system.output_name(k));
    let bad = std::iter::once(&of_cost).chain(of_outputs).enumerate().find(|(_, w)| !w.is_finite());
    bad.map_or(Ok(()), |(k, &value)| {
        let what = k.checked_sub(1).map_or_else(|| "the weight of the cost".into(), of_output);
        Err(Error::NotFinite { what, value })
    })
}

/// Computes one motion.
///
/// # Errors
/// As [`Solver::simulate`]; the error contains the nodes before a failed step.
pub fn simulate(system: &System, inputs: &Inputs, settings: Settings) -> Result<Trajectory, Stopped> {
    let mut solver = Solver::new(system, settings);
    let result = solver.simulate(inputs).map(|_| ());
    let trajectory = solver.forward.motion.trajectory;
    match result {
        Ok(()) => Ok(trajectory),
        Err(error) => Err(Stopped { error, trajectory: Box::new(trajectory) }),
    }
}

/// J and its derivatives with respect to all inputs: one simulation and one adjoint sweep.
///
/// # Errors
/// As [`Solver::simulate`].
pub fn gradient(system: &System, inputs: &Inputs, settings: Settings) -> Result<Gradient, Error> {
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    solver.gradient()?;
    Ok(solver.sweeps.swap_remove(0).gradient)
}
