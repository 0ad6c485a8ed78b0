//! The node problem solved with another linear solver through the same trait.

use super::{Newton, Unknowns};
use crate::linear::{BlockLu, DenseLu, Factorization};
use crate::motion::Report;
use crate::scene::scenes::CartPendulum;
use crate::system::{Given, KnownPart, NodeView};
use crate::{Settings, System};
use approx::assert_relative_eq;

const H: f64 = 0.02;

/// (q, v, σ) of a step from rest, and the solution of Kᵀ x = r for r = 1, 2, … at its end.
fn step_and_adjoint<F: Factorization>(system: &System, q: &[f64]) -> Vec<f64> {
    let (n, m) = (system.n(), system.m());
    let (u, zeros) = ([3.0], vec![0.0; n.max(m)]);
    let mut newton = Newton::<F>::new(system);
    let mut report = Report::default();
    let start = NodeView::of_equations([q, &zeros[..n], &zeros[..m]], (&u, 0.0, &[]));
    newton.linearisation.evaluation.set_start(system, &start).expect("finite constants");
    let [mut end, mut v, mut sigma, mut rate] = [n, n, m, n].map(|len| vec![0.0; len]);
    let mut y = Unknowns { q: &mut end, v: &mut v, sigma: &mut sigma, p_star_dot: &mut rate };
    let from = KnownPart { h: H, q, p_star: &zeros[..n], sigma: &zeros[..m] };
    let given = Given { u: &u, t: H, design: &[] };
    let solved = newton.solve_step(system, &from, given, &mut y, &Settings::default(), &mut report);
    assert!(solved.is_ok(), "no solution of the step");

    let blocks = newton.linearisation.evaluation.blocks.clone();
    let mut x: Vec<f64> = (0..n + m).map(|k| 1.0 + k as f64).collect();
    newton.linearisation.factor_and_solve_transposed(system, H, &blocks, &mut x, &mut report).expect("regular");
    [end, v, sigma, x].concat()
}

#[test]
fn dense_lu_solves_the_same_steps_and_adjoint_equations() {
    for links in [1, 3, 30] {
        let system = CartPendulum::with_links(links).scene().compile().expect("a scene");
        let q = system.initial_coordinates();
        let [ours, other] =
            [step_and_adjoint::<BlockLu>, step_and_adjoint::<DenseLu>].map(|solve| solve(&system, q.as_slice()));
        let size = ours.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        assert_relative_eq!(ours.as_slice(), other.as_slice(), epsilon = 1e-12 * size, max_relative = 1e-10);
    }
}
