//! Axes, and the coordinate with which plotters draws them: linear, or the decimal logarithm.
//!
//! The logarithmic coordinate of plotters has no ticks below 1e-16, but many errors are that small.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::data::float::pretty_print_float;

use crate::statistics::range;

/// Specification of an axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// The quantity with its unit.
    pub label: String,
    /// Least value shown on a logarithmic axis; smaller values are drawn there. If it is 0, values that are not positive are omitted.
    pub floor: Option<f64>,
    /// The least and greatest value shown; determined from the data if not given.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis that fits the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis that fits the data; its least value is the floor.
    pub fn log(label: impl Into<String>, floor: f64) -> Self {
        Self { label: label.into(), floor: Some(floor), range: None }
    }

    /// The axis with its range, in which a fraction at both ends is left free.
    pub fn fit(&self, values: impl Iterator<Item = f64>, margin: f64) -> Ruler {
        let whole = Ruler { floor: self.floor, low: f64::NEG_INFINITY, high: f64::INFINITY };
        if let Some((low, high)) = self.range {
            return Ruler { low: whole.position(low), high: whole.position(high), ..whole };
        }
        let positions = values.map(|value| whole.position(value)).filter(|position| position.is_finite());
        let (low, high) = range(positions);
        let size = (low.abs().max(high.abs())).max(1e-300);
        let (low, high, room) = match high - low {
            spread if spread > 1e-12 * size => (low, high, margin * spread),
            spread if spread >= 0.0 => (low, high, 0.1 * size.max(1e-6)),
            _ => (0.0, 1.0, 0.0),
        };
        Ruler { low: low - room, high: high + room, ..whole }
    }
}

/// An axis with its range, as positions: values, or their decimal logarithms.
#[derive(Clone, Copy, Debug)]
pub struct Ruler {
    floor: Option<f64>,
    low: f64,
    high: f64,
}

impl Ruler {
    fn position(&self, value: f64) -> f64 {
        match self.floor {
            Some(floor) if !value.is_nan() => value.max(floor).log10(),
            _ => value,
        }
    }

    fn value(&self, position: f64) -> f64 {
        if self.floor.is_some() { 10f64.powf(position) } else { position }
    }

    /// Position from 0 at the least to 1 at the greatest value shown; values outside are clamped. `None` if the position is not finite.
    pub fn fraction(&self, value: f64) -> Option<f64> {
        let fraction = (self.position(value) - self.low) / (self.high - self.low);
        fraction.is_finite().then(|| fraction.clamp(0.0, 1.0))
    }

    /// The axis with the given fraction left free above the data.
    pub fn with_free(self, share: f64) -> Self {
        Self { high: self.low + (self.high - self.low) / (1.0 - share), ..self }
    }

    /// Powers of ten, and 2 and 5 times these if there are few.
    fn decades(&self, most: usize) -> Vec<f64> {
        let stride = ((self.high - self.low) / most.max(1) as f64).ceil().max(1.0) as i32;
        let parts: &[f64] = if self.high - self.low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        // A visible floor has a tick.
        let first = self.floor.filter(|floor| *floor > 0.0).map_or(0, |floor| floor.log10().round() as i32);
        let exponents =
            (self.low.floor() as i32..=self.high.ceil() as i32).filter(|exponent| (exponent - first) % stride == 0);
        let ticks = exponents.flat_map(|exponent| parts.iter().map(move |part| part * 10f64.powi(exponent)));
        let near = 1e-9 * (self.high - self.low);
        ticks.filter(|tick| (self.low - near..=self.high + near).contains(&tick.log10())).collect()
    }
}

impl Ranged for Ruler {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (f64::from(to - from) * self.fraction(*value).unwrap_or(0.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let decades = if self.floor.is_some() { self.decades(hint.max_num_points()) } else { Vec::new() };
        if decades.len() > 1 {
            return decades;
        }
        let Range { start, end } = self.range();
        RangedCoordf64::from(start..end).key_points(hint)
    }

    fn range(&self) -> Range<f64> {
        self.value(self.low)..self.value(self.high)
    }
}

impl ValueFormatter<f64> for Ruler {
    fn format_ext(&self, value: &f64) -> String {
        match self.floor {
            Some(floor) if *value <= 1.0001 * floor => format!("≤ {}", scientific(&format!("{value:.0e}"))),
            Some(_) if self.high - self.low > 1.0 => scientific(&format!("{value:.0e}")),
            _ if value.abs() < 1e-6 * (self.high - self.low) => "0".to_owned(),
            _ => scientific(&pretty_print_float(*value, true)),
        }
    }
}

/// The number in typeset form: `1e-4` as 10⁻⁴, `-2e7` as −2·10⁷.
pub(super) fn scientific(number: &str) -> String {
    let (mantissa, exponent) = number.split_once('e').unwrap_or((number, ""));
    let mantissa = mantissa.replace('-', "−");
    let superscript = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(digit),
    };
    let exponent: String = exponent.chars().map(superscript).collect();
    match (mantissa.as_str(), exponent.is_empty()) {
        (_, true) => mantissa,
        ("1", false) => format!("10{exponent}"),
        (_, false) => format!("{mantissa}·10{exponent}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(low: f64, high: f64) -> Ruler {
        Ruler { floor: None, low, high }
    }

    fn ticks(ruler: Ruler, most: usize) -> Vec<String> {
        ruler.key_points(most).iter().map(|value| ruler.format_ext(value)).collect()
    }

    #[test]
    fn linear_ticks_have_the_digits_of_the_step() {
        assert_eq!(ticks(linear(-0.1, 0.35), 5), ["−0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(ticks(linear(0.0, 1.2e-9), 3), ["0", "5·10⁻¹⁰", "10⁻⁹"]);
        assert_eq!(ticks(linear(0.0, 3e7), 4), ["0", "10⁷", "2·10⁷", "3·10⁷"]);
    }

    #[test]
    fn logarithmic_ticks_are_decades_down_to_the_floor() {
        let ruler = Axis::log("", 1e-18).fit([0.0, -1.0, 1e-4].into_iter(), 0.05);
        assert_eq!(ticks(ruler, 4), ["≤ 10⁻¹⁸", "10⁻¹⁴", "10⁻¹⁰", "10⁻⁶"]);
        assert_eq!(ruler.fraction(0.0), ruler.fraction(1e-18));
        assert_eq!(Axis::log("", 0.0).fit([1.0].into_iter(), 0.0).fraction(0.0), None);
        assert_eq!(ticks(Axis { range: Some((2e-2, 0.5)), ..Axis::log("", 0.0) }.fit([].into_iter(), 0.0), 9)[0], "2·10⁻²");
    }

    #[test]
    fn degenerate_ranges_have_ticks() {
        for values in [vec![], vec![0.0], vec![f64::NAN], vec![7.0, 7.0], vec![1e300, -1e300]] {
            for axis in [Axis::default(), Axis::log("", 1e-12)] {
                assert!(!ticks(axis.fit(values.iter().copied(), 0.05), 5).is_empty(), "{values:?}");
            }
        }
    }
}
