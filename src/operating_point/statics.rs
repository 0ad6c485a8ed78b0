//! [`Statics`]: forces and stiffness at rest, in the motions that constraints and held coordinates leave free.
//!
//! ```text
//!   r = 𝓛_q + Q at v = 0,    λ: r − Φ_qᵀ λ = Eᵀ x          force on all coordinates, and reactions
//!   P: Φ_q P = 0, P = 0 for held coordinates, Pᵀ M P = 1     free motions
//!   g = Pᵀ r,    k = −Pᵀ (r − Φ_qᵀ λ)_q P                     force and stiffness (N, N/m per √kg, kg, …)
//! ```

use nalgebra::{DMatrix, DVector};

use super::independent;
use crate::accelerations::Accelerations;
use crate::assembly::Retraction;
use crate::redundancy::Scaled;
use crate::system::{NodeView, Pair};
use crate::{Error, Mechanics, Settings, System};

/// If dependent coordinates move by more than this with independent ones, in m or rad, others are chosen.
const AMPLIFIED: f64 = 10.0;
/// Largest number of corrections without new derivatives; their rounding is below `CLOSE`, m or rad.
const MOST_CORRECTIONS: usize = 20;
const CLOSE: f64 = 1e-6;

/// A configuration at rest.
pub(super) struct Balance {
    pub(super) state: Mechanics,
    /// E, all independent coordinates.
    pub(super) independent: Vec<usize>,
    /// The changes of all coordinates with each independent one.
    pub(super) motions: DMatrix<f64>,
    /// P.
    pub(super) free: DMatrix<f64>,
    /// r, N or N m.
    pub(super) forces: DVector<f64>,
    /// g and k.
    pub(super) force: DVector<f64>,
    pub(super) stiffness: DMatrix<f64>,
    /// λ for zero acceleration, N or N m.
    pub(super) lambda: Vec<f64>,
}

/// Evaluates configurations of one system under constant controls.
pub(super) struct Statics {
    pub(super) system: System,
    pub(super) held: Vec<usize>,
    independent: Vec<usize>,
    retraction: Retraction,
    pub(super) accelerations: Accelerations,
}

impl Statics {
    /// For configurations near one that satisfies the constraints.
    ///
    /// # Errors
    /// A held coordinate that others determine.
    pub(super) fn new(state: &Mechanics, held: Vec<usize>) -> Result<Self, Error> {
        let (system, independent) = (state.system().clone(), independent(state, &held)?);
        let retraction = Retraction::new(&system, &independent, &state.inputs())?;
        let accelerations = Accelerations::new(&system);
        Ok(Statics { system, held, independent, retraction, accelerations })
    }

    /// Evaluates a configuration that satisfies the constraints.
    ///
    /// # Errors
    /// A held coordinate that others determine, a constraint that moves, a singular mass matrix, forces that are not finite.
    pub(super) fn balance(&mut self, state: &Mechanics) -> Result<Balance, Error> {
        self.choose(state)?;
        self.place(state, state.q())
    }

    /// The configuration after a change of coordinates, corrected to satisfy the constraints.
    ///
    /// # Errors
    /// As [`balance`](Self::balance), and no such configuration near.
    pub(super) fn moved(&mut self, from: &Balance, by: &DVector<f64>) -> Result<Balance, Error> {
        let near: Vec<f64> = from.state.q().iter().zip(by.iter()).map(|(q, by)| q + by).collect();
        match self.place(&from.state, &near) {
            Ok(found) if found.motions.amax() > AMPLIFIED => self.balance(&found.state),
            Ok(found) => Ok(found),
            Err(_) => {
                self.choose(&from.state)?;
                self.place(&from.state, &near)
            }
        }
    }

    /// Chooses independent coordinates at a configuration.
    fn choose(&mut self, state: &Mechanics) -> Result<(), Error> {
        self.independent = independent(state, &self.held)?;
        self.retraction = Retraction::new(&self.system, &self.independent, &state.inputs())?;
        Ok(())
    }

    /// Coordinates nearer to Φ = 0, with the derivatives of the last configuration, which cost no factorisation; the given ones if this fails.
    fn nearer(&self, from: &Mechanics, near: &[f64]) -> Result<Vec<f64>, Error> {
        let (mut q, mut last) = (near.to_vec(), f64::INFINITY);
        for _ in 0..MOST_CORRECTIONS {
            let Some(by) = self.retraction.correction(from.resting_at(&q)?.phi().as_slice()) else { break };
            if by.amax() < 0.5 * last {
                q.iter_mut().zip(by.iter()).for_each(|(q, by)| *q += by);
                last = by.amax();
            } else {
                return Ok(if last < CLOSE { q } else { near.to_vec() });
            }
        }
        Ok(q)
    }

