//! [`Levels`]: the differences of J and of its gradient between the given grid, every second, and every fourth of its nodes.

use crate::adjoint::Gradient;
use crate::{Error, Grid, Inputs, Occurrence, Solver};

/// Differences between the given grid and every second node, and between these and every fourth.
pub(super) struct Levels {
    /// Of J, with sign: the finer minus the coarser.
    pub(super) of_value: [f64; 2],
    /// Of the gradient, relative to it.
    pub(super) of_gradient: [f64; 2],
    /// Of the derivatives by the design variables, q₀, and v₀ or p*₀: the larger of the first difference and the second one over 2ᵖ.
    pub(super) of_derivatives: Vec<f64>,
    /// J and its gradient, extrapolated from the given grid and every second node; `None` if kinks lie between nodes.
    pub(super) extrapolated: Option<Gradient>,
}

impl Levels {
    /// From the gradient on the given grid. The solver computes those on the coarser ones.
    pub(super) fn new(
        solver: &mut Solver,
        inputs: &Inputs,
        fine: &Gradient,
        coarse: &[Inputs; 2],
        decrease: f64,
    ) -> Result<Self, Error> {
        let [second, fourth] = coarse;
        let mut gradient = |inputs: &Inputs| {
            solver.simulate(inputs)?;
            solver.gradient().cloned()
        };
        let (middle, last) = (gradient(second)?, gradient(fourth)?);
        let effects = |of: &Gradient, on: &Inputs| effects(inputs, best(of), on);
        let all = [effects(fine, inputs), effects(&middle, second), effects(&last, fourth)];
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart = |x: &[f64], y: &[f64]| norm(&x.iter().zip(y).map(|(x, y)| x - y).collect::<Vec<_>>());
        let size = norm(&all[0]).max(f64::MIN_POSITIVE);
        let singles = [fine, &middle, &last].map(|of| derivatives(best(of)));
        let of_one = |k: usize| {
            let [near, far] = [singles[0][k] - singles[1][k], singles[1][k] - singles[2][k]].map(f64::abs);
            near.max(far / decrease)
        };
        let is_smooth = !inputs.has_knots() && [fine, &middle].iter().all(|of| of.frozen.is_none());
        Ok(Levels {
            extrapolated: is_smooth.then(|| extrapolated(fine, &middle, &inputs.grid.steps, 1.0 / (decrease - 1.0))),
            of_derivatives: (0..singles[0].len()).map(of_one).collect(),
            of_value: [fine.value - middle.value, middle.value - last.value],
            of_gradient: [apart(&all[0], &all[1]) / size, apart(&all[1], &all[2]) / size],
        })
    }
}

/// The gradient at frozen grid phase, if there is one.
pub(super) fn best(gradient: &Gradient) -> &Gradient {
    gradient.frozen.as_deref().unwrap_or(gradient)
}

/// The derivatives by the design variables, q₀, and v₀ or p*₀.
pub(super) fn derivatives(of: &Gradient) -> Vec<f64> {
    [&of.design, of.start.q(), of.start.rate()].into_iter().flat_map(|list| list.iter().copied()).collect()
}

/// J and its gradient, with the error that follows from the difference to those on every second node: the difference times `share`.
fn extrapolated(fine: &Gradient, coarse: &Gradient, steps: &[f64], share: f64) -> Gradient {
    let mut sum = fine.clone();
    sum.value += share * (fine.value - coarse.value);
    sum.design += (&fine.design - &coarse.design) * share;
    *sum.start.q_mut() += (fine.start.q() - coarse.start.q()) * share;
    *sum.start.rate_mut() += (fine.start.rate() - coarse.start.rate()) * share;
    let kept = kept_nodes(steps);
    for (pair, of_both) in kept.windows(2).zip(&coarse.steps) {
        let (of_pair, lengths) = (&mut sum.steps[pair[0]..pair[1]], &steps[pair[0]..pair[1]]);
        let length = lengths.iter().sum::<f64>();
        let part = |dt: f64| if length == 0.0 { 1.0 } else { dt / length };
        let together: f64 = of_pair.iter().zip(lengths).map(|(of, &dt)| of * part(dt)).sum();
        of_pair.iter_mut().for_each(|of| *of += share * (together - of_both));
    }
    for channel in 0..fine.controls.nrows() {
        let row = |of: &Gradient| of.controls.row(channel).iter().copied().collect::<Vec<f64>>();
        let errors = errors_of_control((&row(fine), &row(coarse)), steps, &kept);
        sum.controls.row_mut(channel).iter_mut().zip(errors).for_each(|(of, error)| *of += share * error);
    }
    sum
}

