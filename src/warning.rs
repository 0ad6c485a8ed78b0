//! What a run has to say although it succeeded.

use std::fmt;

use crate::error::seconds;

/// A finding about the mechanism or the numbers of a run, by name, place and size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Constraints that follow from others; they were given a compliance, see [`Trajectory::compliance`](crate::Trajectory::compliance).
    DependentConstraints {
        /// The equations that take part in the dependency.
        equations: Vec<String>,
        /// When, s.
        time: f64,
    },
    /// A change of a design variable alone makes constraints that depend on each other contradict: the mechanism can be put together, or moves, for the present value
    /// only, and the derivative with respect to it is that of no motion nearby.
    BrokenDependence {
        /// The design variables.
        designs: Vec<String>,
        /// The equations that take part in the dependency.
        equations: Vec<String>,
        /// When, s.
        time: f64,
    },
    /// Constraints depend on design variables, as on the length of a link, and the start is given: dJ/db is that of motions from the same q₀, which with another
    /// value would violate them. An assembled start ([`Start::Assembled`](crate::Start::Assembled)) follows, and dJ/db is the total derivative.
    GivenStart {
        /// The design variables.
        designs: Vec<String>,
        /// The elements whose constraints depend on them at the start.
        elements: Vec<String>,
    },
    /// A formula takes the value of an argument by `re()`, as to look it up in a table, and goes on with a plain number: its values change with the argument,
    /// its derivatives do not, and gradients are wrong. The value belongs into the choice of a piece alone, and the number itself into what is computed there.
    LostDerivative {
        /// The element, the cost or the term of an output.
        element: String,
        /// The first argument by which the derivative is lost.
        argument: String,
    },
    /// A problem has no cost and no output that must be anything: every point is its solution.
    NothingAsked,
    /// Costs or outputs read σ of constraints that depend on each other: how these share their common reaction follows from the compliance, to about five digits,
    /// and so do these values and their derivatives.
    SharedReaction {
        /// The costs, and the terms of outputs.
        costs: Vec<String>,
        /// The equations whose multipliers they read.
        equations: Vec<String>,
    },
    /// At the start the kinetic energy is negative for velocities that the constraints allow: what is pushed there moves against the push. A negative mass in
    /// a direction that constraints forbid does no harm.
    NegativeMass {
        /// The coordinates: those with a negative M_ii or, where there are none, all that such velocities move.
        coordinates: Vec<String>,
        /// The smallest M_ii of these coordinates, kg or kg m².
        mass: f64,
        /// When, s.
        time: f64,
    },
    /// Positions have drifted from constraints that depend on each other, so that what each allows another forbids: their compliance resists the motion.
    ///
    /// A drift of Φ_q by δ takes δ²/1e-11 of the velocity in each step, while what is left of dΦ/dt = 0 is small. Otherwise it is [`LeftOut`](Warning::LeftOut);
    /// this is for where nothing can be left out.
    Braked {
        /// The step in which most was taken, counted from 1.
        step: usize,
        /// When it ends, s.
        time: f64,
        /// What the compliances took there, times the number of steps, relative to the largest kinetic energy; at least [`BRAKED`](Warning::BRAKED).
        share: f64,
    },
    /// Positions drift apart from constraints that depend on each other, which would brake the motion: as many as follow from the others are left out, and
    /// chosen anew before the rest comes to depend on each other. [`Trajectory::compliance`](crate::Trajectory::compliance) has all choices.
    LeftOut {
        /// The equations that are left out first.
        equations: Vec<String>,
        /// After which step, counted from 1; 0 for the start.
        step: usize,
        /// When, s.
        time: f64,
    },
    /// A pivot of a tangent matrix lost at least [`LOST_DIGITS`](Warning::LOST_DIGITS) of the numbers it is a difference of: masses far apart, a
    /// configuration that is nearly singular, or a step that is too long.
    LostDigits {
        /// The step of the worst such pivot, counted from 1; 0 for the start.
        step: usize,
        /// When, s.
        time: f64,
        /// The unknown that was eliminated.
        unknown: String,
        /// The ratio of the pivot to its terms.
        pivot: f64,
    },
    /// The adjoint variables grew by more than [`GROWTH`](Warning::GROWTH) on the way back, beyond what the costs put into them: the motion amplifies
    /// changes, and rounding with them, so that about 1e-16 times this is what the gradient is right to.
    AdjointGrowth {
        /// The largest size of (dJ/dq, dJ/dp*) of all nodes looked at, relative to that of the costs' own derivatives up to there.
        factor: f64,
    },
    /// A coordinate whose sine and cosine enter the constraints turned by more than [`TURN`](Warning::TURN) in one step: the motion is not resolved,
    /// and the step's equations may have had other solutions.
    Unresolved {
        /// The coordinate.
        coordinate: String,
        /// The step in which it turned most, counted from 1.
        step: usize,
        /// When that step ends, s.
        time: f64,
        /// By how much, rad.
        turn: f64,
    },
    /// Within a step an element did what its derivatives at the ends of the step do not show: a force that changes faster than the steps, or a kink. The
    /// gradient is exact for the discrete motion, and may be far from that of the motion that is meant (adjoint sweep only).
    ///
    /// What is missed is counted in shares of what the cost gains if the motion is ahead of its time, summed over the steps of an event with their
    /// signs, and over all events and elements by squares; [`BENT`](Warning::BENT) is worth a warning.
    UnresolvedElement {
        /// The element of which most was missed in one event.
        element: String,
        /// The step of it in which most was missed, counted from 1.
        step: usize,
        /// When it ends, s.
        time: f64,
        /// The share that was missed in all.
        share: f64,
    },
    /// Positions have drifted from a constraint by more than [`DRIFT`](Warning::DRIFT) of the lengths in it: velocities satisfy dΦ/dt = 0,
    /// positions follow by quadrature, and what is computed is no longer a motion of this mechanism.
    ///
    /// Looked at are the last node and those whose numbers are powers of two, from 128 on. Lengths are Σ √(α² + β²) of the terms
    /// α sin q + β cos q of an equation; where it has none, Σ |∂Φ/∂q| |q|, with 1 rad for angles. What
    /// [`Settings::position_tolerance`](crate::Settings::position_tolerance) allows at the start is no drift.
    Drift {
        /// The equation that is violated most, relative to its lengths.
        equation: String,
        /// Its largest |Φ| of all nodes looked at, m or rad.
        violation: f64,
        /// The same relative to its lengths.
        share: f64,
        /// The step at the end of which drift was first seen beyond the threshold, counted from 1.
        step: usize,
        /// When that step ends, s.
        time: f64,
    },
    /// The velocities at the ends of steps were far from all that the nodes before led to expect: forces jump, or the steps do not resolve an
    /// oscillation. Of the solutions that their equations may have, the one was taken that v₋ becomes when the step grows from nothing.
    Rough {
        /// The first of these steps, counted from 1.
        step: usize,
        /// When it ends, s.
        time: f64,
        /// How many there are.
        steps: usize,
    },
    /// No solution was found for steps, and they were divided.
    HalvedSteps {
        /// The first of them, counted from 1.
        step: usize,
        /// When it begins, s.
        time: f64,
        /// How many nodes were inserted in all steps.
        inserted: usize,
        /// The length of the shortest part, s.
        shortest: f64,
    },
}

