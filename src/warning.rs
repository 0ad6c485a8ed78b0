//! Warnings of runs that succeeded.

use std::fmt;

use crate::error::seconds;

/// A warning about the mechanism or the accuracy of a successful run, with names, place and size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Some constraints follow from others and were given a compliance, see [`Trajectory::compliance`](crate::Trajectory::compliance).
    DependentConstraints {
        /// The dependent equations.
        equations: Vec<String>,
        /// The time, s.
        time: f64,
    },
    /// A change of a design variable alone makes dependent constraints contradict each other: the mechanism can be assembled, or move, for the present value
    /// only, and no motion nearby has the derivative with respect to it.
    BrokenDependence {
        /// The design variables.
        designs: Vec<String>,
        /// The dependent equations.
        equations: Vec<String>,
        /// The time, s.
        time: f64,
    },
    /// Constraints depend on design variables, such as the length of a link, but the start is given: dJ/db refers to motions from the same q₀, which violates
    /// the constraints for any other value. With an assembled start ([`Start::Assembled`](crate::Start::Assembled)) dJ/db is the total derivative.
    GivenStart {
        /// The design variables.
        designs: Vec<String>,
        /// The elements whose constraints depend on these design variables at the start.
        elements: Vec<String>,
    },
    /// A formula takes the value of an argument by `re()`, as to look it up in a table, and computes with a plain number: its values change with the argument,
    /// its derivatives do not. Gradients are wrong, and so is the motion if the derivative is one of T, V or Φ. Use the value to choose a piece of the formula only,
    /// and compute with the number itself.
    ///
    /// Formulas that read values are examined at some nodes, spread over the motion, and where a contact begins or ends.
    LostDerivative {
        /// The element, the cost or the term of an output.
        element: String,
        /// The first argument by which the derivative is lost.
        argument: String,
        /// Order of the derivative. It is 2 only in warnings of [`Solver::hessian_product`](crate::Solver::hessian_product): motion and gradient are then right.
        order: usize,
    },
    /// The optimisation problem has neither a cost nor a constraint, so every point is a solution.
    NothingAsked,
    /// Costs or outputs read σ of dependent constraints. The share of each constraint in the common reaction follows from the compliance and has about five
    /// correct digits; these values and their derivatives have no more.
    SharedReaction {
        /// The costs, and the terms of outputs.
        costs: Vec<String>,
        /// The equations whose multipliers they read.
        equations: Vec<String>,
    },
    /// The kinetic energy at the start is negative for velocities that the constraints allow: a body would accelerate against the applied force. A negative
    /// mass in a direction that constraints prevent is harmless and causes no warning.
    NegativeMass {
        /// The coordinates with a negative M_ii or, if there are none, all coordinates that such velocities move.
        coordinates: Vec<String>,
        /// The smallest M_ii of these coordinates, kg or kg m².
        mass: f64,
        /// The time, s.
        time: f64,
    },
    /// Positions have drifted from dependent constraints, which now contradict each other slightly, and their compliance dissipates energy.
    ///
    /// A drift of Φ_q by δ removes δ²/1e-11 of the velocity in each step while the residual of dΦ/dt = 0 is small. If an equation can be left out, the warning is
    /// [`LeftOut`](Warning::LeftOut) instead.
    Braked {
        /// The step with the largest loss, counted from 1.
        step: usize,
        /// Time at its end, s.
        time: f64,
        /// Energy lost in this step, times the number of steps, relative to the largest kinetic energy; at least [`BRAKED`](Warning::BRAKED).
        share: f64,
    },
    /// Positions drift from dependent constraints, which would brake the motion, so redundant equations are left out. The choice changes before the
    /// remaining equations become dependent; [`Trajectory::compliance`](crate::Trajectory::compliance) contains all choices.
    LeftOut {
        /// The equations that are left out first.
        equations: Vec<String>,
        /// The step after which they are left out, counted from 1; 0 for the start.
        step: usize,
        /// The time, s.
        time: f64,
    },
    /// A pivot of a tangent matrix is below [`LOST_DIGITS`](Warning::LOST_DIGITS) of the terms of which it is the difference: masses far apart, a nearly
    /// singular configuration, or a step that is too long.
    LostDigits {
        /// The step of the worst such pivot, counted from 1; 0 for the start.
        step: usize,
        /// The time, s.
        time: f64,
        /// The unknown that was eliminated.
        unknown: String,
        /// Ratio of the pivot to its terms.
        pivot: f64,
    },
    /// The adjoint variables grew by more than [`GROWTH`](Warning::GROWTH) in the backward sweep, beyond the contributions of the costs: the motion amplifies
    /// changes, including rounding, so the relative error of the gradient is about 1e-16 times this factor.
    AdjointGrowth {
        /// Largest size of (dJ/dq, dJ/dp*) at the sampled nodes, relative to that of the costs' derivatives added so far.
        factor: f64,
    },
    /// A coordinate whose sine and cosine enter the constraints turned by more than [`TURN`](Warning::TURN) in one step: the motion is not resolved,
    /// and the equations of the step may have several solutions.
    Unresolved {
        /// The coordinate.
        coordinate: String,
        /// The step of the largest turn, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
        /// The largest turn, rad.
        turn: f64,
    },
    /// An element changes within a step in a way that its derivatives at the ends of the step do not show: a force that varies faster than the steps, or a kink. The
    /// gradient is exact for the discrete motion, but may differ much from that of the continuous motion (adjoint sweep only).
    ///
    /// The missing effect is measured relative to the change of the cost under a shift of the motion in time, summed with signs over the steps of one event, and as a
    /// root of squares over all events and elements. The warning is given from [`BENT`](Warning::BENT) on.
    UnresolvedElement {
        /// The element with the largest missing effect in one event.
        element: String,
        /// The step of this event with the largest missing effect, counted from 1.
        step: usize,
        /// Time at its end, s.
        time: f64,
        /// The missing share in total.
        share: f64,
    },
    /// Positions have drifted from a constraint by more than [`DRIFT`](Warning::DRIFT) of the lengths in it: velocities satisfy dΦ/dt = 0, positions follow by
    /// quadrature, and the result is no longer a motion of this mechanism.
    ///
    /// The last node is examined, and those whose numbers are powers of two, from 128 on. The lengths are Σ √(α² + β²) of the terms α sin q + β cos q of an
    /// equation or, if it has none, Σ |∂Φ/∂q| |q|, with 1 rad for angles. The violation that
    /// [`Settings::position_tolerance`](crate::Settings::position_tolerance) allows at the start does not count.
    Drift {
        /// The equation that is violated most, relative to its lengths.
        equation: String,
        /// Its largest |Φ| at the examined nodes, m or rad.
        violation: f64,
        /// Its largest |Φ| relative to its lengths.
        share: f64,
        /// The first examined step whose end exceeds the threshold, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
    },
    /// The velocities at the ends of some steps differ much from their extrapolation: forces jump, or the steps do not resolve an oscillation. If the equations of
    /// such a step have several solutions, the one that develops from v₋ as the step grows from zero was chosen.
    Rough {
        /// The first of these steps, counted from 1.
        step: usize,
        /// Time at its end, s.
        time: f64,
        /// Number of such steps.
        steps: usize,
    },
    /// Some steps had no solution and were halved.
    HalvedSteps {
        /// The first of these steps, counted from 1.
        step: usize,
        /// Time at its beginning, s.
        time: f64,
        /// Number of inserted nodes in all steps.
        inserted: usize,
        /// Length of the shortest part, s.
        shortest: f64,
    },
}

