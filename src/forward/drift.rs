//! Drift of positions from their constraints, checked at some nodes, so that a motion whose joints have opened causes a warning.
//!
//! dΦ/dt = 0 holds at every node to rounding, Φ = 0 only up to the quadrature error of dΦ/dt. Φ_j is compared with its lengths ℓ_j
//! (`node/lengths.rs`).

use super::monitor::Monitor;
use crate::motion::Motion;
use crate::node::Linearisation;
use crate::{Settings, System, Warning};

/// Besides the last node, nodes are checked whose numbers are powers of two, from this one on, so that the cost is negligible.
const FIRST: usize = 128;

impl Monitor {
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
        self.lengths.take_reach(motion, node);
        self.lengths.phi.fill(0.0);
        system.phi(&motion.at(node), &mut self.lengths.phi);
        motion.open_from(node).chain(system.held()).for_each(|j| self.lengths.phi[j] = 0.0);
        let size = |phi: f64| if phi.is_nan() { f64::INFINITY } else { phi.abs() };
        // A violation that is allowed at the start is not drift.
        let violation = |phi: f64| if size(phi) > settings.position_tolerance { size(phi) } else { 0.0 };
        self.lengths.phi.iter_mut().for_each(|phi| *phi = violation(*phi));
        self.lengths.measure(system, motion, linearisation, node);
        let violated =
            self.lengths.phi.iter().zip(&self.lengths.of_equations).enumerate().filter(|(_, (phi, _))| **phi > 0.0);
        // An infinite violation counts even if the length is infinite.
        let share = |phi: f64, length: f64| if phi.is_finite() { phi / length } else { phi };
        let worst =
            violated.map(|(j, (&phi, &length))| (j, phi, share(phi, length))).max_by(|(.., a), (.., b)| a.total_cmp(b));
        if let Some((j, violation, share)) = worst.filter(|(_, _, share)| *share > Warning::DRIFT) {
            self.warn_of_drift(system, motion, node, j, violation, share);
        }
    }

    fn warn_of_drift(&mut self, system: &System, motion: &Motion, node: usize, j: usize, violation: f64, share: f64) {
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
