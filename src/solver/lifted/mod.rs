//! Simulation with complex or dual numbers: complex step and tangents through the entire computation, including Newton's method.
//!
//! The motion is first computed with real numbers. Then every step is solved again with the requested numbers, starting from the real solution,
//! by the plain element formulas (nothing recorded, nothing condensed, nothing skipped) and corrections with
//! the real tangent matrix: r(x + ε w) = 0 holds for w after one exact correction, because K is converged; another one
//! confirms it. The derivative is therefore independent of the blocks from which the adjoint is assembled: they only
//! determine how fast the iteration converges.

mod event;
mod locate;
mod stage;

use nalgebra::DVector;

use crate::assembly::Assembler;
use crate::forward::ForwardSweep;
use crate::motion::{Motion, Refinement, Task, Watch};
use crate::node::Linearisation;
use crate::number::Real;
use crate::scheme::known_part;
use crate::system::{Given, NodeView, Pair, Sums};
use crate::{Error, Inputs, Report, Settings, Solver, Start, System, Trajectory, memory};

/// A solver that computes with numbers of type R (dual or complex), for many motions with the same real part.
///
/// ```
/// use hamiltonian_adjoint::{Cx, Grid, Inputs, LiftedSolver, Settings, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
/// let mut perturbed = inputs.lift::<Cx>();
/// perturbed.controls[(0, 3)] = Cx::new(0.0, 1e-30);
/// let mut solver = LiftedSolver::new(&system, &inputs, Settings::default())?;
/// solver.simulate(&perturbed)?;
/// let derivative = solver.cost()?.0.im / 1e-30;
/// # let gradient = hamiltonian_adjoint::gradient(&system, &inputs, Settings::default())?;
/// # assert!((derivative - gradient.controls[(0, 3)]).abs() < 1e-12);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct LiftedSolver<R: Real> {
    real: Solver,
    refinement: Refinement,
    lifted: Lifted<R>,
}

/// The motion in numbers of type R, and the workspace of its corrections.
struct Lifted<R: Real> {
    inputs: Inputs<R>,
    /// The values of the parameters, computed from the design variables of `inputs`.
    design: Vec<R>,
    /// The largest velocity of the real motion.
    speed: f64,
    trajectory: Trajectory<R>,
    sums: Sums<R>,
    /// q̄ and p̄ of the current stage, and σ₋.
    start_q: Vec<R>,
    start_p: Vec<R>,
    start_sigma: Vec<R>,
    /// A residual, then a correction, of one part.
    part: Pair,
    /// The largest perturbation of any input, in each part beyond the real one: 1e-30 for a complex step, 1 for a tangent.
    unit: Vec<f64>,
    /// The largest correction attributed to rounding, relative to the size that a perturbation of `unit` can cause.
    rounding: f64,
}

/// The real motion near the lifted one, and its Linearisation matrix.
struct Near<'a> {
    system: &'a System,
    motion: &'a Motion,
    linearisation: &'a mut Linearisation,
    report: &'a mut Report,
    watch: &'a mut Watch,
}

impl<R: Real> std::fmt::Debug for LiftedSolver<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LiftedSolver").field("real", &self.real).finish_non_exhaustive()
    }
}

impl<R: Real> LiftedSolver<R> {
    /// A solver for inputs near the given ones; computes the real motion.
    ///
    /// # Errors
    /// As [`Solver::simulate`].
    pub fn new(system: &System, inputs: &Inputs, settings: Settings) -> Result<Self, Error> {
        Self::near(Solver::new(system, settings), inputs)
    }

    /// A solver for inputs near the given ones, whose motion this solver computes; its progress callback is called for all motions.
    pub(crate) fn near(mut real: Solver, inputs: &Inputs) -> Result<Self, Error> {
        real.simulate(inputs)?;
        let (system, settings) = (real.system().clone(), real.settings());
        let (n, m) = (system.n(), system.m());
        let zeros = |len| vec![R::zero(); len];
        let node = Trajectory::<R>::len_of_node(n, m) * settings.scheme.stages() + 1 + system.k();
        memory::check("the motion in complex or dual numbers", real.inputs().grid.nodes(), node * size_of::<R>())?;
        let mut trajectory = Trajectory::zeros(&system, real.inputs().grid.nodes(), settings.scheme);
        trajectory.compliance.clone_from(&real.trajectory().compliance);
        trajectory.inserted.clone_from(&real.trajectory().inserted);
        trajectory.restarted.clone_from(&real.trajectory().restarted);
        let lifted = Lifted {
            inputs: inputs.lift(),
            design: Vec::new(),
            speed: real.trajectory().v.amax(),
            trajectory,
            sums: Sums::new(n, m),
            start_q: zeros(n),
            start_p: zeros(n),
            start_sigma: zeros(m),
            part: Pair::new(n, m),
            unit: vec![0.0; R::PARTS],
            rounding: 0.0,
        };
        Ok(LiftedSolver { refinement: real.refinement(), real, lifted })
    }

