//! Readings: measured values of any quantity of a motion, as outputs whose squares a fit minimises.

use super::Scene;
use super::axis::Axis;
use crate::model::element::{Cost, ListCost, ListPoint, Sum};
use crate::model::{Control, Coordinate, Multiplier, Output, Owner, Param, Point};
use crate::scene::planar::rotated;
use crate::system::Fixed;
use crate::{Error, Scalar};

/// (h − h̃)/σ for a quantity h, a reading h̃ and its standard deviation σ; b = [b of h, h̃, 1/σ].
struct Deviation<H>(H);

impl<H: ListCost> ListCost for Deviation<H> {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let (b, own) = at.b.split_at(at.b.len() - 2);
        (self.0.cost(&ListPoint { b, ..*at }) - own[0]) * own[1]
    }
}

/// s = Σ a_k q_k; b = a.
#[derive(Clone, Copy)]
struct Along;

impl ListCost for Along {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.q.iter().zip(at.b).map(|(q, a)| *a * *q).sum::<S>()
    }
}

/// e · (r + R(φ) s); q = (x, y, φ), or (x, y) of a particle; b = [s, e].
#[derive(Clone, Copy)]
struct PointAlong;

impl ListCost for PointAlong {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let s = [at.b[0], at.b[1]];
        let arm = at.q.get(2).map_or(s, |phi| rotated(*phi, s).into());
        (at.q[0] + arm[0]) * at.b[2] + (at.q[1] + arm[1]) * at.b[3]
    }
}

/// The quantities that a function depends on.
pub(super) struct Arguments<'a> {
    pub(super) q: &'a [Coordinate],
    pub(super) sigma: &'a [Multiplier],
    pub(super) u: &'a [Control],
    pub(super) b: &'a [Param],
}

impl Scene {
    /// Adds readings of a function h of the state as outputs (h − value)/deviation, whose squares a fit minimises. `readings` are pairs of a node and a
    /// value, as [`Table::readings`](crate::Table::readings) returns them; `deviation` is their standard deviation, in the unit of h. The outputs
    /// are called "`name`.0", "`name`.1", …
    ///
    /// ```
    /// use hamiltonian_adjoint::{Cost, CostPoint, Scalar, Scene, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// /// The distance from the origin.
    /// #[derive(Clone)]
    /// struct Distance;
    /// impl Cost<2> for Distance {
    ///     fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
    ///         (at.q[0] * at.q[0] + at.q[1] * at.q[1]).sqrt()
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let puck = scene.body("puck", 0.2, 1e-4, [1.0, 0.0, 0.0]);
    /// let [x, y, _] = puck.coordinates;
    /// scene.readings_of("radar", Distance, &[(10, 1.02), (20, 1.08)], 5e-3, [x, y], [], [], []);
    /// assert_eq!(scene.compile()?.output_name(1), "radar.1");
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// [`compile`](Self::compile) rejects values that are not finite and deviations that are not positive.
    #[expect(clippy::too_many_arguments, reason = "the arguments of the function, one list each")]
    pub fn readings_of<C, const N: usize, const M: usize, const K: usize, const P: usize>(
        &mut self,
        name: &str,
        function: C,
        readings: &[(usize, f64)],
        deviation: f64,
        q: [Coordinate; N],
        sigma: [Multiplier; M],
        u: [Control; K],
        b: [Param; P],
    ) -> Vec<Output>
    where
        C: Cost<N, M, K, P> + Clone,
    {
        let of = Arguments { q: &q, sigma: &sigma, u: &u, b: &b };
        self.add_readings(name, || Fixed(function.clone()), (readings, deviation), &of)
    }

    /// Adds readings of a linear combination of coordinates Σ a_k q_k, m or rad, such as the angle between two bodies, as [`readings_of`](Self::readings_of)
    /// does for any function.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Scene, axis::Axis, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let upper = scene.body("upper", 1.0, 0.1, [0.0, -0.5, 0.0]);
    /// let lower = scene.body("lower", 1.0, 0.1, [0.0, -1.5, 0.0]);
    /// scene.revolute("shoulder", Body::GROUND.at(0.0, 0.0), upper.at(0.0, 0.5));
    /// scene.revolute("elbow", upper.at(0.0, -0.5), lower.at(0.0, 0.5));
    /// let bend = Axis::difference(upper.coordinates[2], 1.0, lower.coordinates[2]);
    /// scene.axis_readings("encoder at the elbow", bend, &[(5, 0.11), (10, 0.19)], 1e-3); // rad
    /// assert_eq!(scene.compile()?.outputs(), 2);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn axis_readings(
        &mut self,
        name: &str,
        axis: impl Into<Axis>,
        readings: &[(usize, f64)],
        deviation: f64,
    ) -> Vec<Output> {
        let Axis { q, factors } = axis.into();
        let of = Arguments { q: &q, sigma: &[], u: &[], b: &factors };
        self.add_readings(name, || Along, (readings, deviation), &of)
    }

    /// Adds readings of the position of a point of a planar body or a particle, m, as [`readings_of`](Self::readings_of) does for any function: the
    /// component e · r of its position r in the inertial frame along a direction e, such as `[1.0, 0.0]` for x.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let rod = scene.body("rod", 1.0, 0.1, [0.0, -0.5, 0.0]);
    /// scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.5));
    /// for (name, e, read) in [("x", [1.0, 0.0], 0.31), ("y", [0.0, 1.0], -0.95)] {
    ///     scene.point_readings(&format!("camera, {name}"), rod.at(0.0, -0.5), e, &[(10, read)], 1e-3);
    /// }
    /// assert_eq!(scene.compile()?.outputs(), 2);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn point_readings(
        &mut self,
        name: &str,
        point: Point,
        direction: [f64; 2],
        readings: &[(usize, f64)],
        deviation: f64,
    ) -> Vec<Output> {
        let q = point.frame.own_coordinates();
        if matches!(point.frame.owner(), Owner::Ground) {
            self.report(Error::NoBody { element: name.into() });
        }
        let b: Vec<Param> = point.at.into_iter().chain(direction.map(Into::into)).collect();
        let of = Arguments { q: &q, sigma: &[], u: &[], b: &b };
        if q.is_empty() { Vec::new() } else { self.add_readings(name, || PointAlong, (readings, deviation), &of) }
    }

    /// Adds an output for each reading of a function.
    pub(super) fn add_readings<H: ListCost>(
        &mut self,
        name: &str,
        function: impl Fn() -> H,
        (readings, deviation): (&[(usize, f64)], f64),
        of: &Arguments,
    ) -> Vec<Output> {
        let mut add = |(k, &(node, value)): (usize, &(usize, f64))| {
            let name = format!("{name}.{k}");
            let output = self.output(&name);
            self.reading_deviation(&name, deviation);
            let b: Vec<Param> = of.b.iter().copied().chain([value.into(), (1.0 / deviation).into()]).collect();
            self.list_term(output, &name, Deviation(function()), Sum::Node(node), of.q, of.sigma, of.u, &b);
            output
        };
        readings.iter().enumerate().map(&mut add).collect()
    }
}
