//! J and its gradient with the estimated errors of the grid added, beside a motion on a much finer grid.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Gradient, Grid, Inputs, Scheme, Settings, Sum, System, estimate, gradient};

/// The force is changed by functions that are linear between so many times.
const KNOTS: usize = 5;

/// A cart with links on a spring, with the final angles, the angle of the first link over time, and the effort as cost.
fn system(links: usize) -> System {
    let mut cart = CartPendulum::with_links(links).mechanism();
    let stiffness = cart.scene.design("stiffness", 20.0);
    let wall = Body::GROUND.at(-1.0, 0.0);
    cart.scene.spring_damper("spring", wall, cart.cart.at(0.0, 0.0), stiffness, 1.0, 0.0);
    let target = cart.scene.design("target", 1.0);
    let angle = cart.links[0].coordinates[2];
    cart.scene.cost("angle over time", AngleError, Sum::Integral, [angle], [], [], [target.into()]);
    cart.scene.effort("effort", cart.force, 1e-2);
    for (k, link) in cart.links.iter().enumerate() {
        let name = format!("angle {k}");
        cart.scene.cost(&name, AngleError, Sum::Terminal, [link.coordinates[2]], [], [], [0.5.into()]);
    }
    cart.scene.compile().expect("a scene")
}

/// The time after this share of the steps; the steps become longer by this factor from the first to the last.
fn time(share: f64, growth: f64) -> f64 {
    share * (2.0 + (growth - 1.0) * share) / (1.0 + growth)
}

/// A force that is linear in time, so that it is the same function on all grids.
fn inputs(system: &System, steps: usize, growth: f64) -> Inputs {
    let at = |n: usize| time(n as f64 / steps as f64, growth);
    let grid = Grid::new(0.0, (0..steps).map(|n| at(n + 1) - at(n)).collect());
    let mut inputs = Inputs::at_rest(system, grid);
    let times = inputs.grid.times();
    inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = 8.0 - 14.0 * t);
    inputs
}

/// The derivatives by numbers that are the same on all grids: design variables, the start, the force at its knots, and the lengths of two parts of the
/// motion.
fn numbers(of: &Gradient, inputs: &Inputs, growth: f64) -> Vec<f64> {
    let (times, steps) = (inputs.grid.times(), &inputs.grid.steps);
    let knots: Vec<f64> = (0..KNOTS).map(|k| time(k as f64 / (KNOTS - 1) as f64, growth)).collect();
    let hat = |k: usize, t: f64| {
        let up = k.checked_sub(1).map_or(1.0, |before| (t - knots[before]) / (knots[k] - knots[before]));
        let down = knots.get(k + 1).map_or(1.0, |next| (next - t) / (next - knots[k]));
        up.min(down).clamp(0.0, 1.0)
    };
    let of_knot = |k: usize| of.controls.iter().zip(&times).map(|(g, t)| g * hat(k, *t)).sum::<f64>();
    let of_length = |part: std::ops::Range<usize>| {
        let length: f64 = steps[part.clone()].iter().sum();
        part.map(|n| of.steps[n] * steps[n] / length).sum::<f64>()
    };
    let lengths = [of_length(0..steps.len() / 4), of_length(steps.len() / 4..steps.len())];
    let given = of.design.iter().chain(of.start.q()).chain(of.start.rate()).copied();
    given.chain((0..KNOTS).map(of_knot)).chain(lengths).collect()
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn corrected_values_have_a_higher_order() {
    let (rule, third) = (Scheme::TRAPEZOIDAL, Scheme::ESDIRK3);
    let cases = [(1, 1.0, rule), (2, 2.5, rule), (2, 2.5, third)];
    for (links, growth, scheme) in cases {
        let (system, settings) = (system(links), Settings { scheme, ..Settings::default() });
        let fine = inputs(&system, 3200, growth);
        let exact = gradient(&system, &fine, Settings { scheme: Scheme::ESDIRK5, ..settings }).expect("a motion");
        let all = numbers(&exact, &fine, growth);
        let mut last: Option<[f64; 3]> = None;
        for steps in [80, 160, 320] {
            let inputs = inputs(&system, steps, growth);
            let found = estimate(&system, &inputs, settings).expect("a motion");
            let corrected = found.corrected.as_ref().unwrap_or_else(|| panic!("{found}"));
            let of_gradient = |of: &Gradient| {
                norm(&numbers(of, &inputs, growth).iter().zip(&all).map(|(x, y)| x - y).collect::<Vec<_>>()) / norm(&all)
            };
            let of_value = |value: f64| (value / exact.value - 1.0).abs();
            let before = [of_value(found.value), of_gradient(&found.gradient)];
            // For the trapezoidal rule, the residuals correct J as well, without another motion.
            let by_residual = found.residual.map_or(corrected.value, |error| found.value + error);
            let after = [of_value(corrected.value), of_gradient(corrected), of_value(by_residual)];
            println!("{links} links, {}, {steps} steps: J and dJ off by {before:?}, corrected {after:?}", scheme.name);
            assert!(10.0 * after[0] < before[0] && 10.0 * after[1] < before[1] && 10.0 * after[2] < before[0]);
            if let Some(last) = last {
                let orders = [0, 1, 2].map(|k| f64::log2(last[k] / after[k]));
                println!("    orders of what remains {orders:.2?}");
                assert!(orders.iter().all(|order| *order > 3.7), "{orders:?}");
            }
            last = Some(after);
        }
    }
}
