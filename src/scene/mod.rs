//! A scene: a mechanism as a list of coordinates, elements, controls and design variables.
//!
//! The methods that add parts never fail; [`Scene::compile`] checks everything and returns the [`System`] to be simulated.

pub mod axis;
mod basic;
mod checks;
mod costs;
mod events;
#[cfg(feature = "files")]
mod formulas;
mod kind;
#[cfg(feature = "files")]
pub(crate) mod kinds;
mod lists;
mod named;
pub mod planar;
mod readings;
pub(crate) mod ready;
pub mod scenes;
pub mod spatial;
mod switches;

use std::any::TypeId;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::SVector;

use crate::model::element::{Constraint, Force, KineticEnergy, ParameterFormula, PotentialEnergy};
use crate::model::{Control, Coordinate, Drawn, Frame, Multiplier, Param, Point, Shape};
use crate::number::guarded;
use crate::program::{Obstacle, Symbol, record};
use crate::system::{
    AnyElement, Applied, Connections, Fixed, Holonomic, Kinetic, Parts, PlacedElement, Potential, Required, Restricted,
};
use crate::{Error, System};
pub use costs::EndState;
#[cfg(feature = "files")]
pub(crate) use formulas::Summed;
use ready::{Added, Recipe};

/// A mechanism under construction.
///
/// Add planar bodies and joints with the methods of [`planar`], and anything else as user-defined elements on coordinates:
///
/// ```
/// use hamiltonian_adjoint::{KineticEnergy, PotentialEnergy, Scalar, Scene};
/// use nalgebra::SVector;
///
/// struct Pendulum; // b = [mass, length]
/// impl KineticEnergy<1, 2> for Pendulum {
///     fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 2>) -> S {
///         b[0] * b[1] * b[1] * v[0] * v[0] * 0.5
///     }
/// }
/// impl PotentialEnergy<1, 2> for Pendulum {
///     fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
///         -(b[0] * b[1] * q[0].cos() * 9.81)
///     }
/// }
///
/// let mut scene = Scene::new();
/// let [angle] = scene.coordinates("pendulum", ["angle"]);
/// let length = scene.design("length", 0.5);
/// scene.kinetic_energy("swing", Pendulum, [angle], [1.2.into(), length.into()]);
/// scene.potential_energy("weight", Pendulum, [angle], [1.2.into(), length.into()]);
/// let system = scene.compile()?;
/// assert_eq!((system.n(), system.m()), (1, 0));
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// A clone has the same parts, and handles of these parts are valid in both scenes. Handles of parts that are added later are valid only in
/// the scene that they were added to.
#[derive(Clone, Default)]
pub struct Scene {
    parts: Parts,
    elements: Vec<String>,
    costs_named: Vec<String>,
    recipe: Recipe,
    /// The first error found, returned by `compile`.
    problem: Option<Error>,
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (coordinates, elements) = (&self.parts.coordinates, &self.elements);
        f.debug_struct("Scene").field("coordinates", coordinates).field("elements", elements).finish_non_exhaustive()
    }
}

impl Scene {
    /// An empty scene.
    pub fn new() -> Self {
        Scene::default()
    }

