//! The relative degree of coordinates: which derivative a control changes.

use nalgebra::DVector;

use super::{LinearModel, control_indices, indices};
use crate::{Control, Coordinate, Error, Mechanics};

/// A product is zero if it is below this fraction of the same product with absolute values.
const ROUNDING: f64 = 1e-10;

impl Mechanics {
    /// The relative degree of a coordinate at this state: the order of its lowest time derivative that one of the controls changes at once; `None` if
    /// they have no influence on it. With the matrices of the linear model,
    ///
    /// ```text
    ///   the least r ≥ 1 for which the row of the coordinate in q_z a^(r−1) b is not zero
    /// ```
    ///
    /// It is 2 if a motor or its reaction acts on the body itself or on one that joints connect to it, 3 if a spring with a damper is between them, and 4
    /// with a spring alone. A servo constraint, which prescribes one coordinate and asks for one control, is a differential-algebraic equation of index
    /// r + 1; several at once may have a higher index. Forces at other states may act with a lower or a higher degree, for example where a lever passes a
    /// dead centre.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Mechanics, Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// let carts = [0.0, 1.0].map(|x| scene.particle(&format!("cart at {x} m"), 2.0, [x, 0.0]));
    /// let force = scene.control("force");
    /// scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, carts[0].point(), force);
    /// scene.spring_damper("spring", carts[0].point(), carts[1].point(), 100.0, 1.0, 0.0);
    /// let system = scene.compile()?;
    /// let at = Mechanics::new(&system, &[0.0, 0.0, 1.0, 0.0], &[0.0; 4])?;
    /// assert_eq!(at.relative_degree(carts[0].coordinates[0], &[force])?, Some(2));
    /// assert_eq!(at.relative_degree(carts[1].coordinates[0], &[force])?, Some(4));
    /// assert_eq!(at.relative_degree(carts[1].coordinates[1], &[force])?, None);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// Source: A. Isidori, *Nonlinear Control Systems*, 3rd edition, section 4.1, for the linear model of the state.
    ///
    /// # Errors
    /// As [`linear_model`](Self::linear_model); a control of another scene.
    pub fn relative_degree(&self, coordinate: Coordinate, controls: &[Control]) -> Result<Option<usize>, Error> {
        let caller = "Mechanics::relative_degree";
        let rows = indices(caller, &[coordinate], self.system())?;
        let columns = control_indices(caller, controls, self.system())?;
        let model = self.linear_model(&[])?;
        Ok(rows.iter().find_map(|&row| model.relative_degree(row, &columns)))
    }
}

impl LinearModel {
    /// The least r for which a control changes the derivative of order r of a coordinate.
    pub(super) fn relative_degree(&self, coordinate: usize, controls: &[usize]) -> Option<usize> {
        let (transposed, sizes_of) = (self.a.transpose(), self.a.abs().transpose());
        let mut row: DVector<f64> = self.q_z.row(coordinate).transpose();
        let mut sizes = row.abs();
        (1..=self.a.nrows()).find(|_| {
            let acts = |&u: &usize| {
                let column = self.b.column(u);
                row.dot(&column).abs() > ROUNDING * sizes.dot(&column.abs())
            };
            let is_found = controls.iter().any(acts);
            (row, sizes) = (&transposed * &row, &sizes_of * &sizes);
            is_found
        })
    }
}
