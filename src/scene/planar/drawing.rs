//! Drawing of user-defined elements.

use super::Point;
use crate::Scene;
use crate::model::Shape;
use crate::scene::ready::Kind;

pub(super) static DRAWN_SPRING: Kind = Kind::of_points("drawn spring", &[], |scene, name, part| {
    scene.draw(name, Shape::Spring, part.points[0], part.points[1]);
});

pub(super) static DRAWN_ROD: Kind = Kind::of_points("drawn rod", &[], |scene, name, part| {
    scene.draw(name, Shape::Rod, part.points[0], part.points[1]);
});

impl Scene {
    /// Draws a spring between two points in pictures and animations, for a user-defined element. It has no effect on the mechanics.
    ///
    /// ```
    /// use hamiltonian_adjoint::{PotentialEnergy, Scalar, Scene, planar::Body};
    /// use nalgebra::SVector;
    ///
    /// /// V = ½ c x² + ¼ d x⁴, b = [c, d] in N/m and N/m³.
    /// struct Stiffening;
    /// impl PotentialEnergy<1, 2> for Stiffening {
    ///     fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 2>, _t: S) -> S {
    ///         let square = q[0] * q[0];
    ///         square * (b[0] + b[1] * square * 0.5) * 0.5
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let cart = scene.body("cart", 1.0, 0.1, [0.3, 0.0, 0.0]);
    /// scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    /// scene.potential_energy("bumper", Stiffening, [cart.coordinates[0]], [100.0.into(), 4e4.into()]);
    /// scene.draw_spring("bumper", Body::GROUND.at(-1.0, 0.0), cart.at(0.0, 0.0));
    /// scene.compile()?;
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    pub fn draw_spring(&mut self, name: &str, a: Point, b: Point) {
        self.draw_own(name, &DRAWN_SPRING, [a, b]);
    }

    /// Draws a rod between two points in pictures and animations, for a user-defined constraint. It has no effect on the mechanics.
    pub fn draw_rod(&mut self, name: &str, a: Point, b: Point) {
        self.draw_own(name, &DRAWN_ROD, [a, b]);
    }

    fn draw_own(&mut self, name: &str, kind: &'static Kind, [a, b]: [Point; 2]) {
        let coordinates = [a, b].into_iter().flat_map(|point| point.frame.own_coordinates().into_iter().map(|q| q.0));
        let is_known = self.check(name, "coordinate", coordinates) & self.check_params(name, &[a.at, b.at].concat());
        if is_known {
            self.ready_between(name, kind, [a, b], []);
        }
    }
}
