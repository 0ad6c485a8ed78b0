//! Blocks of Eq. (10): right ones pass at many random states, in metres and kilograms as in millimetres and tonnes.

use hamiltonian_adjoint::check::{self, Mistake, Verdict};
use hamiltonian_adjoint::paper_system::Equation::{F1, F2, F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{PStar, PStarDot, Q, Sigma, V};
use hamiltonian_adjoint::{Grid, Inputs, Settings, System, Trajectory, scenes::CartPendulum, simulate};
use nalgebra::DMatrix;

/// The paper's example with lengths in units of 1/`length` m and masses in units of 1/`mass` kg.
fn cart(length: f64, mass: f64) -> (System, Inputs, Trajectory) {
    let si = CartPendulum::default();
    let inertia = mass * length * length;
    let scene = CartPendulum {
        cart_mass: si.cart_mass * mass,
        link_mass: si.link_mass * mass,
        cart_inertia: si.cart_inertia * inertia,
        link_inertia: si.link_inertia * inertia,
        link_length: length,
        rail_friction: si.rail_friction * mass,
        hinge_friction: si.hinge_friction * inertia,
        gravity: si.gravity * length,
        ..si
    };
    let system = scene.scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
    inputs.controls.fill(10.0 * mass * length);
    let settings = Settings { position_tolerance: 1e-9 * length, velocity_tolerance: 1e-9 * length, ..Settings::default() };
    let motion = simulate(&system, &inputs, settings).unwrap_or_else(|stopped| panic!("{stopped}"));
    (system, inputs, motion)
}

fn identity(at: &check::StepPoint) -> DMatrix<f64> {
    DMatrix::identity(at.y.q.len(), at.y.q.len())
}

#[test]
fn right_blocks_pass_in_all_units() {
    let (mut blocks, mut worst) = (0, 0.0f64);
    for (length, mass) in [(1.0, 1.0), (1e3, 1e-3), (1e-3, 1.0), (1e-3, 1e3), (1e3, 1e6)] {
        let (system, inputs, motion) = cart(length, mass);
        let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
        for seed in 0..4 {
            let report = check::step(&paper)
                .seed(seed)
                .f_y(F1, Q, |at| identity(at) * -at.gamma)
                .f_y(F2, PStar, |at| identity(at) * -at.gamma)
                .f_y(F3, Q, |at| at.terms().mass * at.gamma + at.terms().phi_q_t_sigma_q)
                .f_y(F3, Sigma, |at| at.terms().phi_q.transpose())
                .f_y(F4, Q, |at| {
                    let t = at.terms();
                    t.force_q + (t.force_v + t.phi_q_t_sigma_q) * at.gamma + t.phi_dot_q_t_sigma_q
                })
                .f_y(F4, Sigma, |at| at.terms().phi_dot_q.transpose())
                .f_y(F5, Q, |at| at.terms().phi_q * at.gamma + at.terms().phi_dot_q)
                .f_y_previous(F1, Q, |at| identity(at) * at.gamma)
                .f_y_previous(F3, V, |at| -at.terms().mass)
                .f_y_previous(F4, V, |at| -(at.terms().phi_q_t_sigma_q + at.terms().force_v))
                .f_y_previous(F4, PStarDot, identity)
                .f_y_previous(F5, Q, |at| at.terms().phi_q * -at.gamma)
                .f_u(F4, |at| at.terms().force_u)
                .run();
            report.assert_passed();
            blocks += report.blocks.len();
            worst = report.blocks.iter().fold(worst, |m, block| m.max(block.relative_error));
        }
    }
    println!("{blocks} right blocks of Eq. (10) pass; the largest relative error is {worst:.1e}");
}

#[test]
fn f_0_is_no_step_and_nothing_is_no_success() {
    let (system, inputs, motion) = cart(1.0, 1.0);
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let report = check::step(&paper).nodes([0, 99]).f_y(F1, V, identity).run();
    println!("{report}");
    assert_eq!(report.verdict(), Verdict::NothingCompared);
}

#[test]
fn controls_are_named() {
    let (system, inputs, motion) = cart(1.0, 1.0);
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let report = check::step(&paper).f_u(F4, |at| at.terms().force_u * at.dt).run();
    println!("{report}");
    assert_eq!(report.blocks[0].diagnoses[0].mistake, Mistake::Factor);
    assert_eq!(report.blocks[0].entries[0].row, "f4 of `cart.x`");
    assert_eq!(report.blocks[0].entries[0].column, "`force on the cart`");
}

/// The cart does not turn and does not leave its rail: two velocities are zero at all nodes.
#[test]
fn the_node_before_is_recognised_where_coordinates_rest() {
    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    inputs.controls.fill(10.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let step = check::step(&paper).nodes([5, 9]).on_the_motion();
    let report = step.f_y_previous(F5, V, |at| -at.previous_terms().phi_q).run();
    println!("{report}");
    assert_eq!(report.blocks[0].diagnoses[0].mistake, Mistake::OtherArgument);
}
