//! Checks that steps resolve the elements: the gradient of a discrete motion is exact, but useless if forces change faster than the steps.
//!
//! An element adds w = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt to the adjoint equations of a step, with the step's c, d and e divided by Δt. On the chord from
//! the point where the step begins to the one where it ends, (q, v, σ, u, t) for s = 0 … 1, the trapezoidal rule represents the derivatives by those
//! at the ends. Let ε be its error, and S the change of the cost per second of advance of the motion:
//!
//! ```text
//!   ε = w(1) − w(0) − ½ (w′(0) + w′(1)),      S = (|aᵀ(q − q₋)| + |bᵀ(p* − p*₋)|)/Δt
//! ```
//!
//! An advance of the motion by τ changes the cost by τ S, and the gradient has the error τ ε of it: of third order in the step for smooth elements,
//! equal to the jump for a force that jumps within the step. The ε of steps over a narrow peak that several nodes sample cancel, as do those of the
//! stages of a composed step. They are therefore summed over the steps of one run; the root of the sum of squares of |Σ ε|/S over all runs and
//! elements causes a warning above [`Warning::BENT`]. On composed grids a macro step is one run, and every step is checked.
//!
//! On other grids a step is checked only if the velocities at its end were badly predicted, so that the check of a resolved motion costs nothing.
//! Forces that no node samples are not detected: a well or a pulse between two nodes.

use crate::adjoint::AdjointSweep;
use crate::motion::{Motion, Report, StepEnd};
use crate::node::Linearisation;
use crate::number::dot;
use crate::system::{Covector, NodeValues, NodeView, Within};
use crate::{System, Warning};

/// An element bends if the error ε of a step exceeds this fraction of the change.
const BENT: f64 = 0.2;
/// The error of a single step counts on its own, even if others compensate it, above this fraction of the change: a pulse sampled by one node.
const MISSED: f64 = 0.8;
/// Number of well-predicted steps that end a run.
const QUIET: usize = 3;

/// Errors of elements within steps.
pub(crate) struct Resolution {
    /// The change of the arguments along a step.
    change: NodeValues<f64>,
    /// The step's c, d and e.
    c: Vec<f64>,
    d: Vec<f64>,
    e: Vec<f64>,
    /// The current run, by element.
    bends: Vec<Bend>,
    /// The largest S in the run.
    most: f64,
    /// Number of well-predicted steps since the last badly predicted one; `None` if no run has begun.
    quiet: Option<usize>,
    /// Σ (Σ ε/S)².
    total: f64,
    /// The largest of these terms, its element, and the step with the largest error.
    worst: f64,
    element: usize,
    at: Place,
}

/// The errors of an element in a run.
#[derive(Clone, Copy, Default)]
struct Bend {
    missed: f64,
    /// The largest error of a step that counts on its own.
    alone: f64,
    bends: bool,
    most: f64,
    /// The number of the element among all elements.
    element: usize,
    at: Place,
}

/// A step, counted from 1, and its end, s.
#[derive(Clone, Copy, Default)]
struct Place {
    step: usize,
    time: f64,
}

impl Resolution {
    pub(crate) fn new(system: &System) -> Self {
        let bending = system.formulas().assembly.bending();
        let (n, m, k) = if bending > 0 { (system.n(), system.m(), system.k()) } else { (0, 0, 0) };
        let zeros = |len| vec![0.0; len];
        Resolution {
            change: NodeValues::zeros((n, m, k), 0),
            c: zeros(n),
            d: zeros(n),
            e: zeros(m),
            bends: vec![Bend::default(); bending],
            most: 0.0,
            quiet: None,
            total: 0.0,
            worst: 0.0,
            element: 0,
            at: Place::default(),
        }
    }

    pub(crate) fn begin(&mut self) {
        self.end_run();
        (self.total, self.worst) = (0.0, 0.0);
    }

    fn end_run(&mut self) {
        for bend in &mut self.bends {
            let Bend { missed, alone, bends, element, at, .. } = std::mem::take(bend);
            let missed = missed.abs().max(alone);
            let share = if bends && missed > 0.0 { missed / self.most } else { 0.0 };
            self.total += share * share;
            if share > self.worst {
                (self.worst, self.element, self.at) = (share, element, at);
            }
        }
        (self.most, self.quiet) = (0.0, None);
    }

