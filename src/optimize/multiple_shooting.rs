//! [`MultipleShooting`]: a motion in segments, each with a start of its own.

mod accepted;
mod problem;

use nalgebra::DVector;
use std::ops::{ControlFlow, Range};

use super::free::{Free, check_reading_times};
use super::motion_problem::{MotionProblem, default_constraints};
use super::problem::{Interval, Problem};
use super::segment::{Part, Segment};
use super::sizes::Sizes;
use super::variables::Variables;
use crate::motion::{Progress, Watch};
use crate::{Coordinate, Error, Inputs, Output, Settings, System};

/// A continuity condition: its row, the entry of (q, v, p\*) at the end of a segment, and the variable of the next one's start that equals it.
pub(super) struct Joint {
    pub(super) row: usize,
    pub(super) end: usize,
    pub(super) start: usize,
}

/// Multiple shooting (Bock and Plitt 1984): the problem of minimising J subject to constraints on outputs and to the continuity of the
/// segments of the motion.
///
/// The initial states of the segments are variables, so a guess of the motion can be given, and the start of a segment affects the motion
/// only up to the end of this segment. Each segment is a motion of its own with σ₀ = 0. With constraints the result therefore differs from
/// a single motion by the error of the scheme; if this matters, use [`solve`](super::solve()), which joins the segments.
///
/// Terminal terms are evaluated at the end of the last segment, and a term at a single node belongs to the segment that contains the node.
/// With constraints, costs may not depend on σ, p\* or ṗ\*, which restart with every segment (this is not detected for formulas that branch).
///
/// [`stages`](super::stages()) solves the problem segment by segment. It is a [`Problem`](super::Problem) for all other methods, too.
///
/// ```
/// use hamiltonian_adjoint::optimize::{Free, Interval, MultipleShooting, Options, silent, stages};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, scenes::CartPendulum};
/// use std::f64::consts::{FRAC_PI_2, PI};
///
/// let mut cart = CartPendulum::with_links(1).mechanism();
/// let (force, rail, angle) = (cart.force, cart.cart.coordinates[0], cart.links[0].coordinates[2]);
/// cart.scene.effort("effort", force, 1e-4);
/// let states = [rail, angle].map(|q| cart.scene.end_state(q)); // one for each degree of freedom
/// let system = cart.scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
/// let mut problem = MultipleShooting::new(&system, Settings::default(), inputs, vec![Free::control(force)], &states, 4)?;
/// problem.constrain(states[1].position, Interval::equal(FRAC_PI_2));
/// // A guess: the link turns evenly.
/// problem.guess(|node, q, v| {
///     q[angle.index()] = -FRAC_PI_2 + PI * node as f64 / 40.0;
///     v[angle.index()] = PI;
/// })?;
/// let start = problem.start();
/// let best = stages(&mut problem, &start, &Options { stationarity: 1e-5, ..Options::default() }, &mut silent)?;
/// assert!(best.reason.is_converged() && best.violation < 1e-9);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Debug)]
pub struct MultipleShooting {
    pub(super) segments: Vec<Segment>,
    /// The free quantities of the whole motion: the first variables, followed by the states at the cuts.
    pub(super) whole: Variables,
    /// The inputs given at construction, or of the last successful evaluation.
    inputs: Inputs,
    x: Vec<f64>,
    /// The point that was tried last, with a value.
    tried: Vec<f64>,
    /// The independent coordinates at the start of the segments.
    states: Vec<Coordinate>,
    /// The entries of (q, v, p\*) at the end of a segment that the variables of the next one's start equal.
    pub(super) entries: Vec<usize>,
    names: Vec<String>,
    /// For each output, true if all segments contribute to it, false if only the last one does.
    pub(super) running: Vec<bool>,
    pub(super) constraints: Vec<Interval>,
    /// For each output, true if it is a term of f.
    pub(super) minimised: Vec<bool>,
}

