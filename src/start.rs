//! The consistent start: p*₀ from the given state, then v₀ and σ₀ from Eq. (1a) and (1c), and what can be wrong with it.

use nalgebra::{DMatrix, DVector};

use crate::equilibrate::equilibrate;
use crate::simulate::Forward;
use crate::system::{At, Covector, Rows, Sums};
use crate::trajectory::{column, column_mut};
use crate::{Error, Settings, Start, System};

/// A pivot ratio below this makes it worth looking at Φ_q and M in full.
const SUSPICIOUS: f64 = 1e-10;
/// Singular values of an equilibrated matrix below this fraction of the largest count as zero.
const RANK: f64 = 1e-10;

/// Solves node 0: with h = 0 the equations of a step are Eq. (1a) and (1c).
pub(crate) fn solve(forward: &mut Forward, system: &System, settings: &Settings) -> Result<(), Error> {
    let (n, m) = (system.n(), system.m());
    let q = forward.inputs.start.q().as_slice().to_vec();
    let rate = forward.inputs.start.rate().as_slice().to_vec();
    let given_velocity = matches!(forward.inputs.start, Start::Velocity { .. });
    column_mut(&mut forward.trajectory.sigma, 0).fill(0.0);
    let v = column_mut(&mut forward.trajectory.v, 0);
    if given_velocity {
        v.copy_from_slice(&rate);
    } else {
        v.fill(0.0);
    }
    check_position(forward, system, &q, settings)?;
    let mut p_star = rate;
    if given_velocity {
        let mut sums = Sums::new(n, m);
        system.plain_sums(&point(forward, &q), &mut sums);
        check_velocity(&sums.phi_dot, system, settings)?;
        // σ₀ = 0, so 𝓛_v is T_v.
        p_star = sums.l_v;
    }
    if let Some((what, value)) = p_star.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        let element = system.find_not_finite(&point(forward, &q)).unwrap_or_else(|| system.coordinate_name(what).into());
        return Err(Error::Model {
            element: format!("{element} (p* = {value})"),
            node: 0,
            time: forward.trajectory.times[0],
        });
    }
    forward.set_start(&q, &p_star);
    check_regular(forward, system, &q)?;
    forward.newton.weigh(system);
    forward.solve_node(system, 0, 0.0, settings)?;
    column_mut(&mut forward.trajectory.p_star, 0).copy_from_slice(&p_star);
    forward.trajectory.computed = 1;
    Ok(())
}

fn point<'a>(forward: &'a Forward, q: &'a [f64]) -> At<'a, f64> {
    At {
        q,
        v: column(&forward.trajectory.v, 0),
        sigma: column(&forward.trajectory.sigma, 0),
        u: column(&forward.inputs.controls, 0),
        t: forward.trajectory.times[0],
        design: forward.inputs.design.as_slice(),
    }
}

fn check_position(forward: &Forward, system: &System, q: &[f64], settings: &Settings) -> Result<(), Error> {
    let mut phi = vec![0.0; system.m()];
    system.phi(&point(forward, q), &mut phi);
    let tolerance = settings.position_tolerance;
    match worst(&phi).filter(|(_, violation)| violation.is_nan() || violation.abs() > tolerance) {
        Some((j, violation)) if !violation.is_finite() => {
            let (element, time) = (system.equation_name(j).into(), forward.trajectory.times[0]);
            Err(Error::Model { element, node: 0, time })
        }
        Some((j, violation)) => {
            Err(Error::InitialPosition { equation: system.equation_name(j).into(), violation, tolerance })
        }
        None => Ok(()),
    }
}

fn check_velocity(phi_dot: &[f64], system: &System, settings: &Settings) -> Result<(), Error> {
    let tolerance = settings.velocity_tolerance;
    match worst(phi_dot).filter(|(_, violation)| violation.is_nan() || violation.abs() > tolerance) {
        Some((j, violation)) => {
            Err(Error::InitialVelocity { equation: system.equation_name(j).into(), violation, tolerance })
        }
        None => Ok(()),
    }
}

/// The entry that is largest, or not a number.
fn worst(values: &[f64]) -> Option<(usize, f64)> {
    let size = |x: f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
    values.iter().copied().enumerate().max_by(|a, b| size(a.1).total_cmp(&size(b.1)))
}

