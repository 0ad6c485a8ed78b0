//! Inputs of a motion: the initial state, the controls, the [`Grid`] and the design variables.

use nalgebra::{DMatrix, DVector, Quaternion};

use super::occurrence::{Occurrence, check_events, check_open};
use super::timed::check_timed;
use crate::motion::{Grid, column};
use crate::number::Real;
use crate::{Control, Coordinate, Error, Multiplier, System, memory};

/// The coordinates and velocities that an assembled start keeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Held {
    /// Coordinates that keep their values: at most one for each degree of freedom.
    pub coordinates: Vec<Coordinate>,
    /// Coordinates whose velocities keep their values.
    pub velocities: Vec<Coordinate>,
}

/// The initial state or, in a [`Gradient`](crate::Gradient), the derivatives with respect to it.
#[derive(Clone, Debug, PartialEq)]
pub enum Start<R = f64> {
    /// Coordinates and velocities are given; p*₀ = T_v(q₀, v₀) and σ₀ = 0.
    Velocity {
        /// q₀, m or rad.
        q: DVector<R>,
        /// v₀, m/s or rad/s.
        v: DVector<R>,
    },
    /// Coordinates and augmented momenta are given; v₀ and σ₀ follow from Eq. (1a) and (1c).
    Momentum {
        /// q₀, m or rad.
        q: DVector<R>,
        /// p*₀, N s or N m s.
        p_star: DVector<R>,
    },
    /// Only a guess is given. The start satisfies Φ(q₀, t₀; b) = 0 and dΦ/dt = 0. It is nearest to the guess in the metric of the mass matrix, with
    /// held coordinates and velocities fixed; p*₀ and σ₀ follow as for [`Velocity`](Self::Velocity). The start depends on design variables, and the
    /// gradient includes this dependence.
    Assembled {
        /// The guess for q₀, m or rad.
        q: DVector<R>,
        /// The guess for v₀, m/s or rad/s.
        v: DVector<R>,
        /// The coordinates and velocities that are kept.
        held: Held,
    },
}

impl Start {
    /// A start assembled from the positions of the scene, at rest, with nothing held.
    pub fn assembled(system: &System) -> Self {
        Start::Assembled { q: system.initial_coordinates(), v: DVector::zeros(system.n()), held: Held::default() }
    }

    /// Holds coordinates and their velocities in an assembled start; other starts keep all values anyway.
    #[must_use]
    pub fn hold(mut self, coordinates: &[Coordinate]) -> Self {
        if let Start::Assembled { held, .. } = &mut self {
            held.coordinates.extend_from_slice(coordinates);
            held.velocities.extend_from_slice(coordinates);
        }
        self
    }

    /// Sets the rates of Euler parameters, `joint.orientation`, to ė = ½ e ⊗ (0, ω): b turns relative to a with the angular velocity ω, rad/s, along the
    /// axes of b. Set the Euler parameters e before.
    ///
    /// # Errors
    /// [`Error::StartKind`] if momenta are given, since those depend on the inertias and on the motion of all bodies.
    ///
    /// # Panics
    /// If the system has no such coordinates.
    pub fn set_angular_velocity(&mut self, orientation: [Coordinate; 4], omega: [f64; 3]) -> Result<(), Error> {
        if let Start::Momentum { .. } = self {
            return Err(Error::StartKind { expected: "velocities", found: self.kind() });
        }
        let ([e0, x, y, z], [p, q, r]) = (orientation.map(|coordinate| self.q()[coordinate.index()]), omega);
        let rates = Quaternion::new(e0, x, y, z) * Quaternion::new(0.0, p, q, r) * 0.5;
        let rates = [rates.w, rates.i, rates.j, rates.k];
        orientation.into_iter().zip(rates).for_each(|(coordinate, rate)| self.set_rate(coordinate, rate));
        Ok(())
    }
}

