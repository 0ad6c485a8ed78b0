//! What happens at the events of a scene: constraints open, close, or are hit.

use nalgebra::SVector;

use super::Scene;
use super::ready::{Entry, Kind, Part, Sort};
use crate::model::{Action, Event, Gap, Multiplier, Param, Switch};
use crate::{Cost, CostPoint, Scalar};

/// λ.
struct Reaction;

impl Cost<0, 1, 0, 0> for Reaction {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 1, 0>, _b: &SVector<S, 0>) -> S {
        at.lambda[0]
    }
}

/// The entries of a part that an event acts on.
const AT_EVENT: &[(&str, Sort)] = &[("name", Sort::Event), ("equations", Sort::Equations)];

pub(super) static OPEN: Kind =
    Kind::new("open at event", &[], |scene, name, part| scene.switch(name, part, Action::Open)).with(AT_EVENT);

pub(super) static CLOSE: Kind =
    Kind::new("close at event", &[], |scene, name, part| scene.switch(name, part, Action::Close)).with(AT_EVENT);

pub(super) static HOLD: Kind =
    Kind::new("hold at event", &[], |scene, name, part| scene.switch(name, part, Action::Hold)).with(AT_EVENT);

pub(super) static IMPACT: Kind = Kind::new("impact at event", &["restitution"], |scene, name, part| {
    let restitution = part.number(0);
    if scene.check_params(name, &[restitution]) {
        scene.require_nonnegative(restitution, format!("the restitution at event `{name}`"));
        scene.switch(name, part, Action::Impact(restitution));
    }
})
.with(&[("name", Sort::Event), ("equation", Sort::Equation)]);

pub(super) static REACTION: Kind = Kind::new("reaction event", &[], |scene, name, part| {
    let event = scene.event(name, Reaction, [], [part.equations()[0]], [], []);
    scene.parts.sides.push((event.index(), -1.0));
})
.with(&[("equation", Sort::Equation)]);

/// All kinds of parts that belong to events.
#[cfg(feature = "files")]
pub(super) static KINDS: [&Kind; 5] = [&OPEN, &CLOSE, &HOLD, &IMPACT, &REACTION];

impl Scene {
    /// Opens constraint equations at an event: from then on, dΦ/dt = 0 does not hold, and σ̇ = 0, so that no force acts.
    ///
    /// A step of length zero must follow the node of the event ([`Inputs::events`](crate::Inputs::events)). Its end belongs to the motion with the
    /// equations open.
    pub fn open_at(&mut self, event: Event, equations: &[Multiplier]) {
        self.ready_at(event, equations, &OPEN, &[]);
    }

    /// Closes constraint equations at an event: from then on, dΦ/dt = 0 holds. The velocities jump as in a plastic impact; the impulses are the changes
    /// of σ, Eq. (1a) with the same q and p*.
    ///
    /// A step of length zero must follow the node of the event ([`Inputs::events`](crate::Inputs::events)). Equations that some event closes are open at
    /// the start, unless [`Inputs::open`](crate::Inputs::open) says otherwise.
    pub fn close_at(&mut self, event: Event, equations: &[Multiplier]) {
        self.ready_at(event, equations, &CLOSE, &[]);
    }

    /// Closes constraint equations at an event, at their present values: from then on, dΦ/dt = 0 holds, but Φ need not be zero. Use it where a foot or a wheel
    /// begins to stick wherever it is. Otherwise as [`close_at`](Self::close_at). Such equations are not projected
    /// ([`Settings::drift_bound`](crate::Settings::drift_bound)).
    pub fn hold_at(&mut self, event: Event, equations: &[Multiplier]) {
        self.ready_at(event, equations, &HOLD, &[]);
    }

