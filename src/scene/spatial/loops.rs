//! Constraints between markers, which close loops.

use super::elements::Arguments;
use super::formula::{Number, dot, minus};
use super::path::Path;
use super::{Marker, Spatial};
use crate::model::{Multiplier, Param};
use crate::{ListConstraint, Scalar};

/// A constraint between two markers a and b. Both paths begin at the last frame that carries both, so that Φ does not depend on other coordinates.
struct Between {
    paths: [Path; 2],
    rows: Rows,
}

#[derive(Clone, Copy)]
enum Rows {
    /// p_b − p_a = 0 along the axes of a.
    Point,
    /// x_a·z_b = y_a·z_b = 0.
    Axis,
    /// x_a·y_b = 0, which together with `Axis` fixes the orientation.
    Turn,
    /// x_a·(p_b − p_a) = y_a·(p_b − p_a) = 0.
    Line,
    /// z_a·(p_b − p_a) = 0.
    Plane,
    /// (|p_b − p_a|² − l²)/(2 l) = 0.
    Distance(Number),
}

impl ListConstraint for Between {
    fn phi<S: Scalar>(&self, q: &[S], b: &[S], _t: S, phi: &mut [S]) {
        let [(from, axes), (to, other)] = self.paths.each_ref().map(|path| path.place(q, b));
        let between = minus(to, from);
        match self.rows {
            Rows::Point => phi.iter_mut().zip(axes).for_each(|(phi, axis)| *phi = dot(axis, between)),
            Rows::Axis => phi.iter_mut().zip(axes).for_each(|(phi, axis)| *phi = dot(axis, other[2])),
            Rows::Turn => phi[0] = dot(axes[0], other[1]),
            Rows::Line => phi.iter_mut().zip(axes).for_each(|(phi, axis)| *phi = dot(axis, between)),
            Rows::Plane => phi[0] = dot(axes[2], between),
            Rows::Distance(length) => {
                let length = length.value(b);
                phi[0] = (dot(between, between) / length - length) * 0.5;
            }
        }
    }
}

impl Spatial<'_> {
    /// Lets two markers coincide as by a ball joint: three equations, along the axes of a.
    pub fn close_ball(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 3] {
        self.close(name, a, b, Rows::Point)
    }

    /// Lets the z axes of two markers be parallel: two equations.
    pub fn close_parallel(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 2] {
        self.close(name, a, b, Rows::Axis)
    }

    /// Closes a loop by a hinge about the common z axis: five equations, those of [`close_ball`](Self::close_ball) and
    /// [`close_parallel`](Self::close_parallel), with " (axis)" in the name of the latter.
    pub fn close_revolute(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 5] {
        let [x, y, z] = self.close_ball(name, a, b);
        let [first, second] = self.close_parallel(&format!("{name} (axis)"), a, b);
        [x, y, z, first, second]
    }

    /// Closes a loop by a slider along and about the common z axis: four equations.
    pub fn close_cylindrical(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 4] {
        let [x, y] = self.close(name, a, b, Rows::Line);
        let [first, second] = self.close_parallel(&format!("{name} (axis)"), a, b);
        [x, y, first, second]
    }

    /// Closes a loop by a slider along the common z axis: five equations.
    pub fn close_prismatic(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 5] {
        let [x, y, first, second] = self.close_cylindrical(name, a, b);
        let [turn] = self.close(&format!("{name} (turn)"), a, b, Rows::Turn);
        [x, y, first, second, turn]
    }

    /// Closes a loop by a weld: six equations.
    pub fn close_fixed(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 6] {
        let [x, y, z, first, second] = self.close_revolute(name, a, b);
        let [turn] = self.close(&format!("{name} (turn)"), a, b, Rows::Turn);
        [x, y, z, first, second, turn]
    }

    /// Keeps b in the x–y plane of a: one equation.
    pub fn point_on_plane(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 1] {
        self.close(name, a, b, Rows::Plane)
    }

    /// Keeps b on the z axis of a: two equations.
    pub fn point_on_line(&mut self, name: &str, a: Marker, b: Marker) -> [Multiplier; 2] {
        self.close(name, a, b, Rows::Line)
    }

    /// Keeps two markers at a distance, m: one equation, as of a massless rod.
    pub fn distance(&mut self, name: &str, a: Marker, b: Marker, length: impl Into<Param>) -> [Multiplier; 1] {
        let length = length.into();
        self.scene.require_positive(length, format!("the length of `{name}`"));
        self.between(name, a, b, |of| Rows::Distance(of.b.number(length)))
    }

    fn close<const M: usize>(&mut self, name: &str, a: Marker, b: Marker, rows: Rows) -> [Multiplier; M] {
        self.between(name, a, b, |_| rows)
    }

    fn between<const M: usize>(
        &mut self,
        name: &str,
        a: Marker,
        b: Marker,
        rows: impl FnOnce(&mut Arguments) -> Rows,
    ) -> [Multiplier; M] {
        let Some((paths, mut of)) = self.paths_between(name, [a, b]) else { return self.scene.no_multipliers() };
        let element = Between { paths, rows: rows(&mut of) };
        let multipliers = self.scene.list_constraint(name, element, M, &of.q, &of.b.0);
        multipliers.try_into().unwrap_or_else(|_| self.scene.no_multipliers())
    }
}
