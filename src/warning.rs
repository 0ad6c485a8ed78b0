//! Warnings of runs that succeeded.

use std::fmt;

use crate::error::seconds;

/// A warning about the mechanism or about the accuracy of a successful run. It contains the names of the parts concerned, the time or step,
/// and the magnitude of the effect.
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
    /// A change of a design variable alone makes dependent constraints contradict each other: the mechanism can be assembled, or can move,
    /// only for the present value of this variable, so the computed derivative with respect to it is not that of any family of nearby
    /// motions.
    BrokenDependence {
        /// The design variables.
        designs: Vec<String>,
        /// The dependent equations.
        equations: Vec<String>,
        /// The time, s.
        time: f64,
    },
    /// Constraints depend on design variables, such as the length of a link, but the start is given: dJ/db refers to motions from the same
    /// q₀, and this q₀ violates the constraints for any other value of these variables. With an assembled start
    /// ([`Start::Assembled`](crate::Start::Assembled)) dJ/db is the total derivative.
    GivenStart {
        /// The design variables.
        designs: Vec<String>,
        /// The elements whose constraints depend on these design variables at the start.
        elements: Vec<String>,
    },
    /// A formula reads the value of an argument with `re()`, for example to look it up in a table, and computes with this plain number. The
    /// result then changes with the argument, but its derivative with respect to the argument is lost. Gradients are wrong, and so is the
    /// motion if the derivative is one of T, V or Φ. Use the value only to choose a piece of the formula, and compute with the number
    /// itself.
    ///
    /// Formulas that read values are examined at some nodes, spread over the motion, and where a contact begins or ends.
    LostDerivative {
        /// The element, the cost or the term of an output.
        element: String,
        /// The first argument with respect to which the derivative is lost.
        argument: String,
        /// Order of the derivative: 1, or 2 in warnings of [`Solver::hessian_product`](crate::Solver::hessian_product), in which case motion
        /// and gradient are right.
        order: usize,
    },
    /// Elements or costs have no program, because their derivatives have too many operations. They are then differentiated by dual numbers at every
    /// point, which is far slower ([`System::without_programs`](crate::System::without_programs)).
    NoProgram {
        /// The elements and costs.
        elements: Vec<String>,
    },
    /// The optimisation problem has neither a cost nor a constraint, so every point is a solution.
    NothingAsked,
    /// Costs or outputs read σ of dependent constraints. The share of each constraint in the common reaction follows from the compliance
    /// and has about five correct digits; these values and their derivatives are no more accurate.
    SharedReaction {
        /// The costs, and the terms of outputs.
        costs: Vec<String>,
        /// The equations whose multipliers they read.
        equations: Vec<String>,
    },
    /// The kinetic energy at the start is negative for velocities that the constraints allow: a body would accelerate against the applied
    /// force. A negative mass in a direction in which the constraints prevent motion is harmless and causes no warning.
    NegativeMass {
        /// The coordinates with a negative diagonal entry M_ii of the mass matrix or, if there are none, all coordinates that change with
        /// the velocities for which the kinetic energy is negative.
        coordinates: Vec<String>,
        /// The smallest M_ii of these coordinates, kg or kg m².
        mass: f64,
        /// The time, s.
        time: f64,
    },
    /// Positions have drifted from dependent constraints, which now contradict each other slightly, and their compliance dissipates energy.
    ///
    /// If the drift changes Φ_q by δ, the compliance (1e-11 in relative units) removes the fraction δ²/1e-11 of the velocity in each step,
    /// although the residual of dΦ/dt = 0 remains small. If an equation can be left out, the warning is [`LeftOut`](Warning::LeftOut)
    /// instead.
    Braked {
        /// The step with the largest loss, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
        /// Energy lost in this step, times the number of steps, relative to the largest kinetic energy; at least [`BRAKED`](Warning::BRAKED).
        share: f64,
    },
    /// Positions drift from dependent constraints. This drift would brake the motion, so redundant equations are left out. The set of
    /// left-out equations is changed before the remaining equations become dependent;
    /// [`Trajectory::compliance`](crate::Trajectory::compliance) contains all choices.
    LeftOut {
        /// The equations that are left out first.
        equations: Vec<String>,
        /// The step after which they are left out, counted from 1; 0 for the start.
        step: usize,
        /// The time, s.
        time: f64,
    },
    /// A pivot of a tangent matrix is below [`LOST_DIGITS`](Warning::LOST_DIGITS) times the terms of which it is the difference. Causes are
    /// very different masses, a nearly singular configuration, or a step that is too long.
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
    /// In the backward sweep the adjoint variables grew by a factor of more than [`GROWTH`](Warning::GROWTH) relative to the contributions
    /// of the costs. The motion amplifies changes, including rounding errors, so the relative error of the gradient is about 1e-16 times
    /// this factor.
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
    /// An element changes within a step in a way that cannot be seen from its derivatives at the ends of the step, for example a force that
    /// varies faster than the steps, or a kink. The gradient is exact for the discrete motion, but may differ much from that of the
    /// continuous motion. Only the adjoint sweep gives this warning.
    ///
    /// The missing effects are summed with their signs over the steps of a run (steps whose velocities differ from their
    /// extrapolation) and divided by the change of the cost when the motion is shifted in time. The root of the sum of the squares of these
    /// shares is then taken over all runs and elements. The warning is given if the result is at least [`BENT`](Warning::BENT).
    UnresolvedElement {
        /// The element with the largest missing effect in one run.
        element: String,
        /// The step of this run with the largest missing effect, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
        /// The missing share of the effect on the cost, over all runs and elements.
        share: f64,
    },
    /// A contact begins or ends, or friction reverses, between two nodes, and the gradient depends on where between them this happens: the kink has
    /// another distance from the nodes on another grid, and the discrete J zigzags with this distance. The gradient is exact for the discrete
    /// motion, but may differ much from that of the continuous motion. [`Gradient::frozen`](crate::Gradient::frozen) is closer to it if several
    /// steps lie within each contact.
    ///
    /// The warning is given if a derivative of the two gradients differs by more than [`GRID_PHASE`](Warning::GRID_PHASE).
    GridPhase {
        /// The element whose kink has the largest effect.
        element: String,
        /// The step within which this kink lies, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
        /// The derivative that differs most; of a control, the norm over all its values.
        of: String,
        /// This derivative in the gradient.
        value: f64,
        /// The same derivative at frozen grid phase.
        frozen: f64,
    },
    /// An element has a kink between two nodes of a motion whose events are located ([`Inputs::events`](crate::Inputs::events)), and none of them is this
    /// one: the gradient depends on where between the nodes the kink lies.
    KinkBetweenNodes {
        /// The element.
        element: String,
        /// The first step within which a kink lies, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
    },
    /// A velocity oscillates with few steps in a period: fewer than 20 for schemes of second order, 8 for others. The gradient is exact for the discrete
    /// motion, but the periods of that motion are too long, and derivatives are off by more than their values.
    CoarseSteps {
        /// The coordinate whose velocity has the fewest steps in a period.
        coordinate: String,
        /// The number of steps in a period, on average along the motion.
        steps: f64,
    },
    /// The gap of a rigid contact ([`Scene::rigid_contact`](crate::Scene::rigid_contact)) is negative although its equation is open: the inputs have no event
    /// where it was zero.
    Penetrated {
        /// The contact.
        contact: String,
        /// The time of the first node with a negative gap, s.
        time: f64,
    },
    /// A rigid contact that has closed pulls, which no surface does.
    Pulls {
        /// The contact.
        contact: String,
        /// The time at the end of the first step in which it pulls, s.
        time: f64,
    },
    /// The function of an event hardly crosses zero: its rate is small in comparison with its values before the event, so that small changes of the inputs
    /// change the time of the event much, or prevent it.
    Grazed {
        /// The event.
        event: String,
        /// The node of the event.
        node: usize,
        /// The time of the event, s.
        time: f64,
        /// The rate times the length of the steps since the event before, relative to the largest value of the function in these steps.
        share: f64,
    },
    /// A control that is a function of time ([`Inputs::controls_in_time`](crate::Inputs::controls_in_time)) jumps in a step of length zero.
    MeanOfJump {
        /// The control.
        control: String,
        /// The step, counted from 1.
        step: usize,
        /// The jump.
        jump: f64,
    },
    /// Between two nodes before an event, its function seems to become zero and to return, so that the event happens earlier than the grid shows.
    MissedEvent {
        /// The event.
        event: String,
        /// The node of the event.
        node: usize,
        /// The time at which its function seems to be zero, s.
        time: f64,
    },
    /// The grid shifts the variables of a fit by more than [`GRID_SHIFT`](Warning::GRID_SHIFT) times the standard errors that follow from the noise of
    /// the residuals ([`Fit::grid_shifts`](crate::optimize::Fit::grid_shifts)). [`Fit::standard_errors`](crate::optimize::Fit::standard_errors)
    /// includes the shift; with shorter steps the residuals determine the variables better.
    GridShift {
        /// The variable that is shifted most, relative to its standard error.
        variable: String,
        /// Its estimated change if the steps became infinitely short.
        shift: f64,
        /// Its standard error by the noise of the residuals alone.
        noise: f64,
    },
    /// The estimated error of J or of a constrained output at a minimum ([`solve`](crate::optimize::solve())) exceeds
    /// [`INACCURATE`](Warning::INACCURATE) times its size (1 m or rad, if an output is smaller), or the accuracy that was wanted: under the same
    /// controls, the continuous motion differs from that of the minimum.
    Inaccurate {
        /// The output, or J.
        quantity: String,
        /// The value of the quantity at the minimum.
        value: f64,
        /// The estimated difference of its value in the continuous motion, from motions with divided steps.
        error: f64,
        /// The accuracy that was wanted, if any.
        wanted: Option<f64>,
    },
    /// A result of [`solve`](crate::optimize::solve()) violates constraints, and at least half of the variables of a free quantity are at their bounds: with
    /// wider bounds, the constraints might be satisfied.
    AtBounds {
        /// The free quantity.
        quantity: String,
        /// The number of its variables at bounds.
        count: usize,
        /// The number of its variables.
        of: usize,
    },
    /// No state at a node satisfies all constraints of a problem on the state there ([`solve`](crate::optimize::solve())), so no motion does: they
    /// contradict each other or, at node 0, the start, which is not free.
    NoState {
        /// The node.
        node: usize,
        /// The time of the node, s.
        time: f64,
        /// The constraints that a fixed start violates, or those that are violated in a state near the guess where the sum of squares of all violations is
        /// least.
        violations: Vec<String>,
    },
    /// The sum of squares χ² of the residuals of a fit is improbable: for a correct model with normal errors of the stated standard deviations, a χ² so
    /// far from the number of degrees of freedom has a probability below [`MISFIT`](Warning::MISFIT).
    ///
    /// If χ² is too large, the model lacks an effect, the minimum is a local one, some readings are outliers, or the standard deviations are too
    /// small. If χ² is too small, the standard deviations are too large; [`Fit::standard_errors`](crate::optimize::Fit::standard_errors) do not depend
    /// on their common factor. The warning is given only if all residuals are those of readings whose standard deviations are known
    /// ([`Scene::reading_deviation`](crate::Scene::reading_deviation)).
    Misfit {
        /// χ², the sum of squares of the residuals.
        chi_squared: f64,
        /// The number of residuals minus that of variables.
        degrees_of_freedom: usize,
        /// The probability of a χ² that is at least, or at most, as large, without the estimated errors of the grid.
        probability: f64,
    },
    /// Positions violate a constraint by more than [`DRIFT`](Warning::DRIFT) times the lengths in it, because only the velocities satisfy
    /// dΦ/dt = 0 and positions follow by quadrature. The result is no longer a motion of this mechanism.
    ///
    /// The nodes examined are the last one and those whose numbers are powers of two, beginning with 128. The lengths in an equation are Σ
    /// √(α² + β²) over its terms α sin q + β cos q or, if it has no such terms, Σ |∂Φ/∂q| |q|, where |q| is replaced by 1 rad for angles.
    /// The violation that [`Settings::position_tolerance`](crate::Settings::position_tolerance) allows at the start does not count.
    Drift {
        /// The equation that is violated most, relative to its lengths.
        equation: String,
        /// Largest |Φ| of this equation at the examined nodes, m or rad.
        violation: f64,
        /// Largest |Φ| of this equation, relative to its lengths.
        share: f64,
        /// The first examined step at whose end the violation exceeds the threshold, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
    },
    /// The velocities at the ends of some steps differ much from their extrapolation: forces jump, or the steps do not resolve an
    /// oscillation. If the equations of such a step have several solutions, the chosen one is connected continuously to v₋, the velocities
    /// at the beginning of the step, when the step length is reduced to zero.
    Rough {
        /// The first of these steps, counted from 1.
        step: usize,
        /// Time at the end of this step, s.
        time: f64,
        /// Number of such steps.
        steps: usize,
    },
    /// Some steps had no solution and were halved.
    HalvedSteps {
        /// The first of these steps, counted from 1.
        step: usize,
        /// Time at the beginning of this step, s.
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
    /// A warning is given if dependent constraints dissipate at least this share of the kinetic energy.
    pub const BRAKED: f64 = 1e-4;
    /// Growth of the adjoint variables beyond this factor causes a warning: half of the gradient's digits are lost.
    pub const GROWTH: f64 = 1e8;
    /// A warning is given if at least this share of an element's effect within steps is missing.
    pub const BENT: f64 = 0.15;
    /// A warning is given if a derivative differs from the one at frozen grid phase by more than this fraction.
    pub const GRID_PHASE: f64 = 0.05;
    /// A warning is given if the grid shifts a variable of a fit by more than this multiple of its standard error.
    pub const GRID_SHIFT: f64 = 0.5;
    /// A warning is given if the grid causes an error of a quantity of a minimum of more than this fraction.
    pub const INACCURATE: f64 = 0.1;
    /// A warning is given if a correct model would have a χ² so large, or so small, with less than this probability.
    pub const MISFIT: f64 = 1e-6;
    /// A warning is given if a coordinate turns by more than this angle in one step, rad: a quarter of a revolution.
    pub const TURN: f64 = std::f64::consts::FRAC_PI_2;
    /// A warning is given if the violation of a constraint, relative to the lengths in it, exceeds this value.
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
                "at t = {} s these constraints depend on each other, and any change of `{}` alone makes them contradict each other: {}; the computed derivatives with respect to it belong to no motion of the mechanism; use one design variable for all constants that must change together, or remove redundant constraints",
                seconds(*time),
                designs.join("`, `"),
                equations.join(", ")
            ),
            Warning::LostDerivative { element, argument, order } => write!(
                f,
                "`{element}` loses its {}derivative with respect to {argument}, because it computes with the value of `re()`: {} wrong; use `re()` only for comparisons and to choose the piece of a table, and compute with the number itself",
                if *order == 1 { "" } else { "second " },
                if *order == 1 { "gradients, and also motions if the formula is an energy or a constraint, are" } else { "products of the Hessian are" },
            ),
            Warning::NoProgram { elements } => write!(
                f,
                "the derivatives of `{}` have too many operations for a program: they are evaluated about a hundred times more slowly; use several small elements instead, and cut a long chain in space with `Spatial::cut`",
                elements.join("`, `")
            ),
            Warning::NothingAsked => f.write_str(
                "the problem has neither a cost nor a constraint, so every point is a solution; add a cost to the scene (`Scene::cost`, `Scene::effort`), or \
                 constrain an output (`constrain`)",
            ),
            Warning::GivenStart { designs, elements } => write!(
                f,
                "constraints of `{}` depend on `{}`, but the start is given: dJ/db is the derivative for fixed initial coordinates, which violate the constraints for any other value of these design variables; use `Start::assembled` for the derivative of a mechanism that stays assembled",
                elements.join("`, `"),
                designs.join("`, `")
            ),
            Warning::SharedReaction { costs, equations } => write!(
                f,
                "σ of dependent constraints, {}, enters `{}`: the shares of these constraints in the common reaction follow from a small compliance, so these values and their \
                 derivatives have about five correct digits; remove redundant constraints, or use costs on quantities that the motion determines",
                equations.join(", "),
                costs.join("`, `")
            ),
            Warning::NegativeMass { coordinates, mass, time } => write!(
                f,
                "at t = {} s the kinetic energy is negative for velocities of {} that the constraints allow (smallest M_ii: {mass:.3e}): a body with these coordinates would accelerate against the applied force, which is unphysical; correct masses and inertias, or bound design variables so that they stay positive",
                seconds(*time),
                coordinates.join(", ")
            ),
            Warning::Braked { step, time, share } => write!(
                f,
                "dependent constraints brake the motion: positions have drifted from them, and no equation can be left out; if all steps dissipated as much as step {step} (t = {} s), the compliance of these constraints would remove {share:.1e} of the kinetic energy; set `Settings::drift_bound` to 0.0, remove redundant \
                 constraints, or use shorter steps or a scheme of higher order",
                seconds(*time)
            ),
            Warning::LeftOut { equations, step, time } => write!(
                f,
                "positions drift from dependent constraints, so after step {step} (t = {} s) these redundant equations are left out and have no share in the common reaction: {}; which equations are left out changes as the mechanism moves",
                seconds(*time),
                equations.join(", ")
            ),
            Warning::LostDigits { step, time, unknown, pivot } => write!(
                f,
                "digits are lost in the elimination of {unknown} in step {step} (t = {} s): the pivot is a difference of nearly equal terms, {pivot:.1e} times their size; masses may be very different, or the configuration nearly singular",
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
                "`{element}` changes faster than the steps: its derivatives at the ends of the steps do not account for {share:.1e} of its effect on the cost, with the largest part in step {step} (t = {} s); the gradient is exact for the discrete motion, but may differ much from that of the continuous \
                 motion; use shorter steps there, or an element that changes more slowly (a wider velocity range of friction, a softer contact)",
                seconds(*time)
            ),
            Warning::GridPhase { element, step, time, of, value, frozen } => write!(
                f,
                "`{element}` has a kink within step {step} (t = {} s), and the gradient depends on where in the step it lies: {of} is {} for this grid, but {} for nodes that keep their distance from the kink; `Gradient::frozen` contains the latter derivatives, which are closer to those of the continuous motion if several steps lie within each contact",
                seconds(*time),
                four_digits(*value),
                four_digits(*frozen)
            ),
            Warning::KinkBetweenNodes { element, step, time } => write!(
                f,
                "`{element}` has a kink within step {step} (t = {} s) that no event locates, and the gradient depends on where in the step it lies; \
                 define an event for it (`Scene::event`), and add it to `Inputs::events`",
                seconds(*time)
            ),
            Warning::Grazed { event, node, time, share } => write!(
                f,
                "event `{event}` at node {node} (t = {} s) hardly happens: its function crosses zero with {share:.1e} of the rate with which it came; derivatives \
                 of its time are large, and small changes of the inputs may prevent it",
                seconds(*time)
            ),
            Warning::MeanOfJump { control, step, jump } => write!(
                f,
                "control `{control}` jumps by {jump:.3e} in step {step}, of length zero, although it is listed in `Inputs::controls_in_time`, where controls do \
                 not jump: the mean is used; let another control, which is not listed, switch it on or off"
            ),
            Warning::CoarseSteps { coordinate, steps } => write!(
                f,
                "the velocity of `{coordinate}` oscillates with {steps:.0} steps in a period: this grid is coarse; ask for the error (`estimate`), use \
                 shorter steps, or a scheme of higher order"
            ),
            Warning::Penetrated { contact, time } => write!(
                f,
                "the gap of `{contact}` is negative at t = {} s, although no event was given where it became zero; add it to `Inputs::events`, or let \
                 `Solver::find_phases` find it",
                seconds(*time)
            ),
            Warning::Pulls { contact, time } => write!(
                f,
                "`{contact}` pulls before t = {} s, which a surface cannot do: the bodies would have separated; let an event open its equation \
                 (`Scene::open_at`) where the reaction changes its sign",
                seconds(*time)
            ),
            Warning::MissedEvent { event, node, time } => write!(
                f,
                "event `{event}` of node {node} seems to happen twice between two nodes at t = {} s, before the node; use shorter steps there",
                seconds(*time)
            ),
            Warning::GridShift { variable, shift, noise } => write!(
                f,
                "with shorter steps the fit would find another value of `{variable}`: the estimated change is {shift:.1e}, but its standard error by the residuals is {noise:.1e}; the standard errors include this change; use shorter steps or a scheme of higher order"
            ),
            Warning::Inaccurate { quantity, value, error, wanted } => {
                let of = format!("{quantity} is {value:.4e}, but would differ by about {error:.1e} with very short steps under the same controls");
                match wanted {
                    None => write!(f, "the steps are too long: {of}; require an accuracy of `solve`, or use shorter steps"),
                    Some(wanted) => write!(
                        f,
                        "the accuracy of {wanted:e} is not reached: {of}; use shorter steps, and neither costs or outputs at single nodes nor piecewise constant controls, with which steps are not halved"
                    ),
                }
            }
            Warning::AtBounds { quantity, count, of } => {
                let many = if *of > 1 { format!(" in {count} of {of} variables") } else { String::new() };
                write!(f, "{quantity} is at its bounds{many} while constraints are violated; wider bounds may be needed")
            }
            Warning::NoState { node: 0, violations, .. } => write!(
                f,
                "the start, which is not free, violates constraints: {}; change the start, let it be free, or state these constraints at later nodes only",
                violations.join("; ")
            ),
            Warning::NoState { node, time, violations } => write!(
                f,
                "no state at node {node} (t = {} s) satisfies all constraints there; in the nearest one, {}",
                seconds(*time),
                violations.join("; ")
            ),
            Warning::Misfit { chi_squared, degrees_of_freedom, probability } => {
                let degrees = *degrees_of_freedom as f64;
                let is_large = *chi_squared > degrees;
                let size = if is_large { "larger" } else { "smaller" };
                let chi = four_digits(*chi_squared);
                write!(
                    f,
                    "the residuals are {size} than the errors of the readings explain: χ² is {chi} for {degrees_of_freedom} degrees of freedom, which a correct model would have with a probability of at most {:.0e}; ",
                    probability.max(1e-300)
                )?;
                let factor = (degrees / chi_squared).sqrt();
                if is_large {
                    write!(f, "the model may lack an effect, the minimum may be a local one, some readings may be outliers, or their standard deviations too small by a factor of {:.1}", 1.0 / factor)
                } else {
                    write!(f, "the standard deviations of the readings seem to be too large by a factor of {factor:.1}; standard errors that the residuals determine do not depend on this factor, absolute errors do")
                }
            }
            Warning::Drift { equation, violation, share, step, time } => write!(
                f,
                "positions have drifted from {equation} by {violation:.1e}, which is {share:.1e} times the lengths in it; this ratio exceeded {:.0e} at or before step {step} (t = {} s); set `Settings::drift_bound`, and `Settings::rebase_every` if multipliers grow, or use \
                 shorter steps",
                Warning::DRIFT,
                seconds(*time)
            ),
            Warning::Rough { step, time, steps } => write!(
                f,
                "velocities differ much from their extrapolation, first at the end of step {step} (t = {} s; number of such steps: {steps}): \
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

fn four_digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    format!("{rounded:?}")
}
