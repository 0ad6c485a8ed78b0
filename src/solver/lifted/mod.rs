//! The same simulation on complex or dual numbers: complex step and tangents through all of it, Newton included.
//!
//! The motion is first computed in real numbers. Then every step is solved again on the numbers asked for, starting from the real solution,
//! by the plain element formulas (nothing recorded, nothing condensed, nothing skipped) and corrections with
//! the real tangent matrix: r(x + ε w) = 0 holds for w after one exact correction, because K is converged; another one
//! confirms it. So a derivative found here owes nothing to the blocks that the adjoint is made of: they only decide how
//! fast the iteration converges.

mod correction;
mod restart;

use correction::{Shrinking, Size, add};
use nalgebra::DVector;

use crate::forward::Assembler;
use crate::forward::restart::Restart;
use crate::forward::{ForwardSweep, Motion};
use crate::motion::Refinement;
use crate::motion::column;
use crate::node::{Newton, SMALL};
use crate::number::Real;
use crate::scheme::known_part;
use crate::system::{Given, NodeView, Pair, Sums};
use crate::{Error, Inputs, Report, Settings, Solver, Start, System, Trajectory, memory};

/// Corrections beyond the first are made until they are below this, relative to the unknowns' parts …
const CONVERGED: f64 = 1e-14;
/// … or until the residual is below this, relative to its terms' parts: the rest is rounding.
const ROUNDING: f64 = 1e-13;
/// Velocities below this part of the largest of the motion are rounding.
const AT_REST: f64 = 1e-14;
/// With an exact tangent matrix two corrections do; a slow decrease means that the blocks are wrong.
const MOST_CORRECTIONS_OF_STAGE: usize = 30;

/// Simulates on numbers of type R, many times near one real motion.
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
pub struct LiftedSolver<'s, R: Real> {
    real: Solver<'s>,
    refinement: Refinement,
    lifted: Lifted<R>,
}

/// The motion on other numbers, and what corrects it.
struct Lifted<R: Real> {
    inputs: Inputs<R>,
    /// The values of the parameters, from its design variables.
    design: Vec<R>,
    /// The largest velocity of the real motion.
    speed: f64,
    trajectory: Trajectory<R>,
    sums: Sums<R>,
    /// q̄ and p̄ of the stage at hand, and σ₋.
    start_q: Vec<R>,
    start_p: Vec<R>,
    start_sigma: Vec<R>,
    /// A residual, then a correction, of one part.
    part: Pair,
    /// The largest perturbation of any input, in each part beyond the real one: 1e-30 for a complex step, 1 for a tangent.
    unit: Vec<f64>,
    /// The largest correction that was left to rounding, relative to what a perturbation of that size could be.
    rounding: f64,
}

/// The real motion that the other one is near, and its Newton matrix.
struct Near<'a> {
    system: &'a System,
    motion: &'a Motion,
    newton: &'a mut Newton,
    report: &'a mut Report,
}

impl<'s, R: Real> LiftedSolver<'s, R> {
    /// Computes the real motion.
    ///
    /// # Errors
    /// As [`Solver::simulate`].
    pub fn new(system: &'s System, inputs: &Inputs, settings: Settings) -> Result<Self, Error> {
        let mut real = Solver::new(system, settings);
        real.simulate(inputs)?;
        let (n, m) = (system.n(), system.m());
        let zeros = |len| vec![R::zero(); len];
        let node = Trajectory::<R>::len_of_node(n, m) * settings.scheme.stages() + 1 + system.k();
        memory::check("the motion on other numbers", real.inputs().grid.nodes(), node * size_of::<R>())?;
        let mut trajectory = Trajectory::zeros(system, real.inputs().grid.nodes(), settings.scheme);
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
    /// A step whose corrections do not converge; sizes that differ from those of the real inputs; parts that are not finite.
    pub fn simulate(&mut self, inputs: &Inputs<R>) -> Result<&Trajectory<R>, Error> {
        self.lifted.trajectory.computed = 0;
        self.check_sizes(inputs)?;
        if let Some(value) = (0..R::PARTS).find_map(|part| parts(inputs, part).find(|x| !x.is_finite())) {
            return Err(Error::NotFinite { what: "a part of a lifted input".into(), value });
        }
        let design = self.real.system().parameters().values(inputs.design.as_slice());
        let assembled = self.assembled(inputs, &design)?;
        let inputs = assembled.as_ref().unwrap_or(inputs);
        self.lifted.begin(self.refinement.refine(inputs), inputs, &design);
        let system = self.real.system();
        let ForwardSweep { motion, stepper, monitor, .. } = self.real.forward_mut();
        let mut near = Near { system, motion, newton: &mut stepper.newton, report: &mut monitor.report };
        self.lifted.start(&mut near)?;
        let nodes = self.lifted.inputs.grid.nodes();
        (1..nodes).try_for_each(|i| self.lifted.step(&mut near, i))?;
        Ok(&self.lifted.trajectory)
    }

    /// J of the last motion.
    ///
    /// # Errors
    /// No complete motion; a cost that is not finite, in real numbers too: √x has a value for every complex x.
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

    /// J (0) or an output (from 1 on).
    pub(crate) fn value_of(&self, which: usize) -> Result<R, Error> {
        if which == 0 { self.cost() } else { Ok(self.outputs()?[which - 1]) }
    }

    /// The largest correction of a step that was left to rounding in the last motion, relative to the unknowns; derivatives are no better.
    ///
    /// It is about 1e-14, and more only where tangent matrices are close to singular, springs are very stiff, or nothing moves.
    pub fn rounding(&self) -> f64 {
        self.lifted.rounding
    }

    /// The inputs of the last motion, on the grid that was taken.
    pub fn inputs(&self) -> &Inputs<R> {
        &self.lifted.inputs
    }

    /// The real motion.
    pub fn real(&self) -> &Solver<'s> {
        &self.real
    }