    /// Simulates with inputs whose real parts are those of the real motion.
    ///
    /// # Errors
    /// A step whose corrections do not converge, inputs whose size differs from the real ones, or parts that are not finite.
    pub fn simulate(&mut self, inputs: &Inputs<R>) -> Result<&Trajectory<R>, Error> {
        self.lifted.trajectory.computed = 0;
        self.check_sizes(inputs)?;
        if let Some(value) = (0..R::PARTS).find_map(|part| parts(inputs, part).find(|x| !x.is_finite())) {
            return Err(Error::NotFinite { what: "a part of a complex or dual input".into(), value });
        }
        let design = self.real.system().parameters().values(inputs.design.as_slice());
        let assembled = self.assembled(inputs, &design)?;
        let inputs = assembled.as_ref().unwrap_or(inputs);
        self.lifted.begin(self.refinement.refine(inputs), inputs, &design);
        let Solver { system, forward, .. } = &mut self.real;
        let ForwardSweep { motion, stepper, monitor, watch, .. } = forward;
        watch.begin();
        let (linearisation, report) = (&mut stepper.newton.linearisation, &mut monitor.report);
        let mut near = Near { system, motion, linearisation, report, watch };
        self.lifted.start(&mut near)?;
        if !inputs.events.is_empty() {
            self.lifted.step_located(&mut near, inputs, &self.refinement)?;
            return Ok(&self.lifted.trajectory);
        }
        let nodes = self.lifted.inputs.grid.nodes();
        (1..nodes).try_for_each(|i| self.lifted.step(&mut near, i))?;
        Ok(&self.lifted.trajectory)
    }

    /// J of the last motion.
    ///
    /// # Errors
    /// No complete motion, or a cost whose value or real counterpart is not finite (√x has a value for every complex x, but not for every
    /// real x).
    pub fn cost(&self) -> Result<R, Error> {
        let Lifted { trajectory, inputs, .. } = &self.lifted;
        trajectory.check_complete(inputs)?;
        self.real.cost()?;
        trajectory.cost(self.real.system(), inputs)
    }

    /// The values of all outputs of the last motion: with `Dual64`, ∂r · d for a direction d of the inputs.
    ///
    /// # Errors
    /// As [`cost`](Self::cost).
    pub fn outputs(&self) -> Result<DVector<R>, Error> {
        let Lifted { trajectory, inputs, .. } = &self.lifted;
        trajectory.check_complete(inputs)?;
        trajectory.outputs(self.real.system(), inputs)
    }

    /// J (`which` = 0) or an output (`which` from 1 on).
    pub(crate) fn value_of(&self, which: usize) -> Result<R, Error> {
        if which == 0 { self.cost() } else { Ok(self.outputs()?[which - 1]) }
    }

    /// Largest remaining correction of a step in the last motion, relative to the unknowns: the accuracy of derivatives.
    ///
    /// It is about 1e-14. It is larger only if tangent matrices are nearly singular, if springs are very stiff, or if the mechanism is at
    /// rest.
    pub fn rounding(&self) -> f64 {
        self.lifted.rounding
    }

    /// The inputs of the last motion, on the grid that was used.
    pub fn inputs(&self) -> &Inputs<R> {
        &self.lifted.inputs
    }

    /// The real motion.
    pub fn real(&self) -> &Solver {
        &self.real
    }

    /// The inputs with the start assembled from a guess; `None` if the start is not a guess.
    fn assembled(&mut self, inputs: &Inputs<R>, design: &[R]) -> Result<Option<Inputs<R>>, Error> {
        let Solver { system, forward, .. } = &mut self.real;
        let ForwardSweep { motion, stepper, monitor, .. } = forward;
        let (linearisation, report) = (&mut stepper.newton.linearisation, &mut monitor.report);
        let (Start::Assembled { q, v, .. }, Some(assembly)) = (&inputs.start, &motion.assembly) else { return Ok(None) };
        let near = (assembly, motion.at(0).into());
        let given = Given { u: inputs.controls_at(0), t: inputs.grid.start, design };
        let open = motion.open_from(0).collect();
        let mut assembler = Assembler { system, linearisation, report, tolerance: 0.0, open };
        let start = assembler.lift((q.as_slice(), v.as_slice()), near, given)?;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(0));
        Ok(Some(Inputs { start, ..inputs.clone() }))
    }

    fn check_sizes(&self, inputs: &Inputs<R>) -> Result<(), Error> {
        let real = self.real.inputs();
        let inserted = self.real.trajectory().inserted.len();
        let sizes = [
            ("time steps", real.grid.steps.len() - inserted, inputs.grid.steps.len()),
            ("q0", real.start.q().len(), inputs.start.q().len()),
            ("v0 or p*0", real.start.rate().len(), inputs.start.rate().len()),
            ("controls: rows (channels)", real.controls.nrows(), inputs.controls.nrows()),
            ("controls: columns (nodes, one more than steps)", real.controls.ncols() - inserted, inputs.controls.ncols()),
            ("design variables", real.design.len(), inputs.design.len()),
            ("events", real.events.len(), inputs.events.len()),
        ];
        let other = inputs.events.iter().zip(&real.events).find(|(own, real)| own != real);
        match (sizes.into_iter().find(|(_, expected, found)| expected != found), other) {
            (Some((what, expected, found)), _) => Err(Error::Size { what, expected, found }),
            (None, Some((own, real))) => {
                let name = self.real.system().event_name(real.event.index());
                let what = format!("a node in `Inputs::events`, where the real motion has event `{name}`,");
                Err(Error::Parameter { what, value: own.node as f64, must_be: "the node of this event in the real motion" })
            }
            (None, None) if matches!(inputs.start, Start::Assembled { .. }) => Ok(()),
            (None, None) => real.start.check_kind(&inputs.start),
        }
    }
}

