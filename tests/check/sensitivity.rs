//! How small an error each reference finds, and what it costs.
//!
//! `cargo test --release --test check sensitivity -- --ignored --nocapture` prints the timings.

use crate::hand::*;
use hamiltonian_adjoint::check::{self, Report};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, V};
use hamiltonian_adjoint::planar::{Damper, LinearSpring, Revolute};
use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, System, scenes::CartPendulum, simulate};
use std::time::Instant;

const ARMS: [f64; 4] = [0.5, 0.1, -0.4, 0.2];
const DAMPER: [f64; 5] = [0.5, 0.1, -0.4, 0.2, 3.0];
const SPRING: [f64; 6] = [0.5, 0.1, -0.4, 0.2, 40.0, 0.3];
const PENDULUM: [f64; 4] = [0.8, 0.4, 1.1, 0.9];

/// The same blocks with a relative error in all their entries.
fn reports(error: f64, seed: u64) -> Vec<Report> {
    let grown = 1.0 + error;
    vec![
        check::constraint(&Revolute, ARMS).random_points(4, seed).phi_q(|at| hinge_q(&at.q, &ARMS) * grown).run(),
        check::constraint(&Revolute, ARMS)
            .random_points(4, seed)
            .phi_q_v_q(|at| hinge_q_v_q(&at.q, &at.v, &ARMS) * grown)
            .run(),
        check::constraint(&Revolute, ARMS)
            .random_points(4, seed)
            .phi_dot_q_t_sigma_q(|at| hinge_dot_t_sigma_q(&at.q, &at.v, &at.sigma, &ARMS) * grown)
            .run(),
        check::force(&Damper, DAMPER).random_points(4, seed).q_q(|at| damper_q(&at.q, &at.v, &DAMPER) * grown).run(),
        check::potential_energy(&LinearSpring, SPRING)
            .random_points(4, seed)
            .v_qq(|at| spring_qq(&at.q, &SPRING) * grown)
            .run(),
        check::kinetic_energy(&DoublePendulum, PENDULUM)
            .random_points(4, seed)
            .t_qq(|at| pendulum_t_qq(&at.q, &at.v, &at.b) * grown)
            .run(),
    ]
}

#[test]
fn an_error_of_one_in_ten_billion_is_found() {
    for exponent in 1..=10 {
        let caught = reports(10f64.powi(-exponent), 1).iter().filter(|report| !report.passed()).count();
        println!("relative error 1e-{exponent}: {caught} of 6 caught");
        assert_eq!(caught, 6);
    }
    let caught = |e: i32| reports(10f64.powi(-e), 1).iter().filter(|report| !report.passed()).count();
    println!("1e-11: {}, 1e-12: {}, 1e-13: {}", caught(11), caught(12), caught(13));
    let (mut hand, mut complex, mut differences) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..100 {
        for report in reports(0.0, seed) {
            report.assert_passed();
            hand.push(report.blocks[0].relative_error);
            complex.push(report.blocks[0].complex_step_error);
            differences.push(report.blocks[0].differences_error);
        }
    }
    for (name, mut values) in [("by hand", hand), ("complex step", complex), ("differences", differences)] {
        values.sort_by(f64::total_cmp);
        println!("{name} − dual numbers, 600 blocks: median {:.0e}, worst {:.0e}", values[300], values[599]);
    }
}

fn cart(links: usize) -> (System, Inputs) {
    let system = CartPendulum::with_links(links).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, if links > 5 { 0.01 } else { 0.02 }));
    inputs.controls.fill(10.0);
    (system, inputs)
}

/// The shortest of some runs, in ms.
fn time(runs: usize, mut run: impl FnMut()) -> f64 {
    let once = |run: &mut dyn FnMut()| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..runs).map(|_| once(&mut run)).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "timings"]
fn costs() {
    let settings = Settings::default();
    for links in [3, 100] {
        let (system, inputs) = cart(links);
        let mut solver = Solver::new(&system, settings);
        let one = time(20, || {
            solver.simulate(&inputs).expect("motion");
            solver.gradient().expect("gradient");
        });
        let mut push = inputs.no_change();
        push.controls.fill(1.0);
        let input = [check::Input::Control { channel: 0, node: 5 }];
        let direct = time(5, || drop(check::direct_differentiation(&system, &inputs, settings, &push)));
        let complex = time(5, || drop(check::complex_step(&system, &inputs, settings, &input)));
        let differences = time(5, || drop(check::central_differences(&system, &inputs, settings, &input, 1e-6)));
        let default = time(3, || check::gradient(&system, &inputs, settings).run().expect("motion").assert_passed());
        println!("{links} links: value and gradient {one:.3} ms");
        for (name, ms) in [
            ("direct differentiation, one direction", direct),
            ("complex step, one direction", complex),
            ("central differences, one direction", differences),
            ("default check of the gradient", default),
        ] {
            println!("  {name}: {ms:.2} ms, {:.0} gradients", ms / one);
        }
        let motion = simulate(&system, &inputs, settings).expect("motion");
        let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
        let blocks = time(1, || {
            let step = check::step(&paper).f_y(F3, Q, |at| at.terms().mass * at.gamma + at.terms().phi_q_t_sigma_q);
            step.f_y_previous(F4, V, |at| -(at.terms().phi_q_t_sigma_q + at.terms().force_v)).run().assert_passed();
        });
        println!("  default check of two blocks of Eq. (10): {blocks:.1} ms");
    }
    let element = time(5, || check::constraint(&Revolute, ARMS).phi_q(|at| hinge_q(&at.q, &ARMS)).run().assert_passed());
    println!("default check of Φ_q of a hinge: {element:.3} ms");
}