/// The differences of the derivatives by one control, at all nodes. Along a control that is linear between every second node, they add up to the
/// difference of both derivatives.
fn errors_of_control((fine, coarse): (&[f64], &[f64]), steps: &[f64], kept: &[usize]) -> Vec<f64> {
    let between = || kept.windows(2).filter(|pair| pair[0] + 1 < pair[1]).map(|pair| pair[0] + 1);
    // Such a control has the shares 1 − θ and θ of its neighbours at the nodes between them.
    let shares = |n: usize| {
        let right = steps[n - 1] / (steps[n - 1] + steps[n]);
        [(n - 1, 1.0 - right), (n + 1, right)]
    };
    let mut errors = vec![0.0; fine.len()];
    kept.iter().zip(coarse).for_each(|(&n, of)| errors[n] = fine[n] - of);
    for n in between() {
        shares(n).into_iter().for_each(|(k, share)| errors[k] += share * fine[n]);
    }
    // A quarter of each difference moves to the node before, a quarter to the node after.
    let quarters: Vec<f64> = between().map(|n| 0.25 * (errors[n - 1] + errors[n + 1])).collect();
    for (n, of) in between().zip(quarters) {
        errors[n] = of;
        shares(n).into_iter().for_each(|(k, share)| errors[k] -= share * of);
    }
    errors
}

/// The controls are changed by so many functions of time.
const HATS: usize = 8;

/// Each derivative times the size of its variable. A control is changed by hat functions of time, which are the same on all grids.
fn effects(inputs: &Inputs, of: &Gradient, on: &Inputs) -> Vec<f64> {
    let size = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
    let pairs = [(&of.design, &inputs.design), (of.start.q(), inputs.start.q()), (of.start.rate(), inputs.start.rate())];
    let of_one = pairs.into_iter().flat_map(|(of, values)| of.iter().zip(values.iter()).map(|(of, x)| of * size(*x)));
    let times = on.grid.times();
    let (start, end) = (times[0], times[times.len() - 1]);
    let of_controls = of.controls.row_iter().enumerate().flat_map(|(channel, row)| {
        let size = size(inputs.controls.row(channel).amax());
        let mut sums = [0.0; HATS];
        for (time, slope) in times.iter().zip(row.iter()) {
            let place = (time - start) / (end - start) * (HATS - 1) as f64;
            let hat = |k: usize| (1.0 - (place - k as f64).abs()).max(0.0);
            sums.iter_mut().enumerate().for_each(|(k, sum)| *sum += size * hat(k) * slope);
        }
        sums
    });
    of_one.chain(of_controls).collect()
}

/// Both ends of steps of length zero, every second node between them, and the last one.
fn kept_nodes(steps: &[f64]) -> Vec<usize> {
    let mut is_half = false;
    let mut is_kept = |&node: &usize| {
        let moves = |step: usize| steps.get(step).is_some_and(|dt| *dt != 0.0);
        is_half = !is_half && node > 0 && moves(node - 1) && moves(node);
        !is_half
    };
    (0..=steps.len()).filter(|node| is_kept(node)).collect()
}

/// True if events, and steps of length zero, have multiples of four steps between them, of which every fourth node keeps both.
pub(super) fn has_quarters(inputs: &Inputs) -> bool {
    let (steps, mut count) = (&inputs.grid.steps, 0);
    let fits = |node: usize| {
        let is_event = inputs.events.iter().any(|event| event.node == node);
        count = if steps[node - 1] == 0.0 { 0 } else { count + 1 };
        !(is_event || steps.get(node) == Some(&0.0)) || count % 4 == 0
    };
    (1..=steps.len()).all(fits)
}

/// The inputs with steps twice as long, without those of length zero; controls keep their values at the nodes that remain.
pub(super) fn every_second(inputs: &Inputs) -> Inputs {
    let nodes = kept_nodes(&inputs.grid.steps);
    let steps = nodes.windows(2).map(|pair| inputs.grid.steps[pair[0]..pair[1]].iter().sum()).collect();
    let grid = Grid::new(inputs.grid.start, steps);
    let place = |node: usize| nodes.partition_point(|kept| *kept < node);
    let events = inputs.events.iter().map(|event| Occurrence { node: place(event.node), ..*event }).collect();
    Inputs { grid, controls: inputs.controls.select_columns(&nodes), events, ..inputs.clone() }
}
