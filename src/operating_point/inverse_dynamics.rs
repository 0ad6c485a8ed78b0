//! Inverse dynamics at a state: controls for given accelerations.

use nalgebra::{DMatrix, DVector};

use super::{control_indices, indices};
use crate::accelerations::Accelerations;
use crate::error::quoted;
use crate::number::largest;
use crate::redundancy::decomposition;
use crate::system::NodeView;
use crate::{Control, Coordinate, Error, Mechanics};

const MOST_STEPS: usize = 50;
/// Corrections below this fraction of the largest control are rounding.
const ROUNDING: f64 = 1e-14;
/// If corrections stop shrinking, remaining accelerations are rounding below this fraction of those that the forces cause without constraints.
const STALLED: f64 = 1e-9;
/// Accelerations below this fraction of the largest one that a control causes without constraints are rounding.
const NO_INFLUENCE: f64 = 1e-12;
/// Singular values of ∂v̇/∂u, with rows and columns of length one, below this are zero.
const SINGULAR: f64 = 1e-9;

impl Mechanics {
    /// This state with the controls for which chosen coordinates have given accelerations, m/s² or rad/s²; there are as many chosen controls.
    ///
    /// ```text
    ///   v̇_i(q, v, u, t; b) = a_i      for the coordinates i, by Newton's method with the exact ∂v̇/∂u
    /// ```
    ///
    /// Controls that are not chosen keep their values. Along a motion q(t), v(t) that is prescribed for all degrees of freedom, these are the
    /// controls of the continuous motion; a simulation with their values at the nodes follows it with an error of the order of its scheme.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Mechanics, scenes::CartPendulum};
    ///
    /// // Which force on the cart keeps the angular acceleration of a falling link at zero?
    /// let parts = CartPendulum { start_angle: 1.2, ..CartPendulum::with_links(1) }.mechanism();
    /// let (force, angle) = (parts.force, parts.links[0].coordinates[2]);
    /// let system = parts.scene.compile()?;
    /// let q = system.initial_coordinates();
    /// let at = Mechanics::new(&system, q.as_slice(), &[0.0; 6])?.inverse_dynamics(&[(angle, 0.0)], &[force])?;
    /// // Cart and link accelerate together: u = (M + m) g cot φ.
    /// assert!((at.controls()[0] - 1.2 * 9.81 / 1.2f64.tan()).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`accelerations`](Self::accelerations); a coordinate or control of another scene; another number of controls than of coordinates; controls
    /// that do not determine these accelerations, for example because constraints do, or because a spring is between motor and coordinate (a servo
    /// constraint of higher index); no solution.
    pub fn inverse_dynamics(mut self, accelerations: &[(Coordinate, f64)], controls: &[Control]) -> Result<Self, Error> {
        let caller = "Mechanics::inverse_dynamics";
        let system = self.system().clone();
        let (coordinates, given): (Vec<Coordinate>, Vec<f64>) = accelerations.iter().copied().unzip();
        let rows = indices(caller, &coordinates, &system)?;
        let columns = control_indices(caller, controls, &system)?;
        if controls.len() != rows.len() {
            return Err(Error::Size {
                what: "controls of the inverse dynamics",
                expected: rows.len(),
                found: controls.len(),
            });
        }
        if let Some((q, &value)) = coordinates.iter().zip(&given).find(|(_, a)| !a.is_finite()) {
            return Err(Error::NotFinite {
                what: format!("the acceleration of `{}`", system.coordinate_name(q.index())),
                value,
            });
        }
        let time = self.t();
        let failure = |coordinates: &[usize], controls: &[usize], is_singular, order| Error::NoControl {
            coordinates: coordinates.iter().map(|&i| quoted(system.coordinate_name(i))).collect(),
            controls: controls.iter().map(|&u| quoted(system.control_name(u))).collect(),
            is_singular,
            order,
            time,
        };
        let singular = |at: &Mechanics| match at.behind_springs(&rows, &columns) {
            Some((coordinates, controls, order)) => failure(&coordinates, &controls, true, Some(order)),
            None => failure(&rows, &columns, true, None),
        };
        let (mut u, mut last) = (self.controls().to_vec(), f64::INFINITY);
        for _ in 0..MOST_STEPS {
            let (v_dot, by_controls, size) = self.by_controls(&rows, &columns)?;
            let left = DVector::from_fn(rows.len(), |i, _| given[i] - v_dot[i]);
            let by = solve(by_controls, &left).ok_or_else(|| singular(&self))?;
            columns.iter().zip(by.iter()).for_each(|(&control, by)| u[control] += by);
            self = self.with_controls(&u)?;
            let (of, size) = (largest(by.as_slice()), size.max(largest(&given)));
            if of <= ROUNDING * largest(&u) || of >= 0.5 * last && left.amax() <= STALLED * size {
                return Ok(self);
            }
            last = of;
        }
        Err(failure(&rows, &columns, false, None))
    }

