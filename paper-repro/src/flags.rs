//! Numbers as flags take them, with what is wrong in words.

pub fn finite(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number".to_owned()).and_then(|value: f64| must(value.is_finite(), value, "be finite"))
}

pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| must(value > 0.0, value, "be positive"))
}

pub fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| must(value > 0.0 && value < 1.0, value, "lie between 0 and 1"))
}

/// Nearer to 1, a step that nothing shortens would be tried for ever.
pub fn shortening(text: &str) -> Result<f64, String> {
    share(text).and_then(|value| must(value <= 0.99, value, "be at most 0.99"))
}

fn must(holds: bool, value: f64, what: &str) -> Result<f64, String> {
    if holds { Ok(value) } else { Err(format!("must {what}")) }
}
