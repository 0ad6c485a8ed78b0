//! [`Region`]: the radius within which steps are computed, and the function φ = f + barrier + ν ‖C‖ by which they are judged.

use super::Step;

/// Steps are accepted if φ decreases by at least this fraction of the prediction.
const ACCEPTED: f64 = 1e-8;
/// Length of the shortest step that is tried, in scaled variables.
const LEAST: f64 = 1e-13;
/// The predicted decrease of φ must be at least this fraction of that of ν ‖C‖.
const SHARE: f64 = 0.3;
/// Differences of φ below this fraction of it are rounding error.
pub(in super::super) const ROUNDING: f64 = 1e-14;
/// Largest number of corrections for the curvature of the constraints.
pub(in super::super) const CORRECTIONS: usize = 3;
/// Corrections end if one of them leaves more than this fraction of the violation.
pub(in super::super) const TAKEN_BACK: f64 = 0.5;

/// The radius of a trust region, and the penalty ν.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Region {
    pub(in super::super) radius: f64,
    pub(in super::super) penalty: f64,
}

impl Region {
    /// Sets a penalty that exceeds the multipliers, given their norm; without multipliers any positive penalty suffices.
    pub(in super::super) fn raise_penalty(&mut self, multipliers: f64) {
        if multipliers > 0.0 && !(1.1 * multipliers..=10.0 * multipliers).contains(&self.penalty) {
            self.penalty = 2.0 * multipliers;
        } else if self.penalty == 0.0 {
            self.penalty = 1.0;
        }
    }

    /// The predicted decrease of φ. ν is increased until the decrease of the violation is a sufficient part of it.
    pub(in super::super) fn predict(&mut self, step: &Step) -> f64 {
        if step.closer > 0.0 && step.model + self.penalty * step.closer < SHARE * self.penalty * step.closer {
            self.penalty = -step.model / ((1.0 - SHARE) * step.closer);
        }
        step.model + self.penalty * step.closer.max(0.0)
    }

    /// The decrease from φ `here` to φ `there`, relative to the prediction.
    pub(in super::super) fn ratio(here: f64, there: f64, foreseen: f64) -> f64 {
        let (fallen, rounding) = (here - there, ROUNDING * here.abs());
        match foreseen <= rounding {
            true if fallen.abs() <= rounding => 1.0,
            // A decrease is not accepted where an increase was predicted.
            _ if foreseen <= 0.0 => f64::NEG_INFINITY,
            _ => fallen / foreseen,
        }
    }

    /// True if a step with this ratio is accepted.
    pub(in super::super) fn accepts(ratio: f64) -> bool {
        ratio >= ACCEPTED
    }

    /// True if a step of this length is tried.
    pub(in super::super) fn is_long_enough(step: &Step) -> bool {
        step.length > LEAST
    }

    /// Increases the radius after an accepted step that the model predicted well.
    pub(in super::super) fn grow(&mut self, ratio: f64, length: f64) {
        self.radius = match ratio {
            _ if ratio >= 0.9 => self.radius.max(3.0 * length),
            _ if ratio >= 0.3 => self.radius.max(2.0 * length),
            _ => self.radius,
        };
    }

    /// Reduces the radius after a rejected step.
    pub(in super::super) fn shrink(&mut self, ratio: f64, length: f64) {
        let shorter = if ratio.is_finite() { (0.5 / (1.0 - ratio)).clamp(0.1, 0.5) } else { 0.1 };
        self.radius = shorter * length.min(self.radius);
    }
}