impl MultipleShooting {
    /// A problem with these inputs and free quantities, in a number of segments with about equal numbers of steps. `states` lists one
    /// coordinate for each degree of freedom, or its end state; the others follow from the constraints.
    ///
    /// # Errors
    /// Invalid inputs and starts, as for a [`MotionProblem`]; more segments than (macro) steps, or none; states that are too few, repeated,
    /// determined by constraints or of another scene; free single step lengths; controls on coarser knots with steps of different signs; with
    /// constraints, costs on σ, p\* or ṗ\*; a free duration if anything depends on time explicitly.
    pub fn new<C: Copy + Into<Coordinate>>(
        system: &System,
        settings: Settings,
        inputs: Inputs,
        free: Vec<Free>,
        states: &[C],
        segments: usize,
    ) -> Result<Self, Error> {
        let states: Vec<Coordinate> = states.iter().map(|state| (*state).into()).collect();
        let whole = Variables::new(system, &inputs, free.clone())?;
        let running = accepted::running_outputs(system);
        accepted::check(system, &inputs, &free, &states, segments)?;
        check_reading_times(system, &inputs, &free)?;
        let of_macro_steps: Vec<usize> = inputs.grid.macro_ends().collect();
        // Cut k is after k/segments of the macro steps, rounded down, so that cuts are in order; remaining steps belong to the last segment.
        let cut = |k: usize| (k * of_macro_steps.len() / segments).checked_sub(1).map_or(0, |last| of_macro_steps[last]);
        let end = |k: usize| if k + 1 < segments { cut(k + 1) } else { inputs.grid.steps.len() };
        let ends: Vec<Range<usize>> = (0..segments).map(|k| cut(k)..end(k)).collect();
        let knots = whole.knots_of(&ends);
        let mut next = whole.len();
        let mut names: Vec<String> = (0..next).map(|i| whole.name(i).to_string()).collect();
        let mut all = Vec::with_capacity(segments);
        for (nodes, knots) in ends.into_iter().zip(knots) {
            let first = nodes.start;
            if first > 0 {
                let of = |q: &Coordinate| {
                    ["", "rate of "].map(|of| format!("{of}{} at node {first}", system.coordinate_name(q.index())))
                };
                names.extend(states.iter().flat_map(of));
            }
            all.push(Segment::new((system, settings), (&inputs, &whole), &states, Part { nodes, knots }, &mut next)?);
        }
        let mut constraints = default_constraints(system);
        constraints.resize(running.len() + 2 * states.len() * (segments - 1), Interval::ZERO);
        let entries = states.iter().flat_map(|q| [q.index(), system.n() + q.index()]).collect();
        let (minimised, mut x) = (vec![false; running.len()], whole.of(&inputs));
        let still = DVector::zeros(system.n());
        all[1..].iter_mut().for_each(|segment| x.extend(segment.guess(inputs.start.q(), &still)));
        let tried = x.clone();
        Ok(MultipleShooting {
            segments: all,
            whole,
            inputs,
            x,
            tried,
            states,
            entries,
            names,
            running,
            constraints,
            minimised,
        })
    }

    /// Sets the guess of the initial states of the segments: `of` receives the node, and modifies q and v.
    ///
    /// # Errors
    /// Values that are not finite; nothing is changed in this case.
    pub fn guess(&mut self, mut of: impl FnMut(usize, &mut DVector<f64>, &mut DVector<f64>)) -> Result<(), Error> {
        let mut guessed = Vec::with_capacity(self.segments.len());
        for segment in &mut self.segments[1..] {
            let Some(mut q) = segment.near() else { continue };
            let mut v = DVector::zeros(q.len());
            for (which, place) in self.states.iter().zip(segment.start_places().chunks(2)) {
                let i = which.index();
                (q[i], v[i]) = (self.x[place[0]], self.x[place[1]]);
            }
            of(segment.first, &mut q, &mut v);
            for (what, of) in [("coordinate", &q), ("velocity", &v)] {
                if let Some(i) = of.iter().position(|x| !x.is_finite()) {
                    let name = segment.motion.solver.system().coordinate_name(i).to_string();
                    let what = format!("the guess of the {what} of `{name}` at node {}", segment.first);
                    return Err(Error::NotFinite { what, value: of[i] });
                }
            }
            guessed.push((q, v));
        }
        for (segment, (q, v)) in self.segments[1..].iter_mut().zip(guessed) {
            let z = segment.guess(&q, &v);
            segment.start_places().iter().zip(z).for_each(|(&at, x)| self.x[at] = x);
            segment.motion.solver.drop_motion();
        }
        Ok(())
    }

    pub(super) fn system(&self) -> &System {
        self.segments[0].motion.solver.system()
    }

    /// Sets the interval of an output; [`Interval::FREE`] only reports it.
    ///
    /// # Panics
    /// If the output belongs to another scene.
    pub fn constrain(&mut self, output: Output, to: Interval) {
        let at = self.system().place_of(output);
        self.constraints[at] = to;
    }

    /// Adds an output to the cost instead of constraining it, for example as a terminal cost.
    ///
    /// # Panics
    /// If the output belongs to another scene.
    pub fn minimise(&mut self, output: Output) {
        let at = self.system().place_of(output);
        self.minimised[at] = true;
        self.constrain(output, Interval::FREE);
    }

    /// The variables of the given inputs and the guess, or of the last point evaluated with a value.
    pub fn start(&self) -> Vec<f64> {
        self.x.clone()
    }

