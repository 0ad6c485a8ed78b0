//! What an [`Error`] says to its reader.

use std::fmt;

use super::{Error, seconds};

/// What a motion that depends on time may have come to.
fn out_of_reach(driven: &[String]) -> String {
    if driven.is_empty() {
        return String::new();
    }
    let (names, depends) = (driven.join(", "), if driven.len() == 1 { "depends" } else { "depend" });
    format!(
        "{names} {depends} on time: a driven mechanism may have come to a position that it cannot pass, such as a dead centre or the end of \
         its reach; see whether the drive and the lengths go together there; else "
    )
}

/// The sentence of `Display`: it is what `expect`, and a `main` that returns the error, print.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Error::DuplicateName { kind, name } => {
                write!(f, "more than one {kind} is called `{name}`; give each its own name")
            }
            Error::Foreign { element, kind } => {
                let article = if kind.starts_with('o') { "an" } else { "a" };
                write!(f, "`{element}` refers to {article} {kind} of another scene; use handles of the scene it is added to")
            }
            Error::ParameterFormula { parameter, branches: true } => write!(
                f,
                "the formula of parameter `{parameter}` looks at a value (`re()`, a comparison, a branch); use `max`, `min` or `abs`, or choose the formula before"
            ),
            Error::ParameterFormula { parameter, .. } => write!(f, "the formula of parameter `{parameter}` panics"),
            Error::RepeatedCoordinate { element, coordinate } => {
                write!(
                    f,
                    "`{element}` lists coordinate `{coordinate}` twice; each coordinate of an element stands once, so what joins two bodies \
                     cannot join one to itself"
                )
            }
            Error::NoBody { element } => {
                write!(f, "`{element}` connects the ground to itself; at least one side must be a body")
            }
            Error::MissingInertia { coordinate } => {
                write!(f, "coordinate `{coordinate}` has no kinetic energy; add a mass or inertia that moves with it (0.0 will do if constraints determine it)")
            }
            Error::Particle { element } => write!(
                f,
                "`{element}` does not go with particles, which have no angle; take a body, or a part between points: hinge, distance, spring, damper, actuator, contact, curve"
            ),
            Error::EmptyScene => write!(f, "the scene has no coordinates; add a body or coordinates first"),
            Error::Parameter { what, value, must_be } => write!(f, "{what} is {value}; it must be {must_be}"),
            Error::Size { what, expected, found } => write!(f, "{what}: expected {expected} entries, found {found}"),
            Error::NotFinite { what, value } => write!(f, "{what} is {value}; it must be finite"),
            Error::TimeStep { step, length } => {
                write!(f, "time step {step} has length {length} s; a step must be finite and not zero")
            }
            Error::InitialPosition { equation, violation, tolerance } => write!(
                f,
                "the initial coordinates violate {equation} by {violation:.3e} (tolerance {tolerance:.1e}); \
                 correct q0, let `Start::Assembled` do it, or raise `Settings::position_tolerance`"
            ),
            Error::InitialVelocity { equation, violation, tolerance } => write!(
                f,
                "the initial velocities violate the rate of {equation} by {violation:.3e} (tolerance {tolerance:.1e}); \
                 correct v0, let `Start::Assembled` do it, or raise `Settings::velocity_tolerance`"
            ),
            Error::Assembly { equation, violation, tolerance, holds } => write!(
                f,
                "the start cannot be assembled: {equation} is left violated by {violation:.3e} (tolerance {tolerance:.1e}); see whether these \
                 lengths can close, {}or begin from a better guess, with links that lie in one line bent a little",
                if *holds { "hold fewer coordinates, " } else { "" }
            ),
            Error::AssemblyStalled { correction } => write!(
                f,
                "the assembly of the start does not converge (corrections stay at {correction:.1e}); hold one coordinate for each degree of \
                 freedom, or begin from a better guess"
            ),
            Error::Held { coordinate } => write!(
                f,
                "`{coordinate}` cannot be held at the start: the constraints and what else is held determine it; hold at most one \
                 coordinate for each degree of freedom"
            ),
            Error::NotFree { quantity, equation } => write!(
                f,
                "`{quantity}` cannot be free by itself where the start is given: {equation} holds it, and would be violated by any other \
                 value; begin with `Start::assembled`, so that the start follows it (a coordinate is held by `Start::hold`)"
            ),
            Error::DependentConstraints { rank, rows, equations, time } => write!(
                f,
                "at t = {} s the constraint Jacobian has rank {rank} but {rows} rows, {} too many; dependent: {}; remove the \
                 equations that follow from others, or move apart points that coincide there though a distance is between them",
                seconds(*time),
                rows.saturating_sub(*rank),
                equations.join(", ")
            ),
            Error::ContradictoryConstraints { equations, violation, time } => write!(
                f,
                "at t = {} s these constraints contradict each other by {violation:.3e}: {}; remove or correct one of them, or, if they agree at the \
                 start, let them drift less: set `Settings::drift_bound` to 0.0, or take shorter steps",
                seconds(*time),
                equations.join(", ")
            ),
            Error::SingularConfiguration { step, time, rank, rows, equations, driven } => write!(
                f,
                "singular configuration {} (t = {} s): the constraint Jacobian with {rows} rows has rank {rank} there, less than \
                 nearby, so the motion may branch and is not determined; equations: {}; {}start elsewhere or change the geometry",
                if *step == 0 { "at the start".into() } else { format!("in step {step}") },
                seconds(*time),
                equations.join(", "),
                out_of_reach(driven)
            ),
            Error::SingularMass { coordinates, time } => write!(
                f,
                "at t = {} s the mass matrix is singular on the admissible motions; coordinates that move without kinetic energy: {}; check \
                 masses and inertias: a coordinate needs a mass, if a small one, or a constraint that determines it, which a force or a spring does not",
                seconds(*time),
                coordinates.join(", ")
            ),
            Error::Newton { step, time, iterations, length, driven, jump: Some(jump), .. } => write!(
                f,
                "no solution of step {step} continues the motion (t = {} s, last tried with Δt = {length:.3e} s): the one that Newton's method \
                 found after {iterations} iterations has velocities that differ from what was to be expected by {jump:.0} times their size; {}try \
                 a shorter time step, `Settings::rebase_every` if multipliers have grown in a long motion, or raise `Settings::max_halvings`",
                seconds(*time),
                out_of_reach(driven)
            ),
            Error::Newton { step, time, iterations, length, residual, equation, driven, jump: None } => write!(
                f,
                "Newton did not converge in step {step} (t = {} s, last tried with Δt = {length:.3e} s): the relative residual after \
                 iteration {iterations} is {residual:.2e} in {equation}; {}try a shorter time step, or raise \
                 `Settings::max_iterations` or `Settings::max_halvings`",
                seconds(*time),
                out_of_reach(driven)
            ),
            Error::StartKind { expected, found } => {
                write!(
                    f,
                    "the start gives {found}, and the inputs that it belongs to {expected}; use the same kind of `Start`"
                )
            }
            Error::Projection { step, time, iterations, correction } => write!(
                f,
                "positions at the end of step {step} (t = {} s) could not be projected onto Φ = 0: after {iterations} corrections they \
                 still move by {correction:.2e} m or rad; they have drifted too far, so take shorter steps or, where it is not 0.0 \
                 already, a smaller `Settings::drift_bound`",
                seconds(*time)
            ),
            Error::Interrupted { done, of } => write!(f, "stopped when asked to, after {done} of {of} nodes"),
            Error::File { kind, place, problem } => write!(f, "{kind}, {place}: {problem}"),
            Error::UndeterminedReaction { equation, time } => write!(
                f,
                "a cost depends on the λ of {equation}, which is not determined at t = {} s: other constraints hold the same points, and may \
                 take its force over; remove one of them, or take a cost on the acceleration or on what Φ_qᵀλ is in sum",
                seconds(*time)
            ),
            Error::SingularStep { step, time, unknown, pivot } => write!(
                f,
                "the tangent matrix is singular in step {step} (t = {} s) at {unknown} ({}); \
                 the mechanism is in a singular configuration, or the time step is too long",
                seconds(*time),
                if pivot.is_finite() { format!("relative pivot {pivot:.1e}") } else { "numbers overflow there".into() }
            ),
            Error::Model { element, arguments, node, time } => write!(
                f,
                "{element} gave a value or derivative that is not finite{} at node {node} (t = {} s); check its formula \
                 (division by zero, root of zero, for second derivatives also a power below 2 of zero, logarithm of a negative number, points \
                 of a spring that coincide)",
                if arguments.is_empty() { String::new() } else { format!(" for {arguments}") },
                seconds(*time)
            ),
            Error::Changed { element } => write!(
                f,
                "the formula of `{element}` depends on its arguments in another way than when the scene was compiled; make what \
                 changes between runs a control or a design variable, or compile the scene again"
            ),
            Error::Overflow { what, value } if value.is_nan() => write!(
                f,
                "{what} is NaN: a formula has no derivative there (a root or a power of zero), or sums beyond the range of numbers cancel; \
                 move the input away from there, or take other units"
            ),
            Error::Overflow { what, value } => write!(
                f,
                "{what} is {value}: a sum is beyond the range of numbers, or a formula has an infinite derivative there (a root of zero); \
                 take other units, scale the cost, shorten a motion that amplifies every change, or move the input away from there"
            ),
            Error::NotInSegments { what, why } => write!(f, "multiple shooting cannot do with {what}: {why}"),
            Error::NoSuchInput { input } => {
                write!(f, "{input} is no input of this motion; is its handle one of another scene? `check::Input::all` lists all inputs")
            }
            Error::NoPoint { drawn } => write!(
                f,
                "none of {drawn} random points is admissible and gives finite values; give points with `at`, or the sizes of the \
                 arguments with `magnitudes`"
            ),
            Error::Memory { given, needed } => {
                write!(f, "{given} bytes are too few for what is asked of this motion; about {needed} are needed")
            }
            Error::OutOfMemory { what, bytes } => write!(
                f,
                "{what} cannot be held in memory: {bytes} bytes or more; take fewer steps or a smaller scene, or a `LongSolver` for a \
                 long motion"
            ),
            Error::Restarted { node, time } => write!(
                f,
                "the motion was started anew at node {node} (t = {} s), which the paper's system does not know; simulate without \
                 `Settings::drift_bound` and `Settings::rebase_every`",
                seconds(*time)
            ),
            Error::LinearEnergy { coordinate, momentum, step, time } => write!(
                f,
                "positions cannot be projected onto Φ = 0 at the end of step {step} (t = {} s): the kinetic energy has a term linear in the \
                 velocities, {momentum:.3e} in p* of `{coordinate}` at v = 0; simulate without `Settings::drift_bound`, with shorter steps",
                seconds(*time)
            ),
            Error::Tolerance { time, length, error } => write!(
                f,
                "the tolerance cannot be met at t = {} s: a step of {length:.1e} s still has {error:.1e} times that error as estimated; ask for a \
                 larger tolerance, or look for a formula that jumps there",
                seconds(*time)
            ),
            Error::Rounding { time, coordinate, rounding, tolerance } => write!(
                f,
                "the tolerance cannot be met at t = {} s: `{coordinate}` is rounded by {rounding:.1e} in a step, and the tolerance is {tolerance:.1e}; \
                 ask for a larger tolerance: above {:.1e} none is below rounding",
                seconds(*time),
                0.5 * f64::EPSILON
            ),
            Error::Scheme { found } => write!(
                f,
                "the paper's equations are those of the trapezoidal rule, and the motion was computed with {found}; simulate with \
                 `Scheme::TRAPEZOIDAL`"
            ),
            Error::NoSecondDerivatives { of } => {
                write!(f, "there are no exact second derivatives of {of}; use a method that needs gradients alone")
            }
            Error::NoHyperDual => f.write_str(
                "hyper-dual numbers do not go through costs that depend on accelerations or reactions; `Solver::hessian_product` has their exact \
                 products, which `check::hessian` holds to differences of gradients",
            ),
            Error::Incomplete { computed: 0, .. } => {
                write!(f, "there is no motion: nothing was simulated, or the start was refused; call `simulate` first")
            }
            Error::Incomplete { expected, computed } => write!(
                f,
                "the trajectory holds {computed} of the {expected} nodes of the grid; simulate to the end before asking for a gradient"
            ),
        }
    }
}
