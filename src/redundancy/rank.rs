//! Ranks of the constraint Jacobian and of the mass matrix, from dense matrices without units: for explanations only, never for a step.

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector, Dyn, SVD};
use num_dual::Dual64;

use crate::linear::eigen;
use crate::system::{NodeValues, NodeView, Sums};
use crate::{Error, System};

/// Singular values below this fraction of the largest count as zero: their squares are the pivots of K.
pub(crate) const RANK: f64 = 1e-7;
/// Eigenvalues of M̂ below this are negative, and not rounding.
const NEGATIVE: f64 = -1e-10;
/// A smallest singular value below this means that a singular configuration is near.
const NEARLY_SINGULAR: f64 = 1e-3;
/// Nearby configurations are at this relative distance.
const ASIDE: f64 = 1e-3;
/// Largest number of coordinates: beyond it the decompositions here would take too long.
const MOST_COORDINATES: usize = 400;

/// Φ̂ = R Φ_q D with rows of length one, D = |diag(M)|^(−1/2).
pub(crate) struct Scaled {
    phi_q: DMatrix<f64>,
    /// The diagonals of R and D.
    row: DVector<f64>,
    column: DVector<f64>,
    /// Combinations of rows that vanish, and directions that the constraints allow, by columns; computed on first use.
    dependencies: OnceCell<DMatrix<f64>>,
    free: OnceCell<DMatrix<f64>>,
}

impl Scaled {
    /// For one configuration; `None` if there are too many coordinates or a value is not finite.
    pub(crate) fn at(system: &System, at: &NodeView<f64>) -> Option<Self> {
        if system.n() > MOST_COORDINATES {
            return None;
        }
        let column = mass_diagonal(system, at).map(|mass| if mass != 0.0 { mass.abs().sqrt().recip() } else { 1.0 });
        Scaled::by(column, system, at)
    }

    /// For a given D.
    fn by(column: DVector<f64>, system: &System, at: &NodeView<f64>) -> Option<Self> {
        let (n, m) = (system.n(), system.m());
        let mut phi_q = DMatrix::zeros(m, n);
        system.phi_q(at).iter().for_each(|e| phi_q[(e.row, e.col)] += e.value * column[e.col]);
        let row = DVector::from_fn(m, |j, _| {
            let length: f64 = phi_q.row(j).norm();
            if length > 0.0 { length.recip() } else { 1.0 }
        });
        phi_q.row_iter_mut().zip(&row).for_each(|(mut entries, factor)| entries *= *factor);
        let is_finite = phi_q.iter().chain(&column).all(|x| x.is_finite());
        is_finite.then(|| Scaled { phi_q, row, column, dependencies: OnceCell::new(), free: OnceCell::new() })
    }

    /// M̂ = D M D.
    fn mass(&self, system: &System, at: &NodeView<f64>) -> DMatrix<f64> {
        let (mass, d) = (mass_matrix(system, at), &self.column);
        DMatrix::from_fn(d.len(), d.len(), |i, j| mass[(i, j)] * d[i] * d[j])
    }

    /// Coordinates moved by a fraction of the largest, in a direction that the constraints allow.
    pub(crate) fn aside(&self, at: &NodeView<f64>, share: f64) -> DVector<f64> {
        let free = self.free();
        // An arbitrary direction in which every coordinate takes part.
        let weights = DVector::from_fn(free.ncols(), |k, _| 1.0 + 0.37 * k as f64);
        let direction = (free * weights).component_mul(&self.column);
        let largest = at.q.iter().fold(0.0f64, |largest, q| largest.max(q.abs()));
        let length = share * if largest > 0.0 { largest } else { 1.0 };
        DVector::from_column_slice(at.q) + &direction * (length / direction.amax().max(f64::MIN_POSITIVE))
    }

    /// Nearby coordinates after at most this number of shortest corrections towards Φ = 0, and Φ_q before the last correction.
    fn corrected(&self, system: &System, at: &NodeView<f64>, most: usize) -> Option<(DVector<f64>, Scaled)> {
        let (mut q, mut last, mut phi) = (self.aside(at, ASIDE), None, vec![0.0; system.m()]);
        for _ in 0..most {
            let there = NodeView { q: q.as_slice(), ..*at };
            let scaled = Scaled::by(self.column.clone(), system, &there)?;
            system.phi(&there, &mut phi);
            let values = DVector::from_column_slice(&phi).component_mul(&scaled.row);
            let back = decomposition(scaled.phi_q.clone())?.pseudo_inverse(RANK).ok()? * values;
            let correction = back.component_mul(&scaled.column);
            q -= &correction;
            last = Some(scaled);
            if correction.amax() <= f64::EPSILON * q.amax() {
                break;
            }
        }
        Some((q, last?))
    }

