//! Everything that can go wrong: where, how much, and what to do about it.

use std::fmt;

/// Why a scene could not be compiled, an input was refused, or a sweep stopped.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Two things of one kind have the same name.
    DuplicateName {
        /// The kind: coordinate, body, element, control, design variable.
        kind: &'static str,
        /// The name they share.
        name: String,
    },
    /// An element refers to something of another scene.
    Foreign {
        /// The element.
        element: String,
        /// What it refers to: coordinate, control, design variable, multiplier.
        kind: &'static str,
    },
    /// An element that does not go with particles, which have no angle.
    Particle {
        /// The element.
        element: String,
    },
    /// A formula of a parameter that cannot be recorded.
    ParameterFormula {
        /// The parameter.
        parameter: String,
        /// Whether it branches on a value; else it panicked.
        branches: bool,
    },
    /// A coordinate stands twice in the list of one element.
    RepeatedCoordinate {
        /// The element.
        element: String,
        /// The coordinate.
        coordinate: String,
    },
    /// A joint or force between the ground and itself.
    NoBody {
        /// The element.
        element: String,
    },
    /// A coordinate without any kinetic energy.
    MissingInertia {
        /// The coordinate.
        coordinate: String,
    },
    /// A scene without coordinates.
    EmptyScene,
    /// A physical constant with a value that makes no sense.
    Parameter {
        /// Which one.
        what: String,
        /// Its value.
        value: f64,
        /// What it must be.
        must_be: &'static str,
    },
    /// A direction, or lifted inputs, with another kind of start than the inputs that they belong to.
    StartKind {
        /// What the inputs start with: velocities, augmented momenta.
        expected: &'static str,
        /// What was given.
        found: &'static str,
    },
    /// An input with the wrong number of entries.
    Size {
        /// Which input.
        what: &'static str,
        /// How many entries the scene and the grid need.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// An input that is infinite or not a number.
    NotFinite {
        /// Which entry of which input.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A step of length zero.
    TimeStep {
        /// The step, counted from 1.
        step: usize,
        /// Its length in s.
        length: f64,
    },
    /// The initial coordinates violate a constraint: Φ(q₀, t₀) ≠ 0.
    InitialPosition {
        /// The constraint equation that is violated most.
        equation: String,
        /// Its value, m or rad.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The initial velocities violate a constraint: dΦ/dt(q₀, v₀, t₀) ≠ 0.
    InitialVelocity {
        /// The constraint equation that is violated most.
        equation: String,
        /// Its rate, m/s or rad/s.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// No configuration that satisfies all constraints was found near the guess of a start.
    Assembly {
        /// The constraint that is left most violated.
        equation: String,
        /// By how much, m or rad.
        violation: f64,
        /// How much is accepted.
        tolerance: f64,
    },
    /// The assembly of a start, or its derivative, does not converge.
    AssemblyStalled {
        /// What corrections stay at, m or rad, m/s or rad/s.
        correction: f64,
    },
    /// A coordinate that is held at the start though the constraints and what else is held determine it.
    Held {
        /// The coordinate.
        coordinate: String,
    },
    /// Φ_q has less than full row rank: some constraints follow from (or contradict) others.
    DependentConstraints {
        /// The rank of Φ_q.
        rank: usize,
        /// Its number of rows.
        rows: usize,
        /// The constraint equations that take part in the dependency.
        equations: Vec<String>,
        /// When, s.
        time: f64,
    },
    /// Constraints that contradict each other: no motion satisfies them all.
    ContradictoryConstraints {
        /// The constraint equations that take part.
        equations: Vec<String>,
        /// By how much they cannot be satisfied together, m or m/s (rad or rad/s).
        violation: f64,
        /// When, s.
        time: f64,
    },
    /// Φ_q has a smaller rank here than at other configurations nearby: the motion may branch.
    SingularConfiguration {
        /// The step, counted from 1; 0 for the start.
        step: usize,
        /// When, s.
        time: f64,
        /// The rank of Φ_q.
        rank: usize,
        /// Its number of rows.
        rows: usize,
        /// The constraint equations that take part.
        equations: Vec<String>,
    },
    /// The mass matrix is singular on the motions that the constraints allow.
    SingularMass {
        /// The coordinates that move without kinetic energy.
        coordinates: Vec<String>,
        /// When, s.
        time: f64,
    },
    /// Newton's iteration did not converge in a step.
    Newton {
        /// The step, counted from 1.
        step: usize,
        /// The time at its end, s.
        time: f64,
        /// How many iterations were made.
        iterations: usize,
        /// The length of the step, or of the part of it that was tried last, s.
        length: f64,
        /// The largest residual left, relative to the size of the terms in its equation.
        residual: f64,
        /// The equation that holds it.
        equation: String,
    },
    /// Positions at the end of a step could not be projected onto Φ = 0.
    Projection {
        /// The step, counted from 1.
        step: usize,
        /// The time at its end, s.
        time: f64,
        /// How many corrections were made.
        iterations: usize,
        /// The last of them, in m or rad.
        correction: f64,
    },
    /// Stopped by whoever was told of the progress.
    Interrupted {
        /// The nodes that were done.
        done: usize,
        /// All nodes.
        of: usize,
    },
    /// A file that does not say what it should.
    File {
        /// What kind of file: inputs, a table.
        kind: &'static str,
        /// Where: line and column, or the name of an entry.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// A cost depends on the λ of a constraint whose reaction others may take over.
    UndeterminedReaction {
        /// The constraint equation.
        equation: String,
        /// When, s.
        time: f64,
    },
    /// The tangent matrix K of a step is singular.
    SingularStep {
        /// The step, counted from 1.
        step: usize,
        /// The time at its end, s.
        time: f64,
        /// The unknown at which the elimination broke down.
        unknown: String,
        /// The ratio of the pivot to the entries it came from.
        pivot: f64,
    },
    /// A model function returned an infinite value or NaN for finite arguments.
    Model {
        /// The element.
        element: String,
        /// Those of its arguments for which it has no derivatives there, and their values; empty if they are not known.
        arguments: String,
        /// The node, 0 … N.
        node: usize,
        /// Its time, s.
        time: f64,
    },
    /// A formula that is another one than when the scene was compiled, so that what was concluded from it does not hold any more.
    Changed {
        /// The element.
        element: String,
    },
    /// J, a derivative of it or a violation of a constraint that is infinite or NaN although every term of it is finite.
    Overflow {
        /// Which one.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A motion that cannot be computed in segments.
    NotInSegments {
        /// What stands in the way.
        what: String,
        /// Why, and what to do.
        why: &'static str,
    },
    /// A derivative was asked for with respect to something that a motion does not have.
    NoSuchInput {
        /// What was asked for.
        input: String,
    },
    /// A check drew random points and could use none of them.
    NoPoint {
        /// How many.
        drawn: usize,
    },
    /// A motion that is too long for the memory that was given.
    Memory {
        /// Bytes.
        given: usize,
        /// About so many bytes are needed.
        needed: usize,
    },
    /// More than the memory of the machine, before any of it was allocated.
    OutOfMemory {
        /// What would be stored.
        what: &'static str,
        /// About so many bytes.
        bytes: usize,
    },
    /// The paper's system was asked for of a motion that was started anew on the way.
    Restarted {
        /// The first node where that happened.
        node: usize,
        /// Its time, s.
        time: f64,
    },
    /// Positions cannot be projected onto Φ = 0, since the kinetic energy is not quadratic in v: T_v(q, 0) ≠ 0.
    LinearEnergy {
        /// The coordinate with the largest such momentum.
        coordinate: String,
        /// T_v(q, 0), N s or N m s.
        momentum: f64,
        /// The step at whose end a projection was due, counted from 1.
        step: usize,
        /// When, s.
        time: f64,
    },
    /// No step, however short, has an estimated error below the tolerance.
    Tolerance {
        /// Where the step begins, s.
        time: f64,
        /// The shortest step that was tried, s.
        length: f64,
        /// Its estimated error in parts of the tolerance.
        error: f64,
    },
    /// The paper's equations were asked for of a motion by another scheme than the trapezoidal rule.
    Scheme {
        /// The scheme of the motion.
        found: &'static str,
    },
    /// Second derivatives were asked for of a motion that has something without.
    NoSecondDerivatives {
        /// What it is.
        of: String,
    },
    /// A gradient was asked for of a trajectory that is incomplete or belongs to something else.
    Incomplete {
        /// The nodes that the grid has.
        expected: usize,
        /// The nodes that were computed.
        computed: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Error::DuplicateName { kind, name } => {
                write!(f, "more than one {kind} is called `{name}`; give each its own name")
            }
            Error::Foreign { element, kind } => {
                write!(f, "`{element}` refers to a {kind} of another scene; use handles of the scene it is added to")
            }
            Error::ParameterFormula { parameter, branches: true } => write!(
                f,
                "the formula of parameter `{parameter}` branches on a value; use `max`, `min` or `abs`, or choose the formula before"
            ),
            Error::ParameterFormula { parameter, .. } => write!(f, "the formula of parameter `{parameter}` panics"),
            Error::RepeatedCoordinate { element, coordinate } => {
                write!(f, "`{element}` lists coordinate `{coordinate}` twice; each coordinate of an element stands once")
            }
            Error::NoBody { element } => {
                write!(f, "`{element}` connects the ground to itself; at least one side must be a body")
            }
            Error::MissingInertia { coordinate } => {
                write!(f, "coordinate `{coordinate}` has no kinetic energy; add a mass or inertia that moves with it")
            }
            Error::Particle { element } => write!(
                f,
                "`{element}` does not go with particles, which have no angle; take a body, or a part between points: hinge, distance, spring, damper, actuator, contact, curve"
            ),
            Error::EmptyScene => write!(f, "the scene has no coordinates; add a body or coordinates first"),
            Error::Parameter { what, value, must_be } => write!(f, "{what} is {value}; it must be {must_be}"),
            Error::Size { what, expected, found } => write!(f, "{what}: expected {expected} entries, found {found}"),
            Error::NotFinite { what, value } => write!(f, "{what} is {value}; every input must be finite"),
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
                 correct v0 or p*0, let `Start::Assembled` do it, or raise `Settings::velocity_tolerance`"
            ),
            Error::Assembly { equation, violation, tolerance } => write!(
                f,
                "the start cannot be assembled: {equation} is left violated by {violation:.3e} (tolerance {tolerance:.1e}); see whether these \
                 lengths can close, hold fewer coordinates, or begin from a better guess"
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
            Error::DependentConstraints { rank, rows, equations, time } => write!(
                f,
                "at t = {} s the constraint Jacobian has rank {rank} but {rows} rows, {} too many; dependent: {}; remove the \
                 equations that follow from others",
                seconds(*time),
                rows.saturating_sub(*rank),
                equations.join(", ")
            ),
            Error::ContradictoryConstraints { equations, violation, time } => write!(
                f,
                "at t = {} s these constraints contradict each other by {violation:.3e}: {}; remove or correct one of them",
                seconds(*time),
                equations.join(", ")
            ),
            Error::SingularConfiguration { step, time, rank, rows, equations } => write!(
                f,
                "singular configuration {} (t = {} s): the constraint Jacobian with {rows} rows has rank {rank} there, less than \
                 nearby, so the motion may branch and is not determined; equations: {}; start elsewhere or change the geometry",
                if *step == 0 { "at the start".into() } else { format!("in step {step}") },
                seconds(*time),
                equations.join(", ")
            ),
            Error::SingularMass { coordinates, time } => write!(
                f,
                "at t = {} s the mass matrix is singular on the admissible motions; \
                 coordinates that move without kinetic energy: {}; check masses and inertias",
                seconds(*time),
                coordinates.join(", ")
            ),
            Error::Newton { step, time, iterations, length, residual, equation } => write!(
                f,
                "Newton did not converge in step {step} (t = {} s, last tried with Δt = {length:.3e} s): the relative residual after \
                 iteration {iterations} is {residual:.2e} in {equation}; try a shorter time step, or raise \
                 `Settings::max_iterations` or `Settings::max_halvings`",
                seconds(*time)
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
                 (division by zero, root of zero, logarithm of a negative number, points of a spring that coincide)",
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
                "{what} is {value}: a sum is beyond the range of numbers; take other units, scale the cost, or shorten a motion that \
                 amplifies every change"
            ),
            Error::NotInSegments { what, why } => write!(f, "multiple shooting cannot do with {what}: {why}"),
            Error::NoSuchInput { input } => {
                write!(f, "{input} is no input of this motion; `check::Input::all` lists them")
            }
            Error::NoPoint { drawn } => write!(
                f,
                "none of {drawn} random points is admissible and gives finite values; give points with `at`, or the sizes of the \
                 arguments with `magnitudes`"
            ),
            Error::Memory { given, needed } => {
                write!(f, "{given} bytes are too few for this motion and its gradient; about {needed} are needed")
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
            Error::Scheme { found } => write!(
                f,
                "the paper's equations are those of the trapezoidal rule, and the motion was computed with {found}; simulate with \
                 `Scheme::TRAPEZOIDAL`"
            ),
            Error::NoSecondDerivatives { of } => {
                write!(f, "there are no exact second derivatives of {of}; use a method that needs gradients alone")
            }
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

impl std::error::Error for Error {}

/// A time to six digits: what a sum of steps is beyond that is rounding.
pub(crate) fn seconds(time: f64) -> String {
    let rounded: f64 = format!("{time:.5e}").parse().unwrap_or(time);
    format!("{rounded:?}")
}

pub(crate) fn quoted(name: &str) -> String {
    format!("`{name}`")
}