impl<R: Real> Start<R> {
    /// The coordinates q₀, m or rad.
    pub fn q(&self) -> &DVector<R> {
        match self {
            Start::Velocity { q, .. } | Start::Momentum { q, .. } | Start::Assembled { q, .. } => q,
        }
    }

    /// Sets one coordinate. The start is not linked to a scene, so a handle of another scene sets the coordinate with the same number.
    ///
    /// # Panics
    /// If the system has no such coordinate.
    pub fn set_coordinate(&mut self, coordinate: Coordinate, value: R) {
        self.q_mut()[coordinate.index()] = value;
    }

    /// Sets one velocity, or one momentum if momenta are given.
    ///
    /// # Panics
    /// If the system has no such coordinate.
    pub fn set_rate(&mut self, coordinate: Coordinate, value: R) {
        self.rate_mut()[coordinate.index()] = value;
    }

    /// Mutable access to the coordinates q₀.
    pub fn q_mut(&mut self) -> &mut DVector<R> {
        match self {
            Start::Velocity { q, .. } | Start::Momentum { q, .. } | Start::Assembled { q, .. } => q,
        }
    }

    /// The velocities v₀ or the momenta p*₀, whichever the start contains.
    pub fn rate(&self) -> &DVector<R> {
        match self {
            Start::Velocity { v, .. } | Start::Assembled { v, .. } => v,
            Start::Momentum { p_star, .. } => p_star,
        }
    }

    /// Mutable access to v₀ or p*₀, whichever the start contains.
    pub fn rate_mut(&mut self) -> &mut DVector<R> {
        match self {
            Start::Velocity { v, .. } | Start::Assembled { v, .. } => v,
            Start::Momentum { p_star, .. } => p_star,
        }
    }

    /// The symbol of the velocities v₀ or the momenta p*₀, whichever the start contains.
    pub(crate) fn rate_symbol(&self) -> &'static str {
        match self {
            Start::Velocity { .. } | Start::Assembled { .. } => "v₀",
            Start::Momentum { .. } => "p*₀",
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Start::Velocity { .. } => "velocities",
            Start::Momentum { .. } => "augmented momenta",
            Start::Assembled { .. } => "a guess",
        }
    }

    /// Checks that a change of the start is of the same kind: velocities, momenta or a guess.
    pub(crate) fn check_kind<T: Real>(&self, changed: &Start<T>) -> Result<(), Error> {
        let (expected, found) = (self.kind(), changed.kind());
        if expected == found { Ok(()) } else { Err(Error::StartKind { expected, found }) }
    }

    fn map<T>(&self, f: impl Fn(R) -> T) -> Start<T>
    where
        T: nalgebra::Scalar,
    {
        match self {
            Start::Velocity { q, v } => Start::Velocity { q: q.map(&f), v: v.map(&f) },
            Start::Momentum { q, p_star } => Start::Momentum { q: q.map(&f), p_star: p_star.map(&f) },
            Start::Assembled { q, v, held } => Start::Assembled { q: q.map(&f), v: v.map(&f), held: held.clone() },
        }
    }
}

/// The inputs of a motion: grid, start, controls and design variables.
///
/// The fields are public: start from [`Inputs::at_rest`] and change them.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs<R = f64> {
    /// The time grid.
    pub grid: Grid<R>,
    /// The initial state.
    pub start: Start<R>,
    /// The controls: u_i in column i = 0 … N, one row for each channel (k × (N + 1)).
    pub controls: DMatrix<R>,
    /// The values of the design variables.
    pub design: DVector<R>,
    /// The events that determine nodes, in the order of their nodes ([`Scene::event`](crate::Scene::event)). The steps of the grid are then guesses:
    /// those before an event are multiplied by a common factor, and those after the last event by one that keeps the end of the motion, unless
    /// the last node has an event. Controls belong to nodes and move with them, except [`controls_in_time`](Self::controls_in_time).
    pub events: Vec<Occurrence>,
    /// The controls that are functions of time although events move the nodes: lines through their values at the times of the given nodes (of a
    /// composed grid, at the ends of macro steps), constant after the last one. They do not jump: in steps of length zero they have the mean of both values. Without
    /// events there is no difference.
    pub controls_in_time: Vec<Control>,
    /// The constraint equations that are open at the start ([`Scene::open_at`](crate::Scene::open_at)).
    pub open: Vec<Multiplier>,
}