    fn dependencies(&self) -> &DMatrix<f64> {
        self.dependencies.get_or_init(|| null_space(&self.phi_q.transpose(), RANK))
    }

    fn free(&self) -> &DMatrix<f64> {
        self.free.get_or_init(|| null_space(&self.phi_q, RANK))
    }

    /// The rank, and the equations that depend on each other; `None` if all are independent.
    fn dependent(&self, system: &System) -> Option<(usize, Vec<String>)> {
        let null = self.dependencies();
        (null.ncols() > 0).then(|| (system.m() - null.ncols(), names_of_rows(null, system)))
    }

    /// The rank of Φ_q at this configuration or at admissible nearby ones, where it may be larger.
    pub(crate) fn rank(&self, system: &System, at: &NodeView<f64>) -> usize {
        let of = |scaled: &Scaled| system.m() - scaled.dependencies().ncols();
        let nearby = if of(self) < system.m() { self.corrected(system, at, 20) } else { None };
        nearby.map_or(0, |(_, nearby)| of(&nearby)).max(of(self))
    }

    /// The error for constraints that depend on each other, or for motions without kinetic energy.
    pub(crate) fn explain(&self, system: &System, at: &NodeView<f64>) -> Option<Error> {
        let time = at.t;
        if let Some((rank, equations)) = self.dependent(system) {
            return Some(Error::DependentConstraints { rank, rows: system.m(), equations, time });
        }
        let free = self.free();
        let idle = null_space(&(free.transpose() * self.mass(system, at) * free), RANK * RANK);
        if idle.ncols() == 0 {
            return None;
        }
        let motion = free * idle;
        let moves = |i: &usize| motion.row(*i).norm() > 1e-6;
        let coordinates = (0..system.n()).filter(moves).map(|i| format!("`{}`", system.coordinate_name(i))).collect();
        Some(Error::SingularMass { coordinates, time })
    }

    /// The coordinates in admissible motions with negative kinetic energy.
    pub(crate) fn negative(&self, system: &System, at: &NodeView<f64>) -> Vec<usize> {
        let free = self.free();
        let Some(energies) = eigen(free.transpose() * self.mass(system, at) * free) else { return Vec::new() };
        let picked = (0..free.ncols()).filter(|&k| energies.eigenvalues[k] < NEGATIVE);
        let motions: Vec<_> = picked.map(|k| free * energies.eigenvectors.column(k)).collect();
        let moves = |i: &usize| motions.iter().any(|motion| motion[*i].abs() > 1e-6);
        (0..free.nrows()).filter(moves).collect()
    }

    /// The error for dependent equations that the values `phi` (Φ or dΦ/dt) cannot satisfy together.
    pub(crate) fn contradiction(&self, system: &System, phi: &[f64], time: f64) -> Option<Error> {
        let null = self.dependencies();
        let values = DVector::from_column_slice(phi).component_mul(&self.row);
        let clash = null * null.tr_mul(&values);
        if clash.norm() <= 1e-6 * values.norm() {
            return None;
        }
        let takes_part = |j: &usize| clash[*j].abs() > 1e-6 * clash.amax();
        let equations = (0..system.m()).filter(takes_part).map(|j| system.equation_name(j).to_string()).collect();
        // zᵀΦ, for any q or v, of the combination z whose largest share is 1.
        let violation = clash.norm_squared() / clash.component_mul(&self.row).amax();
        Some(Error::ContradictoryConstraints { equations, violation, time })
    }
}

/// The equations that depend on each other, if there are any and they can be determined.
pub(crate) fn dependent(system: &System, at: &NodeView<f64>) -> Option<Vec<String>> {
    Some(Scaled::at(system, at)?.dependent(system)?.1)
}