    /// Coordinates and controls of which the latter change only higher derivatives than accelerations, and the lowest order of these: a coordinate with
    /// all controls, or a control with all coordinates; `None` if there are none.
    fn behind_springs(&self, rows: &[usize], columns: &[usize]) -> Option<(Vec<usize>, Vec<usize>, usize)> {
        let model = self.linear_model(&[]).ok()?;
        let of_rows = rows.iter().map(|&i| (vec![i], columns.to_vec()));
        let of_columns = columns.iter().map(|&u| (rows.to_vec(), vec![u]));
        of_rows.chain(of_columns).find_map(|(coordinates, controls)| {
            let degrees = coordinates.iter().filter_map(|&i| model.relative_degree(i, &controls));
            let order = degrees.min().filter(|order| *order > 2)?;
            Some((coordinates, controls, order))
        })
    }

    /// The accelerations of coordinates, their derivatives with respect to controls, and the largest acceleration without constraints.
    fn by_controls(&self, rows: &[usize], controls: &[usize]) -> Result<(Vec<f64>, DMatrix<f64>, f64), Error> {
        let (system, none) = (self.system(), vec![0.0; self.system().m()]);
        let (at, mut accelerations) = (self.view(&none), Accelerations::new(self.system()));
        let masses = self.mass().diagonal();
        let unconstrained = |forces: &[f64]| {
            let heavy = forces.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0);
            heavy.map(|(force, mass)| (force / mass).abs()).fold(0.0, f64::max)
        };
        let size = unconstrained(&accelerations.right(system, &at, 0)?.v);
        accelerations.evaluate(system, &at, (0, &self.compliances()))?;
        let (still, no_design) = (vec![0.0; system.n()], vec![0.0; system.parameters().len()]);
        let mut by_controls = DMatrix::zeros(rows.len(), controls.len());
        for (column, &control) in controls.iter().enumerate() {
            let mut unit = vec![0.0; system.k()];
            unit[control] = 1.0;
            let along = NodeView::of_equations([&still, &still, &none], (&unit, 0.0, &no_design));
            let [x, change] = accelerations.along(system, &at, &along);
            let (x, change) = (x.clone(), change.v.clone());
            let least = NO_INFLUENCE * unconstrained(&accelerations.changes(system, (&at, &along), &x).v);
            let significant = |i: usize| if change[i].abs() > least { change[i] } else { 0.0 };
            rows.iter().enumerate().for_each(|(row, &i)| by_controls[(row, column)] = significant(i));
        }
        let v_dot = accelerations.found().v;
        Ok((rows.iter().map(|&i| v_dot[i]).collect(), by_controls, size))
    }
}

/// The solution of square equations; `None` if they are singular, independently of the units of rows and columns.
fn solve(mut matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    if right.is_empty() {
        return Some(right.clone());
    }
    let (mut right, mut of_columns) = (right.clone(), DVector::from_element(matrix.ncols(), 1.0));
    for _ in 0..2 {
        for (i, right) in right.iter_mut().enumerate() {
            let length = matrix.row(i).norm();
            matrix.row_mut(i).unscale_mut(length);
            *right /= length;
        }
        for (j, of_column) in of_columns.iter_mut().enumerate() {
            let length = matrix.column(j).norm();
            matrix.column_mut(j).unscale_mut(length);
            *of_column /= length;
        }
    }
    let singular_values = decomposition(matrix.clone())?.singular_values;
    if singular_values.min() < SINGULAR {
        return None;
    }
    matrix.lu().solve(&right).map(|x| x.component_mul(&of_columns))
}
