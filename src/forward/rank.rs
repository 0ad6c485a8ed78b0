//! Ranks of the constraint Jacobian and of the mass matrix, dense and free of units: for explanations, never for a step.

use nalgebra::{DMatrix, DVector, Dyn, SVD};
use num_dual::Dual64;

use crate::linear::eigen;
use crate::system::{NodeValues, NodeView, Sums};
use crate::{Error, System};

/// Singular values below this fraction of the largest count as zero: their squares are the pivots of K.
const RANK: f64 = 1e-7;
/// Eigenvalues of M̂ below this are negative, and not rounding.
const NEGATIVE: f64 = -1e-10;
/// Close to a singular configuration the smallest singular value is below this.
const NEARLY_SINGULAR: f64 = 1e-3;
/// What lies so far aside is nearby.
const ASIDE: f64 = 1e-3;
/// Beyond this number of coordinates the decompositions here would take longer than anybody wants to wait.
const MOST_COORDINATES: usize = 400;

/// Φ̂ = R Φ_q D with rows of length one, and M̂ = D M D with D = |diag(M)|^(−1/2).
pub(crate) struct Scaled {
    phi_q: DMatrix<f64>,
    mass: DMatrix<f64>,
    /// The diagonals of R and D.
    row: DVector<f64>,
    column: DVector<f64>,
}

impl Scaled {
    /// At one configuration; None if there are too many coordinates or anything is not finite.
    pub(crate) fn at(system: &System, at: &NodeView<f64>) -> Option<Self> {
        let (n, m) = (system.n(), system.m());
        if n > MOST_COORDINATES {
            return None;
        }
        let mut mass = mass_matrix(system, at);
        let column = DVector::from_fn(n, |i, _| if mass[(i, i)] != 0.0 { mass[(i, i)].abs().sqrt().recip() } else { 1.0 });
        mass = DMatrix::from_fn(n, n, |i, j| mass[(i, j)] * column[i] * column[j]);
        let mut phi_q = DMatrix::zeros(m, n);
        system.phi_q(at).iter().for_each(|e| phi_q[(e.row, e.col)] += e.value * column[e.col]);
        let row = DVector::from_fn(m, |j, _| {
            let length: f64 = phi_q.row(j).norm();
            if length > 0.0 { length.recip() } else { 1.0 }
        });
        phi_q.row_iter_mut().zip(&row).for_each(|(mut entries, factor)| entries *= *factor);
        let finite = phi_q.iter().chain(&mass).all(|x| x.is_finite());
        finite.then_some(Scaled { phi_q, mass, row, column })
    }

    /// Coordinates aside by a share of the largest, where the constraints leave room.
    pub(super) fn aside(&self, at: &NodeView<f64>, share: f64) -> DVector<f64> {
        let free = null_space(&self.phi_q, RANK);
        // Any direction: that of every coordinate counts.
        let weights = DVector::from_fn(free.ncols(), |k, _| 1.0 + 0.37 * k as f64);
        let direction = (free * weights).component_mul(&self.column);
        let largest = at.q.iter().fold(0.0f64, |largest, q| largest.max(q.abs()));
        let length = share * if largest > 0.0 { largest } else { 1.0 };
        DVector::from_column_slice(at.q) + &direction * (length / direction.amax().max(f64::MIN_POSITIVE))
    }

    /// Combinations of rows that vanish, by columns.
    fn dependencies(&self) -> DMatrix<f64> {
        null_space(&self.phi_q.transpose(), RANK)
    }

    /// Which equations depend on each other, and the rank; None if all are independent.
    fn dependent(&self, system: &System) -> Option<(usize, Vec<String>)> {
        let null = self.dependencies();
        (null.ncols() > 0).then(|| (system.m() - null.ncols(), names_of_rows(&null, system)))
    }

    /// Constraints that depend on each other, or motions without kinetic energy, as an error.
    pub(crate) fn explain(&self, system: &System, time: f64) -> Option<Error> {
        if let Some((rank, equations)) = self.dependent(system) {
            return Some(Error::DependentConstraints { rank, rows: system.m(), equations, time });
        }
        let free = null_space(&self.phi_q, RANK);
        let idle = null_space(&(free.transpose() * &self.mass * &free), RANK * RANK);
        if idle.ncols() == 0 {
            return None;
        }
        let motion = free * idle;
        let moves = |i: &usize| motion.row(*i).norm() > 1e-6;
        let coordinates = (0..system.n()).filter(moves).map(|i| format!("`{}`", system.coordinate_name(i))).collect();
        Some(Error::SingularMass { coordinates, time })
    }

