//! Errors: what failed, where, by how much, and what to do.

mod message;

/// Reason why a scene could not be compiled, an input was refused, or a sweep stopped.
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Two items of the same kind have the same name.
    DuplicateName {
        /// The kind: coordinate, body, element, control, design variable.
        kind: &'static str,
        /// The name they share.
        name: String,
    },
    /// An element refers to a part of another scene.
    Foreign {
        /// The element.
        element: String,
        /// The kind of part: coordinate, control, design variable, multiplier.
        kind: &'static str,
    },
    /// An element that needs an angle is attached to a particle, which has none.
    Particle {
        /// The element.
        element: String,
    },
    /// The formula of a parameter cannot be recorded.
    ParameterFormula {
        /// The parameter.
        parameter: String,
        /// True if it branches on a value, false if it panicked.
        branches: bool,
    },
    /// An element lists a coordinate twice.
    RepeatedCoordinate {
        /// The element.
        element: String,
        /// The coordinate.
        coordinate: String,
    },
    /// A joint or force connects the ground or one body to itself.
    NoBody {
        /// The element.
        element: String,
    },
    /// No distribution of mass has this inertia tensor.
    Inertia {
        /// The body.
        body: String,
        /// The principal moments of inertia about the centre of mass, kg m², in ascending order.
        moments: [f64; 3],
    },
    /// No joint carries a body in space.
    NoJoint {
        /// The body.
        body: String,
    },
    /// Two joints carry the same body.
    SecondJoint {
        /// The joint that was added later.
        joint: String,
        /// The joint that was added first.
        first: String,
        /// The body.
        body: String,
    },
    /// A joint carries the ground.
    CarriesGround {
        /// The joint.
        joint: String,
    },
    /// A cut is at the ground, or at a body that is fixed to it.
    NothingToCut {
        /// The cut.
        cut: String,
    },
    /// A part is attached to a body in space that no joint carries yet.
    NotCarried {
        /// The part.
        part: String,
        /// The body.
        body: String,
    },
    /// A coordinate occurs in no kinetic energy and in no constraint.
    MissingInertia {
        /// The coordinate.
        coordinate: String,
    },
    /// The scene has no coordinates.
    EmptyScene,
    /// A physical constant has an impossible value.
    Parameter {
        /// Name of the constant.
        what: String,
        /// Value of the constant.
        value: f64,
        /// The condition on the value.
        must_be: &'static str,
    },
    /// The start of a direction, or of lifted inputs, is of a different kind from the start of the inputs to which they belong, or an angular velocity
    /// was given to a start that contains momenta.
    StartKind {
        /// Kind of start that is needed: velocities, augmented momenta.
        expected: &'static str,
        /// Kind of start that was found.
        found: &'static str,
    },
    /// An input has the wrong number of entries.
    Size {
        /// Name of the input.
        what: &'static str,
        /// Number of entries that the scene and the grid need.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// An input is infinite or NaN.
    NotFinite {
        /// Name of the input and its entry.
        what: String,
        /// Value of the entry.
        value: f64,
    },
    /// The length of a time step is not finite, or zero where this is not supported.
    TimeStep {
        /// The step, counted from 1.
        step: usize,
        /// Length of the step, s.
        length: f64,
    },
    /// The initial coordinates violate a constraint: Φ(q₀, t₀) ≠ 0.
    InitialPosition {
        /// The constraint equation that is violated most.
        equation: String,
        /// Value of this equation, m or rad.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The initial velocities violate a constraint: dΦ/dt(q₀, v₀, t₀) ≠ 0.
    InitialVelocity {
        /// The constraint equation that is violated most.
        equation: String,
        /// Rate of this equation, m/s or rad/s.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// No configuration that satisfies all constraints was found near the guess of a start.
    Assembly {
        /// The constraint equation that is violated most.
        equation: String,
        /// Violation of this equation, m or rad.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
        /// True if a coordinate is held.
        holds: bool,
    },
    /// The assembly of a start, or its derivative, does not converge.
    AssemblyStalled {
        /// Size of the corrections that no longer decrease, in m, rad, m/s or rad/s.
        correction: f64,
    },
    /// A coordinate is held at the start although the constraints and the other held coordinates determine it.
    Held {
        /// The coordinate.
        coordinate: String,
    },
    /// A coordinate that should be independent is determined by the constraints and the other chosen coordinates.
    NotIndependent {
        /// The coordinate.
        coordinate: String,
    },
    /// A state violates a constraint: Φ(q, t) ≠ 0 or dΦ/dt(q, v, t) ≠ 0.
    InadmissibleState {
        /// The constraint equation that is violated most.
        equation: String,
        /// Value of this equation, m or rad, or its rate, m/s or rad/s.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
        /// True if the rate of the equation is violated.
        is_rate: bool,
    },
    /// No equilibrium was found near a configuration.
    NoEquilibrium {
        /// The coordinate with the largest force that nothing balances.
        coordinate: String,
        /// This force, N or N m: the force on motions of the coordinate in which the other independent coordinates rest.
        force: f64,
        /// The time, s.
        time: f64,
    },
    /// An equilibrium is not isolated: no force changes if these coordinates move.
    NeutralEquilibrium {
        /// The coordinates that move.
        coordinates: Vec<String>,
    },
    /// Controls do not determine the accelerations of coordinates.
    NoControl {
        /// The coordinates.
        coordinates: Vec<String>,
        /// The controls.
        controls: Vec<String>,
        /// True if the controls have no or the same influence on these accelerations, false if their equations have no solution.
        is_singular: bool,
        /// If these controls change only higher derivatives than accelerations of these coordinates, the lowest order of the former.
        order: Option<usize>,
        /// The time, s.
        time: f64,
    },
    /// A constraint depends on time at the requested time, so that the mechanism cannot be at rest.
    MovingConstraint {
        /// The constraint equation.
        equation: String,
        /// dΦ/dt of the equation at rest, m/s or rad/s, or, if it is zero, its time derivative.
        rate: f64,
        /// The time, s.
        time: f64,
    },
    /// A free variable of a given start is determined by a constraint: no change of the other free variables could keep the constraint
    /// satisfied if this variable changes.
    NotFree {
        /// The initial coordinate, its rate, or the design variable.
        quantity: String,
        /// The constraint that determines it.
        equation: String,
    },
    /// Φ_q has less than full row rank: some constraints follow from others or contradict them.
    DependentConstraints {
        /// The rank of Φ_q.
        rank: usize,
        /// Number of rows of Φ_q.
        rows: usize,
        /// The dependent constraint equations.
        equations: Vec<String>,
        /// The time, s.
        time: f64,
    },
    /// Constraints contradict each other: no motion satisfies all of them.
    ContradictoryConstraints {
        /// The contradicting constraint equations.
        equations: Vec<String>,
        /// Value of the linear combination of these equations, with largest coefficient 1, that should vanish in every state; m, rad, m/s
        /// or rad/s.
        violation: f64,
        /// The time, s.
        time: f64,
    },
    /// Φ_q has a smaller rank here than in nearby configurations: the motion may branch.
    SingularConfiguration {
        /// The step, counted from 1; 0 for the start.
        step: usize,
        /// The time, s.
        time: f64,
        /// The rank of Φ_q.
        rank: usize,
        /// Number of rows of Φ_q.
        rows: usize,
        /// The dependent constraint equations.
        equations: Vec<String>,
        /// The constraint equations among them that depend on time; none for the start.
        driven: Vec<String>,
    },
    /// The mass matrix is singular on the velocities that the constraints allow.
    SingularMass {
        /// The coordinates that move without kinetic energy.
        coordinates: Vec<String>,
        /// The time, s.
        time: f64,
    },
    /// Newton's method did not converge in a step.
    Newton {
        /// The step, counted from 1.
        step: usize,
        /// Time at the end of the step, s.
        time: f64,
        /// Number of iterations.
        iterations: usize,
        /// Length of the step, or of its part that was tried last, s.
        length: f64,
        /// Largest residual, relative to the size of the terms in its equation.
        residual: f64,
        /// The equation with this residual.
        equation: String,
        /// The constraint equations that depend on time: the driven position may be out of reach.
        driven: Vec<String>,
        /// The difference of the velocities from the expected ones, relative to the size of the expected ones, if a solution was found but
        /// rejected because it does not continue this motion.
        jump: Option<f64>,
    },
    /// Positions at the end of a step could not be projected onto Φ = 0.
    Projection {
        /// The step, counted from 1.
        step: usize,
        /// Time at the end of the step, s.
        time: f64,
        /// Number of corrections.
        iterations: usize,
        /// The last correction, m or rad.
        correction: f64,
    },
    /// The progress callback stopped the computation.
    Interrupted {
        /// Number of nodes computed.
        done: usize,
        /// Number of all nodes.
        of: usize,
    },
    /// A file is malformed or cannot be written.
    File {
        /// Kind of file: inputs, table, animation.
        kind: &'static str,
        /// Path, line and column, or name of an entry.
        place: String,
        /// The problem.
        problem: String,
    },
    /// A cost depends on the λ of a constraint that shares its reaction with dependent constraints, so that λ is not unique.
    UndeterminedReaction {
        /// The constraint equation.
        equation: String,
        /// The time, s.
        time: f64,
    },
    /// The tangent matrix K of a step is singular.
    SingularStep {
        /// The step, counted from 1.
        step: usize,
        /// Time at the end of the step, s.
        time: f64,
        /// The unknown at which the elimination failed.
        unknown: String,
        /// Ratio of the pivot to its terms.
        pivot: f64,
    },
    /// A model function returned an infinite value or NaN for finite arguments.
    Model {
        /// The element.
        element: String,
        /// The arguments without a finite derivative, with their values; empty if unknown.
        arguments: String,
        /// The node, 0 … N.
        node: usize,
        /// Time of the node, s.
        time: f64,
    },
    /// A formula panics at the start of a motion, for example because of an index out of range.
    Panics {
        /// The element or cost.
        element: String,
        /// Time of the start, s.
        time: f64,
    },
    /// A formula depends on its arguments differently than when the scene was compiled, so its structure is no longer valid.
    Changed {
        /// The element.
        element: String,
    },
    /// J, a derivative of it or the violation of a constraint is infinite or NaN although each of its terms is finite.
    Overflow {
        /// Name of the quantity.
        what: String,
        /// Value of the quantity.
        value: f64,
    },
    /// Multiple shooting does not support a feature of the problem.
    NotInSegments {
        /// The feature.
        what: String,
        /// The reason, and what to do.
        why: &'static str,
    },
    /// A quantity is not a variable of the problem.
    NotAVariable {
        /// The quantity.
        what: String,
        /// The number of variables.
        variables: usize,
    },
    /// A point at which derivatives of a minimum were requested is not a minimum of the problem.
    NoMinimum {
        /// The reason.
        why: String,
    },
    /// The motion does not have the requested input.
    NoSuchInput {
        /// The requested input.
        input: String,
    },
    /// A check found no admissible random point.
    NoPoint {
        /// Number of points drawn.
        drawn: usize,
    },
    /// The given memory is too small for the motion.
    Memory {
        /// Given memory, bytes.
        given: usize,
        /// Approximate memory needed, bytes.
        needed: usize,
    },
    /// The data would exceed the memory of the machine; nothing was allocated.
    OutOfMemory {
        /// The data.
        what: &'static str,
        /// Approximate size, bytes.
        bytes: usize,
    },
    /// The paper's system does not support motions with restarts.
    Restarted {
        /// The first node with a restart.
        node: usize,
        /// Time of the restart, s.
        time: f64,
    },
    /// Positions cannot be projected onto Φ = 0, because the kinetic energy is not quadratic in v: T_v(q, 0) ≠ 0.
    LinearEnergy {
        /// The coordinate with the largest T_v(q, 0).
        coordinate: String,
        /// T_v(q, 0), N s or N m s.
        momentum: f64,
        /// The step whose end should be projected, counted from 1.
        step: usize,
        /// The time, s.
        time: f64,
    },
    /// The function of an event does not become zero before the motion ends.
    EventNotReached {
        /// The event.
        event: String,
        /// The node that it should determine.
        node: usize,
        /// The end of the search, s.
        until: f64,
        /// The time at which the function is closest to zero, s.
        closest: f64,
        /// The value of the function at that time.
        gap: f64,
    },
    /// The zero of the function of an event is not found by changing the length of the steps before it.
    EventNotLocated {
        /// The event.
        event: String,
        /// The node that it should determine.
        node: usize,
        /// The time that was tried last, s.
        time: f64,
        /// The value of the function there.
        gap: f64,
    },
    /// No time is left after the last event.
    EventAtEnd {
        /// The event.
        event: String,
        /// The node of the event.
        node: usize,
        /// The time of the event, s.
        time: f64,
        /// The time from the event to the end of the grid, s.
        left: f64,
    },
    /// The derivative of the function of an event by its time vanishes, so that the event has no derivatives.
    EventGrazed {
        /// The event.
        event: String,
        /// The node of the event.
        node: usize,
        /// The time of the event, s.
        time: f64,
        /// The derivative of the function by the time.
        slope: f64,
    },
    /// The function of an event reads u̇.
    EventArguments {
        /// The event.
        event: String,
    },
    /// A cost or an output reads an event ([`Sum::Event`](crate::Sum::Event)) that the inputs do not have.
    NoSuchEvent {
        /// The cost, or the term of an output.
        term: String,
        /// The event, counted from 0.
        event: usize,
        /// The number of events of the inputs.
        events: usize,
    },
    /// A reading is compared with a node that is at another time ([`Scene::reading_time`](crate::Scene::reading_time)).
    ReadingTime {
        /// The reading.
        reading: String,
        /// The time of the reading, s.
        time: f64,
        /// The node at which the reading is compared.
        node: usize,
        /// The time of this node, s; `None` if the grid has no such node.
        found: Option<f64>,
    },
    /// The inputs of a part of a motion have events.
    EventsInPart,
    /// Two events at which constraint equations open or close happen at the same time, and what follows depends on their order.
    EventsAtOnce {
        /// One of the events.
        first: String,
        /// The other one.
        second: String,
        /// Their time, s.
        time: f64,
    },
    /// An event closes a constraint equation that is not satisfied there.
    ClosesApart {
        /// The event.
        event: String,
        /// The equation.
        equation: String,
        /// Value of the equation, m or rad.
        violation: f64,
        /// The tolerance.
        tolerance: f64,
        /// The time of the event, s.
        time: f64,
    },
    /// Impacts follow each other ever faster, so that infinitely many of them happen before a certain time.
    Accumulation {
        /// The event.
        event: String,
        /// The number of impacts found.
        count: usize,
        /// The time before which all impacts happen, s.
        time: f64,
    },
    /// Even the shortest step has an estimated error above the tolerance.
    Tolerance {
        /// Time at the beginning of the step, s.
        time: f64,
        /// Length of the shortest step tried, s.
        length: f64,
        /// Estimated error of this step, relative to the tolerance.
        error: f64,
    },
    /// The tolerance is below the rounding error of a coordinate in one step.
    Rounding {
        /// Time at the end of the step, s.
        time: f64,
        /// The coordinate.
        coordinate: String,
        /// Rounding error of the coordinate, m or rad, or relative to the coordinate if it is larger than 1.
        rounding: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// The paper's equations need a motion computed with the trapezoidal rule.
    Scheme {
        /// The scheme of the motion.
        found: &'static str,
    },
    /// Hyper-dual numbers do not support costs on accelerations or reactions.
    NoHyperDual,
    /// A part of the motion has no second derivatives.
    NoSecondDerivatives {
        /// The part.
        of: String,
    },
    /// The trajectory is incomplete or does not belong to the inputs.
    Incomplete {
        /// Number of nodes of the grid.
        expected: usize,
        /// Number of nodes computed.
        computed: usize,
    },
}

impl std::error::Error for Error {}

impl Error {
    /// The error with node numbers of a longer motion, in which the present motion begins at node `first`.
    pub(crate) fn started_at(mut self, first: usize) -> Self {
        if let Error::Model { node: node @ 0, .. } = &mut self {
            *node = first;
        }
        self
    }
}

/// A time with six digits; further digits of a sum of steps are rounding.
pub(crate) fn seconds(time: f64) -> String {
    let rounded: f64 = format!("{time:.5e}").parse().unwrap_or(time);
    format!("{rounded:?}")
}

pub(crate) fn quoted(name: &str) -> String {
    format!("`{name}`")
}
