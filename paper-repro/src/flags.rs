//! Parsers for numeric flags, with error messages.

pub fn finite(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number".to_owned()).and_then(|value: f64| must(value.is_finite(), value, "be finite"))
}

pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| must(value > 0.0, value, "be positive"))
}

pub fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| must(value > 0.0 && value < 1.0, value, "lie between 0 and 1"))
}

/// With a factor closer to 1, the line search would hardly shorten a step and would not end.
pub fn shortening(text: &str) -> Result<f64, String> {
    share(text).and_then(|value| must(value <= 0.99, value, "be at most 0.99"))
}

fn must(holds: bool, value: f64, what: &str) -> Result<f64, String> {
    if holds { Ok(value) } else { Err(format!("must {what}")) }
}

/// A number as it was given, with an exponent if it is far from 1 (1e300 has 301 digits).
pub fn shown(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_however_large_or_small() {
        let numbers = [1.0, -9.81, 0.0, 0.0001, 999_999.5, 1e300, -1e-3, -2.5e-300];
        assert_eq!(numbers.map(shown), ["1", "-9.81", "0", "0.0001", "999999.5", "1e300", "-0.001", "-2.5e-300"]);
    }
}
