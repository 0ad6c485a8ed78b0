//! A restart in numbers of type R, near the real one.

use super::super::{Lifted, OnNumbers};
use crate::Error;
use crate::motion::{Restart, column};
use crate::node::{MOST_CORRECTIONS_OF_PROJECTION, SETTLED, Shrinking, Size, add_correction, diverged, overflow};
use crate::number::Real;
use crate::system::NodeView;

/// A correction larger than this fraction of the previous one no longer shrinks: those of slow projections that converge shrink by a third.
const SHRINKING: f64 = 0.75;
const WHAT: &str = "the complex or dual part of the projection onto Φ = 0";

impl<R: Real> OnNumbers<R> for Restart {
    /// Φ = 0 and T_v as in the real motion.
    fn reset(&self, mut of: Lifted<R>) -> Result<(), Error> {
        if let Some(point) = self.numbers(&of.happened).projection {
            project(&mut of, point.sigma)?;
        }
        let Lifted { system, trajectory, end, after, sums, .. } = of;
        let ends = column(&trajectory.sigma, self.before).iter().zip(end.sigma);
        after.sigma.iter_mut().zip(ends).for_each(|(s, (before, now))| *s = self.begin(*before, *now));
        system.plain_sums(&NodeView { q: after.q, sigma: after.sigma, ..end }, sums);
        after.p_star.copy_from_slice(sums.l_v());
        Ok(())
    }
}

/// 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0 for q = q⁻ + w, starting from the real solution, by corrections with K(0).
fn project<R: Real>(of: &mut Lifted<R>, nu: &[f64]) -> Result<(), Error> {
    let Lifted {
        system,
        motion,
        happened,
        linearisation,
        report,
        end,
        after,
        sums,
        part: correction_of,
        unit,
        rounding,
        ..
    } = of;
    let node = happened.node;
    after.q.iter_mut().zip(motion.at(node).q).for_each(|(q, &real)| *q = real.into());
    let mut nu: Vec<R> = nu.iter().map(|&nu| nu.into()).collect();
    let mut w: Vec<R> = after.q.iter().zip(end.q).map(|(&q, &before)| q - before).collect();
    let mut phi = vec![R::zero(); nu.len()];
    linearisation.evaluation.set_compliance(&motion.compliance_of_projection(system, node));
    let factored = linearisation.factor(system, 0.0, motion.node_blocks(node), report);
    factored.map_err(|breakdown| system.singular_step(&breakdown, motion.step_of_whole(node), motion.time(node)))?;
    let mut sizes = vec![Shrinking::new(); R::PARTS];
    for correction in 0..MOST_CORRECTIONS_OF_PROJECTION {
        let at = NodeView { q: after.q, v: &w, sigma: &nu, ..*end };
        system.plain_sums(&at, sums);
        system.phi_on(&at, &mut phi);
        for &(j, mu) in linearisation.evaluation.compliance() {
            phi[j] -= nu[j] * mu;
        }
        let mut done = true;
        for (part, sizes) in sizes.iter_mut().enumerate() {
            correction_of.v.iter_mut().zip(sums.l_v()).for_each(|(r, l_v)| *r = -l_v.part(part));
            correction_of.sigma.iter_mut().zip(&phi).for_each(|(r, phi)| *r = -phi.part(part));
            linearisation.solve(system, correction_of);
            let size = add_correction(after.q, part, &correction_of.v, (0.0, unit[part]));
            let size = size.ok_or_else(|| overflow(motion, node, WHAT))?.of_all;
            w.iter_mut().zip(&correction_of.v).for_each(|(w, &delta)| w.add_to_part(part, delta));
            nu.iter_mut().zip(&correction_of.sigma).for_each(|(nu, &delta)| nu.add_to_part(part, delta));
            // An input in much larger units may determine the perturbation; corrections that still shrink by a third are not rounding error.
            let shrinks = size < SHRINKING * sizes.last && correction + 1 < MOST_CORRECTIONS_OF_PROJECTION;
            let is_stalled = sizes.is_stalled(Size { of_part: size, of_all: f64::INFINITY });
            done &= correction > 0 && (size <= SETTLED && !shrinks || is_stalled);
        }
        if done {
            **rounding = sizes.iter().fold(**rounding, |rounding, sizes| rounding.max(sizes.last));
            return Ok(());
        }
    }
    let last = sizes.iter().fold(0.0, |most, sizes| sizes.last.max(most));
    Err(diverged(motion, node, (MOST_CORRECTIONS_OF_PROJECTION, last), WHAT))
}
