//! The lengths in position constraints, with which their violations are compared.
//!
//! They have the unit of Φ_j for any choice of units and do not depend on the position of the mechanism:
//!
//! ```text
//!   Φ_j = … + α₁ sin q₁ + β₁ cos q₁ + …      ℓ_j = Σ √(α² + β²)                     (hinges: the distances from the centres of mass)
//!   any other                                ℓ_j = Σ |∂Φ_j/∂q_i| w_i,  w_i = 1 rad for angles, the largest |q_i| so far for the rest
//! ```

use super::linearisation::Linearisation;
use crate::System;
use crate::motion::{Motion, column};
use crate::number::larger;

/// The largest coordinates are updated once in this number of nodes, and at nodes at which Φ is checked.
const REACH_EVERY: usize = 8;

/// Φ of a node, and the lengths with which it is compared.
pub(crate) struct Lengths {
    pub(crate) phi: Vec<f64>,
    pub(crate) of_equations: Vec<f64>,
    /// The largest |q_i| up to the last node; empty if no length needs it.
    pub(crate) reach: Vec<f64>,
}

impl Lengths {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Lengths { phi: vec![0.0; m], of_equations: vec![0.0; m], reach: Vec::with_capacity(n) }
    }

    /// Prepares for a motion whose largest coordinates are not known yet.
    pub(crate) fn begin(&mut self, system: &System, linearisation: &Linearisation) {
        self.measure_sinusoidal(linearisation);
        self.reach.clear();
        if self.of_equations.contains(&0.0) {
            self.reach.resize(system.n(), 0.0);
        }
    }

    /// Includes the coordinates of a node in the largest ones, for the first nodes and one in `REACH_EVERY`.
    #[inline]
    pub(crate) fn watch_reach(&mut self, motion: &Motion, node: usize) {
        if node < REACH_EVERY || node.is_multiple_of(REACH_EVERY) {
            self.take_reach(motion, node);
        }
    }

    #[inline(never)]
    pub(crate) fn take_reach(&mut self, motion: &Motion, node: usize) {
        let q = column(&motion.trajectory.q, node - motion.first);
        self.reach.iter_mut().zip(q).for_each(|(reach, q)| *reach = larger(*reach, q.abs()));
    }

    /// Computes ℓ of the violated equations.
    pub(crate) fn measure(&mut self, system: &System, motion: &Motion, linearisation: &Linearisation, node: usize) {
        self.measure_sinusoidal(linearisation);
        if self.phi.iter().zip(&self.of_equations).any(|(phi, length)| *phi != 0.0 && *length == 0.0) {
            self.measure_others(system, motion, node);
        }
    }

    /// Computes ℓ of the sinusoidal equations, and zero for the others.
    fn measure_sinusoidal(&mut self, linearisation: &Linearisation) {
        self.of_equations.fill(0.0);
        let waves = &linearisation.evaluation.constants.waves;
        waves.iter().for_each(|wave| self.of_equations[wave.equation] += wave.sine.hypot(wave.cosine));
    }

    /// Computes ℓ of the equations that are not sinusoidal, with Φ_q at a node.
    fn measure_others(&mut self, system: &System, motion: &Motion, node: usize) {
        let is_sinusoidal: Vec<bool> = self.of_equations.iter().map(|length| *length > 0.0).collect();
        let reach = &self.reach;
        let of_coordinate = |i: usize| if system.sines().coordinates().any(|angle| angle == i) { 1.0 } else { reach[i] };
        for entry in system.phi_q(&motion.at(node)).into_iter().filter(|entry| !is_sinusoidal[entry.row]) {
            self.of_equations[entry.row] += entry.value.abs() * of_coordinate(entry.col);
        }
    }
}
