//! Costs and outputs of a scene.

use nalgebra::SVector;
use std::sync::Arc;

use super::Scene;
use super::ready::{Added, Entry, Kind, Part, Sort};
use crate::model::element::{Cost, CostPoint, ListCost, Sum};
use crate::model::{Control, Coordinate, Multiplier, Output, Param};
use crate::system::{AnyCost, CostOfLists, Fixed, PlacedCost, Shape};
use crate::{Error, Scalar};

/// The outputs of a coordinate at the end of a motion ([`Scene::end_state`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndState {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// The coordinate q_N at the end, m or rad.
    pub position: Output,
    /// The velocity q̇_N at the end, m/s or rad/s.
    pub rate: Output,
}

impl From<EndState> for Coordinate {
    fn from(state: EndState) -> Self {
        state.coordinate
    }
}

impl EndState {
    /// The names of both outputs for the coordinate with the given name.
    pub(super) fn names(coordinate: &str) -> [String; 2] {
        ["value", "rate"].map(|what| format!("{what} of {coordinate} at the end"))
    }
}

/// b₁ (q − b₀).
struct Position;

impl Cost<1, 0, 0, 2> for Position {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 2>) -> S {
        (at.q[0] - b[0]) * b[1]
    }
}

/// b u².
struct Effort;

impl Cost<0, 0, 1, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, b: &SVector<S, 1>) -> S {
        b[0] * at.u[0] * at.u[0]
    }
}

/// b; its integral is b times the duration.
struct Time;

impl Cost<0, 0, 0, 1> for Time {
    fn cost<S: Scalar>(&self, _at: &CostPoint<S, 0, 0, 0>, b: &SVector<S, 1>) -> S {
        b[0]
    }
}

/// t.
struct When;

impl Cost<0, 0, 0, 0> for When {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.t
    }
}

/// b₀ σ.
struct Multiple;

impl Cost<0, 1, 0, 1> for Multiple {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, b: &SVector<S, 1>) -> S {
        b[0] * at.sigma[0]
    }
}

/// q̇.
struct Rate;

impl Cost<1, 0, 0, 0> for Rate {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v[0]
    }
}

static EFFORT: Kind = Kind::new("effort", &["weight"], |scene, name, part| {
    scene.cost(name, Effort, Sum::Integral, [], [], part.by(), [part.number(0)]);
})
.driven_by("control");

static TIME: Kind = Kind::new("time", &["weight"], |scene, name, part| {
    scene.cost(name, Time, Sum::Integral, [], [], [], [part.number(0)]);
});

static END_STATE: Kind = Kind::new("end state", &[], |scene, of, part| {
    let (names, coordinate) = (EndState::names(of), part.coordinate());
    let [position, rate] = names.each_ref().map(|name| scene.output(name));
    scene.parts.looked_at.extend([position.index(), rate.index()]);
    scene.term(position, &names[0], Position, Sum::Terminal, [coordinate], [], [], [0.0.into(), 1.0.into()]);
    scene.term(rate, &names[1], Rate, Sum::Terminal, [coordinate], [], [], []);
})
.with(&[("name", Sort::Coordinate)]);

static READING: Kind = Kind::new("reading", &[], |scene, name, part| {
    let (output, b) = (scene.output(name), part.fixed_numbers());
    let at = (Sum::Node(part.count()), part.coordinate());
    scene.term(output, name, Position, at.0, [at.1], [], [], [b[0].into(), b[1].into()]);
    // The weight 1 is that of a reading of which nothing is known.
    if b[1] != 1.0 {
        scene.parts.readings.push(name.to_string());
    }
})
.with(&[("coordinate", Sort::Coordinate), ("node", Sort::Count), ("value", Sort::Number), ("weight", Sort::Number)]);

static READING_TIME: Kind = Kind::new("reading time", &[], |scene, name, part| {
    let time = part.fixed_numbers()[0];
    if !time.is_finite() {
        scene.report(Error::NotFinite { what: format!("the time of reading `{name}`"), value: time });
    }
    scene.parts.reading_times.push((name.to_string(), part.count(), time));
})
.with(&[("node", Sort::Count), ("time", Sort::Number)]);

