//! Events of a scene.

use super::Scene;
use super::ready::Added;
use crate::model::element::{Cost, ListCost, Sum};
use crate::model::{Control, Coordinate, Event, Multiplier, Param};
use crate::system::{Connections, EVENTS, Fixed, PlacedCost};

impl Scene {
    /// Adds an event: a function g of the coordinates `q`, their velocities, multipliers `sigma`, controls `u`, parameters `b` and the time, whose
    /// zero is the event. The inputs of a motion say which node an event determines ([`Inputs::events`](crate::Inputs::events)): the steps
    /// before the node become longer or shorter until g = 0 holds there. Gradients include the dependence of the time of the event on all
    /// inputs.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// /// The coordinate.
    /// struct Height;
    /// impl Cost<1, 0, 0, 0> for Height {
    ///     fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
    ///         at.q[0]
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let ball = scene.particle("ball", 1.0, [0.0, 2.0]);
    /// scene.gravity(0.0, -9.81);
    /// let landing = scene.event("landing", Height, [ball.coordinates[1]], [], [], []);
    /// let time = scene.event_time("time of landing", 0);
    /// let system = scene.compile()?;
    ///
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.03)); // about 0.6 s
    /// inputs.events = vec![landing.at(20)];
    /// let mut solver = Solver::new(&system, Settings::default());
    /// solver.simulate(&inputs)?;
    /// let exact = (2.0 * 2.0 / 9.81f64).sqrt();
    /// assert!((solver.outputs()?[time.index()] - exact).abs() < 1e-12);
    /// let by_height = solver.jacobian()?[time.index()].start.q()[1];
    /// assert!((by_height - 1.0 / (9.81 * exact)).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn event<C, const N: usize, const M: usize, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        function: C,
        q: [Coordinate; N],
        sigma: [Multiplier; M],
        u: [Control; K],
        b: [Param; P],
    ) -> Event
    where
        C: Cost<N, M, K, P>,
    {
        self.add_event(name, Fixed(function), (&q, &sigma, &u, &b))
    }

    /// Adds an event as a function of lists whose lengths are known at run time ([`ListCost`]).
    pub fn list_event<C: ListCost>(
        &mut self,
        name: &str,
        function: C,
        q: &[Coordinate],
        sigma: &[Multiplier],
        u: &[Control],
        b: &[Param],
    ) -> Event {
        self.add_event(name, function, (q, sigma, u, b))
    }

    fn add_event(
        &mut self,
        name: &str,
        function: impl ListCost,
        (q, sigma, u, b): (&[Coordinate], &[Multiplier], &[Control], &[Param]),
    ) -> Event {
        let event = self.parts.events.len();
        self.parts.scene.begin_part();
        self.parts.events.push(name.to_string());
        if let Some(to) = self.connect(name, (q, sigma, u, b)) {
            let place = self.parts.costs.push(PlacedCost::new((name, EVENTS + event), (function, Sum::AllNodes), to));
            self.note(name, Added::Function(place));
        }
        Event(self.parts.scene.handle(event))
    }

    /// The connections of a cost or an event; `None` if it refers to parts of another scene.
    pub(super) fn connect(
        &mut self,
        name: &str,
        (q, sigma, u, b): (&[Coordinate], &[Multiplier], &[Control], &[Param]),
    ) -> Option<Connections> {
        let known = self.check(name, "coordinate", q.iter().map(|q| q.0))
            & self.check(name, "multiplier", sigma.iter().map(|s| s.0))
            & self.check(name, "control", u.iter().map(|u| u.0))
            & self.check_params(name, b);
        known.then(|| Connections {
            q: q.iter().map(|q| q.index()).collect(),
            sigma: sigma.iter().map(|s| s.index()).collect(),
            u: u.iter().map(|u| u.index()).collect(),
            b: b.to_vec(),
        })
    }
}
