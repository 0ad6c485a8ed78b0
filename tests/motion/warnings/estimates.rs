//! Error estimates of random motions, beside a motion with many more steps.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Scheme, Settings, Warning, estimate, gradient};

use super::elements::Element;
use super::motion::{Motion, between};
use super::{sharp, smooth};

/// A gradient whose error is below this is resolved, and one above the other is not.
const RESOLVED: f64 = 0.05;
const UNRESOLVED: f64 = 0.3;

#[test]
fn errors_lie_within_their_estimates_and_what_is_not_resolved_has_none() {
    let (mut within, mut within_gradient, mut trusted, mut resolved) = (0, 0, 0, 0);
    let (mut unresolved, mut lulled, mut ratios) = (0, 0, Vec::new());
    let (mut coarse, mut of_default, mut warned) = ([0; 3], [0; 3], [0; 3]);
    let (mut trusted_smooth, mut corrected, mut closer, mut gains) = (0, 0, [0; 2], Vec::new());
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let (masses, duration) = (1 + random.below(3), random.uniform(0.8, 2.0));
        // What lies between two nodes and is zero at all of them cannot be known.
        let is_seen = |element: &Element| !matches!(element, Element::Well { .. } | Element::Pulse { .. });
        let seen: Vec<Element> = sharp().into_iter().filter(is_seen).collect();
        let element = if seed % 3 == 0 { seen[random.below(seen.len())] } else { smooth(&mut random, seed as usize) };
        let steps = (duration / between(&mut random, 2e-3, 5e-2)) as usize;
        let mut motion = Motion::new(&mut random, masses, vec![element], duration, steps);
        motion.settings.scheme =
            [Scheme::TRAPEZOIDAL, Scheme::TRAPEZOIDAL, Scheme::ESDIRK4, Scheme::ESDIRK3][seed as usize % 4];
        let inputs = motion.inputs(1);
        let fine = motion.inputs(16);
        let accurate = Settings { scheme: Scheme::ESDIRK5, ..motion.settings };
        let (Ok(found), Ok(truth)) =
            (estimate(&motion.system, &inputs, motion.settings), gradient(&motion.system, &fine, accurate))
        else {
            continue;
        };
        let best = |of: &hamiltonian_adjoint::Gradient| of.frozen.as_deref().unwrap_or(of).clone();
        let (own, exact) = (motion.numbers(&inputs, &best(&found.gradient)), motion.numbers(&fine, &best(&truth)));
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = |x: &[f64]| norm(&x.iter().zip(&exact).map(|(x, y)| x - y).collect::<Vec<_>>()) / norm(&exact);
        let error = apart(&own);
        let error_of_value = (found.value - truth.value).abs();
        let line = format!(
            "{seed} {:?}, {steps} steps, {}: J off by {error_of_value:.1e}, gradient by {error:.1e}; {found}",
            motion.what, motion.settings.scheme.name
        );
        let is_smooth = found.gradient.frozen.is_none();
        let is_coarse = found.gradient.warnings.iter().any(|warning| matches!(warning, Warning::CoarseSteps { .. }));
        let kind = if error < 0.01 { 0 } else { 1 + usize::from(error > UNRESOLVED) };
        coarse[kind] += usize::from(is_coarse);
        if motion.settings.scheme == Scheme::TRAPEZOIDAL {
            of_default[kind] += 1;
            warned[kind] += usize::from(!found.gradient.warnings.is_empty());
        }
        let estimates = found.uncertainty.zip(found.gradient_uncertainty);
        assert!(found.corrected.is_none() || is_smooth && found.withdrawn.is_none(), "{line}");
        trusted_smooth += usize::from(is_smooth && found.withdrawn.is_none());
        if let Some(other) = &found.corrected {
            let other_error = apart(&motion.numbers(&inputs, other));
            corrected += 1;
            closer[0] += usize::from((other.value - truth.value).abs() < error_of_value);
            closer[1] += usize::from(other_error < error);
            gains.push(error / other_error);
        }
        if error < RESOLVED {
            resolved += 1;
            if let Some((of_value, of_gradient)) = estimates {
                trusted += 1;
                within += usize::from(error_of_value <= of_value);
                within_gradient += usize::from(error <= of_gradient);
                ratios.push(error / of_gradient);
                if error > of_gradient || error_of_value > of_value {
                    println!("OUTSIDE {line}");
                }
            } else {
                println!("NONE {line}");
            }
        } else if error > UNRESOLVED {
            unresolved += 1;
            if estimates.is_some_and(|(_, of_gradient)| of_gradient < 0.1) {
                lulled += 1;
                println!("LULLED {line}");
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "resolved {resolved}, with estimates {trusted}: J within {within}, gradient within {within_gradient}; not resolved {unresolved}, with an estimate below 10 % {lulled}; median error/estimate {:?}",
        ratios.get(ratios.len() / 2)
    );
    // For errors below 1 %, up to 30 % and above.
    println!("coarse steps {coarse:?}; of the default scheme {of_default:?}, with any warning {warned:?}");
    assert!(coarse[0] <= 4 && coarse[2] >= 5 && 10 * warned[2] >= 9 * of_default[2]);
    gains.sort_by(f64::total_cmp);
    println!(
        "smooth with estimates {trusted_smooth}, corrected {corrected}: J closer {}, gradient {}, median gain {:?}",
        closer[0],
        closer[1],
        gains.get(gains.len() / 2)
    );
    assert!(resolved > 150 && 10 * trusted > 7 * resolved);
    assert!(100 * within >= 95 * trusted && 10 * within_gradient >= 9 * trusted);
    assert!(corrected > 150 && closer.iter().all(|closer| 10 * closer > 9 * corrected));
    assert!(unresolved > 30 && 20 * lulled <= unresolved);
}
