//! Axes: what they measure, the stretch they show, and their ticks.

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By their decimal logarithm; values below the floor, also zero and negative ones, are drawn at the floor,
    /// and with a floor of zero those not positive are left out.
    Log {
        /// The least value shown.
        floor: f64,
    },
}

impl Scale {
    /// The position of the value along the axis, if it has one.
    fn position(self, value: f64) -> Option<f64> {
        let position = match self {
            Self::Linear => value,
            Self::Log { .. } if value.is_nan() => value,
            Self::Log { floor } => value.max(floor).log10(),
        };
        position.is_finite().then_some(position)
    }
}

/// An axis as asked for.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// The quantity with its unit.
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
    /// The least and greatest value shown, found from the data if not given.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis that fits the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), ..Self::default() }
    }

    /// A logarithmic axis that fits the data, its least value the floor.
    pub fn log(label: impl Into<String>, floor: f64) -> Self {
        Self { label: label.into(), scale: Scale::Log { floor }, range: None }
    }
}

/// A tick: its place as a fraction of the axis, and its words (none for a minor one).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// From 0 at the least to 1 at the greatest value shown.
    pub(super) place: f64,
    /// The value in words.
    pub(super) words: String,
}

/// An axis with its range decided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ruler {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Ruler {
    /// Fits the axis to the values, with a margin on both sides as a fraction of their spread.
    pub(super) fn fit(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64) -> Self {
        let scale = axis.scale;
        let given = axis.range.and_then(|(low, high)| Some((scale.position(low)?, scale.position(high)?)));
        let (low, high) = given.unwrap_or_else(|| {
            let (low, high) = extent(values.filter_map(|value| scale.position(value))).unwrap_or((0.0, 1.0));
            let room = margin * (high - low);
            (low - room, high + room)
        });
        let (low, high) = widened(low, high);
        Self { scale, low, high }
    }

    /// A linear ruler from the least to the greatest value.
    pub(super) fn linear(low: f64, high: f64) -> Self {
        let (low, high) = widened(low, high);
        Self { scale: Scale::Linear, low, high }
    }

    /// The place of the value as a fraction of the axis, outside 0 to 1 if it is not shown.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        Some(self.fraction(self.scale.position(value)?))
    }

    /// Ticks with words, about as many as asked for or fewer.
    pub(super) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.even_ticks(wanted),
            Scale::Log { floor } => {
                let ticks = self.decade_ticks(wanted, floor);
                if ticks.len() > 1 { ticks } else { self.even_ticks_among_decades(wanted) }
            }
        }
    }

    /// Ticks without words, between those with.
    pub(super) fn minor_ticks(&self) -> Vec<Tick> {
        let decades = self.high - self.low;
        if self.scale == Scale::Linear || decades > 30.0 {
            return Vec::new();
        }
        let parts: &[f64] = if decades > 4.0 { &[1.0] } else { &[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0] };
        let exponents = self.low.floor() as i32..=self.high.ceil() as i32;
        exponents
            .flat_map(|exponent| parts.iter().map(move |part| f64::from(exponent) + part.log10()))
            .filter(|position| self.shows(*position))
            .map(|position| Tick { place: self.fraction(position), words: String::new() })
            .collect()
    }

    /// Ticks at multiples of 1, 2 or 5 times a power of ten.
    fn even_ticks(&self, wanted: usize) -> Vec<Tick> {
        let step = nice_step((self.high - self.low) / wanted.max(1) as f64);
        let first = (self.low / step - 1e-6).ceil();
        (0..=2 * wanted)
            .map(|index| first + index as f64)
            .take_while(|multiple| *multiple <= self.high / step + 1e-6)
            .map(|multiple| Tick { place: self.fraction(multiple * step), words: words(multiple, step) })
            .collect()
    }

    /// Ticks at powers of ten, among them that of a floor in sight, or also at 2 and 5 times those if they are few.
    fn decade_ticks(&self, wanted: usize, floor: f64) -> Vec<Tick> {
        let decades = self.high - self.low;
        let parts: &[i32] = if decades < 2.5 { &[1, 2, 5] } else { &[1] };
        let stride = (decades / wanted.max(1) as f64).ceil().max(1.0) as i32;
        let start = if self.place(0.0).is_some_and(|place| place > 0.0) { floor.log10().round() as i32 } else { 0 };
        let exponents = self.low.floor() as i32..=self.high.ceil() as i32;
        exponents
            .filter(|exponent| (exponent - start) % stride == 0)
            .flat_map(|exponent| parts.iter().map(move |part| (exponent, *part)))
            .filter_map(|(exponent, part)| {
                let position = f64::from(exponent) + f64::from(part).log10();
                let above_floor = position - floor.max(0.0).log10();
                let sign = if above_floor < 1e-9 { "≤" } else { "" };
                (self.shows(position) && above_floor > -1e-9)
                    .then(|| Tick { place: self.fraction(position), words: format!("{sign}{part}e{exponent}") })
            })
            .collect()
    }

    /// Ticks at evenly spaced values on a logarithmic axis of less than a decade.
    fn even_ticks_among_decades(&self, wanted: usize) -> Vec<Tick> {
        let (low, high) = (10_f64.powf(self.low), 10_f64.powf(self.high));
        let ticks = Self::linear(low, high).even_ticks(wanted).into_iter();
        let moved = |tick: Tick| Tick { place: self.fraction((low + tick.place * (high - low)).log10()), ..tick };
        ticks.map(moved).collect()
    }

    /// Whether the position is on the axis.
    fn shows(&self, position: f64) -> bool {
        (-1e-9..=1.0 + 1e-9).contains(&self.fraction(position))
    }

    /// The position as a fraction of the axis.
    fn fraction(&self, position: f64) -> f64 {
        (position - self.low) / (self.high - self.low)
    }
}