    /// The inputs with the start that a guess leads to, if there is one.
    fn assembled(&mut self, inputs: &Inputs<R>, design: &[R]) -> Result<Option<Inputs<R>>, Error> {
        let system = self.real.system();
        let ForwardSweep { motion, stepper, monitor, .. } = self.real.forward_mut();
        let (newton, report) = (&mut stepper.newton, &mut monitor.report);
        let (Start::Assembled { q, v, .. }, Some(assembly)) = (&inputs.start, &motion.assembly) else { return Ok(None) };
        let near = (assembly, motion.at(0).into());
        let given = Given { u: inputs.controls_at(0), t: inputs.grid.start, design };
        let mut assembler = Assembler { system, newton, report, tolerance: 0.0 };
        let start = assembler.lift((q.as_slice(), v.as_slice()), near, given)?;
        newton.evaluation.set_compliance(motion.trajectory.compliance_from(0));
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
        ];
        match sizes.into_iter().find(|(_, expected, found)| expected != found) {
            Some((what, expected, found)) => Err(Error::Size { what, expected, found }),
            None if matches!(inputs.start, Start::Assembled { .. }) => Ok(()),
            None => real.start.check_kind(&inputs.start),
        }
    }
}

impl Near<'_> {
    /// Factors K(h) with the blocks of a stage of the step into a node.
    fn factor(&mut self, i: usize, h: f64, blocks: &[f64]) -> Result<(), Error> {
        let factored = self.newton.factor(self.system, h, blocks, self.report);
        factored.map(|_| ()).map_err(|breakdown| self.system.singular_step(&breakdown, i, self.motion.trajectory.times[i]))
    }
}

