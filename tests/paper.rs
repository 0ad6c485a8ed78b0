//! The numbers of the paper's example against reference values in 128-bit floats (`tests/data/README.md`).

use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};

/// The array of numbers called `key` in a reference file.
fn numbers(file: &str, key: &str) -> Vec<f64> {
    let quoted = format!("\"{key}\"");
    let after = &file[file.find(&quoted).expect("key") + quoted.len()..];
    let start = after.find(':').expect("value") + 1;
    let value = after[start..].trim_start();
    let end = if value.starts_with('[') { value.find(']') } else { value.find([',', '}']) };
    let list = value[..end.expect("end")].trim_start_matches('[');
    list.split(',').map(|x| x.trim().parse().expect("a number")).collect()
}

fn relative_error(ours: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(ours.len(), reference.len());
    let scale = reference.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    let error = ours.iter().zip(reference).fold(0.0f64, |e, (a, b)| e.max((a - b).abs()));
    error / scale
}

fn compare(file: &str, links: usize, dt: f64) {
    let system = CartPendulum::with_links(links).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, dt));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings::default());
    let end = solver.simulate(&inputs).expect("motion").clone();
    let gradient = solver.gradient().expect("gradient");
    let last = |matrix: &nalgebra::DMatrix<f64>| matrix.column(100).as_slice().to_vec();
    let errors = [
        ("J", relative_error(&[gradient.value], &numbers(file, "J"))),
        ("dJ/du", relative_error(gradient.controls.as_slice(), &numbers(file, "grad"))),
        ("q", relative_error(&last(&end.q), &numbers(file, "q_final"))),
        ("p*", relative_error(&last(&end.p_star), &numbers(file, "p_final"))),
    ];
    for (what, error) in errors {
        println!("k = {links}: relative error of {what} {error:.1e}");
        assert!(error <= 1e-12, "{what}: {error:.1e}");
    }
    println!("{:?}", solver.report());
}

#[test]
fn three_links_agree_with_128_bit_reference() {
    compare(include_str!("data/truth_k3_cr0_const10.json"), 3, 0.02);
}

#[test]
fn ten_links_agree_with_128_bit_reference() {
    compare(include_str!("data/truth_k10_cr0_const10.json"), 10, 0.01);
}

#[test]
fn every_derivative_agrees_with_complex_step_and_tangents() {
    use hamiltonian_adjoint::check::{Input, complex_step, tangent};
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.02));
    inputs.controls.fill(10.0);
    let gradient = hamiltonian_adjoint::gradient(&system, &inputs, Settings::default()).expect("gradient");
    let all = Input::all(&inputs);
    let adjoint: Vec<f64> = all.iter().map(|input| input.in_gradient(&gradient)).collect();
    let now = std::time::Instant::now();
    let complex = complex_step(&system, &inputs, Settings::default(), &all).expect("complex step");
    println!("{:?}", now.elapsed());
    let dual = tangent(&system, &inputs, Settings::default(), &all).expect("tangents");
    for (k, chunk) in all.chunks(101).enumerate() {
        let r = k * 101..k * 101 + chunk.len();
        println!(
            "{:?}: {:.1e} {:.1e}",
            chunk[0],
            relative_error(&adjoint[r.clone()], &complex[r.clone()]),
            relative_error(&dual[r.clone()], &complex[r])
        );
    }
    for (i, input) in all.iter().enumerate().skip(101).take(26) {
        println!("{} {} {}", input.name(&system), adjoint[i], complex[i]);
    }
}