    /// Warns of unresolved elements if the errors are large enough.
    pub(crate) fn tell(&mut self, system: &System, report: &mut Report) {
        self.end_run();
        let share = self.total.sqrt();
        if share > Warning::BENT {
            let element = system.formulas().elements[self.element].name.as_str().into();
            report.warn(Warning::UnresolvedElement { element, step: self.at.step, time: self.at.time, share });
        }
    }
}

/// Computes the change from one point to another; design variables are constant.
fn load_change(change: &mut NodeValues<f64>, [from, to]: [&NodeView<f64>; 2]) {
    let load = |into: &mut [f64], from: &[f64], to: &[f64]| {
        into.iter_mut().zip(from.iter().zip(to)).for_each(|(x, (from, to))| *x = to - from);
    };
    load(&mut change.q, from.q, to.q);
    load(&mut change.v, from.v, to.v);
    load(&mut change.sigma, from.sigma, to.sigma);
    load(&mut change.u, from.u, to.u);
    change.t = to.t - from.t;
}

impl AdjointSweep {
    /// Checks whether elements bend within the step that ends at a node, if necessary; its adjoint equations have just been solved.
    pub(crate) fn watch_resolution(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        end: Option<&StepEnd>,
        node: usize,
    ) {
        let (run, grid) = (&mut self.resolution, &motion.inputs.grid);
        if motion.length(node) == 0.0 {
            return run.end_run();
        }
        if grid.stages > 1 {
            // The stages of a macro step compensate each other's errors.
            if self.refinement.given_node(node).is_some_and(|given| grid.macro_steps(given).is_some()) {
                run.end_run();
            }
            run.quiet = Some(0);
        } else if motion.is_surprising(node) {
            run.quiet = Some(0);
        } else if let Some(quiet) = &mut run.quiet {
            *quiet += 1;
            if *quiet > QUIET {
                run.end_run();
            }
        }
        if self.resolution.quiet.is_some() {
            self.look_into_step(system, motion, linearisation, end, node);
        }
    }

    #[cold]
    fn look_into_step(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        end: Option<&StepEnd>,
        node: usize,
    ) {
        let (here, before) = (motion.at(node), motion.at(node - 1));
        let steps = &motion.inputs.grid.steps;
        let after = if end.is_some() { 0.0 } else { steps.get(node).copied().unwrap_or(0.0) };
        let both = 0.5 * (steps[node - 1] + after);
        let end = end.map_or(here, |end| end.view(here));
        let Resolution { change, c, d, e, bends, most, .. } = &mut self.resolution;
        load_change(change, [&before, &end]);
        // c and e belong to the halves of both steps at the node.
        let per_second = if both == 0.0 { 0.0 } else { both.recip() };
        let done = &self.step[self.stage];
        c.iter_mut().zip(&done.c).for_each(|(c, of_node)| *c = per_second * of_node);
        e.iter_mut().zip(&done.e).for_each(|(e, of_node)| *e = per_second * of_node);
        d.iter_mut().zip(&done.b).for_each(|(d, b)| *d = -b);
        let mean = |x: &[f64], y: &[f64], z: &[f64]| 0.5 * (dot(x, y) + dot(x, z)).abs();
        let gain = mean(&done.a, end.v, before.v) + mean(&done.b, end.p_star_dot, before.p_star_dot);
        *most = most.max(gain);
        let place = Place { step: self.refinement.step_of_whole(node), time: here.t };
        let mut bends = bends.iter_mut();
        let mut judge = |Within { element, missed, change }: Within| {
            let Some(bend) = bends.next().filter(|_| missed.is_finite()) else { return };
            bend.missed += missed;
            if missed.abs() > MISSED * change {
                bend.alone = bend.alone.max(missed.abs());
            }
            if missed.abs() > BENT * change {
                bend.bends = true;
                if missed.abs() > bend.most {
                    (bend.most, bend.element, bend.at) = (missed.abs(), element, place);
                }
            }
        };
        let with = Covector { c, d, e };
        linearisation.evaluation.look_within(system, ([&before, &end], &change.view()), &with, &mut judge);
        self.report.chord_evaluations += 2 * self.resolution.bends.len();
    }
}