impl<R: Real> Lifted<R> {
    /// Stores the inputs on the grid that is used, and the size of their perturbation computed from the given inputs.
    fn begin(&mut self, taken: Inputs<R>, given: &Inputs<R>, design: &[R]) {
        self.rounding = 0.0;
        self.inputs = taken;
        self.design.clear();
        self.design.extend_from_slice(design);
        for part in 1..R::PARTS {
            let all = parts(given, part).chain(design.iter().map(|x| x.part(part)));
            self.unit[part] = all.fold(0.0, |largest, x| largest.max(x.abs()));
        }
        if let [_, first, second, mixed] = &mut self.unit[..] {
            *mixed = mixed.max(*first * *second);
        }
        self.inputs.grid.write_times(&mut self.trajectory.times);
    }

    fn step(&mut self, near: &mut Near, i: usize) -> Result<(), Error> {
        let happened = near.motion.events.at(i);
        // A phase whose end is located is passed several times.
        near.linearisation.evaluation.set_compliance(near.motion.trajectory.compliance_into(i));
        let (scheme, dt) = (self.trajectory.scheme, self.inputs.grid.steps[i - 1]);
        for s in 1..=scheme.stages() {
            let is_node = s == scheme.stages();
            if !is_node {
                self.trajectory.place_stage(i, s, dt, self.inputs.at_ends(i));
            }
            let (y, trajectory) = (self.trajectory.columns(i - 1), &self.trajectory);
            known_part((&scheme, s), dt, (y.q, y.v), |j| trajectory.rates(i, j).0, &mut self.start_q);
            known_part((&scheme, s), dt, (y.p_star, y.p_star_dot), |j| trajectory.rates(i, j).1, &mut self.start_p);
            self.start_sigma.copy_from_slice(y.sigma);
            self.solve_stage(near, (i, s), dt * scheme.a(s, s), happened.filter(|_| is_node).map(|happened| happened.end))?;
        }
        if let Some(happened) = happened {
            self.pass(near, happened)?;
        }
        self.trajectory.computed = i + 1;
        near.watch.tell(Task::Simulation, i + 1, self.inputs.grid.nodes())
    }

    /// p*₀ = T_v(q₀, v₀), unless it is given; then node 0 as a step with h = 0.
    fn start(&mut self, near: &mut Near) -> Result<(), Error> {
        self.start_q.copy_from_slice(self.inputs.start.q().as_slice());
        self.start_p.copy_from_slice(self.inputs.start.rate().as_slice());
        self.start_sigma.fill(R::zero());
        near.linearisation.evaluation.set_compliance(near.motion.trajectory.compliance_from(0));
        if let Start::Velocity { q, v } = &self.inputs.start {
            let sigma = vec![R::zero(); self.trajectory.sigma.nrows()];
            let (u, design) = (self.inputs.controls_at(0), self.design.as_slice());
            let at = NodeView::of_equations([q.as_slice(), v.as_slice(), &sigma], (u, self.trajectory.times[0], design));
            near.system.plain_sums(&at, &mut self.sums);
            self.start_p.copy_from_slice(self.sums.l_v());
        }
        self.solve_node(near, 0)?;
        self.trajectory.computed = 1;
        Ok(())
    }
}

/// One part of all inputs.
fn parts<R: Real>(inputs: &Inputs<R>, part: usize) -> impl Iterator<Item = f64> {
    let (grid, start) = (&inputs.grid, &inputs.start);
    let states = start.q().iter().chain(start.rate().iter());
    let all = states.chain(&inputs.controls).chain(&inputs.design).chain(&grid.steps).chain([&grid.start]);
    all.map(move |x| x.part(part))
}