/// The error if constraints that depend on each other here are independent at admissible configurations nearby.
pub(crate) fn is_singular(here: &Scaled, system: &System, at: &NodeView<f64>) -> Option<Error> {
    let (rank, equations) = here.dependent(system)?;
    let (_, nearby) = here.corrected(system, at, 20)?;
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

/// True if other coordinates satisfy constraints that seem contradictory from their derivatives here: those of an overstretched chain do not allow it
/// to shorten, except sideways.
pub(crate) fn can_be_met(here: &Scaled, system: &System, at: &NodeView<f64>) -> bool {
    let size = |q: &[f64]| {
        let mut phi = vec![0.0; system.m()];
        system.phi(&NodeView { q, ..*at }, &mut phi);
        phi.iter().fold(0.0, |most: f64, phi| if phi.is_nan() { f64::INFINITY } else { most.max(phi.abs()) })
    };
    let found = here.corrected(system, at, 30);
    found.is_some_and(|(q, _)| size(q.as_slice()) <= 1e-6 * size(at.q))
}

/// The error if a step may have failed because Φ_q is nearly rank-deficient here, with a larger rank nearby.
pub(crate) fn near_singular(system: &System, at: &NodeView<f64>, step: usize, driven: Vec<String>) -> Option<Error> {
    let here = Scaled::at(system, at)?;
    let null = null_space(&here.phi_q.transpose(), NEARLY_SINGULAR);
    let (rows, equations) = (system.m(), names_of_rows(&null, system));
    let rank = rows - null.ncols();
    let usual = || here.corrected(system, at, 20).map_or(0, |(_, nearby)| nearby.dependencies().ncols());
    let is_singular = rank < rows && rank < rows - usual();
    is_singular.then_some(Error::SingularConfiguration { step, time: at.t, rank, rows, equations, driven })
}

fn names_of_rows(null: &DMatrix<f64>, system: &System) -> Vec<String> {
    let takes_part = |j: &usize| null.row(*j).norm() > 1e-6;
    (0..system.m()).filter(takes_part).map(|j| system.equation_name(j).to_string()).collect()
}

/// diag(M) by dual numbers, along several coordinates at once if M does not couple them.
fn mass_diagonal(system: &System, at: &NodeView<f64>) -> DVector<f64> {
    let mut there = NodeValues::of_equations(at, Dual64::from_re);
    let (mut sums, mut diagonal) = (Sums::new(system.n(), system.m()), DVector::zeros(system.n()));
    for uncoupled in system.uncoupled_by_energies() {
        uncoupled.iter().for_each(|&i| there.v[i].eps = 1.0);
        system.plain_sums(&there.view(), &mut sums);
        uncoupled.iter().for_each(|&i| (diagonal[i], there.v[i].eps) = (sums.l_v()[i].eps, 0.0));
    }
    diagonal
}

/// M = 𝓛_vv.
pub(crate) fn mass_matrix(system: &System, at: &NodeView<f64>) -> DMatrix<f64> {
    let [mass, ..] =
        system.columns(System::plain_sums, &mut NodeValues::of_equations(at, Dual64::from_re), |there| &mut there.v);
    mass
}

/// An orthonormal basis of the null space, by columns.
pub(crate) fn null_space(matrix: &DMatrix<f64>, tolerance: f64) -> DMatrix<f64> {
    let columns = matrix.ncols();
    // Squared up with zero rows, so that the decomposition contains all right singular vectors.
    let square = matrix.clone().resize_vertically(matrix.nrows().max(columns), 0.0);
    let Some(SVD { singular_values, v_t: Some(directions), .. }) = decomposition(square) else {
        return DMatrix::zeros(columns, 0);
    };
    let largest = singular_values.iter().fold(0.0f64, |a, &b| a.max(b));
    let rows = directions.row_iter().zip(singular_values.iter());
    let picked: Vec<_> = rows.filter(|(_, s)| **s <= tolerance * largest).map(|(row, _)| row.transpose()).collect();
    if picked.is_empty() { DMatrix::zeros(columns, 0) } else { DMatrix::from_columns(&picked) }
}

/// The singular value decomposition of a matrix with entries of order one; `None` if it is empty or not finite.
pub(crate) fn decomposition(mut matrix: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    // nalgebra panics for an empty matrix, and the decomposition of NaN is meaningless.
    if matrix.is_empty() || !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    // Entries whose squares underflow prevent the iteration from ending, or end it with NaN.
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