static READING_DEVIATION: Kind = Kind::new("reading deviation", &[], |scene, name, part| {
    let value = part.fixed_numbers()[0];
    if !(value > 0.0 && value.is_finite()) {
        let what = format!("the standard deviation of reading `{name}`");
        scene.report(Error::Parameter { what, value, must_be: "positive and finite" });
    }
    scene.parts.readings.push(name.to_string());
})
.with(&[("deviation", Sort::Number)]);

static EVENT_TIME: Kind = Kind::new("event time", &[], |scene, name, part| {
    let output = scene.output(name);
    scene.term(output, name, When, Sum::Event(part.count()), [], [], [], []);
})
.with(&[("event", Sort::Count)]);

static EVENT_IMPULSE: Kind = Kind::new("event impulse", &[], |scene, name, part| {
    let (output, event, equation) = (scene.output(name), part.count(), part.equations()[0]);
    scene.term(output, name, Multiple, Sum::AfterEvent(event), [], [equation], [], [(-1.0).into()]);
    scene.term(output, &format!("{name} (before)"), Multiple, Sum::Event(event), [], [equation], [], [1.0.into()]);
})
.with(&[("equation", Sort::Equation), ("event", Sort::Count)]);

/// The kinds of ready-made costs and outputs.
#[cfg(feature = "files")]
pub(super) static KINDS: [&Kind; 8] =
    [&EFFORT, &TIME, &END_STATE, &READING, &READING_TIME, &READING_DEVIATION, &EVENT_TIME, &EVENT_IMPULSE];