impl Warning {
    /// Pivots below this fraction of their terms cause a warning: half of the digits are lost.
    pub const LOST_DIGITS: f64 = 1e-8;
    /// Share of the kinetic energy lost to dependent constraints from which a warning is given.
    pub const BRAKED: f64 = 1e-4;
    /// Growth of the adjoint variables beyond this factor causes a warning: half of the gradient's digits are lost.
    pub const GROWTH: f64 = 1e8;
    /// Missing share of an element's effect within steps from which a warning is given.
    pub const BENT: f64 = 0.15;
    /// Turn in one step, rad, from which a warning is given: a quarter of a revolution.
    pub const TURN: f64 = std::f64::consts::FRAC_PI_2;
    /// Violation of a constraint, relative to the lengths in it, from which a warning is given.
    pub const DRIFT: f64 = 1e-2;
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Warning::DependentConstraints { equations, time } => write!(
                f,
                "at t = {} s these constraints depend on each other: {}; the motion is determined, but the share of each in their \
                 common reaction is not, and follows from a small compliance",
                seconds(*time),
                equations.join(", ")
            ),
            Warning::BrokenDependence { designs, equations, time } => write!(
                f,
                "at t = {} s these constraints depend on each other, and any change of `{}` alone makes them contradict each other: {}; no motion has the derivatives \
                 with respect to it; use one design variable for all constants that must change together, or remove redundant constraints",
                seconds(*time),
                designs.join("`, `"),
                equations.join(", ")
            ),
            Warning::LostDerivative { element, argument, order } => write!(
                f,
                "`{element}` loses its {}derivative with respect to {argument}, because it computes with the value of `re()`: {} wrong; use `re()` for comparisons \
                 and to choose the piece of a table only, and compute with the number itself",
                if *order == 1 { "" } else { "second " },
                if *order == 1 { "gradients, and motions if it is an energy or a constraint, are" } else { "products of the Hessian are" },
            ),
            Warning::NothingAsked => f.write_str(
                "the problem has neither a cost nor a constraint, so every point is a solution; add a cost to the scene (`Scene::cost`, `Scene::effort`), or \
                 constrain an output (`constrain`)",
            ),
            Warning::GivenStart { designs, elements } => write!(
                f,
                "constraints of `{}` depend on `{}`, but the start is given: dJ/db refers to the same initial coordinates, which violate the constraints for \
                 any other value; use `Start::assembled` for the derivative of a mechanism that stays assembled",
                elements.join("`, `"),
                designs.join("`, `")
            ),
            Warning::SharedReaction { costs, equations } => write!(
                f,
                "σ of dependent constraints, {}, is read by `{}`: their shares in the common reaction follow from a small compliance, so these values and their \
                 derivatives have about five correct digits; remove redundant constraints, or use costs on quantities that the motion determines",
                equations.join(", "),
                costs.join("`, `")
            ),
            Warning::NegativeMass { coordinates, mass, time } => write!(
                f,
                "at t = {} s the kinetic energy is negative for velocities of {} that the constraints allow (smallest M_ii: {mass:.3e}): a body there would \
                 accelerate against the applied force, which is unphysical; correct masses and inertias, or bound design variables so that they stay positive",
                seconds(*time),
                coordinates.join(", ")
            ),
            Warning::Braked { step, time, share } => write!(
                f,
                "dependent constraints brake the motion: positions have drifted from them, none can be left out, and at the rate of step {step} (t = {} s) their \
                 compliance would dissipate {share:.1e} of the kinetic energy over all steps; set `Settings::drift_bound` to 0.0, remove redundant \
                 constraints, or use shorter steps or a scheme of higher order",
                seconds(*time)
            ),
            Warning::LeftOut { equations, step, time } => write!(
                f,
                "positions drift from dependent constraints, so from step {step} (t = {} s) on these redundant equations are left out and have no share in the \
                 common reaction: {}; the choice changes as the mechanism turns",
                seconds(*time),
                equations.join(", ")
            ),
            Warning::LostDigits { step, time, unknown, pivot } => write!(
                f,
                "digits are lost in the elimination of {unknown} in step {step} (t = {} s): the pivot is {pivot:.1e} of its terms; \
                 masses may be far apart, or the configuration nearly singular",
                seconds(*time)
            ),
            Warning::AdjointGrowth { factor } => write!(
                f,
                "changes, including rounding, grow by a factor of {factor:.1e} along this motion: expect {:.0} correct digits of the \
                 gradient",
                (16.0 - factor.log10()).max(0.0)
            ),
            Warning::Unresolved { coordinate, step, time, turn } => write!(
                f,
                "`{coordinate}` turns by {} rad in step {step} (t = {} s): the motion is not resolved and may not be the intended \
                 one; use shorter steps",
                if *turn < 1e4 { format!("{turn:.1}") } else { format!("{turn:.1e}") },
                seconds(*time)
            ),
            Warning::UnresolvedElement { element, step, time, share } => write!(
                f,
                "`{element}` changes faster than the steps: its derivatives at the ends of steps, above all of step {step} (t = {} s), miss a share of \
                 {share:.1e} of the effect on the cost; the gradient is exact for the discrete motion, but may differ much from that of the continuous \
                 motion; use shorter steps there, or an element that changes more slowly (a wider velocity range of friction, a softer contact)",
                seconds(*time)
            ),
            Warning::Drift { equation, violation, share, step, time } => write!(
                f,
                "positions have drifted from {equation} by {violation:.1e}, which is {share:.1e} of the lengths in it, and exceeded {:.0e} at or before \
                 step {step} (t = {} s); set `Settings::drift_bound`, and `Settings::rebase_every` if multipliers grow, or use \
                 shorter steps",
                Warning::DRIFT,
                seconds(*time)
            ),
            Warning::Rough { step, time, steps } => write!(
                f,
                "velocities differ much from their extrapolation, first at the end of step {step} (t = {} s; such steps: {steps}): \
                 forces jump there, or the steps are too long for an oscillation",
                seconds(*time)
            ),
            Warning::HalvedSteps { step, time, inserted, shortest } => write!(
                f,
                "some steps had no solution and were halved, the first of them step {step} (t = {} s; nodes inserted: {inserted}): the shortest part \
                 is {shortest:.3e} s long; the gradient is that of the motion on this grid",
                seconds(*time)
            ),
        }
    }
}