    /// Adds a parameter computed from other parameters by a user-defined formula. In most cases the operators and functions of [`Param`]
    /// suffice instead.
    ///
    /// A formula that branches on a value or panics is an error when the scene is compiled.
    ///
    /// ```
    /// use hamiltonian_adjoint::{ParameterFormula, Scalar, Scene, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// /// The moment of inertia of n equal masses m on a ring: x = [m, radius].
    /// struct Ring(usize);
    /// impl ParameterFormula<2> for Ring {
    ///     fn value<S: Scalar>(&self, x: &SVector<S, 2>) -> S {
    ///         (0..self.0).map(|_| x[0] * x[1] * x[1]).sum()
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let radius = scene.design("radius", 0.3);
    /// let inertia = scene.parameter("inertia", Ring(5), [0.1.into(), radius.into()]);
    /// let wheel = scene.body("wheel", 0.5, inertia, [0.0; 3]);
    /// scene.revolute("axle", Body::GROUND.at(0.0, 0.0), wheel.at(0.0, 0.0));
    /// scene.compile()?;
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn parameter<F, const N: usize>(&mut self, name: &str, formula: F, of: [Param; N]) -> Param
    where
        F: ParameterFormula<N>,
    {
        if !self.check_params(name, &of) {
            return f64::NAN.into();
        }
        let numbers = of.map(|param| param.constant());
        if numbers.iter().all(Option::is_some) {
            let value = guarded(|| formula.value(&SVector::from_fn(|i, _| numbers[i].unwrap_or_default())));
            return value.map_or_else(|| self.refuse_parameter(name, false), Param::from);
        }
        let symbol = |i: usize| numbers[i].map_or_else(|| Symbol::input(i, 1.0), Symbol::from);
        match record(|result| result(formula.value(&SVector::from_fn(|i, _| symbol(i))))) {
            Ok((graph, results)) => Param::expression(&of, &|into, of| {
                let nodes = into.import(&graph, of);
                nodes[results[0].index()]
            }),
            Err(obstacle) => self.refuse_parameter(name, obstacle == Obstacle::Branches),
        }
    }

    fn refuse_parameter(&mut self, name: &str, branches: bool) -> Param {
        self.report(Error::ParameterFormula { parameter: name.to_string(), branches });
        f64::NAN.into()
    }