impl Scene {
    /// Adds a cost h or S of Eq. (5) that depends on the coordinates `q`, multipliers `sigma` and controls `u`; `sum` is the rule by which its
    /// values at the nodes are summed.
    #[expect(clippy::too_many_arguments, reason = "the arguments of the cost function, one list each")]
    pub fn cost<C, const N: usize, const M: usize, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        cost: C,
        sum: Sum,
        q: [Coordinate; N],
        sigma: [Multiplier; M],
        u: [Control; K],
        b: [Param; P],
    ) where
        C: Cost<N, M, K, P>,
    {
        self.add_cost((name, 0), (Fixed(cost), sum), &q, &sigma, &u, &b);
    }

    /// Adds an output, a scalar result of the motion in addition to J. Its value is the sum of its terms ([`term`](Self::term)).
    pub fn output(&mut self, name: &str) -> Output {
        let output = self.parts.outputs.len();
        self.parts.scene.begin_part();
        self.parts.outputs.push(name.to_string());
        self.note(name, Added::Output);
        Output(self.parts.scene.handle(output))
    }

    /// Adds a term to an output, as [`cost`](Self::cost) adds one to J. The residual of a reading is a term with [`Sum::Terminal`] or
    /// [`Sum::Node`]; approximate a maximum smoothly by the p-norm (∫ |h|ᵖ dt)^(1/p).
    ///
    /// ```
    /// use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// /// q − b.
    /// struct Miss;
    /// impl Cost<1, 0, 0, 1> for Miss {
    ///     fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
    ///         at.q[0] - b[0]
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
    /// let force = scene.control("force");
    /// scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    /// let [x, y, _] = cart.coordinates;
    /// let (right, up) = (scene.output("right"), scene.output("up"));
    /// scene.term(right, "x", Miss, Sum::Terminal, [x], [], [], [1.0.into()]);
    /// scene.term(up, "y", Miss, Sum::Terminal, [y], [], [], [0.5.into()]);
    /// let system = scene.compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
    /// inputs.controls.fill(4.0);
    /// let mut solver = Solver::new(&system, Settings::default());
    /// solver.simulate(&inputs)?;
    /// assert!((solver.outputs()?[right.index()] - (0.5 * 4.0 / 2.0 - 1.0)).abs() < 1e-14);
    /// let jacobian = solver.jacobian()?;
    /// assert!((jacobian[right.index()].controls.sum() - 0.25).abs() < 1e-14); // x = u t²/(2 m)
    /// assert_eq!(jacobian[up.index()].controls.amax(), 0.0);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn term<C, const N: usize, const M: usize, const K: usize, const P: usize>(
        &mut self,
        output: Output,
        name: &str,
        term: C,
        sum: Sum,
        q: [Coordinate; N],
        sigma: [Multiplier; M],
        u: [Control; K],
        b: [Param; P],
    ) where
        C: Cost<N, M, K, P>,
    {
        if self.check(name, "output", [output.0]) {
            self.add_cost((name, 1 + output.index()), (Fixed(term), sum), &q, &sigma, &u, &b);
        }
    }

    /// Adds an output with the value of a function h at each of some nodes, for example to limit it along the motion. The outputs are named
    /// "`name` at node i"; [`MotionProblem::constrain_all`](crate::optimize::MotionProblem::constrain_all) limits them.
    ///
    /// ```
    /// use hamiltonian_adjoint::optimize::{Free, Interval, MotionProblem, Variables};
    /// use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Settings, scenes::CartPendulum};
    /// use nalgebra::SVector;
    ///
    /// #[derive(Clone)]
    /// struct Place;
    /// impl Cost<1> for Place {
    ///     fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
    ///         at.q[0]
    ///     }
    /// }
    ///
    /// let mut cart = CartPendulum::with_links(1).mechanism();
    /// let places = cart.scene.outputs_at("place", Place, 0..=40, [cart.cart.coordinates[0]], [], [], []);
    /// let system = cart.scene.compile()?;
    /// let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.025));
    /// let variables = Variables::new(&system, &inputs, vec![Free::control(cart.force)])?;
    /// let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables)?;
    /// problem.constrain_all(&places, Interval::new(-0.5, 0.5)); // the ends of a rail, m
    /// assert_eq!(system.output_name(places[7].index()), "place at node 7");
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn outputs_at<C, const N: usize, const M: usize, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        function: C,
        nodes: impl IntoIterator<Item = usize>,
        q: [Coordinate; N],
        sigma: [Multiplier; M],
        u: [Control; K],
        b: [Param; P],
    ) -> Vec<Output>
    where
        C: Cost<N, M, K, P>,
    {
        let formula = CostOfLists::shared(Fixed(function), Shape { n: N, m: M, k: K, p: P });
        let mut output = |node: usize| {
            let name = format!("{name} at node {node}");
            let output = self.output(&name);
            self.add_formula((&name, 1 + output.index(), Sum::Node(node)), formula.clone(), (&q, &sigma, &u, &b));
            output
        };
        nodes.into_iter().map(&mut output).collect()
    }

    /// Adds the effort w ∫ u² dt of a control to J.
    pub fn effort(&mut self, name: &str, control: Control, weight: impl Into<Param>) {
        let (control, numbers) = (Some(control), vec![weight.into()]);
        self.ready(name, Part { control, numbers, ..Part::of(&EFFORT) });
    }

    /// Adds the duration of the motion (s) times a weight to J.
    pub fn time(&mut self, name: &str, weight: impl Into<Param>) {
        self.ready(name, Part { numbers: vec![weight.into()], ..Part::of(&TIME) });
    }

    /// Adds outputs for the value and the rate of a coordinate at the end of the motion. They become constraints of an optimisation problem
    /// only if you call [`MotionProblem::constrain`](crate::optimize::MotionProblem::constrain).
    pub fn end_state(&mut self, coordinate: Coordinate) -> EndState {
        let own = self.parts.coordinates.get(coordinate.index()).filter(|_| self.parts.scene.owns(&coordinate.0));
        let of = own.cloned().unwrap_or_else(|| "a coordinate of another scene".into());
        let more = vec![Entry::Coordinate(coordinate)];
        let [position, rate] = self.ready_outputs(&of, Part { more, ..Part::of(&END_STATE) });
        EndState { coordinate, position, rate }
    }

    /// Adds the residual of a reading as an output: w (q_i − q̃) with the measured value (reading) q̃ of a coordinate at node i and the
    /// weight w, such as the inverse standard deviation of the reading. The weight 1 means that the standard deviation is not known: fits then do
    /// not test χ² ([`Warning::Misfit`](crate::Warning::Misfit)). [`readings_of`](Self::readings_of) is for other quantities than coordinates.
    pub fn reading(&mut self, name: &str, coordinate: Coordinate, node: usize, value: f64, weight: f64) -> Output {
        let [value, weight] = [value, weight].map(|number| Entry::Numbers(vec![number]));
        let more = vec![Entry::Coordinate(coordinate), Entry::Count(node), value, weight];
        let [output] = self.ready_outputs(name, Part { more, ..Part::of(&READING) });
        output
    }

    /// Records the time of a reading, s, that an output compares with a node. Optimisation problems then
    /// reject inputs whose node is at another time ([`Inputs::check_reading_times`](crate::Inputs::check_reading_times)).
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let block = scene.body("block", 1.0, 0.1, [0.0; 3]);
    /// scene.reading("x", block.coordinates[0], 20, 0.1, 1e3);
    /// scene.reading_time("x", 20, 0.2);
    /// let system = scene.compile()?;
    /// Inputs::at_rest(&system, Grid::uniform(50, 0.01)).check_reading_times(&system)?;
    /// let error = Inputs::at_rest(&system, Grid::uniform(50, 0.02)).check_reading_times(&system).unwrap_err();
    /// assert!(error.to_string().contains("`x` belongs to 0.2 s, but node 20 is at 0.4 s"));
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn reading_time(&mut self, name: &str, node: usize, time: f64) {
        let more = vec![Entry::Count(node), Entry::Numbers(vec![time])];
        self.ready(name, Part { more, ..Part::of(&READING_TIME) });
    }

    /// States that the output with this name is the difference of a quantity and a reading, divided by the known standard deviation of the reading
    /// (in the unit of the quantity), so that fits test χ² ([`Warning::Misfit`](crate::Warning::Misfit)). For outputs that are made by
    /// [`output`](Self::output); ready-made readings do so themselves.
    pub fn reading_deviation(&mut self, name: &str, deviation: f64) {
        let more = vec![Entry::Numbers(vec![deviation])];
        self.ready(name, Part { more, ..Part::of(&READING_DEVIATION) });
    }

    /// Adds the time of an event, s, as an output; events are counted from 0 in [`Inputs::events`](crate::Inputs::events).
    pub fn event_time(&mut self, name: &str, event: usize) -> Output {
        let [output] = self.ready_outputs(name, Part { more: vec![Entry::Count(event)], ..Part::of(&EVENT_TIME) });
        output
    }

    /// Adds the impulse of a constraint equation at an event, N s or N m s, as an output: −Δσ over the steps of length zero that follow the event. It acts
    /// along Φ_qᵀ and is positive if it increases dΦ/dt. Events are counted from 0 in [`Inputs::events`](crate::Inputs::events).
    pub fn event_impulse(&mut self, name: &str, equation: Multiplier, event: usize) -> Output {
        let more = vec![Entry::Equations(vec![equation]), Entry::Count(event)];
        let [output] = self.ready_outputs(name, Part { more, ..Part::of(&EVENT_IMPULSE) });
        output
    }

    /// Adds a cost as a function of lists whose lengths are known at run time ([`ListCost`]).
    #[expect(clippy::too_many_arguments, reason = "the arguments of the cost function, one list each")]
    pub fn list_cost<C: ListCost>(
        &mut self,
        name: &str,
        cost: C,
        sum: Sum,
        q: &[Coordinate],
        sigma: &[Multiplier],
        u: &[Control],
        b: &[Param],
    ) {
        self.add_cost((name, 0), (cost, sum), q, sigma, u, b);
    }

    /// Adds a term as a function of lists ([`ListCost`]) to an output.
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn list_term<C: ListCost>(
        &mut self,
        output: Output,
        name: &str,
        term: C,
        sum: Sum,
        q: &[Coordinate],
        sigma: &[Multiplier],
        u: &[Control],
        b: &[Param],
    ) {
        if self.check(name, "output", [output.0]) {
            self.add_cost((name, 1 + output.index()), (term, sum), q, sigma, u, b);
        }
    }

    fn add_cost(
        &mut self,
        (name, output): (&str, usize),
        (cost, sum): (impl ListCost, Sum),
        q: &[Coordinate],
        sigma: &[Multiplier],
        u: &[Control],
        b: &[Param],
    ) {
        let shape = Shape { n: q.len(), m: sigma.len(), k: u.len(), p: b.len() };
        self.add_formula((name, output, sum), CostOfLists::shared(cost, shape), (q, sigma, u, b));
    }

    fn add_formula(
        &mut self,
        what: (&str, usize, Sum),
        formula: Arc<dyn AnyCost>,
        handles: (&[Coordinate], &[Multiplier], &[Control], &[Param]),
    ) {
        let (name, to) = (what.0, self.connect(what.0, handles));
        self.costs_named.push(name.to_string());
        if let Some(to) = to {
            let place = self.parts.costs.push(PlacedCost::of(what, formula, to));
            self.note(name, Added::Function(place));
        }
    }
}
