//! The order of convergence that measured errors show, and the time at which an error is reached.

/// Between two runs, error ~ steps^(−order).
fn slope((coarse, large): (f64, f64), (fine, small): (f64, f64)) -> f64 {
    (large / small).log2() / (fine / coarse).log2()
}

/// The order from the two finest runs (steps, error) above the floor, below which rounding or the reference dominates.
pub fn observed(runs: &[(f64, f64)], floor: f64) -> Option<f64> {
    let above: Vec<(f64, f64)> = runs.iter().copied().take_while(|run| run.1 > floor).collect();
    match above[..] {
        [.., first, second] => Some(slope(first, second)),
        _ => None,
    }
}

/// The time at which the error is reached, by logarithmic interpolation between the runs (time, error), from coarse to fine.
///
/// If the coarsest run already reaches the error, its time is returned.
pub fn time_for(error: f64, runs: &[(f64, f64)]) -> Option<f64> {
    if let Some(coarsest) = runs.first().filter(|run| run.1 <= error) {
        return Some(coarsest.0);
    }
    let crossing = runs.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error)?;
    let [(t0, e0), (t1, e1)] = [crossing[0], crossing[1]].map(|(time, error)| (time.ln(), error.ln()));
    Some((t0 + (t1 - t0) * (error.ln() - e0) / (e1 - e0)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_shows_its_order_above_the_floor() {
        let runs: Vec<(f64, f64)> = [10.0, 20.0, 30.0, 60.0, 120.0].map(|n: f64| (n, (5.0 * n.powi(-4)).max(2e-7))).to_vec();
        assert!((observed(&runs, 3e-7).unwrap() - 4.0).abs() < 1e-12);
        assert!(observed(&runs, 0.0).unwrap() < 1.0);
        assert_eq!(observed(&runs, 1e-4), None);
    }

    #[test]
    fn times_are_interpolated_and_never_extrapolated() {
        let runs = [(1.0, 1e-2), (10.0, 1e-4), (100.0, 1e-6)];
        assert!((time_for(1e-5, &runs).unwrap() - 10f64.powf(1.5)).abs() < 1e-9);
        assert_eq!((time_for(1e-1, &runs), time_for(1e-7, &runs)), (Some(1.0), None));
    }
}