    /// A motion at a point in a number of segments, with the constraints of its problem, which reports to the progress callback of its solver.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub(super) fn of(problem: &MotionProblem, x: &[f64], (states, segments): (&[Coordinate], usize)) -> Result<Self, Error> {
        let (system, settings) = (problem.solver.system(), problem.solver.settings());
        let (inputs, free) = (problem.inputs_at(x), problem.free().free().to_vec());
        let mut shooting = MultipleShooting::new(system, settings, inputs, free, states, segments)?;
        // Coefficients of splines do not follow from controls at nodes.
        shooting.x[..x.len()].copy_from_slice(x);
        shooting.report_to(&problem.solver.forward().watch);
        for (k, interval) in problem.constraints().into_iter().enumerate() {
            shooting.constrain(system.output(k), interval);
        }
        Ok(shooting)
    }

    /// Starts each segment with the drift and the multipliers of the end of the previous one.
    ///
    /// # Errors
    /// A segment without a motion.
    fn follow(&mut self) -> Result<(), Error> {
        let times = self.inputs.grid.times();
        for k in 1..self.segments.len() {
            let end = self.segments[k - 1].motion.solver.end_of_constraints();
            let segment = &mut self.segments[k];
            let own: Vec<f64> = segment.places.iter().map(|&at| self.x[at]).collect();
            segment.continue_from(end);
            segment.try_at(&own, times[segment.first])?;
            segment.settle();
        }
        Ok(())
    }

    /// Replaces the independent coordinates at the starts of the segments by q and p\*, so that the segments are a single motion once they meet.
    /// Returns the variables.
    ///
    /// # Errors
    /// A segment without a motion.
    pub(super) fn join(&mut self) -> Result<Vec<f64>, Error> {
        self.follow()?;
        let (n, whole) = (self.system().n(), self.whole.len());
        let mut x = self.x.clone();
        x.truncate(whole);
        self.names.truncate(whole);
        for segment in &mut self.segments[1..] {
            x.extend(segment.use_state(x.len()));
            let all = ["", "p* of "].into_iter().flat_map(|of| (0..n).map(move |i| (of, i)));
            let (system, first) = (segment.motion.solver.system(), segment.first);
            self.names.extend(all.map(|(of, i)| format!("{of}{} at node {first}", system.coordinate_name(i))));
        }
        self.entries = (0..n).chain(2 * n..3 * n).collect();
        self.constraints.truncate(self.running.len());
        self.constraints.resize(self.running.len() + self.entries.len() * (self.segments.len() - 1), Interval::ZERO);
        self.x.clone_from(&x);
        Ok(x)
    }

    /// The inputs of a single motion over all segments at a point.
    ///
    /// # Panics
    /// If the point has too few variables.
    pub fn inputs_at(&self, x: &[f64]) -> Inputs {
        let mut inputs = self.inputs.clone();
        self.whole.write(x, &mut inputs);
        inputs
    }

    /// Sets a progress callback for all motions and gradients, as [`Solver::watch`](crate::Solver::watch) does, counting the nodes of all
    /// segments. If it returns `Break`, the method stops with [`Reason::Interrupted`](super::Reason::Interrupted).
    pub fn watch(&mut self, callback: impl FnMut(Progress) -> ControlFlow<()> + Send + 'static) {
        self.report_to(&Watch::new(callback));
    }

    /// Reports progress to the callback of another motion, if it has one.
    pub(super) fn report_to(&mut self, watch: &Watch) {
        let last = self.inputs.grid.nodes() - 1;
        for segment in &mut self.segments {
            segment.motion.solver.forward_mut().watch = watch.shared([segment.first, last - segment.last]);
        }
    }

    fn sizes(&self) -> Sizes {
        Sizes { variables: self.names.len(), constraints: self.constraints.len() }
    }

    /// The segments, each with the motion of the last evaluated point.
    pub fn segments(&self) -> impl Iterator<Item = &MotionProblem> {
        self.segments.iter().map(|segment| &segment.motion)
    }

    /// Continuity conditions between the end of a segment and the start of the next one: row, entry of (q, v, p\*) at the end, and variable.
    pub(super) fn joints(&self, segment: usize) -> impl Iterator<Item = Joint> + use<'_> {
        let row = self.running.len() + self.entries.len() * segment;
        let starts = self.segments.get(segment + 1).map_or(&[][..], Segment::start_places);
        self.entries.iter().copied().zip(starts).enumerate().map(move |(k, (end, start))| Joint {
            row: row + k,
            end,
            start: *start,
        })
    }

    /// True if a segment contributes to an output.
    pub(super) fn contributes(&self, segment: usize, output: usize) -> bool {
        self.running[output] || segment + 1 == self.segments.len()
    }

    /// The outputs to which a segment contributes.
    fn rows(&self, segment: usize) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.running.len()).filter(move |&output| self.contributes(segment, output))
    }
}