    /// Evaluates the configuration near given coordinates with their independent ones.
    fn place(&mut self, from: &Mechanics, near: &[f64]) -> Result<Balance, Error> {
        let near = &self.nearer(from, near)?;
        let z: Vec<f64> = self.independent.iter().flat_map(|&i| [near[i], 0.0]).collect();
        self.retraction.place(&z, near, &from.inputs())?;
        let (state, motions) = (from.resting_at(self.retraction.q())?, self.retraction.motions());
        self.check_rest(&state)?;
        let none = vec![0.0; self.system.m()];
        let forces = DVector::from_vec(self.accelerations.right(&self.system, &state.view(&none), 0)?.v.clone());
        let lambda = self.retraction.reactions(&forces);
        let free = self.free(&state, &motions)?;
        let force = free.tr_mul(&forces);
        let stiffness = -free.tr_mul(&self.force_changes(&state, &lambda, [&free, &DMatrix::zeros(0, 0)])?);
        let independent = self.independent.clone();
        Ok(Balance { state, independent, motions, free, forces, force, stiffness, lambda })
    }

    /// P from the motions of free coordinates, by Cholesky factors of their mass matrix.
    fn free(&self, state: &Mechanics, motions: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
        let independent = &self.independent;
        let columns: Vec<usize> = (0..independent.len()).filter(|&c| !self.held.contains(&independent[c])).collect();
        let free = motions.select_columns(&columns);
        if free.ncols() == 0 {
            return Ok(free);
        }
        let mass = free.tr_mul(&(state.mass() * &free));
        // Masses of very different size belong to coordinates of different units.
        let scale = mass.diagonal().map(|mass| if mass > 0.0 { mass.sqrt().recip() } else { 1.0 });
        let scaled = DMatrix::from_fn(mass.nrows(), mass.ncols(), |i, j| mass[(i, j)] * scale[i] * scale[j]);
        let Some(factor) = scaled.cholesky() else {
            let none = vec![0.0; self.system.m()];
            let at = state.view(&none);
            let coordinates = columns.iter().map(|&c| self.system.coordinate_name(independent[c]).to_string()).collect();
            let unknown = Error::SingularMass { coordinates, time: at.t };
            return Err(Scaled::at(&self.system, &at).and_then(|here| here.explain(&self.system, &at)).unwrap_or(unknown));
        };
        let scaled = free * DMatrix::from_diagonal(&scale);
        let transposed = factor.l().solve_lower_triangular(&scaled.transpose());
        transposed.map(|of| of.transpose()).ok_or(Error::Overflow { what: "the mass matrix".into(), value: f64::NAN })
    }

    /// The changes of r − Φ_qᵀ λ along columns of changes of coordinates and velocities, either of which may be empty.
    pub(super) fn force_changes(
        &mut self,
        state: &Mechanics,
        lambda: &[f64],
        [q, v]: [&DMatrix<f64>; 2],
    ) -> Result<DMatrix<f64>, Error> {
        let (system, none) = (&self.system, vec![0.0; self.system.m()]);
        let (still, no_u, no_design) = (vec![0.0; system.n()], vec![0.0; system.k()], vec![0.0; system.parameters().len()]);
        let (at, x) = (state.view(&none), Pair { v: still.clone(), sigma: lambda.to_vec() });
        let count = q.ncols().max(v.ncols());
        let mut changes = DMatrix::zeros(system.n(), count);
        for j in 0..count {
            let column = |of: &DMatrix<f64>| {
                if j < of.ncols() { of.column(j).iter().copied().collect() } else { still.clone() }
            };
            let (q, v) = (column(q), column(v));
            let along = NodeView::of_equations([&q, &v, &none], (&no_u, 0.0, &no_design));
            changes.column_mut(j).copy_from_slice(&self.accelerations.changes(system, (&at, &along), &x).v);
        }
        let is_finite = changes.iter().all(|x| x.is_finite());
        let unknown = || Error::Overflow { what: "a derivative of a force".into(), value: f64::NAN };
        if is_finite { Ok(changes) } else { Err(system.find_not_finite(&at, 0).unwrap_or_else(unknown)) }
    }

    /// Returns an error if a constraint moves: Φ_t or Φ_tt is not zero.
    fn check_rest(&mut self, state: &Mechanics) -> Result<(), Error> {
        let (system, none, tolerance) = (&self.system, vec![0.0; self.system.m()], Settings::default().velocity_tolerance);
        let at = state.view(&none);
        let is_closed = |j: &usize| state.open().iter().all(|open| open.index() != *j);
        let second = &self.accelerations.right(system, &at, 0)?.sigma;
        let phi_t = state.phi_dot();
        let moving = |j: &usize| phi_t[*j].abs() > tolerance || second[*j].abs() > tolerance;
        match (0..system.m()).filter(is_closed).find(moving) {
            Some(j) => {
                // At rest, g = −Φ_tt.
                let rate = if phi_t[j].abs() > tolerance { phi_t[j] } else { -second[j] };
                Err(Error::MovingConstraint { equation: system.equation_name(j).to_string(), rate, time: at.t })
            }
            None => Ok(()),
        }
    }
}