impl<R> Inputs<R> {
    /// The controls at a node.
    pub(crate) fn controls_at(&self, node: usize) -> &[R] {
        column(&self.controls, node)
    }
}

impl<R: Real> Inputs<R> {
    /// The controls at both ends of the step that ends at `node`.
    pub(crate) fn at_ends(&self, node: usize) -> [&[R]; 2] {
        [column(&self.controls, node - 1), column(&self.controls, node)]
    }

    /// True if events move nodes under controls that are functions of time.
    pub(crate) fn has_knots(&self) -> bool {
        !self.events.is_empty() && !self.controls_in_time.is_empty()
    }

    /// Writes u̇ in the step that ends at a node; does nothing if there is no such step.
    pub(crate) fn control_rates(&self, step: usize, u_dot: &mut [R]) {
        let Some(&length) = self.grid.steps.get(step - 1) else { return };
        let [begin, end] = self.at_ends(step);
        u_dot.iter_mut().zip(begin.iter().zip(end)).for_each(|(u_dot, (&begin, &end))| *u_dot = (end - begin) / length);
    }

    /// The controls at the fraction c of the step that ends at `node`, linear between its ends.
    pub(crate) fn controls_within(&self, node: usize, c: f64, u: &mut [R]) {
        let (before, after) = (column(&self.controls, node - 1), column(&self.controls, node));
        u.iter_mut().zip(before.iter().zip(after)).for_each(|(u, (&before, &after))| *u = before * (1.0 - c) + after * c);
    }
}

impl Inputs {
    /// Inputs at rest at the positions of the scene, with zero controls and the design of the scene.
    ///
    /// # Panics
    /// If the controls do not fit into memory.
    pub fn at_rest(system: &System, grid: Grid) -> Self {
        memory::require("the controls", grid.nodes(), system.k() * size_of::<f64>());
        Inputs {
            start: Start::Velocity { q: system.initial_coordinates(), v: DVector::zeros(system.n()) },
            controls: DMatrix::zeros(system.k(), grid.nodes()),
            design: system.design_values(),
            events: Vec::new(),
            controls_in_time: Vec::new(),
            open: system.open_equations(),
            grid,
        }
    }

    /// Sets a control at all nodes to a function of time, u(t). The inputs are not linked to a scene, so a handle of another scene sets the
    /// control with the same number.
    ///
    /// # Panics
    /// If the system has no such control.
    pub fn set_control(&mut self, control: Control, signal: impl Fn(f64) -> f64) {
        let (which, count) = (control.index(), self.controls.nrows());
        assert!(
            which < count,
            "control {which} does not exist: these inputs have {count}; does its handle belong to another scene?"
        );
        for (node, t) in self.grid.times().into_iter().enumerate() {
            self.controls[(which, node)] = signal(t);
        }
    }

    /// A zero direction in the space of the inputs. Set its nonzero entries, and use it for derivatives along a direction.
    pub fn no_change(&self) -> Inputs {
        let grid = Grid { start: 0.0, steps: vec![0.0; self.grid.steps.len()], ..self.grid };
        let (start, controls) = (self.start.map(|_| 0.0), self.controls.map(|_| 0.0));
        Inputs {
            grid,
            start,
            controls,
            design: self.design.map(|_| 0.0),
            events: self.events.clone(),
            controls_in_time: self.controls_in_time.clone(),
            open: self.open.clone(),
        }
    }

