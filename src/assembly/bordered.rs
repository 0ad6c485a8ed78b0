//! [`Bordered`]: K(0) bordered by the held coordinates, and solutions with matrices close to it.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use crate::linear::gmres;
use crate::node::Linearisation;
use crate::number::larger;
use crate::system::Pair;
use crate::{Error, System};

/// Relative residual of GMRES; Newton's corrections remove the remaining error.
const EXACT: f64 = 1e-14;
const MOST_PRODUCTS: usize = 200;
/// A coordinate has no freedom left if its mobility is below this fraction of that without constraints.
const DETERMINED: f64 = 1e-10;
/// Corrections that have stopped shrinking are rounding below this fraction of the largest number if all coordinates are free …
const STALLED: f64 = 1e-11;
/// As `STALLED`, if coordinates are held: the fraction is then this number divided by the smallest freedom of a held coordinate, if that is larger.
const ROUNDED: f64 = 64.0 * f64::EPSILON;

/// K(0) bordered by the held coordinates.
pub(crate) struct Bordered {
    held: Vec<usize>,
    /// K(0)⁻¹ E, and Eᵀ K(0)⁻¹ E.
    columns: Vec<Pair>,
    small: LU<f64, Dyn, Dyn>,
    /// The held coordinate that is closest to being determined, and its remaining fraction of mobility.
    least_free: Option<(usize, f64)>,
}

impl Bordered {
    /// Uses the factors of K(0) in `linearisation` and the masses in K(0).
    ///
    /// # Errors
    /// The constraints and the other held coordinates determine a held coordinate.
    pub(crate) fn new(
        system: &System,
        linearisation: &mut Linearisation,
        held: &[usize],
        masses: &[f64],
    ) -> Result<Self, Error> {
        let columns: Vec<Pair> = Vec::from_iter(held.iter().map(|&i| {
            let mut column = Pair::new(system.n(), system.m());
            column.v[i] = 1.0;
            linearisation.solve(system, &mut column);
            column
        }));
        let matrix = DMatrix::from_fn(held.len(), held.len(), |i, j| columns[j].v[held[i]]);
        let freedom = |i: usize| {
            // Remaining mobility if the previous coordinates are held, relative to the mobility without constraints.
            let along = matrix.view((0, i), (i, 1)).into_owned();
            let others = if i == 0 { None } else { matrix.view((0, 0), (i, i)).into_owned().lu().solve(&along) };
            let left = matrix[(i, i)] - others.map_or(0.0, |x| along.dot(&x));
            left * masses[held[i]]
        };
        let freedoms = Vec::from_iter((0..held.len()).map(freedom));
        // A comparison is false for a NaN.
        let is_free = |freedom: &f64| *freedom > DETERMINED;
        match freedoms.iter().position(|freedom| !is_free(freedom)) {
            Some(i) => Err(Error::Held { coordinate: system.coordinate_name(held[i]).to_string() }),
            None => {
                let least_free = held.iter().copied().zip(freedoms).min_by(|a, b| a.1.total_cmp(&b.1));
                Ok(Bordered { held: held.to_vec(), columns, small: matrix.lu(), least_free })
            }
        }
    }

    /// If corrections have stopped shrinking, they are rounding below this fraction of the corrected values: the less freedom the held coordinates
    /// have, the more their rounding errors move the others.
    pub(super) fn stalled(&self) -> f64 {
        self.least_free.map_or(STALLED, |(_, freedom)| larger(STALLED, ROUNDED / freedom))
    }

    /// The held coordinate with the least freedom.
    pub(super) fn least_free(&self) -> Option<usize> {
        self.least_free.map(|(coordinate, _)| coordinate)
    }

    /// Replaces the right-hand side x by the solution x with Eᵀ x = 0.
    pub(crate) fn solve(&self, system: &System, linearisation: &mut Linearisation, x: &mut Pair) {
        // Rows of held coordinates contain only κ: other values there would cancel, with a loss of digits in the other rows.
        self.held.iter().for_each(|&i| x.v[i] = 0.0);
        linearisation.solve(system, x);
        if self.held.is_empty() {
            return;
        }
        let mut kappa = DVector::from_iterator(self.held.len(), self.held.iter().map(|&i| x.v[i]));
        self.small.solve_mut(&mut kappa);
        for (column, &factor) in self.columns.iter().zip(&kappa) {
            x.v.iter_mut().zip(&column.v).for_each(|(x, column)| *x -= factor * column);
            x.sigma.iter_mut().zip(&column.sigma).for_each(|(x, column)| *x -= factor * column);
        }
        self.held.iter().for_each(|&i| x.v[i] = 0.0);
    }

    /// Solves A x = r in place of r for a matrix A that differs from K(0) only in its block of velocities, by products with A. With x = (x_v, x_σ),
    /// GMRES solves K(0)⁻¹ A (x_v, 0) = K(0)⁻¹ r for x_v; the residual gives x_σ. Its norms do not contain multipliers of dependent constraints.
    pub(crate) fn solve_close(
        &self,
        system: &System,
        linearisation: &mut Linearisation,
        x: &mut Pair,
        mut product: impl FnMut(&Linearisation, &Pair, &mut Pair),
    ) {
        let (n, m) = (system.n(), system.m());
        let (right, mut along, mut image) = (x.clone(), Pair::new(n, m), Pair::new(n, m));
        self.solve(system, linearisation, x);
        let found = gmres(&x.v, EXACT, MOST_PRODUCTS, |v| {
            along.v.copy_from_slice(v);
            product(linearisation, &along, &mut image);
            self.solve(system, linearisation, &mut image);
            image.v.clone()
        });
        along.v.copy_from_slice(&found);
        product(linearisation, &along, &mut image);
        image.subtract_from(&right);
        self.solve(system, linearisation, &mut image);
        image.add(&along);
        *x = image;
    }
}
