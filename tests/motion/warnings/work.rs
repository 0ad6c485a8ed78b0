//! Which scheme reaches a gradient of some accuracy with the least work, on random smooth motions of 0.8 to 2 s, with controls that are linear between
//! nodes.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Scheme, Settings, gradient};

use super::motion::Motion;
use super::smooth;

/// Numbers of steps, in units of the coarsest grid.
const STEPS: [usize; 13] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96];
const COARSEST: usize = 8;
const FINEST: usize = 512;

#[test]
fn the_trapezoidal_rule_needs_the_least_work_if_controls_are_given_at_nodes() {
    let tolerances = [1e-1, 1e-2, 1e-3];
    // For each tolerance and scheme, the numbers of steps, and of solved stages relative to those of the trapezoidal rule.
    let mut steps = vec![vec![Vec::new(); Scheme::ALL.len()]; tolerances.len()];
    let mut work = steps.iter().map(|all| all.iter().map(|_| Vec::<f64>::new()).collect::<Vec<_>>()).collect::<Vec<_>>();
    for seed in 0..40 {
        let mut random = Random::new(1000 + seed);
        let (masses, duration) = (1 + random.below(3), random.uniform(0.8, 2.0));
        let element = smooth(&mut random, seed as usize);
        let mut motion = Motion::new(&mut random, masses, vec![element], duration, COARSEST);
        let with = |motion: &Motion, scheme: Scheme, steps: usize| {
            let inputs = motion.inputs(steps);
            let found = gradient(&motion.system, &inputs, Settings { scheme, ..motion.settings }).ok()?;
            Some(motion.numbers(&inputs, &found))
        };
        motion.settings.scheme = Scheme::TRAPEZOIDAL;
        let Some(exact) = with(&motion, Scheme::ESDIRK5, FINEST) else { continue };
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = |x: &[f64]| norm(&x.iter().zip(&exact).map(|(x, y)| x - y).collect::<Vec<_>>()) / norm(&exact);
        let errors: Vec<Vec<f64>> = Scheme::ALL
            .iter()
            .map(|&scheme| STEPS.iter().map(|&k| with(&motion, scheme, k).map_or(f64::INFINITY, |x| apart(&x))).collect())
            .collect();
        for (t, tolerance) in tolerances.iter().enumerate() {
            // From there on, all finer grids are as good.
            let needed = |errors: &[f64]| {
                let bad = errors.iter().rposition(|error| error > tolerance).map_or(0, |bad| bad + 1);
                STEPS.get(bad).map_or(f64::INFINITY, |k| (k * COARSEST) as f64)
            };
            let all: Vec<f64> = errors.iter().map(|errors| needed(errors)).collect();
            for (s, scheme) in Scheme::ALL.iter().enumerate() {
                steps[t][s].push(all[s]);
                work[t][s].push(all[s] * scheme.stages() as f64 / all[0]);
            }
        }
    }
    let median = |x: &[f64]| {
        let mut sorted = x.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    for (t, tolerance) in tolerances.iter().enumerate() {
        for (s, scheme) in Scheme::ALL.iter().enumerate() {
            let (steps, work) = (median(&steps[t][s]), median(&work[t][s]));
            println!("{tolerance:e} by {}: {steps} steps, {work:.2} times the work", scheme.name);
            assert!(s == 0 || work > 1.2, "{}", scheme.name);
        }
    }
    assert!(steps[0][0].len() > 30);
}
