use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};
use std::time::Instant;
fn main() {
    let ks: Vec<usize> = std::env::args().skip(1).map(|k| k.parse().unwrap()).collect();
    let ks = if ks.is_empty() { vec![3, 10, 30, 100] } else { ks };
    for k in ks {
        let system = CartPendulum::with_links(k).scene().compile().unwrap();
        let dt = if k == 3 { 0.02 } else { 0.01 };
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, dt));
        inputs.controls.fill(10.0);
        let mut solver = Solver::new(&system, Settings::default());
        let mut f = vec![];
        let mut g = vec![];
        for _ in 0..(3000 / k).max(20) {
            let a = Instant::now();
            solver.simulate(&inputs).unwrap();
            let b = Instant::now();
            solver.gradient().unwrap();
            let c = Instant::now();
            f.push((b - a).as_secs_f64() * 1e6);
            g.push((c - b).as_secs_f64() * 1e6);
        }
        f.sort_by(f64::total_cmp);
        g.sort_by(f64::total_cmp);
        println!(
            "k={k} fwd {:.1} adj {:.1} us (min {:.1} {:.1}) its {}",
            f[f.len() / 2],
            g[g.len() / 2],
            f[0],
            g[0],
            solver.report().newton_iterations
        );
    }
}