    /// The coordinates that take part in motions of negative kinetic energy which the constraints allow.
    pub(crate) fn negative(&self) -> Vec<usize> {
        let free = null_space(&self.phi_q, RANK);
        let Some(energies) = eigen(free.transpose() * &self.mass * &free) else { return Vec::new() };
        let picked = (0..free.ncols()).filter(|&k| energies.eigenvalues[k] < NEGATIVE);
        let motions: Vec<_> = picked.map(|k| &free * energies.eigenvectors.column(k)).collect();
        let moves = |i: &usize| motions.iter().any(|motion| motion[*i].abs() > 1e-6);
        (0..free.nrows()).filter(moves).collect()
    }

    /// Dependent equations that the values `phi` (Φ or dΦ/dt) do not satisfy together, as an error.
    pub(crate) fn contradiction(&self, system: &System, phi: &[f64], time: f64) -> Option<Error> {
        let null = self.dependencies();
        let values = DVector::from_column_slice(phi).component_mul(&self.row);
        let clash = &null * null.tr_mul(&values);
        if clash.norm() <= 1e-6 * values.norm() {
            return None;
        }
        let takes_part = |j: &usize| clash[*j].abs() > 1e-6 * clash.amax();
        let equations = (0..system.m()).filter(takes_part).map(|j| system.equation_name(j).to_string()).collect();
        let violation = (0..system.m()).filter(takes_part).map(|j| phi[j].abs()).fold(0.0, f64::max);
        Some(Error::ContradictoryConstraints { equations, violation, time })
    }
}

/// The equations that depend on each other, if there are any and they can be told.
pub(crate) fn dependent(system: &System, at: &NodeView<f64>) -> Option<Vec<String>> {
    Some(Scaled::at(system, at)?.dependent(system)?.1)
}

/// Whether constraints that depend on each other here are independent at other admissible configurations nearby.
pub(crate) fn is_singular(here: &Scaled, system: &System, at: &NodeView<f64>) -> Option<Error> {
    let (rank, equations) = here.dependent(system)?;
    let (_, nearby) = corrected(system, at, here.aside(at, ASIDE), 20)?;
    let dependencies = nearby.dependencies().ncols();
    let (rows, time) = (system.m(), at.t);
    (rows - dependencies > rank).then_some(Error::SingularConfiguration {
        step: 0,
        time,
        rank,
        rows,
        equations,
        driven: Vec::new(),
    })
}

/// Whether other coordinates satisfy constraints that contradict each other as far as their derivatives here tell: those of a chain that is stretched too far
/// do not let it shorten, but to the side it can go.
pub(crate) fn can_be_met(here: &Scaled, system: &System, at: &NodeView<f64>) -> bool {
    let size = |q: &[f64]| {
        let mut phi = vec![0.0; system.m()];
        system.phi(&NodeView { q, ..*at }, &mut phi);
        phi.iter().fold(0.0, |most: f64, phi| if phi.is_nan() { f64::INFINITY } else { most.max(phi.abs()) })
    };
    let found = corrected(system, at, here.aside(at, ASIDE), 30);
    found.is_some_and(|(q, _)| size(q.as_slice()) <= 1e-6 * size(at.q))
}

/// Coordinates after so many corrections of least length towards Φ = 0, and Φ_q before the last.
fn corrected(system: &System, at: &NodeView<f64>, mut q: DVector<f64>, count: usize) -> Option<(DVector<f64>, Scaled)> {
    let mut last = None;
    for _ in 0..count {
        let there = NodeView { q: q.as_slice(), ..*at };
        let scaled = Scaled::at(system, &there)?;
        let mut phi = vec![0.0; system.m()];
        system.phi(&there, &mut phi);
        let values = DVector::from_vec(phi).component_mul(&scaled.row);
        let back = decomposition(scaled.phi_q.clone())?.pseudo_inverse(RANK).ok()? * values;
        q -= back.component_mul(&scaled.column);
        last = Some(scaled);
    }
    Some((q, last?))
}

