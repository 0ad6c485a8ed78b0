//! Costs, outputs and events that are functions of markers.

use super::elements::Arguments;
use super::formula::{cross, plus, scaled};
use super::path::{MarkerState, Path};
use super::{Marker, Quantity, Spatial};
use crate::model::{Control, Event, Output, Param};
use crate::scene::readings;
use crate::scene::ready::{Entry, Kind, Part, Sort};
use crate::{Error, ListCost, ListPoint, Scalar, Sum};

/// A function of the positions and motions of markers, for costs, outputs and events.
///
/// ```
/// use hamiltonian_adjoint::spatial::{Body, Inertia, MarkerFunction, MarkerPoint};
/// use hamiltonian_adjoint::{Scalar, Scene, Sum};
///
/// /// The height of the first marker over the second one.
/// struct Height;
/// impl MarkerFunction for Height {
///     fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
///         at.markers[0].position[2] - at.markers[1].position[2]
///     }
/// }
///
/// let mut scene = Scene::new();
/// let mut space = scene.spatial();
/// let rod = space.body("rod", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]));
/// space.ball("joint", Body::GROUND.origin(), rod.at([0.0, 0.0, 0.5]));
/// space.cost("height", Height, Sum::Terminal, &[rod.at([0.0, 0.0, -0.5]), Body::GROUND.origin()], &[], &[]);
/// scene.compile()?;
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub trait MarkerFunction: Send + Sync + 'static {
    /// The value at one node.
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S;
}

/// The arguments of a [`MarkerFunction`] or a [`MarkerForce`](super::MarkerForce) at one point.
#[derive(Clone, Copy, Debug)]
pub struct MarkerPoint<'a, S> {
    /// The markers, in the given order.
    pub markers: &'a [MarkerState<S>],
    /// Controls.
    pub u: &'a [S],
    /// Time, s.
    pub t: S,
    /// Constants.
    pub b: &'a [S],
}

/// Paths to markers, and the number of the user's constants, which follow those of the paths.
#[derive(Clone, Debug, Default)]
pub(super) struct Markers {
    pub(super) paths: Vec<Path>,
    pub(super) own: usize,
}

/// A function of markers as a function of coordinates.
struct AtMarkers<F> {
    function: F,
    markers: Markers,
}

impl<F: MarkerFunction> ListCost for AtMarkers<F> {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let states: Vec<_> = self.markers.paths.iter().map(|path| path.state([at.q, at.v, at.v_dot, at.b])).collect();
        let own = &at.b[at.b.len() - self.markers.own..];
        self.function.value(&MarkerPoint { markers: &states, u: at.u, t: at.t, b: own })
    }
}

/// One component of a quantity.
struct Component(Quantity, usize);

impl MarkerFunction for Component {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        let of = &at.markers[0];
        let vector = match self.0 {
            Quantity::Position => of.position,
            Quantity::Velocity => of.velocity,
            Quantity::Acceleration => of.acceleration,
            Quantity::XAxis => of.axes[0],
            Quantity::YAxis => of.axes[1],
            Quantity::ZAxis => of.axes[2],
            Quantity::AngularVelocity => of.angular_velocity,
            Quantity::AngularAcceleration => of.angular_acceleration,
        };
        vector[self.1]
    }
}

/// ½ Σ a_i × b_i over the axes of two markers: for small rotations, the rotation vector from the first to the second.
struct RotationError(usize);

impl MarkerFunction for RotationError {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        let [a, b] = [0, 1].map(|k| at.markers[k].axes);
        let both = plus(cross(a[0], b[0]), plus(cross(a[1], b[1]), cross(a[2], b[2])));
        scaled(both, S::from(0.5))[self.0]
    }
}

pub(super) static OUTPUTS: Kind = Kind::of_markers("outputs of a marker", &[], |scene, name, part| {
    let quantity = part.quantity();
    scene.spatial().three(name, part, |axis| Component(quantity, axis));
})
.at(&["marker"])
.with(&[("quantity", Sort::Quantity), ("sum", Sort::Sum)]);

pub(super) static ROTATION_ERROR: Kind = Kind::of_markers("rotation error", &[], |scene, name, part| {
    scene.spatial().three(name, part, RotationError);
})
.with(&[("sum", Sort::Sum)]);