    /// Inputs of another number type; `make` combines each value with its change along a direction of the same shape.
    pub(crate) fn along<R: Real>(&self, direction: &Inputs, make: impl Fn(f64, f64) -> R) -> Inputs<R> {
        let mut moved = self.lift::<R>();
        let change = |to: &mut [R], from: &[f64], by: &[f64]| {
            to.iter_mut().zip(from.iter().zip(by)).for_each(|(to, (&x, &d))| *to = make(x, d));
        };
        change(&mut moved.grid.steps, &self.grid.steps, &direction.grid.steps);
        moved.grid.start = make(self.grid.start, direction.grid.start);
        change(moved.start.q_mut().as_mut_slice(), self.start.q().as_slice(), direction.start.q().as_slice());
        change(moved.start.rate_mut().as_mut_slice(), self.start.rate().as_slice(), direction.start.rate().as_slice());
        change(moved.controls.as_mut_slice(), self.controls.as_slice(), direction.controls.as_slice());
        change(moved.design.as_mut_slice(), self.design.as_slice(), direction.design.as_slice());
        moved
    }

    /// Checks the sizes of a direction and that its numbers are finite. `inserted` nodes were added to these inputs after the direction was given.
    pub(crate) fn check_direction(&self, direction: &Inputs, inserted: usize) -> Result<(), Error> {
        let nodes = self.grid.nodes() - inserted;
        check_size("direction: time steps", nodes - 1, direction.grid.steps.len())?;
        check_size("direction: q0", self.start.q().len(), direction.start.q().len())?;
        check_size("direction: v0 or p*0", self.start.rate().len(), direction.start.rate().len())?;
        check_size("direction: controls: rows (channels)", self.controls.nrows(), direction.controls.nrows())?;
        check_size("direction: controls: columns (nodes)", nodes, direction.controls.ncols())?;
        check_size("direction: design variables", self.design.len(), direction.design.len())?;
        self.start.check_kind(&direction.start)?;
        let starts = direction.start.q().iter().chain(direction.start.rate().iter());
        let changes = direction.grid.steps.iter().chain([&direction.grid.start]).chain(starts);
        finite(changes.chain(&direction.controls).chain(&direction.design).copied(), |_| "a number of the direction".into())
    }

    /// Copies the values of `other`, without allocation if the sizes are equal.
    pub(crate) fn copy_from(&mut self, other: &Inputs) {
        let same = self.controls.shape() == other.controls.shape()
            && self.start.q().len() == other.start.q().len()
            && std::mem::discriminant(&self.start) == std::mem::discriminant(&other.start)
            && self.design.len() == other.design.len();
        if !same {
            self.clone_from(other);
            return;
        }
        (self.grid.start, self.grid.stages, self.grid.around) = (other.grid.start, other.grid.stages, other.grid.around);
        self.grid.steps.clone_from(&other.grid.steps);
        if let (Start::Assembled { held, .. }, Start::Assembled { held: given, .. }) = (&mut self.start, &other.start) {
            held.clone_from(given);
        }
        self.start.q_mut().copy_from(other.start.q());
        self.start.rate_mut().copy_from(other.start.rate());
        self.controls.copy_from(&other.controls);
        self.design.copy_from(&other.design);
        self.events.clone_from(&other.events);
        self.controls_in_time.clone_from(&other.controls_in_time);
        self.open.clone_from(&other.open);
    }

    /// The inputs converted to another number type, with zero imaginary or derivative parts.
    pub fn lift<R: Real>(&self) -> Inputs<R> {
        let steps = self.grid.steps.iter().map(|&dt| dt.into()).collect();
        Inputs {
            grid: Grid { start: self.grid.start.into(), steps, stages: self.grid.stages, around: self.grid.around },
            start: self.start.map(R::from),
            controls: self.controls.map(R::from),
            design: self.design.map(R::from),
            events: self.events.clone(),
            controls_in_time: self.controls_in_time.clone(),
            open: self.open.clone(),
        }
    }