/// What a step that failed can have met: Φ_q of nearly deficient rank, where nearby it has a larger one.
pub(crate) fn near_singular(system: &System, at: &NodeView<f64>, step: usize, driven: Vec<String>) -> Option<Error> {
    let here = Scaled::at(system, at)?;
    let null = null_space(&here.phi_q.transpose(), NEARLY_SINGULAR);
    let (rows, equations) = (system.m(), names_of_rows(&null, system));
    let rank = rows - null.ncols();
    let usual = || corrected(system, at, here.aside(at, ASIDE), 20).map_or(0, |(_, nearby)| nearby.dependencies().ncols());
    let is_singular = rank < rows && rank < rows - usual();
    is_singular.then_some(Error::SingularConfiguration { step, time: at.t, rank, rows, equations, driven })
}

fn names_of_rows(null: &DMatrix<f64>, system: &System) -> Vec<String> {
    let takes_part = |j: &usize| null.row(*j).norm() > 1e-6;
    (0..system.m()).filter(takes_part).map(|j| system.equation_name(j).to_string()).collect()
}

/// M = 𝓛_vv, one column after the other by dual numbers.
pub(crate) fn mass_matrix(system: &System, at: &NodeView<f64>) -> DMatrix<f64> {
    let mut there = NodeValues::of_equations(at, Dual64::from_re);
    let mut sums = Sums::new(system.n(), system.m());
    DMatrix::from_columns(&Vec::from_iter((0..system.n()).map(|j| {
        there.v[j].eps = 1.0;
        system.plain_sums(&there.view(), &mut sums);
        there.v[j].eps = 0.0;
        DVector::from_iterator(system.n(), sums.l_v().iter().map(|l_v| l_v.eps))
    })))
}

/// An orthonormal basis of the null space, by columns.
fn null_space(matrix: &DMatrix<f64>, tolerance: f64) -> DMatrix<f64> {
    let columns = matrix.ncols();
    // Squared up with zero rows, so that the decomposition holds all right singular vectors.
    let square = matrix.clone().resize_vertically(matrix.nrows().max(columns), 0.0);
    let Some(SVD { singular_values, v_t: Some(directions), .. }) = decomposition(square) else {
        return DMatrix::zeros(columns, 0);
    };
    let largest = singular_values.iter().fold(0.0f64, |a, &b| a.max(b));
    let rows = directions.row_iter().zip(singular_values.iter());
    let picked: Vec<_> = rows.filter(|(_, s)| **s <= tolerance * largest).map(|(row, _)| row.transpose()).collect();
    if picked.is_empty() { DMatrix::zeros(columns, 0) } else { DMatrix::from_columns(&picked) }
}

/// The singular value decomposition of a matrix of entries about one, unless it is empty or not finite.
fn decomposition(mut matrix: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    // nalgebra panics at an empty matrix, and the decomposition of a NaN means nothing.
    if matrix.is_empty() || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    // Entries whose squares underflow keep its iteration from ending, or end it with NaN.
    matrix.iter_mut().filter(|x| x.abs() < 1e-100).for_each(|x| *x = 0.0);
    let iterations = 100 * (matrix.nrows() + matrix.ncols());
    let svd = SVD::try_new_unordered(matrix, true, true, 5.0 * f64::EPSILON, iterations)?;
    svd.singular_values.iter().all(|s| s.is_finite()).then_some(svd)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ̂ of a parallelogram with three cranks of 1e154 m.
    #[test]
    fn entries_whose_squares_underflow_do_not_keep_the_decomposition_from_ending() {
        let (one, tiny) = (0.9999999999999999, 1.3220991182148473e-154);
        let ones = [(2, 5), (8, 6), (8, 8), (10, 9), (10, 11), (12, 12), (12, 13)];
        let mut matrix = DMatrix::zeros(14, 14);
        ones.iter().for_each(|&(row, col)| matrix[(row, col)] = one);
        [8, 11, 13].iter().for_each(|&col| matrix[(3, col)] = tiny);
        assert_eq!(null_space(&matrix, RANK).ncols(), 10);
    }
}
