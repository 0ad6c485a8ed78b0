//! [`Line`]: the line of a correction that is shortened.

/// Points x + α δ along a correction.
pub(super) struct Line {
    /// δ.
    pub(super) direction: Vec<f64>,
    /// x, and ℓ at x.
    pub(super) x: Vec<f64>,
    pub(super) linear: Vec<f64>,
    /// −r(x).
    pub(super) residual: Vec<f64>,
}

impl Line {
    pub(super) fn new(unknowns: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        Line { direction: zeros(), x: zeros(), linear: zeros(), residual: zeros() }
    }

    pub(super) fn begin(&mut self, x: &[f64], linear: &[f64]) {
        self.x.copy_from_slice(x);
        self.linear.copy_from_slice(linear);
    }
}
