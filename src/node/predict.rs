//! The first guess of a step: v and σ extrapolated through the last nodes.

use crate::Trajectory;

/// Upper bound of Σ |weights|: beyond it rounding and roughness are amplified too much, and fewer nodes are used.
const MOST_AMPLIFICATION: f64 = 40.0;

/// Extrapolation by the polynomial in t through the last nodes.
pub(crate) struct Predictor {
    weights: [f64; Predictor::MOST],
    /// The steps for which the weights were computed; the last one is to be predicted.
    steps: [f64; Predictor::MOST],
    used: usize,
    /// (v, σ) of a stage between nodes.
    guess: Vec<f64>,
}

impl Predictor {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Predictor { weights: [0.0; Self::MOST], steps: [0.0; Self::MOST], used: 0, guess: vec![0.0; n + m] }
    }

    /// Largest number of nodes in an extrapolation.
    pub(crate) const MOST: usize = 5;

    /// Writes the guess for stage `s` of the last of these steps into column `i`. It extrapolates through the nodes at which the steps begin and
    /// through the previous stages of the last step.
    pub(crate) fn predict(&mut self, steps: &[f64], trajectory: &mut Trajectory, i: usize, s: usize) {
        if trajectory.scheme.inner() > 0 {
            self.predict_stage(steps, trajectory, (i, s));
            return;
        }
        self.prepare(steps);
        let nodes = &mut trajectory.nodes;
        for matrix in [&mut nodes.v, &mut nodes.sigma] {
            let rows = matrix.nrows();
            let columns = &mut matrix.as_mut_slice()[(i - self.used) * rows..][..(self.used + 1) * rows];
            let (before, now) = columns.split_at_mut(self.used * rows);
            self.extrapolate(before, now);
        }
    }

    /// Writes the weighted sum of the previous nodes.
    fn extrapolate(&self, before: &[f64], now: &mut [f64]) {
        let rows = now.len();
        let node = |k: usize| &before[k * rows..][..rows];
        match (self.used, self.weights) {
            // The usual case in one pass.
            (5, [a, b, c, d, e]) => {
                let nodes = node(0).iter().zip(node(1)).zip(node(2).iter().zip(node(3))).zip(node(4));
                for (x, (((x0, x1), (x2, x3)), x4)) in now.iter_mut().zip(nodes) {
                    *x = (a * x0 + b * x1) + (c * x2 + d * x3) + e * x4;
                }
            }
            (used, weights) => {
                now.fill(0.0);
                for (k, weight) in weights[..used].iter().enumerate() {
                    now.iter_mut().zip(node(k)).for_each(|(x, y)| *x += weight * y);
                }
            }
        }
    }

    fn predict_stage(&mut self, steps: &[f64], trajectory: &mut Trajectory, (k, s): (usize, usize)) {
        let (scheme, dt) = (trajectory.scheme, steps[steps.len() - 1]);
        let c = scheme.c(s);
        // The oldest first: nodes, then stages.
        let stages = (s - 1).min(Self::MOST - 1);
        let nodes = steps.len().min(Self::MOST - stages);
        let mut distances = [0.0; Self::MOST];
        for j in (0..nodes).rev() {
            distances[j] = if j + 1 == nodes { c * dt } else { distances[j + 1] + steps[steps.len() - nodes + j] };
        }
        for j in 0..stages {
            distances[nodes + j] = (c - scheme.c(s - stages + j)) * dt;
        }
        let most = nodes + stages;
        let used = (1..=most).rev().find(|&used| self.weigh(&distances[most - used..most])).unwrap_or(1);
        self.guess.fill(0.0);
        for (j, &weight) in (most - used..most).zip(&self.weights) {
            let y = if j < nodes { trajectory.columns(k - nodes + j) } else { trajectory.stage(k, s - stages + j - nodes) };
            self.guess.iter_mut().zip(y.v.iter().chain(y.sigma)).for_each(|(x, y)| *x += weight * y);
        }
        let now = trajectory.stage_mut(k, s);
        now.v.iter_mut().chain(now.sigma).zip(&self.guess).for_each(|(x, guess)| *x = *guess);
    }

    /// Computes the weights for the last steps, including the one to be predicted.
    fn prepare(&mut self, steps: &[f64]) {
        if self.used == steps.len() && self.steps[..self.used] == *steps {
            return;
        }
        let most = steps.len();
        self.used = (1..=most).rev().find(|&used| self.find_weights(&steps[most - used..])).unwrap_or(1);
        self.steps[..most].copy_from_slice(steps);
        if self.used < most {
            // The weights belong to the last of these steps only and must not be reused for all of them.
            self.steps[0] = f64::NAN;
        }
    }

    /// Computes the weights, at the end of the last step, of the nodes at which the steps begin; false if they are too large.
    fn find_weights(&mut self, steps: &[f64]) -> bool {
        let used = steps.len();
        let mut distances = [0.0; Self::MOST];
        for j in (0..used).rev() {
            distances[j] = steps[j] + if j + 1 < used { distances[j + 1] } else { 0.0 };
        }
        self.weigh(&distances[..used])
    }

    /// Lagrange's weights w_j = Π d_l/(d_l − d_j) of values at these distances before the predicted one; false if they are too large.
    fn weigh(&mut self, distances: &[f64]) -> bool {
        for (j, of_j) in distances.iter().enumerate() {
            let others = distances.iter().enumerate().filter(|(l, _)| *l != j);
            self.weights[j] = others.map(|(_, of_l)| of_l / (of_l - of_j)).product();
        }
        self.weights[..distances.len()].iter().map(|w| w.abs()).sum::<f64>() <= MOST_AMPLIFICATION
    }
}

#[cfg(test)]
mod tests {
    use super::Predictor;

    #[test]
    fn weights_on_equal_steps_are_the_binomial_ones_and_coincident_nodes_are_refused() {
        let mut predictor = Predictor::new(1, 0);
        assert!(predictor.find_weights(&[0.5; 5]));
        assert_eq!(predictor.weights, [1.0, -5.0, 10.0, -10.0, 5.0]);
        assert!(!predictor.find_weights(&[0.5, 0.0, 0.5]));
        // Forward, back and forward again: the end coincides with node 1.
        predictor.prepare(&[1.0, -1.0, 1.0]);
        assert_eq!((predictor.used, &predictor.weights[..2]), (2, &[1.0, 0.0][..]));
        // The first two of three steps; only the last two of them were used above.
        predictor.prepare(&[0.1, 1.0, 1.5]);
        assert_eq!((predictor.used, &predictor.weights[..2]), (2, &[-1.5, 2.5][..]));
        predictor.prepare(&[0.1, 1.0]);
        let [first, second] = [predictor.weights[0], predictor.weights[1]];
        assert!((first + 10.0).abs() < 1e-12 && (second - 11.0).abs() < 1e-12, "{first}, {second}");
    }
}