    /// Adds a kinetic energy T(q, v; b).
    pub fn kinetic_energy<E, const N: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        q: [Coordinate; N],
        b: [Param; P],
    ) where
        E: KineticEnergy<N, P>,
    {
        self.insert(name, Kinetic::<Fixed<_, N, 0, 0, P>, N>::fixed(element), (&q, 0..0), &[], &b);
    }

    /// Adds a potential energy V(q, t; b).
    pub fn potential_energy<E, const N: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        q: [Coordinate; N],
        b: [Param; P],
    ) where
        E: PotentialEnergy<N, P>,
    {
        self.insert(name, Potential::<Fixed<_, N, 0, 0, P>, N>::fixed(element), (&q, 0..0), &[], &b);
    }

    /// Adds a generalized force Q(q, v, u, t; b).
    pub fn force<E, const N: usize, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        q: [Coordinate; N],
        u: [Control; K],
        b: [Param; P],
    ) where
        E: Force<N, K, P>,
    {
        self.insert(name, Applied::<Fixed<_, N, 0, K, P>, N>::fixed(element), (&q, 0..0), &u, &b);
    }

    /// Adds a holonomic constraint Φ(q, t; b) = 0 and returns its multipliers, for costs on σ.
    pub fn constraint<E, const N: usize, const M: usize, const P: usize>(
        &mut self,
        name: &str,
        element: E,
        q: [Coordinate; N],
        b: [Param; P],
    ) -> [Multiplier; M]
    where
        E: Constraint<N, M, P>,
    {
        let equations = self.equations(name, M);
        self.insert(name, Holonomic::<Fixed<_, N, M, 0, P>, N>::fixed(element), (&q, equations.clone()), &[], &b);
        self.multipliers(equations.start)
    }

    /// Validates the scene and compiles it to a [`System`].
    ///
    /// # Errors
    /// Duplicate names, handles of another scene, coordinates without inertia, or parameters out of range.
    pub fn compile(self) -> Result<System, Error> {
        self.compiled(false)
    }

    /// Compiles the scene without programs: num-dual differentiates every element at every point. This is slower, but gives the same
    /// gradient up to rounding.
    ///
    /// # Errors
    /// As [`compile`](Self::compile).
    pub fn compile_without_programs(self) -> Result<System, Error> {
        self.compiled(true)
    }

    fn compiled(mut self, without_programs: bool) -> Result<System, Error> {
        if let Some(problem) = self.problem.take() {
            return Err(problem);
        }
        self.add_trees()?;
        self.check_names()?;
        System::compile(self.parts, without_programs)
    }

    fn insert<T: AnyElement + 'static>(
        &mut self,
        name: &str,
        formula: T,
        (q, sigma): (&[Coordinate], Range<usize>),
        u: &[Control],
        b: &[Param],
    ) {
        self.add(name, (TypeId::of::<T>(), &[]), Arc::new(formula), (q, sigma), u, b);
    }

    /// Adds an element of which only the coordinates `there` (by their numbers in the element) exist.
    pub(crate) fn insert_on<T: AnyElement + 'static>(
        &mut self,
        name: &str,
        formula: T,
        there: &'static [usize],
        on: (&[Coordinate], Range<usize>),
        u: &[Control],
        b: &[Param],
    ) {
        let (is_whole, formula): (bool, Arc<dyn AnyElement>) = (there.len() == formula.shape().n, Arc::new(formula));
        let formula = if is_whole { formula } else { Arc::new(Restricted { inner: formula, there }) };
        self.add(name, (TypeId::of::<T>(), if is_whole { &[] } else { there }), formula, on, u, b);
    }

    fn add(
        &mut self,
        name: &str,
        batch: (TypeId, &'static [usize]),
        formula: Arc<dyn AnyElement>,
        (q, sigma): (&[Coordinate], Range<usize>),
        u: &[Control],
        b: &[Param],
    ) {
        self.elements.push(name.to_string());
        let known = self.check(name, "coordinate", q.iter().map(|q| q.0))
            & self.check(name, "control", u.iter().map(|u| u.0))
            & self.check_params(name, b);
        // An energy or force without coordinates has no effect, and dual numbers cannot represent it.
        if !known || !self.check_distinct(name, q) || q.len() + sigma.len() == 0 {
            return;
        }
        let to = Connections {
            q: q.iter().map(|q| q.index()).collect(),
            sigma: sigma.collect(),
            u: u.iter().map(|u| u.index()).collect(),
            b: b.to_vec(),
        };
        let place = self.parts.batches.push(batch, PlacedElement::new(name, formula, to));
        self.note(name, Added::Element(place));
    }

    /// Adds the equations of a constraint.
    fn equations(&mut self, name: &str, count: usize) -> Range<usize> {
        let first = self.parts.equations;
        self.parts.scene.begin_part();
        self.parts.equations += count;
        self.parts.constraints.push((name.to_string(), count));
        first..self.parts.equations
    }

    fn multipliers<const M: usize>(&self, first: usize) -> [Multiplier; M] {
        std::array::from_fn(|j| Multiplier(self.parts.scene.handle(first + j)))
    }

    /// Requires a parameter to be positive; checked when the scene is compiled and before every run.
    pub(crate) fn require_positive(&mut self, param: Param, what: String) {
        self.note_required(Required { param, what, may_be_zero: false });
    }

    /// Requires a parameter to be positive or zero.
    pub(crate) fn require_nonnegative(&mut self, param: Param, what: String) {
        self.note_required(Required { param, what, may_be_zero: true });
    }

    fn note_required(&mut self, required: Required) {
        // Checked here with its name, before the element reports it with its number only.
        let value = required.param.factor();
        if !value.is_finite() {
            self.report(Error::NotFinite { what: required.what.clone(), value });
        }
        self.parts.positive.push(required);
    }

    /// Records how a part is drawn.
    pub(crate) fn draw(&mut self, name: &str, shape: Shape, a: Point, b: Point) {
        self.parts.sketch.drawn.push(Drawn { name: name.to_string(), shape, a, b });
    }

    pub(crate) fn draw_body(&mut self, name: &str, frame: Frame) {
        self.parts.sketch.bodies.push((name.to_string(), frame));
    }

    /// Placeholder for the multipliers of a joint that could not be added.
    pub(crate) fn no_multipliers<const M: usize>(&self) -> [Multiplier; M] {
        std::array::from_fn(|_| Multiplier(self.parts.scene.handle(0)))
    }
}