    /// Checks sizes, finite values, step lengths and macro steps, and the ranges of node numbers and parameters.
    pub(crate) fn check(&self, system: &System) -> Result<(), Error> {
        let (n, nodes) = (system.n(), self.grid.nodes());
        let rate = match self.start {
            Start::Velocity { .. } | Start::Assembled { .. } => "v0",
            Start::Momentum { .. } => "p*0",
        };
        check_size("q0", n, self.start.q().len())?;
        check_size(rate, n, self.start.rate().len())?;
        check_size("controls: rows (channels)", system.k(), self.controls.nrows())?;
        check_size("controls: columns (nodes, one more than steps)", nodes, self.controls.ncols())?;
        check_size("design variables", system.designs(), self.design.len())?;
        let [before, behind] = self.grid.around;
        let mut farthest = self.grid.start.abs();
        let moves = self.grid.steps.iter().any(|&length| length != 0.0);
        for (step, &length) in self.grid.steps.iter().enumerate() {
            let of_whole = before.saturating_add(step);
            let is_refused = length == 0.0 && (!moves || of_whole == 0 || system.has_control_rates());
            if is_refused || !length.is_finite() {
                return Err(Error::TimeStep { step: of_whole.saturating_add(1), length });
            }
            farthest += length.abs();
        }
        let Some(of_whole) = before.checked_add(nodes).and_then(|nodes| nodes.checked_add(behind)) else {
            let (what, must_be) =
                ("a number of nodes in `Grid::around`".into(), "small enough that all nodes can be counted");
            return Err(Error::Parameter { what, value: before.max(behind) as f64, must_be });
        };
        if let Some((node, cost)) = system.last_cost_node().filter(|(node, _)| *node >= of_whole) {
            let last = of_whole - 1;
            let what = format!("the node at which `{cost}` is evaluated (`Sum::Node`), on a grid with nodes 0 to {last},");
            return Err(Error::Parameter { what, value: node as f64, must_be: "at most the number of steps" });
        }
        check_open("Inputs::open", &self.open, system)?;
        check_events(self, system)?;
        check_timed(self, system)?;
        if self.grid.stages == 0 {
            return Err(Error::Parameter { what: "`Grid::stages`".into(), value: 0.0, must_be: "1 or more" });
        }
        if let Start::Assembled { held: Held { coordinates, velocities }, .. } = &self.start
            && let Some(other) = coordinates.iter().chain(velocities).find(|q| q.index() >= n || !system.owns(q.0))
        {
            return Err(Error::NoSuchInput { input: format!("held coordinate {}", other.index()) });
        }
        let of = |i: usize| format!("of `{}`", system.coordinate_name(i));
        finite([self.grid.start], |_| "the start of the time grid".into())?;
        finite([farthest], |_| "the sum of the start time and the step lengths of the grid".into())?;
        finite(self.start.q().iter().copied(), |i| format!("q0 {}", of(i)))?;
        finite(self.start.rate().iter().copied(), |i| format!("{rate} {}", of(i)))?;
        finite(self.design.iter().copied(), |p| format!("design variable `{}`", system.design_name(p)))?;
        let channels = system.k().max(1);
        finite(self.controls.iter().copied(), |i| {
            format!("control `{}` at node {}", system.control_name(i % channels), before + i / channels)
        })?;
        system.check_design(self.design.as_slice())
    }
}

/// Checks the length of a list.
pub(crate) fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), Error> {
    if expected == found { Ok(()) } else { Err(Error::Size { what, expected, found }) }
}

fn finite(values: impl IntoIterator<Item = f64>, what: impl Fn(usize) -> String) -> Result<(), Error> {
    match values.into_iter().enumerate().find(|(_, x)| !x.is_finite()) {
        Some((i, value)) => Err(Error::NotFinite { what: what(i), value }),
        None => Ok(()),
    }
}
