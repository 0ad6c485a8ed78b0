//! The first guess of a step: v and σ extrapolated through the last nodes.

use crate::Trajectory;

/// Beyond this sum of |weights| rounding and roughness are amplified too much, and fewer nodes are used.
const MOST_AMPLIFICATION: f64 = 40.0;

/// Extrapolation by the polynomial in t through the last nodes.
pub(crate) struct Predictor {
    weights: [f64; Predictor::MOST],
    /// The steps that the weights belong to, the one to be predicted last.
    steps: [f64; Predictor::MOST],
    used: usize,
}

impl Predictor {
    pub(crate) fn new() -> Self {
        Predictor { weights: [0.0; Self::MOST], steps: [0.0; Self::MOST], used: 0 }
    }

    /// The most nodes to extrapolate through.
    pub(crate) const MOST: usize = 5;

    /// Writes the guess for the node in column `i` into it, from the columns before, which lie at the beginnings of these steps.
    pub(crate) fn predict(&mut self, steps: &[f64], trajectory: &mut Trajectory, i: usize) {
        self.prepare(steps);
        for matrix in [&mut trajectory.v, &mut trajectory.sigma] {
            let rows = matrix.nrows();
            let (before, now) = matrix.as_mut_slice()[(i - self.used) * rows..(i + 1) * rows].split_at_mut(self.used * rows);
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
    }

    /// Finds the weights for the last steps, the one to be predicted included.
    fn prepare(&mut self, steps: &[f64]) {
        if self.used == steps.len() && self.steps[..self.used] == *steps {
            return;
        }
        let most = steps.len();
        self.used = (1..=most).rev().find(|&used| self.find_weights(&steps[most - used..])).unwrap_or(1);
        self.steps[..most].copy_from_slice(steps);
        if self.used < most {
            // Weights of the last of these steps: not to be taken for those of the first.
            self.steps[0] = f64::NAN;
        }
    }

    /// Lagrange's weights w_j = Π (t − t_l)/(t_j − t_l) of the nodes where the steps begin, at the end of the last; false if too large.
    fn find_weights(&mut self, steps: &[f64]) -> bool {
        let used = steps.len();
        let mut nodes = [0.0; Self::MOST];
        for j in (0..used).rev() {
            nodes[j] = steps[j] + if j + 1 < used { nodes[j + 1] } else { 0.0 };
        }
        // nodes[j] is how far node j lies before the end.
        for j in 0..used {
            let others = (0..used).filter(|&l| l != j);
            self.weights[j] = others.map(|l| nodes[l] / (nodes[l] - nodes[j])).product();
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
        assert!(predictor.find_weights(&[0.5; 5]));
        assert_eq!(predictor.weights, [1.0, -5.0, 10.0, -10.0, 5.0]);
        assert!(!predictor.find_weights(&[0.5, 0.0, 0.5]));
        // Forth, back and forth again: the end lies where node 1 does.
        predictor.prepare(&[1.0, -1.0, 1.0]);
        assert_eq!((predictor.used, &predictor.weights[..2]), (2, &[1.0, 0.0][..]));
        // The first two of three steps, of which the last two were used.
        predictor.prepare(&[0.1, 1.0, 1.5]);
        assert_eq!((predictor.used, &predictor.weights[..2]), (2, &[-1.5, 2.5][..]));
        predictor.prepare(&[0.1, 1.0]);
        let [first, second] = [predictor.weights[0], predictor.weights[1]];
        assert!((first + 10.0).abs() < 1e-12 && (second - 11.0).abs() < 1e-12, "{first}, {second}");
    }
}
