//! Messages of [`Error`].

use std::fmt;

use super::{Error, seconds};

/// Hint if the motion is driven by constraints that depend on time.
fn out_of_reach(driven: &[String]) -> String {
    if driven.is_empty() {
        return String::new();
    }
    let (names, depends) = (driven.join(", "), if driven.len() == 1 { "depends" } else { "depend" });
    format!(
        "{names} {depends} on time, so the drive may prescribe a position that the mechanism cannot reach or pass, such as a dead centre or a fully stretched position: check the range of the drive against the lengths of the links; otherwise "
    )
}

/// `Debug` prints the message of `Display`, because `expect`, and a `main` that returns the error, print `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Error::DuplicateName { kind, name } => {
                write!(f, "more than one {kind} has the name `{name}`; names must be unique")
            }
            Error::Foreign { element, kind } => {
                let article = if kind.starts_with(['o', 'e']) { "an" } else { "a" };
                write!(f, "`{element}` refers to {article} {kind} of another scene; use handles of the scene that contains it")
            }
            Error::ParameterFormula { parameter, branches: true } => write!(
                f,
                "the formula of parameter `{parameter}` branches on a value (`re()`, a comparison); use `max`, `min` or `abs`, or choose the branch before the scene is built"
            ),
            Error::ParameterFormula { parameter, .. } => write!(f, "the formula of parameter `{parameter}` panics"),
            Error::RepeatedCoordinate { element, coordinate } => {
                write!(
                    f,
                    "`{element}` lists coordinate `{coordinate}` twice; list each coordinate of an element once, and connect two different bodies"
                )
            }
            Error::NoBody { element } => {
                write!(f, "`{element}` connects the ground or one body to itself; at least one side must be a body, and not that of the other side")
            }
            Error::Inertia { body, moments: [a, b, c] } => write!(
                f,
                "the principal moments of inertia of `{body}` about its centre of mass are {a:.4e}, {b:.4e} and {c:.4e} kg m²; none may be negative, or larger \
                 than the sum of the other two; is the tensor about the centre of mass, with J_xy = −∫ x y dm? `Inertia::unchecked` accepts it as it is"
            ),
            Error::NoJoint { body } => write!(
                f,
                "no joint carries body `{body}`; add a joint whose second marker is on it, or `free` if it moves freely"
            ),
            Error::SecondJoint { joint, first, body } => write!(
                f,
                "joint `{joint}` carries body `{body}`, which joint `{first}` carries already; let its second marker be on the other body, or close the loop \
                 by constraints between markers"
            ),
            Error::CarriesGround { joint } => {
                write!(f, "the second marker of joint `{joint}` is on the ground; exchange both markers")
            }
            Error::NothingToCut { cut } => {
                write!(f, "cut `{cut}` is at the ground or at a body that is fixed to it; cut a body that joints move")
            }
            Error::NotCarried { part, body } => write!(
                f,
                "`{part}` is attached to body `{body}`, which no joint carries yet; add joints from the ground outwards, and other parts after them"
            ),
            Error::MissingInertia { coordinate } => {
                write!(f, "coordinate `{coordinate}` has neither kinetic energy nor a constraint; add a mass or inertia that moves with it, or constraints that determine it")
            }
            Error::Particle { element } => write!(
                f,
                "`{element}` needs an angle, which particles do not have; use a body, or a part that connects points: hinge, distance, spring, damper, actuator, contact, curve"
            ),
            Error::EmptyScene => write!(f, "the scene has no coordinates; add a body or coordinates first"),
            Error::Parameter { what, value, must_be } => write!(f, "{what} is {value}; it must be {must_be}"),
            Error::Size { what, expected, found } => write!(f, "{what}: expected {expected} entries, found {found}"),
            Error::NotFinite { what, value } => write!(f, "{what} is {value}; it must be finite"),
            Error::TimeStep { step, length } => write!(
                f,
                "time step {step} has length {length} s; it must be finite, and it may be zero only after the first step and beside longer ones, without costs on du/dt, and not in the paper's equations"
            ),
            Error::InitialPosition { equation, violation, tolerance } => write!(
                f,
                "the initial coordinates violate {equation} by {violation:.3e} (tolerance {tolerance:.1e}); \
                 correct q0, compute it with `Start::assembled`, or increase `Settings::position_tolerance`"
            ),
            Error::InitialVelocity { equation, violation, tolerance } => write!(
                f,
                "the initial velocities violate the rate of {equation} by {violation:.3e} (tolerance {tolerance:.1e}); \
                 correct v0, compute it with `Start::assembled`, or increase `Settings::velocity_tolerance`"
            ),
            Error::Assembly { equation, violation, tolerance, holds } => write!(
                f,
                "the start cannot be assembled: {equation} remains violated by {violation:.3e} (tolerance {tolerance:.1e}); check whether the loops can close with these lengths, {}or give a better guess (if links lie on one line, bend them slightly)",
                if *holds { "hold fewer coordinates, " } else { "" }
            ),
            Error::AssemblyStalled { correction } => write!(
                f,
                "the assembly of the start does not converge (corrections stay at {correction:.1e}); hold one coordinate for each degree of \
                 freedom, or give a better guess"
            ),
            Error::Held { coordinate } => write!(
                f,
                "`{coordinate}` cannot be held at the start, because the constraints and the other held coordinates determine it; hold at most one \
                 coordinate for each degree of freedom"
            ),
            Error::NotIndependent { coordinate } => write!(
                f,
                "`{coordinate}` is not independent, because the constraints and the other chosen coordinates determine it; choose at most one coordinate \
                 for each degree of freedom"
            ),
            Error::InadmissibleState { equation, violation, tolerance, is_rate } => write!(
                f,
                "the state violates {}{equation} by {violation:.3e} (tolerance {tolerance:.1e}); use a state that satisfies the constraints, for example \
                 `Mechanics::at_start` of a start assembled from a guess (`Start::Assembled`)",
                if *is_rate { "the rate of " } else { "" }
            ),
            Error::NoEquilibrium { coordinate, force, time } => write!(
                f,
                "no equilibrium was found at t = {} s: a force of {force:.3e} on `{coordinate}` remains unbalanced; hold this coordinate, change the controls, \
                 or begin nearer to the equilibrium",
                seconds(*time)
            ),
            Error::NeutralEquilibrium { coordinates } => write!(
                f,
                "the equilibrium is not isolated, because no force changes if these coordinates move: {}; hold one of them for each independent motion",
                coordinates.join(", ")
            ),
            Error::NoControl { coordinates, controls, is_singular, order, time } => {
                let do_not = if controls.len() == 1 { "does not" } else { "do not" };
                let (all, coordinates, time) = (controls.join(", "), coordinates.join(", "), seconds(*time));
                let which = if controls.len() == 1 { "control" } else { "controls" };
                write!(f, "at t = {time} s the {which} {all} {do_not} determine the accelerations of {coordinates}: ")?;
                match (order, is_singular) {
                    (Some(order), _) => write!(
                        f,
                        "only derivatives of order {order} or higher change at once, as behind springs (a servo constraint of index {} or \
                         higher); find the controls of the whole motion by `optimize::solve`, as splines, with readings of the coordinates",
                        order + 1
                    ),
                    (None, true) => f.write_str(
                        "there is no influence on one of the coordinates, or the same influence on several, as where constraints couple them; choose other controls or \
                         coordinates",
                    ),
                    (None, false) => f.write_str(
                        "Newton's method finds no controls with these accelerations; begin with controls nearer to the solution",
                    ),
                }
            }
            Error::MovingConstraint { equation, rate, time } => write!(
                f,
                "there is no equilibrium at t = {} s, because {equation} depends on time there ({rate:.3e}); replace the drive by a constant constraint, or \
                 choose a time at which it rests",
                seconds(*time)
            ),
            Error::NotFree { quantity, equation } => write!(
                f,
                "`{quantity}` cannot be free if the start is given, because any other value would violate {equation}; use `Start::assembled`, which adjusts the start to this quantity (an initial coordinate that is free must also be held with `Start::hold`)"
            ),
            Error::DependentConstraints { rank, rows, equations, time } => write!(
                f,
                "at t = {} s the constraint Jacobian has rank {rank} but {rows} rows, {} too many; dependent: {}; remove the \
                 equations that follow from others, or separate points that coincide although a distance is prescribed between them",
                seconds(*time),
                rows.saturating_sub(*rank),
                equations.join(", ")
            ),
            Error::ContradictoryConstraints { equations, violation, time } => write!(
                f,
                "at t = {} s these constraints contradict each other by {violation:.3e}: {}; remove or correct one of them, or, if they agree at the \
                 start, reduce their drift: set `Settings::drift_bound` to 0.0, or use shorter steps",
                seconds(*time),
                equations.join(", ")
            ),
            Error::SingularConfiguration { step, time, rank, rows, equations, driven } => write!(
                f,
                "singular configuration {} (t = {} s): the constraint Jacobian with {rows} rows has rank {rank}, less than in nearby \
                 configurations, so the motion may branch and is not determined; equations: {}; {}start elsewhere or change the geometry",
                if *step == 0 { "at the start".into() } else { format!("in step {step}") },
                seconds(*time),
                equations.join(", "),
                out_of_reach(driven)
            ),
            Error::SingularMass { coordinates, time } => write!(
                f,
                "at t = {} s the mass matrix is singular, because these coordinates have neither inertia nor a joint that determines them: {}; \
                 give each a mass or inertia, however small, or a constraint that determines it (a force or a spring does not)",
                seconds(*time),
                coordinates.join(", ")
            ),
            Error::Newton { step, time, iterations, length, driven, jump: Some(jump), .. } => write!(
                f,
                "no solution of step {step} continues the motion (t = {} s, last tried with Δt = {length:.3e} s): Newton's method found a solution after {iterations} iterations, but its velocities differ from the expected ones by {jump:.0} times the size of the expected ones; {}use \
                 shorter steps, `Settings::rebase_every` if multipliers have grown in a long motion, or a larger `Settings::max_halvings`",
                seconds(*time),
                out_of_reach(driven)
            ),
            Error::Newton { step, time, iterations, length, residual, equation, driven, jump: None } => write!(
                f,
                "Newton's method did not converge in step {step} (t = {} s, last tried with Δt = {length:.3e} s): the relative residual after \
                 iteration {iterations} is {residual:.2e} in {equation}; {}{}",
                seconds(*time),
                out_of_reach(driven),
                if *length == 0.0 {
                    "a step of length zero cannot be halved: use a larger `Settings::max_iterations`, or check what changes abruptly there"
                } else {
                    "use shorter steps, or a larger `Settings::max_iterations` or `Settings::max_halvings`"
                }
            ),
            Error::StartKind { expected, found } => {
                write!(f, "this start contains {found} instead of {expected}; use a `Start` with {expected}")
            }
            Error::Projection { step, time, iterations, correction } => write!(
                f,
                "positions at the end of step {step} (t = {} s) could not be projected onto Φ = 0: after {iterations} corrections they \
                 still change by {correction:.2e} m or rad; they have drifted too far, so use shorter steps or, unless it is 0.0 \
                 already, a smaller `Settings::drift_bound`",
                seconds(*time)
            ),
            Error::Interrupted { done, of } => write!(f, "stopped by the progress callback after {done} of {of} nodes"),
            Error::File { kind, place, problem } => write!(f, "{kind}, {place}: {problem}"),
            Error::UndeterminedReaction { equation, time } => write!(
                f,
                "a cost depends on the λ of {equation}, which is not unique at t = {} s, because redundant constraints share the reaction; \
                 remove one of them, or use a cost on accelerations or on the sum Φ_qᵀλ",
                seconds(*time)
            ),
            Error::SingularStep { step, time, unknown, pivot } => write!(
                f,
                "the tangent matrix is singular in step {step} (t = {} s) at {unknown} ({}); \
                 the mechanism is in a singular configuration, or the time step is too long",
                seconds(*time),
                if pivot.is_finite() { format!("relative pivot {pivot:.1e}") } else { "numbers overflow".into() }
            ),
            Error::Model { element, arguments, node, time } => write!(
                f,
                "{element} returned a value or derivative that is not finite{} at node {node} (t = {} s); check its formula \
                 (division by zero, root of zero, logarithm of a negative number, coinciding end points of a spring; for second derivatives also zero raised to a power below 2)",
                if arguments.is_empty() { String::new() } else { format!(" for {arguments}") },
                seconds(*time)
            ),
            Error::Panics { element, time } => write!(
                f,
                "the formula of `{element}` panics at the start of the motion (t = {} s), for example because of an index out of range; see the message \
                 of the panic",
                seconds(*time)
            ),
            Error::Changed { element } => write!(
                f,
                "the formula of `{element}` depends on its arguments differently than when the scene was compiled; turn quantities that \
                 change between runs into controls or design variables, or compile the scene again"
            ),
            Error::Overflow { what, value } if value.is_nan() => write!(
                f,
                "{what} is NaN: a formula has no derivative at this input (a root or a power of zero), or terms that exceed the floating-point range cancel; \
                 change the input, or use other units"
            ),
            Error::Overflow { what, value } => write!(
                f,
                "{what} is {value}: a sum exceeds the floating-point range, or a formula has an infinite derivative at this input (a root of zero); \
                 use other units, scale the cost, shorten a motion that amplifies every change, or change the input"
            ),
            Error::NoMinimum { why } => write!(f, "the point is not a minimum at which derivatives exist: {why}; solve the problem first"),
            Error::NotAVariable { what, variables } => write!(
                f,
                "{what} is not among the {variables} variables of this problem; only quantities given to `Variables::new` as free are \
                 (`MotionProblem::free` lists them)"
            ),
            Error::NotInSegments { what, why } => write!(f, "multiple shooting does not support {what}: {why}"),
            Error::NoSuchInput { input } => {
                write!(f, "{input} is not an input of this motion; its handle may belong to another scene (`check::Input::all` lists all inputs)")
            }
            Error::NoPoint { drawn } => write!(
                f,
                "none of {drawn} random points is admissible and has finite values; give points with `at`, or the sizes of the \
                 arguments with `magnitudes`"
            ),
            Error::Memory { given, needed } => {
                write!(f, "{given} bytes are too few for this motion; about {needed} are needed")
            }
            Error::OutOfMemory { what, bytes } => write!(
                f,
                "{what} would need {bytes} bytes or more, which exceeds the memory; use fewer steps, a smaller scene, or a `LongSolver` for a \
                 long motion"
            ),
            Error::Restarted { node, time } => write!(
                f,
                "the motion has a restart at node {node} (t = {} s), which the paper's system does not support; simulate without \
                 `Settings::drift_bound` and `Settings::rebase_every`",
                seconds(*time)
            ),
            Error::LinearEnergy { coordinate, momentum, step, time } => write!(
                f,
                "positions cannot be projected onto Φ = 0 at the end of step {step} (t = {} s): the kinetic energy has a term linear in the \
                 velocities, {momentum:.3e} in p* of `{coordinate}` at v = 0; simulate without `Settings::drift_bound`, and use shorter steps instead",
                seconds(*time)
            ),
            Error::EventNotReached { event, node, until, closest, gap } => write!(
                f,
                "event `{event}`, which should determine node {node}, does not happen until t = {} s: its function is closest to zero at t = {} s, where it is \
                 {gap:.3e}; extend the grid, or remove the event from `Inputs::events`",
                seconds(*until),
                seconds(*closest)
            ),
            Error::EventNotLocated { event, node, time, gap } => write!(
                f,
                "event `{event}`, which should determine node {node}, cannot be located: at t = {} s its function is still {gap:.3e}; begin with a grid \
                 whose node {node} is closer to the event, and check that the function crosses zero there, not with a jump nor with the rate zero",
                seconds(*time)
            ),
            Error::EventAtEnd { event, node, time, left } => write!(
                f,
                "event `{event}` at node {node} happens at t = {} s, {:.3e} s after the end of the grid; extend the grid, or remove the event from \
                 `Inputs::events`",
                seconds(*time),
                left.abs()
            ),
            Error::EventsAtOnce { first, second, time } => write!(
                f,
                "events `{first}` and `{second}` both happen at t = {} s; constraints open or close at both, so that the motion, and its derivatives, depend \
                 on their order: change the start or a design variable so that they happen one after the other, or let one event do both",
                seconds(*time)
            ),
            Error::ClosesApart { event, equation, violation, tolerance, time } => write!(
                f,
                "event `{event}` closes {equation} at t = {} s, where it is violated by {violation:.3e} (tolerance {tolerance:.1e}); let the function of the \
                 event be that of the equation, or increase `Settings::position_tolerance`",
                seconds(*time)
            ),
            Error::Accumulation { event, count, time } => write!(
                f,
                "impacts accumulate: after {count} impacts at event `{event}`, all further ones happen before t = {} s; end the grid before, or add an \
                 event with the same function that closes the equation (`Scene::close_at`): `Solver::find_phases` then lets it end them",
                seconds(*time)
            ),
            Error::EventGrazed { event, node, time, slope } => write!(
                f,
                "event `{event}` at node {node}, t = {} s, has no derivatives: its function touches zero there (rate {slope:.3e}) and does not cross it",
                seconds(*time)
            ),
            Error::EventArguments { event } => write!(
                f,
                "event `{event}` depends on rates of controls; its function may read q, v, v̇, σ, λ, u, the time and parameters"
            ),
            Error::NoSuchEvent { term, event, events } => write!(
                f,
                "`{term}` reads event {event}, counted from 0 (`Sum::Event`), but the inputs have {events}; name the event and its node in `Inputs::events`, \
                 for example by `Solver::find_phases`"
            ),
            Error::ReadingTime { reading, time, node, found } => {
                write!(f, "reading `{reading}` belongs to {time} s, but ")?;
                match found {
                    Some(found) => write!(f, "node {node} is at {found} s")?,
                    None => write!(f, "the grid has no node {node}")?,
                }
                write!(f, "; use the steps and the start time for which the readings were added")
            }
            Error::EventsInPart => write!(
                f,
                "the inputs are a part of a longer motion (`Grid::part`), and have events; events are located in whole motions only, so simulate the part \
                 with the steps found for the whole motion (`Solver::inputs`) and without events"
            ),
            Error::Tolerance { time, length, error } => write!(
                f,
                "the tolerance cannot be met at t = {} s: the estimated error of a step of {length:.1e} s is still {error:.1e} times the tolerance; use a \
                 larger tolerance, or look for a formula that is discontinuous there",
                seconds(*time)
            ),
            Error::Rounding { time, coordinate, rounding, tolerance } => write!(
                f,
                "the tolerance cannot be met at t = {} s: the rounding error of `{coordinate}` in a step is {rounding:.1e}, and the tolerance {tolerance:.1e}; \
                 use a larger tolerance (every tolerance above {:.1e} exceeds rounding)",
                seconds(*time),
                0.5 * f64::EPSILON
            ),
            Error::Scheme { found } => write!(
                f,
                "the paper's equations are those of the trapezoidal rule, but the motion was computed with {found}; simulate with \
                 `Scheme::TRAPEZOIDAL`"
            ),
            Error::NoSecondDerivatives { of } => {
                write!(f, "exact second derivatives of {of} do not exist; use a method that needs only gradients")
            }
            Error::NoHyperDual => f.write_str(
                "hyper-dual numbers do not support costs on accelerations or reactions; `Solver::hessian_product` computes the exact \
                 products, which `check::hessian` compares with differences of gradients",
            ),
            Error::Incomplete { computed: 0, .. } => {
                write!(f, "there is no motion: nothing was simulated, or the start was invalid; call `simulate` first")
            }
            Error::Incomplete { expected, computed } => write!(
                f,
                "the trajectory contains {computed} of the {expected} nodes of the grid; simulate to the end before computing a gradient"
            ),
        }
    }
}