impl Spatial<'_> {
    /// Adds a cost that depends on markers and controls; `sum` is the rule by which its values at the nodes are summed.
    pub fn cost(
        &mut self,
        name: &str,
        function: impl MarkerFunction,
        sum: Sum,
        markers: &[Marker],
        u: &[Control],
        b: &[Param],
    ) {
        let Some((markers, Arguments { q, b })) = self.markers(name, markers, b) else { return };
        self.scene.list_cost(name, AtMarkers { function, markers }, sum, &q, &[], u, &b.0);
    }

    /// Adds a term that depends on markers and controls to an output.
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn term(
        &mut self,
        output: Output,
        name: &str,
        function: impl MarkerFunction,
        sum: Sum,
        markers: &[Marker],
        u: &[Control],
        b: &[Param],
    ) {
        let Some((markers, Arguments { q, b })) = self.markers(name, markers, b) else { return };
        self.scene.list_term(output, name, AtMarkers { function, markers }, sum, &q, &[], u, &b.0);
    }

    /// Adds readings of a function of markers and controls as outputs (value of the function − reading)/deviation, as
    /// [`Scene::readings_of`](crate::Scene::readings_of) does for functions of coordinates.
    ///
    /// ```
    /// use hamiltonian_adjoint::spatial::{Body, Inertia, MarkerFunction, MarkerPoint};
    /// use hamiltonian_adjoint::{Scalar, Scene};
    ///
    /// /// The height of a marker, m.
    /// #[derive(Clone)]
    /// struct Height;
    /// impl MarkerFunction for Height {
    ///     fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
    ///         at.markers[0].position[2]
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let mut space = scene.spatial();
    /// let rod = space.body("rod", Inertia::cuboid(1.0, [0.1, 0.1, 1.0]));
    /// space.ball("joint", Body::GROUND.origin(), rod.at([0.0, 0.0, 0.5]));
    /// space.readings_of("camera", Height, &[(10, -0.97), (20, -0.91)], 2e-3, &[rod.at([0.0, 0.0, -0.5])], &[], &[]);
    /// assert_eq!(scene.compile()?.outputs(), 2);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn readings_of(
        &mut self,
        name: &str,
        function: impl MarkerFunction + Clone,
        readings: &[(usize, f64)],
        deviation: f64,
        markers: &[Marker],
        u: &[Control],
        b: &[Param],
    ) -> Vec<Output> {
        let Some((markers, Arguments { q, b })) = self.markers(name, markers, b) else { return Vec::new() };
        let function = || AtMarkers { function: function.clone(), markers: markers.clone() };
        let of = readings::Arguments { q: &q, sigma: &[], u, b: &b.0 };
        self.scene.add_readings(name, function, (readings, deviation), &of)
    }

    /// Adds an event: a function of markers and controls whose zero is the event ([`Scene::event`](crate::Scene::event)).
    pub fn event(
        &mut self,
        name: &str,
        function: impl MarkerFunction,
        markers: &[Marker],
        u: &[Control],
        b: &[Param],
    ) -> Event {
        let (markers, of) = self.markers(name, markers, b).unwrap_or_default();
        self.scene.list_event(name, AtMarkers { function, markers }, &of.q, &[], u, &of.b.0)
    }

    /// Adds the three components of a quantity of a marker as outputs, summed over the nodes by the rule `sum`.
    pub fn outputs(&mut self, name: &str, quantity: Quantity, marker: Marker, sum: Sum) -> [Output; 3] {
        let more = vec![Entry::Quantity(quantity), Entry::Sum(sum)];
        self.scene.ready_outputs(name, Part { more, ..Part::at_markers(&OUTPUTS, &[marker], &[]) })
    }

    /// Adds the rotation from marker a to marker b as three outputs with components in the inertial frame: ½ Σ a_i × b_i over the axes a_i and b_i, which
    /// is sin θ times the axis of a rotation by the angle θ.
    pub fn rotation_error(&mut self, name: &str, a: Marker, b: Marker, sum: Sum) -> [Output; 3] {
        let more = vec![Entry::Sum(sum)];
        self.scene.ready_outputs(name, Part { more, ..Part::at_markers(&ROTATION_ERROR, &[a, b], &[]) })
    }

    /// Adds an output for each component of a vector.
    fn three<F: MarkerFunction>(&mut self, name: &str, part: &Part, component: impl Fn(usize) -> F) {
        for (axis, of) in [(0, "x"), (1, "y"), (2, "z")] {
            let name = format!("{name} {of}");
            let output = self.scene.output(&name);
            self.term(output, &name, component(axis), part.sum(), &part.markers, &[], &[]);
        }
    }

    /// The paths to markers, with the coordinates and parameters; `None` after an error was reported.
    pub(super) fn markers(&mut self, part: &str, markers: &[Marker], b: &[Param]) -> Option<(Markers, Arguments)> {
        let mut of = Arguments::default();
        let paths = markers.iter().map(|marker| self.path(part, *marker, &mut of)).collect::<Option<_>>()?;
        of.b.0.extend(b);
        Some((Markers { paths, own: b.len() }, of))
    }

    fn path(&mut self, part: &str, marker: Marker, of: &mut Arguments) -> Option<Path> {
        let at = self.fixed_at(part, marker)?;
        Some(self.scene.parts.sketch.space.path(None, &at, of))
    }

    /// As [`markers`](Self::markers), relative to the last frame that carries both: for forces that act between them.
    pub(super) fn pair(&mut self, part: &str, both: [Marker; 2], b: &[Param]) -> Option<(Markers, Arguments)> {
        let (paths, mut of) = self.paths_between(part, both)?;
        of.b.0.extend(b);
        Some((Markers { paths: paths.into(), own: b.len() }, of))
    }

    /// The paths to two markers from the last frame that carries both; `None` after an error was reported.
    pub(super) fn paths_between(&mut self, part: &str, both: [Marker; 2]) -> Option<([Path; 2], Arguments)> {
        let [first, second] = [self.fixed_at(part, both[0])?, self.fixed_at(part, both[1])?];
        let (space, mut of) = (&self.scene.parts.sketch.space, Arguments::default());
        let base = space.common(first.frame, second.frame);
        let paths = [first, second].map(|at| space.path(base, &at, &mut of));
        if of.q.is_empty() {
            self.scene.report(Error::NoBody { element: part.into() });
            return None;
        }
        Some((paths, of))
    }
}