/// The least and the greatest of the values, if any.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |found: Option<(f64, f64)>, value| match found {
        Some((low, high)) => Some((low.min(value), high.max(value))),
        None => Some((value, value)),
    })
}

/// The range, made wide enough to be divided if it is a point.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if (high - low).abs() > 1e-12 * size && high != low {
        return (low, high);
    }
    let room = if size > 0.0 { 0.1 * size } else { 1.0 };
    (low - room, high + room)
}

/// The step rounded to 1, 2 or 5 times a power of ten.
fn nice_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let part = match step / power {
        part if part < 1.4 => 1.0,
        part if part < 3.2 => 2.0,
        part if part < 7.1 => 5.0,
        _ => 10.0,
    };
    part * power
}

/// The multiple of the step, with the digits that the step has and no more.
fn words(multiple: f64, step: f64) -> String {
    let value = multiple * step;
    let step_exponent = (step.log10() + 1e-9).floor() as i32;
    if multiple == 0.0 {
        return "0".to_owned();
    }
    let exponent = (value.abs().log10() + 1e-9).floor() as i32;
    if (-4..=4).contains(&step_exponent) && exponent < 6 {
        return format!("{value:.*}", (-step_exponent).max(0) as usize).replace('-', "−");
    }
    let digits = (exponent - step_exponent).max(0) as usize;
    let written = format!("{value:.digits$e}");
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    format!("{mantissa}e{exponent}").replacen('-', "−", usize::from(value < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words_of(ruler: Ruler, wanted: usize) -> Vec<String> {
        ruler.ticks(wanted).into_iter().map(|tick| tick.words).collect()
    }

    #[test]
    fn linear_ticks_have_the_digits_of_the_step() {
        assert_eq!(words_of(Ruler::linear(-0.1, 0.35), 5), ["−0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(words_of(Ruler::linear(0.0, 1.2e-9), 3), ["0", "5e-10", "1e-9"]);
        assert_eq!(words_of(Ruler::linear(0.0, 3e7), 3), ["0", "1e7", "2e7", "3e7"]);
    }

    #[test]
    fn logarithmic_ticks_are_decades_down_to_the_floor() {
        let axis = Axis::log("", 1e-16);
        let ruler = Ruler::fit(&axis, [0.0, -1.0, 1e-4].into_iter(), 0.05);
        assert_eq!(words_of(ruler, 4), ["≤1e-16", "1e-12", "1e-8", "1e-4"]);
        assert_eq!(ruler.place(0.0), ruler.place(1e-16));
        assert_eq!(Ruler::fit(&Axis::log("", 0.0), [1.0].into_iter(), 0.0).place(0.0), None);
    }

    #[test]
    fn degenerate_ranges_have_ticks() {
        for values in [vec![], vec![0.0], vec![f64::NAN], vec![7.0, 7.0], vec![1e300, -1e300]] {
            for axis in [Axis::default(), Axis::log("", 1e-12)] {
                assert!(!Ruler::fit(&axis, values.iter().copied(), 0.05).ticks(5).is_empty(), "{values:?}");
            }
        }
    }
}
