//! Everything that can go wrong: where, how much, and what to do about it.

mod message;

/// Why a scene could not be compiled, an input was refused, or a sweep stopped.
#[derive(Clone, PartialEq)]
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
        /// Whether any coordinate is held.
        holds: bool,
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
    /// What is free of a start that is given, though a constraint holds it and nothing that is free beside it follows.
    NotFree {
        /// The initial coordinate, its rate, or the design variable.
        quantity: String,
        /// The constraint that holds it.
        equation: String,
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
        /// What is left of their combination that should vanish whatever the state is, with the largest share 1: m or m/s (rad or rad/s).
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
        /// The constraint equations that depend on time there, in the step; none for the start.
        driven: Vec<String>,
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
        /// The constraint equations that depend on time there: what they ask for may be out of reach.
        driven: Vec<String>,
        /// Where a solution was found and refused, since it belongs to another motion: by how much its velocities differ from those that were to be
        /// expected, in sizes of these.
        jump: Option<f64>,
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
    /// A file that does not say what it should, or cannot be written.
    File {
        /// What kind of file: inputs, a table, an animation.
        kind: &'static str,
        /// Where: the path, line and column, or the name of an entry.
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
    /// The tolerance of steps is below what rounding makes of a coordinate in one.
    Rounding {
        /// Where such a step ends, s.
        time: f64,
        /// The coordinate.
        coordinate: String,
        /// What it is rounded by, m or rad, or relative to it if it is larger than 1.
        rounding: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The paper's equations were asked for of a motion by another scheme than the trapezoidal rule.
    Scheme {
        /// The scheme of the motion.
        found: &'static str,
    },
    /// Numbers with derivatives along two directions met a cost on accelerations or reactions.
    NoHyperDual,
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

impl std::error::Error for Error {}

impl Error {
    /// An error of the start of a motion that begins at this node of a longer one.
    pub(crate) fn started_at(mut self, first: usize) -> Self {
        if let Error::Model { node: node @ 0, .. } = &mut self {
            *node = first;
        }
        self
    }
}

/// A time to six digits: what a sum of steps is beyond that is rounding.
pub(crate) fn seconds(time: f64) -> String {
    let rounded: f64 = format!("{time:.5e}").parse().unwrap_or(time);
    format!("{rounded:?}")
}

pub(crate) fn quoted(name: &str) -> String {
    format!("`{name}`")
}
