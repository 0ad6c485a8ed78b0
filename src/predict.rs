//! The first guess of a step: v and σ extrapolated through the last nodes.

use crate::Trajectory;

/// The most nodes to extrapolate through.
const MOST: usize = 4;
/// Beyond this sum of |weights| rounding and roughness are amplified too much, and fewer nodes are used.
const MOST_AMPLIFICATION: f64 = 20.0;

/// Extrapolation by the polynomial in t through the last nodes.
pub(crate) struct Predictor {
    weights: [f64; MOST],
}

impl Predictor {
    pub(crate) fn new() -> Self {
        Predictor { weights: [0.0; MOST] }
    }

    /// Writes the guess for node `i` ≥ 1 into its columns.
    pub(crate) fn predict(&mut self, trajectory: &mut Trajectory, i: usize) {
        let used = (1..=MOST.min(i)).rev().find(|&used| self.find_weights(&trajectory.times, i, used)).unwrap_or(1);
        for matrix in [&mut trajectory.v, &mut trajectory.sigma] {
            let rows = matrix.nrows();
            let (before, now) = matrix.as_mut_slice()[(i - used) * rows..(i + 1) * rows].split_at_mut(used * rows);
            now.fill(0.0);
            for (node, &weight) in before.chunks_exact(rows.max(1)).zip(&self.weights) {
                now.iter_mut().zip(node).for_each(|(x, &y)| *x += weight * y);
            }
        }
    }

    /// Lagrange's weights w_j = Π (t − t_l)/(t_j − t_l) of nodes i − used … i − 1 at t_i; false if they are too large.
    fn find_weights(&mut self, times: &[f64], i: usize, used: usize) -> bool {
        let nodes = &times[i - used..i];
        for (j, &tj) in nodes.iter().enumerate() {
            let others = nodes.iter().enumerate().filter(|&(l, _)| l != j);
            self.weights[j] = others.map(|(_, &tl)| (times[i] - tl) / (tj - tl)).product();
        }
        self.weights[..used].iter().map(|w| w.abs()).sum::<f64>() <= MOST_AMPLIFICATION
    }
}

#[cfg(test)]
mod tests {
    use super::Predictor;

    #[test]
    fn weights_on_equal_steps_are_the_binomial_ones_and_coincident_nodes_are_refused() {
        let mut predictor = Predictor::new();
        assert!(predictor.find_weights(&[0.0, 1.0, 2.0, 3.0, 4.0], 4, 4));
        assert_eq!(predictor.weights, [-1.0, 4.0, -6.0, 4.0]);
        assert!(!predictor.find_weights(&[0.0, 0.5, 0.5, 1.0], 3, 3));
    }
}
