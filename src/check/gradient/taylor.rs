//! The Taylor remainder test: J(x + s d) − J(x) − s g·d must shrink like s².

use crate::{Error, Inputs, Settings, Solver, System};

use super::directions::along;

/// The remainder at one step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Remainder {
    /// s.
    pub step: f64,
    /// J(x + s d) − J(x) − s g·d.
    pub value: f64,
}

/// Remainders and their observed order.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Taylor {
    /// Steps, halved from one to the next.
    pub remainders: Vec<Remainder>,
    /// The median of log₂(R(s)/R(s/2)) above rounding: 2 for a right gradient, 1 for a wrong one. None if all is rounding.
    pub slope: Option<f64>,
}

/// Steps tried, from the first on.
const STEPS: usize = 8;

/// Remainders along a direction for the derivative `slope` = g·d.
pub(super) fn taylor(
    system: &System,
    inputs: &Inputs,
    (settings, which): (Settings, usize),
    (direction, derivative): (&Inputs, f64),
    first: f64,
) -> Result<Taylor, Error> {
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    let here = solver.value_of(which)?;
    let mut remainders = Vec::new();
    let mut floor = 0.0f64;
    for k in 0..STEPS {
        let step = first * 0.5f64.powi(k as i32);
        // A step too long to have a motion is no failure of the gradient.
        if solver.simulate(&along(inputs, direction, step)).is_ok() {
            let there = solver.value_of(which)?;
            floor = floor.max(1e-13 * (here.abs() + there.abs() + (step * derivative).abs()));
            remainders.push(Remainder { step, value: there - here - step * derivative });
        }
    }
    let pairs = remainders.windows(2).filter(|pair| pair[1].value.abs() > 100.0 * floor);
    let mut slopes: Vec<f64> = pairs.map(|pair| (pair[0].value / pair[1].value).abs().log2()).collect();
    slopes.sort_by(f64::total_cmp);
    let slope = slopes.get(slopes.len() / 2).copied();
    Ok(Taylor { remainders, slope })
}