/// Factors K(0) = [M Φ_qᵀ; Φ_q 0], and explains a breakdown by the ranks of its parts.
fn check_regular(forward: &mut Forward, system: &System, q: &[f64]) -> Result<(), Error> {
    let (n, m) = (system.n(), system.m());
    let result = forward.factor_start(system);
    if result.is_ok() && forward.report.worst_pivot > SUSPICIOUS {
        return Ok(());
    }
    let time = forward.trajectory.times[0];
    if let Some(element) = system.find_not_finite(&point(forward, q)) {
        return Err(Error::Model { element, node: 0, time });
    }
    let (mass, phi_q) = mass_and_jacobian(forward, system, n, m);
    let mut transposed = phi_q.transpose();
    equilibrate(&mut transposed);
    let null = kernel(transposed);
    if null.ncols() > 0 {
        let takes_part = |j: &usize| null.row(*j).norm() > 1e-6;
        let equations = (0..m).filter(takes_part).map(|j| system.equation_name(j).to_string()).collect();
        return Err(Error::DependentConstraints { rank: m - null.ncols(), rows: m, equations, time });
    }
    let motion = idle_motions(&mass, &phi_q);
    if motion.ncols() > 0 {
        let moves = |i: &usize| motion.row(*i).norm() > 1e-6;
        let coordinates = (0..n).filter(moves).map(|i| format!("`{}`", system.coordinate_name(i))).collect();
        return Err(Error::SingularMass { coordinates, time });
    }
    match result {
        Ok(()) => Ok(()),
        Err(breakdown) => Err(system.singular_step(&breakdown, 0, time)),
    }
}

/// M = 𝓛_vv and Φ_q, dense, at the point that was evaluated last.
fn mass_and_jacobian(forward: &Forward, system: &System, n: usize, m: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let (mut mass, mut phi_q) = (DMatrix::zeros(n, n), DMatrix::zeros(m, n));
    let (zeros, none, mut rows) = (vec![0.0; n], vec![0.0; m], Rows::new(n, m));
    let evaluation = &forward.newton.evaluation;
    for j in 0..n {
        let mut unit = zeros.clone();
        unit[j] = 1.0;
        evaluation.pull_back(system, &evaluation.blocks, &Covector { c: &unit, d: &zeros, e: &none }, &mut rows);
        mass.column_mut(j).copy_from_slice(&rows.v);
        phi_q.column_mut(j).copy_from_slice(&rows.sigma);
    }
    (mass, phi_q)
}

/// The motions z with Φ_q z = 0 and without kinetic energy, M z = 0, by columns, each coordinate in a unit of its own.
///
/// M is brought to a diagonal of ones first: a small mass is a mass.
fn idle_motions(mass: &DMatrix<f64>, phi_q: &DMatrix<f64>) -> DMatrix<f64> {
    let of_phi = equilibrate(&mut phi_q.clone());
    let unit = |i: usize| if mass[(i, i)] > 0.0 { mass[(i, i)].sqrt().recip() } else { of_phi[i] };
    let massless = kernel(DMatrix::from_fn(mass.nrows(), mass.ncols(), |i, j| unit(i) * mass[(i, j)] * unit(j)));
    let mut reached = DMatrix::from_fn(phi_q.nrows(), phi_q.ncols(), |j, i| phi_q[(j, i)] * unit(i)) * &massless;
    let factors = equilibrate(&mut reached);
    let mut motions = massless * DMatrix::from_diagonal(&DVector::from_vec(factors)) * kernel(reached);
    motions.column_iter_mut().for_each(|mut motion| motion /= motion.amax());
    motions
}

/// An orthonormal basis of the null space, by columns; singular values are compared with the largest.
fn kernel(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let columns = matrix.ncols();
    // nalgebra panics at an empty matrix, and the decomposition of a NaN means nothing.
    if columns == 0 || !matrix.iter().all(|x| x.is_finite()) {
        return DMatrix::zeros(columns, 0);
    }
    // Squared up with zero rows, so that the decomposition holds all right singular vectors.
    let rows = matrix.nrows().max(columns);
    let svd = matrix.resize_vertically(rows, 0.0).svd(false, true);
    let largest = svd.singular_values.iter().fold(0.0f64, |a, &b| a.max(b));
    let zero = |s: f64| s <= RANK * largest;
    let directions = svd.v_t.unwrap_or_else(|| DMatrix::zeros(0, columns));
    let picked: Vec<_> = directions
        .row_iter()
        .zip(svd.singular_values.iter())
        .filter(|(_, s)| zero(**s))
        .map(|(row, _)| row.transpose())
        .collect();
    if picked.is_empty() { DMatrix::zeros(columns, 0) } else { DMatrix::from_columns(&picked) }
}