impl<R: Real> Lifted<R> {
    /// Takes the inputs on the grid that was taken, and the size of their perturbation from those that were given.
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
        let restart = near.motion.restarts.at(i);
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
            self.solve_stage(near, (i, s), dt * scheme.a(s, s), restart.filter(|_| is_node))?;
        }
        if let Some(restart) = restart {
            self.restart(near, i, &restart)?;
        }
        self.trajectory.computed = i + 1;
        Ok(())
    }

    /// p*₀ = T_v(q₀, v₀), unless it is given; then node 0 as a step with h = 0.
    fn start(&mut self, near: &mut Near) -> Result<(), Error> {
        self.start_q.copy_from_slice(self.inputs.start.q().as_slice());
        self.start_p.copy_from_slice(self.inputs.start.rate().as_slice());
        self.start_sigma.fill(R::zero());
        near.newton.evaluation.set_compliance(near.motion.trajectory.compliance_from(0));
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

    fn solve_node(&mut self, near: &mut Near, i: usize) -> Result<(), Error> {
        self.solve_stage(near, (i, self.trajectory.last_stage()), R::zero(), None)
    }

    /// Solves a stage, or the end of the step into a node if there was a restart, from the real solution on.
    fn solve_stage(&mut self, near: &mut Near, (i, s): (usize, usize), h: R, restart: Option<Restart>) -> Result<(), Error> {
        let motion = near.motion;
        self.start_from_real(motion, (i, s), restart);
        let at = motion.block_column(i, s);
        let blocks = restart.map_or_else(|| column(&motion.blocks, at), |restart| restart.step_blocks);
        near.factor(i, h.part(0), blocks)?;
        let mut sizes = Shrinking::new();
        for correction in 0..MOST_CORRECTIONS_OF_STAGE {
            self.evaluate(near, (i, s), h);
            let (size, is_rounding) =
                self.correct(near, (i, s), h).ok_or_else(|| overflow(near, i, "the complex or dual part of the motion"))?;
            let is_stalled = sizes.is_stalled(size.of_part);
            if correction > 0 && (size.of_part <= CONVERGED || is_rounding || is_stalled) {
                self.rounding = self.rounding.max(size.of_all);
                self.evaluate(near, (i, s), h);
                self.store((i, s), h);
                return Ok(());
            }
        }
        Err(self.diverged(near, i, (MOST_CORRECTIONS_OF_STAGE, sizes.last), "the complex or dual part of the step"))
    }

    fn diverged(&self, near: &Near, i: usize, (iterations, residual): (usize, f64), what: &str) -> Error {
        Error::Newton {
            step: near.motion.given_step(i),
            time: self.trajectory.times[i].part(0),
            iterations,
            length: i.checked_sub(1).map_or(0.0, |before| self.inputs.grid.steps[before].part(0)),
            residual,
            equation: what.into(),
            driven: Vec::new(),
            jump: None,
        }
    }

    fn start_from_real(&mut self, motion: &Motion, (i, s): (usize, usize), restart: Option<Restart>) {
        let real = motion.trajectory.stage(i, s);
        let (v, sigma) = restart.map_or((real.v, real.sigma), |restart| (restart.v, restart.sigma));
        let lift = |to: &mut [R], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, &from)| *to = from.into());
        let now = self.trajectory.stage_mut(i, s);
        lift(now.v, v);
        lift(now.sigma, sigma);
    }

    /// q = q̄ + h v and the sums of all elements there.
    fn evaluate(&mut self, near: &Near, (i, s): (usize, usize), h: R) {
        let now = self.trajectory.stage_mut(i, s);
        for ((q, &start), &v) in now.q.iter_mut().zip(&self.start_q).zip(now.v.iter()) {
            *q = start + h * v;
        }
        let now = self.trajectory.stage(i, s);
        let sigma = now.sigma;
        let u = if s == self.trajectory.last_stage() { self.inputs.controls_at(i) } else { now.u };
        near.system.plain_sums(&now.with_inputs((u, &self.design)), &mut self.sums);
        for &(j, mu) in near.newton.evaluation.compliance() {
            self.sums.parts_mut()[2][j] -= (sigma[j] - self.start_sigma[j]) * mu;
        }
    }

    /// One correction of every part by K⁻¹; returns its size, the largest of all parts, and whether the residual before it was nothing but
    /// rounding; if all parts are finite.
    fn correct(&mut self, near: &mut Near, (i, s): (usize, usize), h: R) -> Option<(Size, bool)> {
        let (mut largest, mut is_rounding) = (Size::default(), true);
        for part in 0..R::PARTS {
            let (mut residual, mut scale) = (0.0f64, 0.0f64);
            for (k, r) in self.part.v.iter_mut().enumerate() {
                let terms = [self.start_p[k], h * self.sums.force()[k], self.sums.l_v()[k]];
                *r = (terms[0] + terms[1] - terms[2]).part(part);
                residual = residual.max(r.abs());
                // A term whose part is zero but for rounding counts by its real part and the size of the perturbation.
                for term in terms {
                    scale = scale.max(term.part(part).abs()).max(term.part(0).abs() * self.unit[part]);
                }
            }
            is_rounding &= residual <= ROUNDING * scale;
            self.part.sigma.iter_mut().zip(self.sums.phi_dot()).for_each(|(r, phi_dot)| *r = -phi_dot.part(part));
            near.newton.solve(near.system, &mut self.part);
            let unit = self.unit[part];
            // At rest but for rounding, derivatives that vanish are rounding too.
            let speed = largest_real(self.trajectory.stage(i, s).v);
            let floor = if speed <= AT_REST * self.speed { SMALL * self.speed * unit } else { 0.0 };
            largest = largest.max(add(self.trajectory.stage_mut(i, s).v, part, &self.part.v, (floor, unit))?);
            // σ from rest is a difference of momenta, and its rounding is theirs.
            let sigma = add(self.trajectory.stage_mut(i, s).sigma, part, &self.part.sigma, (SMALL * scale, unit))?;
            // Of dependent constraints, the part of σ that moves nothing is known to a few digits only.
            largest = if self.trajectory.compliance.is_empty() { largest.max(sigma) } else { largest };
        }
        Some((largest, is_rounding))
    }

    /// p* = p̄ + h ṗ*, and ṗ* = 𝓛_q + Q.
    fn store(&mut self, (i, s): (usize, usize), h: R) {
        let now = self.trajectory.stage_mut(i, s);
        for ((p, &start), &force) in now.p_star.iter_mut().zip(&self.start_p).zip(self.sums.force()) {
            *p = start + h * force;
        }
        now.p_star_dot.copy_from_slice(self.sums.force());
    }
}

/// The error of a part that is beyond the range of numbers at a node.
fn overflow(near: &Near, i: usize, what: &str) -> Error {
    Error::Overflow { what: format!("{what} at node {}", near.motion.given_step(i)), value: f64::INFINITY }
}

fn largest_real<R: Real>(x: &[R]) -> f64 {
    x.iter().fold(0.0, |largest, x| largest.max(x.part(0).abs()))
}

/// One part of all inputs.
fn parts<R: Real>(inputs: &Inputs<R>, part: usize) -> impl Iterator<Item = f64> {
    let (grid, start) = (&inputs.grid, &inputs.start);
    let states = start.q().iter().chain(start.rate().iter());
    let all = states.chain(&inputs.controls).chain(&inputs.design).chain(&grid.steps).chain([&grid.start]);
    all.map(move |x| x.part(part))
}
