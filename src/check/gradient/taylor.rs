//! The Taylor remainder test: J(x + s d) − J(x) − s g·d must shrink like s².

use super::FIRST_STEP;

/// The Taylor remainder at one step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Remainder {
    /// The step s.
    pub step: f64,
    /// The remainder J(x + s d) − J(x) − s g·d.
    pub value: f64,
}

/// Taylor remainders and their observed order.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Taylor {
    /// Remainders at steps that are successively halved.
    pub remainders: Vec<Remainder>,
    /// Median of log₂(R(s)/R(s/2)) above rounding: 2 for a right gradient, 1 for a wrong one; `None` if all remainders are rounding.
    pub slope: Option<f64>,
    /// The least R(s)/s behind which the order is too low, and no lower than of a wrong gradient, which is wrong by that; infinite if it nowhere is.
    pub(super) wrong_by: f64,
}

/// The least observed order that a right gradient has, half-way between 1 and 2; and that a wrong one has: below is noise.
pub(super) const ENOUGH: f64 = 1.5;
const OF_WRONG: f64 = 0.5;

/// Steps tried, from the first on.
const STEPS: usize = 8;

/// Remainders of the values `along` a direction, NaN where there is none, from what it is `here` and the derivative g·d.
pub(super) fn taylor(along: impl Fn(f64) -> f64, here: f64, derivative: f64) -> Taylor {
    let mut remainders = Vec::new();
    let mut floor = 0.0f64;
    for k in 0..STEPS {
        let step = FIRST_STEP * 0.5f64.powi(k as i32);
        let there = along(step);
        // A step too long to have a motion is no failure of the gradient.
        if !there.is_nan() {
            floor = floor.max(1e-13 * (here.abs() + there.abs() + (step * derivative).abs()));
            remainders.push(Remainder { step, value: there - here - step * derivative });
        }
    }
    let pairs = remainders.windows(2).filter(|pair| pair[1].value.abs() > 100.0 * floor);
    let orders = pairs.map(|pair| ((pair[0].value / pair[1].value).abs().log2(), (pair[1].value / pair[1].step).abs()));
    let orders: Vec<(f64, f64)> = orders.collect();
    let of_wrong = orders.iter().filter(|(order, _)| (OF_WRONG..=ENOUGH).contains(order));
    let wrong_by = of_wrong.fold(f64::INFINITY, |least, (_, by)| least.min(*by));
    let mut slopes: Vec<f64> = orders.into_iter().map(|(order, _)| order).collect();
    slopes.sort_by(f64::total_cmp);
    let slope = slopes.get(slopes.len() / 2).copied();
    Taylor { remainders, slope, wrong_by }
}