impl Warning {
    /// Pivots below this fraction of their terms are worth a warning: half of the digits are gone.
    pub const LOST_DIGITS: f64 = 1e-8;
    /// Kinetic energy that dependent constraints take is worth a warning from this share on.
    pub const BRAKED: f64 = 1e-4;
    /// Growth beyond this is worth a warning: half of the gradient's digits are gone.
    pub const GROWTH: f64 = 1e8;
    /// What elements do within steps unseen is worth a warning from this share on.
    pub const BENT: f64 = 0.15;
    /// A quarter of a turn in one step, rad, is worth a warning.
    pub const TURN: f64 = std::f64::consts::FRAC_PI_2;
    /// Constraints that are violated by this fraction of the lengths in them are worth a warning.
    pub const DRIFT: f64 = 1e-2;
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Warning::DependentConstraints { equations, time } => write!(
                f,
                "at t = {} s these constraints depend on each other: {}; the motion is determined, the share of each in their \
                 common reaction is not, and was chosen by a small compliance",
                seconds(*time),
                equations.join(", ")
            ),
            Warning::BrokenDependence { designs, equations, time } => write!(
                f,
                "at t = {} s these constraints depend on each other, and any change of `{}` alone makes them contradict: {}; derivatives with respect to it are those \
                 of no motion: let one design variable set all constants that have to change together, or remove constraints that follow from others",
                seconds(*time),
                designs.join("`, `"),
                equations.join(", ")
            ),
            Warning::LostDerivative { element, argument } => write!(
                f,
                "`{element}` loses its derivative by {argument}: its values change with it, by differences, its derivatives do not, and gradients are wrong; take \
                 `re()` for comparisons and to choose the piece of a table only, and compute with the number itself"
            ),
            Warning::NothingAsked => f.write_str(
                "there is no cost, and no output must be anything: every point is a solution; add a cost to the scene (`Scene::cost`, `Scene::effort`), or say what \
                 outputs must be (`constrain`)",
            ),
            Warning::GivenStart { designs, elements } => write!(
                f,
                "constraints of `{}` depend on `{}`, and the start is given: dJ/db is that of the same initial coordinates, which with another value would \
                 violate them; take `Start::assembled`, whose coordinates follow, for the derivative of a mechanism that stays together",
                elements.join("`, `"),
                designs.join("`, `")
            ),
            Warning::SharedReaction { costs, equations } => write!(
                f,
                "σ of constraints that depend on each other, {}, is read by `{}`: how these share their common reaction follows from a small compliance, to \
                 about five digits, and so do such values and their derivatives; leave out constraints that follow from others, or let costs read what the motion determines",
                equations.join(", "),
                costs.join("`, `")
            ),
            Warning::NegativeMass { coordinates, mass, time } => write!(
                f,
                "at t = {} s the kinetic energy is negative for velocities that the constraints allow, those of {} (smallest M_ii: {mass:.3e}): what is \
                 pushed there moves against the push, as nothing does; correct masses and inertias, or give design variables bounds that keep them above zero",
                seconds(*time),
                coordinates.join(", ")
            ),
            Warning::Braked { step, time, share } => write!(
                f,
                "constraints that depend on each other brake the motion: positions have drifted from them where none can be left out, and their compliance takes so much in \
                 step {step} (t = {} s) that in all steps it would be {share:.1e} of the kinetic energy; set `Settings::drift_bound` to 0.0, remove \
                 those that follow from others, or take shorter steps or a scheme of higher order",
                seconds(*time)
            ),
            Warning::LeftOut { equations, step, time } => write!(
                f,
                "positions drift apart from constraints that depend on each other, so after step {step} (t = {} s) these are left out, which follow from \
                 the others and have no share in the common reaction: {}; they are chosen anew as the mechanism turns",
                seconds(*time),
                equations.join(", ")
            ),
            Warning::LostDigits { step, time, unknown, pivot } => write!(
                f,
                "digits are lost where {unknown} is eliminated in step {step} (t = {} s): the pivot is {pivot:.1e} of its terms; \
                 masses may be far apart, or the configuration nearly singular",
                seconds(*time)
            ),
            Warning::AdjointGrowth { factor } => write!(
                f,
                "changes grow by a factor of {factor:.1e} along this motion, and rounding with them: expect {:.0} digits of the \
                 gradient",
                (16.0 - factor.log10()).max(0.0)
            ),
            Warning::Unresolved { coordinate, step, time, turn } => write!(
                f,
                "`{coordinate}` turns by {} rad in step {step} (t = {} s): the motion is not resolved, and may not be the one that was \
                 meant; take shorter steps",
                if *turn < 1e4 { format!("{turn:.1}") } else { format!("{turn:.1e}") },
                seconds(*time)
            ),
            Warning::UnresolvedElement { element, step, time, share } => write!(
                f,
                "`{element}` changes faster than the steps: its derivatives at the ends of steps, first of all of step {step} (t = {} s), do not show what \
                 happens in between, {share:.1e} of what the cost feels of the motion; the gradient is exact for the discrete motion, and may be far \
                 from that of the motion that is meant: take shorter steps there, or make the element change more slowly, as by a wider \
                 velocity of friction or a softer contact",
                seconds(*time)
            ),
            Warning::Drift { equation, violation, share, step, time } => write!(
                f,
                "positions have drifted from {equation} by {violation:.1e}, {share:.1e} of the lengths in it, and beyond {:.0e} at or before \
                 step {step} (t = {} s): set `Settings::drift_bound`, and `Settings::rebase_every` where multipliers grow, or take \
                 shorter steps",
                Warning::DRIFT,
                seconds(*time)
            ),
            Warning::Rough { step, time, steps } => write!(
                f,
                "velocities were far from what the nodes before led to expect, first at the end of step {step} (t = {} s; such steps: {steps}): \
                 forces jump there, or the steps are too long for an oscillation",
                seconds(*time)
            ),
            Warning::HalvedSteps { step, time, inserted, shortest } => write!(
                f,
                "no solution was found for steps, and they were halved, the first of them step {step} (t = {} s; nodes inserted: {inserted}): the shortest part \
                 is {shortest:.3e} s long; the gradient is that of the motion on this grid",
                seconds(*time)
            ),
        }
    }
}