    /// Makes an event an impact on a constraint equation, with a coefficient of restitution e: dΦ/dt jumps to −e dΦ/dt, by an impulse along Φ_qᵀ, to which
    /// all joints react. Without friction, Poisson's and Newton's hypotheses agree.
    ///
    /// An event is an impact on one equation.
    ///
    /// Two steps of length zero must follow the node of the event ([`Inputs::events`](crate::Inputs::events)): at the end of the first, dΦ/dt = 0; at the
    /// end of the second, the velocities are those after the impact. The equation is open before and after, and its σ has changed by the impulse, N s.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, Solver, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let ball = scene.particle("ball", 2.0, [0.0, 1.0]);
    /// scene.gravity(0.0, -9.81);
    /// let floor = scene.rigid_contact("floor", Body::GROUND.at(0.0, 0.0), std::f64::consts::FRAC_PI_2, ball.point());
    /// let restitution = scene.design("restitution", 0.8);
    /// scene.impact_at(floor.event, floor.equation, restitution);
    /// let system = scene.compile()?;
    ///
    /// let mut inputs = Inputs::at_rest(&system, Grid::new(0.0, [vec![0.03; 15], vec![0.0; 2], vec![0.03; 10]].concat()));
    /// inputs.events = vec![floor.event.at(15)];
    /// let mut solver = Solver::new(&system, Settings::default());
    /// let motion = solver.simulate(&inputs)?;
    /// let fall = (2.0 * 9.81f64).sqrt();
    /// let [before, after] = [15, 17].map(|node| motion.v[(1, node)]);
    /// assert!((before + fall).abs() < 1e-12 && (after - 0.8 * fall).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn impact_at(&mut self, event: Event, equation: Multiplier, restitution: impl Into<Param>) {
        self.ready_at(event, &[equation], &IMPACT, &[restitution.into()]);
    }

    /// Adds the event at which the reaction λ of a constraint equation becomes zero from below: a contact that pushes (its force is −Φ_qᵀλ, so λ < 0) would
    /// begin to pull.
    pub fn reaction_event(&mut self, name: &str, equation: Multiplier) -> Event {
        let number = self.parts.events.len();
        self.ready(name, Part { more: vec![Entry::Equations(vec![equation])], ..Part::of(&REACTION) });
        Event(self.parts.scene.handle(number))
    }

    fn ready_at(&mut self, event: Event, equations: &[Multiplier], kind: &'static Kind, numbers: &[Param]) {
        let name = self.parts.events.get(event.index()).cloned().unwrap_or_default();
        let more = vec![Entry::Event(event), Entry::Equations(equations.to_vec())];
        self.ready(&name, Part { numbers: numbers.to_vec(), more, ..Part::of(kind) });
    }

    fn switch(&mut self, name: &str, part: &Part, action: Action) {
        let (event, equations) = (part.event(), part.equations());
        if !(self.check(name, "event", [event.0]) && self.check(name, "multiplier", equations.iter().map(|sigma| sigma.0))) {
            return;
        }
        self.parts.scene.begin_part();
        for equation in equations.iter().map(Multiplier::index) {
            let here: Vec<Switch> =
                self.parts.switches.iter().filter(|known| known.event == event.index()).copied().collect();
            let is_impact = |action: Action| matches!(action, Action::Impact(_));
            let is_twice = here.iter().any(|known| known.equation == equation);
            self.require(!is_twice, &format!("the number of changes of one equation at event `{name}`"), 2.0, "1");
            // The impulse of a second impact would depend on that of the first.
            let impacts = here.iter().any(|known| is_impact(known.action)) && is_impact(action);
            self.require(!impacts, &format!("the number of equations with an impact at event `{name}`"), 2.0, "1");
            self.parts.switches.push(Switch { event: event.index(), equation, action });
        }
    }

    /// Notes that the event and the constraint with this name are the gap of a rigid contact.
    pub(crate) fn note_gap(&mut self, name: &str) {
        if let (Some(event), Some(equation)) = (self.event_named(name), self.parts.equations.checked_sub(1)) {
            self.parts.gaps.push(Gap { event: event.index(), equation });
            self.parts.sides.push((event.index(), 1.0));
        }
    }
}
