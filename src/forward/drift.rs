//! Drift of positions from their constraints, checked at some nodes, so that a motion whose joints have opened causes a warning.
//!
//! dΦ/dt = 0 holds at every node to rounding, Φ = 0 only up to the quadrature error of dΦ/dt. Φ_j is compared with its lengths ℓ_j, which have its
//! unit for any choice of units and do not depend on the position of the mechanism:
//!
//! ```text
//!   Φ_j = … + α₁ sin q₁ + β₁ cos q₁ + …      ℓ_j = Σ √(α² + β²)                     (hinges: the distances from the centres of mass)
//!   any other                                ℓ_j = Σ |∂Φ_j/∂q_i| w_i,  w_i = 1 rad for angles, the largest |q_i| so far for the rest
//! ```

use super::monitor::Monitor;
use crate::motion::{Motion, column};
use crate::node::Linearisation;
use crate::number::larger;
use crate::{Settings, System, Warning};

/// Besides the last node, nodes are checked whose numbers are powers of two, from this one on, so that the cost is negligible.
const FIRST: usize = 128;
/// The largest coordinates are updated once in this number of nodes, and at nodes at which Φ is checked.
const REACH_EVERY: usize = 8;

impl Monitor {
    /// Includes the coordinates of a node in the largest ones, for the first nodes and one in `REACH_EVERY`.
    #[inline]
    pub(super) fn watch_reach(&mut self, motion: &Motion, node: usize) {
        if node < REACH_EVERY || node.is_multiple_of(REACH_EVERY) {
            self.take_reach(motion, node);
        }
    }

    #[inline(never)]
    fn take_reach(&mut self, motion: &Motion, node: usize) {
        let q = column(&motion.trajectory.q, node - motion.first);
        self.reach.iter_mut().zip(q).for_each(|(reach, q)| *reach = larger(*reach, q.abs()));
    }

    /// Prepares for a motion whose largest coordinates are not known yet.
    pub(crate) fn begin(&mut self, system: &System, linearisation: &Linearisation) {
        self.measure_sinusoidal(linearisation);
        self.reach.clear();
        if self.lengths.contains(&0.0) {
            self.reach.resize(system.n(), 0.0);
        }
    }

    /// Compares Φ with the lengths in the constraints, at the last node and some others, and keeps the worst warning.
    #[inline]
    pub(crate) fn watch_drift(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &Linearisation,
        node: usize,
        settings: &Settings,
    ) {
        let is_last = node + 1 == motion.nodes();
        if (is_last || node >= FIRST && node.is_power_of_two()) && system.m() > 0 {
            self.measure_drift(system, motion, linearisation, node, settings);
        }
    }

    // Rare, and therefore not part of the loop over the steps.
    #[cold]
    #[inline(never)]
    fn measure_drift(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &Linearisation,
        node: usize,
        settings: &Settings,
    ) {
        self.take_reach(motion, node);
        self.phi.fill(0.0);
        system.phi(&motion.at(node), &mut self.phi);
        let size = |phi: f64| if phi.is_nan() { f64::INFINITY } else { phi.abs() };
        // A violation that is allowed at the start is not drift.
        let violation = |phi: f64| if size(phi) > settings.position_tolerance { size(phi) } else { 0.0 };
        self.phi.iter_mut().for_each(|phi| *phi = violation(*phi));
        self.measure_lengths(system, motion, linearisation, node);
        let violated = self.phi.iter().zip(&self.lengths).enumerate().filter(|(_, (phi, _))| **phi > 0.0);
        // An infinite violation counts even if the length is infinite.
        let share = |phi: f64, length: f64| if phi.is_finite() { phi / length } else { phi };
        let worst = violated.map(|(j, (&phi, &length))| (j, phi, share(phi, length))).max_by(|a, b| a.2.total_cmp(&b.2));
        if let Some(worst) = worst.filter(|(_, _, share)| *share > Warning::DRIFT) {
            self.warn_of_drift(system, motion, node, worst);
        }
    }

    /// Computes ℓ of the violated equations.
    pub(crate) fn measure_lengths(&mut self, system: &System, motion: &Motion, linearisation: &Linearisation, node: usize) {
        self.measure_sinusoidal(linearisation);
        if self.phi.iter().zip(&self.lengths).any(|(phi, length)| *phi != 0.0 && *length == 0.0) {
            self.measure_other_lengths(system, motion, node);
        }
    }

    /// Computes ℓ of the sinusoidal equations, and zero for the others.
    fn measure_sinusoidal(&mut self, linearisation: &Linearisation) {
        self.lengths.fill(0.0);
        let waves = &linearisation.evaluation.constants.waves;
        waves.iter().for_each(|wave| self.lengths[wave.equation] += wave.sine.hypot(wave.cosine));
    }

    /// Computes ℓ of the equations that are not sinusoidal, with Φ_q at a node.
    fn measure_other_lengths(&mut self, system: &System, motion: &Motion, node: usize) {
        let is_sinusoidal: Vec<bool> = self.lengths.iter().map(|length| *length > 0.0).collect();
        let reach = &self.reach;
        let of_coordinate = |i: usize| if system.sines().coordinates().any(|angle| angle == i) { 1.0 } else { reach[i] };
        for entry in system.phi_q(&motion.at(node)).into_iter().filter(|entry| !is_sinusoidal[entry.row]) {
            self.lengths[entry.row] += entry.value.abs() * of_coordinate(entry.col);
        }
    }

    fn warn_of_drift(&mut self, system: &System, motion: &Motion, node: usize, (j, violation, share): (usize, f64, f64)) {
        let before = self.report.warnings.iter().find_map(|warning| match warning {
            Warning::Drift { step, time, share, .. } => Some((*step, *time, *share)),
            _ => None,
        });
        if before.is_some_and(|(.., before)| before >= share) {
            return;
        }
        let here = || (motion.step_of_whole(node), motion.time(node));
        let (step, time) = before.map_or_else(here, |(step, time, _)| (step, time));
        let equation = system.equation_name(j).to_string();
        self.report.replace(Warning::Drift { equation, violation, share, step, time });
    }
}
