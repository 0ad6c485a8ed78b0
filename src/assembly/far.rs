//! The coordinates of a start far from its guess, where Newton's method does not converge: steps in a metric with the curvature of the constraints,
//!
//! ```text
//!   [M + |diag D|  Φ_qᵀ; Φ_q  −C] (δ, ν⁺) = −(M w, Φ)        w ← w + s δ,   ν ← ν + s (ν⁺ − ν),   s |δ_φ| ≤ ½ rad
//! ```
//!
//! with D of [`Tangent`] and compliances C of the loops. In the metric of M alone, a chain of many short rods would turn some of them by several
//! radians and leave the others; in this metric the multipliers ν keep neighbours together, like tension in a rope. The steps end where the equations
//! for w and ν are satisfied; Newton's method then converges to this point. If loops cannot close, C → 0 leaves them open by as little as possible.

use super::assembler::Assembler;
use super::coordinates::SOFTEST;
use super::equations::sum;
use super::tangent::Tangent;
use crate::Error;
use crate::motion::Which;
use crate::number::larger;
use crate::system::{Given, Pair};

const MOST_STEPS: usize = 400;
/// Largest rotation of an angle in a step, rad.
const MOST_TURN: f64 = 0.5;
/// After a full step below this fraction of w, Newton's method is tried …
const SHORT: f64 = 1e-2;
/// … and again when the steps have decreased by this factor.
const SHORTER: f64 = 0.3;
/// The result of Newton's method is accepted if it changes w by no more than this fraction.
const CLOSE: f64 = 0.1;
/// If a loop stops closing, with steps below this fraction of w, its compliance is reduced …
const SETTLED: f64 = 1e-3;
/// … down to this one, relative to its own flexibility.
const STIFFEST: f64 = 1e-9;

impl Assembler<'_> {
    /// Solves for w and ν, starting from w = 0.
    pub(super) fn come_from_far(
        &mut self,
        (q, held): (&[f64], &[usize]),
        moved: &mut Pair,
        given: Given,
    ) -> Result<(), Error> {
        let zeros = moved.clone();
        let (mut left, mut sizes) = (zeros.clone(), None);
        let (mut to_try, mut softest, mut last) = (SHORT, SOFTEST, f64::INFINITY);
        for _ in 0..MOST_STEPS {
            let q0 = sum(q, &moved.v);
            let [at, from] = [given.at(&q0, &moved.v, &moved.sigma), given.at(&q0, &zeros.v, &zeros.sigma)];
            left.sigma = self.phi(q, &moved.v, given);
            let (unmoved, momentum) = (self.l_v(&from), self.l_v(&given.at(&q0, &moved.v, &zeros.sigma)));
            left.v.iter_mut().zip(momentum.iter().zip(&unmoved)).for_each(|(left, (p, from))| *left = p - from);
            let sizes = &*sizes.get_or_insert_with(|| self.sizes(q, &from));
            let violation = sizes.violation(&left.sigma);
            let soft = sizes.soft(self.system, violation, softest);
            let tangent = Tangent::new(self, Which::Coordinates, [&at, &from], held, &soft)?;
            tangent.step(self.system, self.linearisation, &mut left);
            let turn = self.system.sines().coordinates().fold(0.0, |turn, i| larger(turn, left.v[i].abs()));
            let share = if turn > MOST_TURN { MOST_TURN / turn } else { 1.0 };
            moved.v.iter_mut().zip(&left.v).for_each(|(w, delta)| *w -= share * delta);
            moved.sigma.iter_mut().zip(&left.sigma).for_each(|(nu, next)| *nu -= share * (*nu + next));
            let (step, size) = (self.linearisation.size_of(&left.v), self.linearisation.size_of(&moved.v));
            if share == 1.0 && step <= to_try * size {
                to_try = SHORTER * step / size;
                let mut near = moved.clone();
                let found = self.approach((q, held), &mut near, given, softest).is_ok();
                let change: Vec<f64> = near.v.iter().zip(&moved.v).map(|(near, w)| near - w).collect();
                if found && self.linearisation.size_of(&change) <= CLOSE * size {
                    *moved = near;
                    return Ok(());
                }
            }
            if share == 1.0 && step <= SETTLED * size && violation >= 0.9 * last {
                softest *= 0.01;
                if softest < STIFFEST {
                    break;
                }
            }
            last = violation;
        }
        self.see_that_it_closes((q, held), &moved.v, given)?;
        Err(Error::AssemblyStalled { correction: left.v.iter().fold(0.0, |most, delta| larger(most, delta.abs())) })
    }
}
