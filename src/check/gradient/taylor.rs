//! The Taylor remainder test: J(x + s d) − J(x) − s g·d must shrink like s².

/// First step of the differences and of the Taylor test, relative to the direction.
pub(super) const FIRST_STEP: f64 = 4e-3;
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
    /// Smallest R(s)/s among steps of the order of a wrong gradient, which would be wrong by this amount; infinite if there is none.
    pub(super) wrong_by: f64,
}

/// Smallest observed order of a right gradient, half-way between 1 and 2; and of a wrong one, below which orders are noise.
pub(super) const ENOUGH: f64 = 1.5;
const OF_WRONG: f64 = 0.5;

/// Number of steps.
const STEPS: usize = 8;

/// Remainders from the values `along` a direction (NaN without a motion), the value `here` and the derivative g·d.
pub(super) fn taylor(along: impl Fn(f64) -> f64, here: f64, derivative: f64) -> Taylor {
    let mut remainders = Vec::new();
    let mut floor = 0.0f64;
    for k in 0..STEPS {
        let step = FIRST_STEP * 0.5f64.powi(k as i32);
        let there = along(step);
        // A step that is too long for a motion does not count against the gradient.
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
