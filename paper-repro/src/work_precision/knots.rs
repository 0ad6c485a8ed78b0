//! A control that is piecewise linear on equally spaced knots, at the nodes of a composed grid.

use hamiltonian_adjoint::Composition;
use nalgebra::DMatrix;
use serde::Serialize;

/// Interpolation of the control at the nodes between the ends of macro steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// By the linear piece of the macro step, extrapolated to nodes outside it: smooth for the scheme.
    Piece,
    /// At the time of the node, even if a kink lies between the node and its macro step: not smooth.
    Time,
}

/// u_i = (1 − s_i) x_k + s_i x_{k+1} with k = k_i: the control at node i from the values x at the knots.
pub struct Interpolation {
    intervals: usize,
    /// (k_i, s_i).
    nodes: Vec<(usize, f64)>,
}

impl Interpolation {
    /// The control with this interpolation; `parts` macro steps fill the interval between two knots.
    pub fn new(reading: Reading, intervals: usize, parts: usize, composition: Composition) -> Self {
        let node = |(step, end): (usize, f64)| match reading {
            Reading::Piece => (step / parts, ((step % parts) as f64 + end) / parts as f64),
            Reading::Time => {
                let place = ((step as f64 + end) / parts as f64).clamp(0.0, intervals as f64);
                let knot = (place as usize).min(intervals - 1);
                (knot, place - knot as f64)
            }
        };
        let ends = composition.stage_ends();
        let nodes = (0..intervals * parts).flat_map(|step| ends.iter().map(move |&end| (step, end))).map(node);
        Interpolation { intervals, nodes: std::iter::once((0, 0.0)).chain(nodes).collect() }
    }

    /// u_i from the values at the knots.
    #[cfg(test)]
    pub fn controls(&self, x: &[f64]) -> DMatrix<f64> {
        DMatrix::from_iterator(1, self.nodes.len(), self.nodes.iter().map(|&(k, s)| (1.0 - s) * x[k] + s * x[k + 1]))
    }

    /// dJ/dx from dJ/du: the transpose of the interpolation.
    pub fn pull_back(&self, dj_du: &DMatrix<f64>) -> Vec<f64> {
        let mut dj_dx = vec![0.0; self.intervals + 1];
        for (&(k, s), derivative) in self.nodes.iter().zip(dj_du) {
            dj_dx[k] += (1.0 - s) * derivative;
            dj_dx[k + 1] += s * derivative;
        }
        dj_dx
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hamiltonian_adjoint::Grid;

    #[test]
    fn a_straight_line_is_met_at_every_node() {
        let x: Vec<f64> = (0..=4).map(|k| 3.0 - f64::from(k)).collect();
        for composition in Composition::ALL {
            let times = Grid::composed(12, 1.0 / 3.0, composition).times();
            let controls = Interpolation::new(Reading::Piece, 4, 3, composition).controls(&x);
            assert_eq!(controls.len(), times.len());
            assert!(controls.iter().zip(&times).all(|(u, t)| (u - (3.0 - t)).abs() < 1e-12), "{composition:?}");
        }
    }

    #[test]
    fn beyond_a_kink_pieces_are_continued_and_times_are_not() {
        let hat = [0.0, 1.0, 0.0];
        // The second stage of the first macro step ends at 1.02.
        let end = Composition::Yoshida6.stage_ends()[1];
        let new = |reading| move |knots, parts, composition| Interpolation::new(reading, knots, parts, composition);
        let [pieces, time] = [Reading::Piece, Reading::Time].map(new);
        assert!((pieces(2, 1, Composition::Yoshida6).controls(&hat)[2] - end).abs() < 1e-15);
        assert!((time(2, 1, Composition::Yoshida6).controls(&hat)[2] - (2.0 - end)).abs() < 1e-15);
        // The stages of these two compositions lie inside the macro step, so both interpolations are equal.
        for composition in [Composition::Suzuki4, Composition::KahanLi6] {
            let difference = pieces(2, 2, composition).controls(&hat) - time(2, 2, composition).controls(&hat);
            assert!(difference.amax() < 1e-14);
        }
    }

    #[test]
    fn pulling_back_is_the_transposed() {
        let interpolation = Interpolation::new(Reading::Piece, 3, 2, Composition::Suzuki4);
        let x = [0.3, -1.0, 2.0, 0.7];
        let u = interpolation.controls(&x);
        let dj_du = u.map_with_location(|_, i, _| (i as f64).sin());
        let pulled = interpolation.pull_back(&dj_du);
        let product: f64 = pulled.iter().zip(x).map(|(a, b)| a * b).sum();
        assert!((product - dj_du.dot(&u)).abs() < 1e-12);
    }
}
