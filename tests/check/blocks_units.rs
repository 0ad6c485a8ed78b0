//! Blocks by hand in other units: the same verdicts and mistakes.

use crate::hand::*;
use hamiltonian_adjoint::check::{self, Mistake, Report, Verdict};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, Sigma, V};
use hamiltonian_adjoint::planar::{Damper, Distance, LinearSpring, Revolute};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Settings, simulate};
use nalgebra::{DMatrix, SMatrix, SVector};

#[derive(Clone, Copy, Debug)]
struct Units {
    mass: f64,
    length: f64,
    time: f64,
}
const SI: Units = Units { mass: 1.0, length: 1.0, time: 1.0 };

const OTHERS: [Units; 5] = [
    Units { mass: 1.0 / 1048576.0, ..SI },
    Units { length: 1048576.0, ..SI },
    Units { length: 1.0 / 1099511627776.0, ..SI },
    Units { time: 1048576.0, ..SI },
    Units { mass: 1024.0, length: 1.0 / 1024.0, time: 1024.0 },
];

fn bodies(length: f64, angle: f64) -> SVector<f64, 6> {
    SVector::from([length, length, angle, length, length, angle])
}

/// Makes a block wrong in one of many ways.
fn wrong<const R: usize, const C: usize>(how: usize, mut a: SMatrix<f64, R, C>) -> SMatrix<f64, R, C> {
    match how {
        0 => {}
        1 => a = -a,
        2 => a *= 2.0,
        _ => unreachable!("a way to be wrong"),
    }
    a
}

fn elements(u: Units, how: usize) -> Vec<Report> {
    let (l, t) = (u.length, u.time);
    let force = u.mass * l / (t * t);
    let speeds = bodies(l, 1.0) / t;
    let hinge = check::constraint(&Revolute, [0.3, -0.2, 0.7, 0.1].map(|x| x * l))
        .random_points(4, 3)
        .magnitudes(|m| {
            m.q = bodies(l, 1.0);
            m.v = speeds;
            m.sigma.fill(force * t);
            m.t = t;
        })
        .phi_q(|at| wrong(how, SMatrix::<f64, 2, 6>::from_fn(|i, j| hinge_q(&at.q, at.b.as_slice())[(i, j)])))
        .phi_q_t_sigma_q(|at| {
            wrong(how, SMatrix::<f64, 6, 6>::from_fn(|i, j| hinge_t_sigma_q(&at.q, &at.sigma, at.b.as_slice())[(i, j)]))
        })
        .run();
    let b = [0.3, 0.2, 0.5, 0.4, 0.7].map(|x| x * l);
    let rod = check::constraint(&Distance, b)
        .random_points(4, 3)
        .magnitudes(|m| {
            m.q = bodies(l, 1.0);
            m.v = speeds;
            m.sigma.fill(force * t);
            m.t = t;
        })
        .phi_q(|at| wrong(how, SMatrix::<f64, 1, 6>::from_fn(|i, j| rod_q(&at.q, at.b.as_slice())[(i, j)])))
        .phi_q_v_q(|at| wrong(how, SMatrix::<f64, 1, 6>::from_fn(|i, j| rod_q_v_q(&at.q, &at.v, at.b.as_slice())[(i, j)])))
        .run();
    let arm = [0.3, -0.2, 0.4, 0.1].map(|x| x * l);
    let stiffness = 37.0 * force / l;
    let spring = [arm[0], arm[1], arm[2], arm[3], stiffness, 0.3 * l];
    let damper = [arm[0], arm[1], arm[2], arm[3], stiffness * t];
    let apart = |q: &Six| between(q, &arm).norm() > 0.1 * l;
    let spring = check::potential_energy(&LinearSpring, spring)
        .random_points(4, 3)
        .magnitudes(|m| (m.q, m.t) = (bodies(l, 1.0), t))
        .admissible(|at| apart(&at.q))
        .v_q(|at| wrong(how, SMatrix::<f64, 6, 1>::from_fn(|i, _| spring_q(&at.q, at.b.as_slice())[i])))
        .v_qq(|at| wrong(how, SMatrix::<f64, 6, 6>::from_fn(|i, j| spring_qq(&at.q, at.b.as_slice())[(i, j)])))
        .run();
    let damper = check::force(&Damper, damper)
        .random_points(4, 3)
        .magnitudes(|m| (m.q, m.v, m.t) = (bodies(l, 1.0), speeds, t))
        .admissible(|at| apart(&at.q))
        .q_v(|at| wrong(how, SMatrix::<f64, 6, 6>::from_fn(|i, j| damper_v(&at.q, at.b.as_slice())[(i, j)])))
        .q_q(|at| wrong(how, SMatrix::<f64, 6, 6>::from_fn(|i, j| damper_q(&at.q, &at.v, at.b.as_slice())[(i, j)])))
        .run();
    vec![hinge, rod, spring, damper]
}

/// Name, verdict, mistakes, and how many entries are wrong, points and places where it bends were compared.
type Said = (String, Verdict, Vec<Mistake>, [usize; 3]);

fn said(reports: &[Report]) -> Vec<Said> {
    let of = |block: &check::BlockReport| {
        let mistakes = block.diagnoses.iter().map(|diagnosis| diagnosis.mistake).collect();
        (block.name.clone(), block.verdict, mistakes, [block.wrong_entries, block.points, block.bends])
    };
    reports.iter().flat_map(|report| report.blocks.iter().map(of)).collect()
}

/// The same in all units, and right if nothing was made wrong.
fn assert_same(how: usize, run: impl Fn(Units) -> Vec<Report>) {
    let plain = said(&run(SI));
    let is_right = |said: &Said| said.1 == Verdict::Right;
    assert!(plain.iter().any(is_right) == (how == 0) && (how > 0 || plain.iter().all(is_right)), "{how}: {plain:?}");
    OTHERS.into_iter().for_each(|units| assert_eq!(said(&run(units)), plain, "{how}: {units:?}"));
}

#[test]
fn elements_are_judged_the_same() {
    for how in 0..3 {
        assert_same(how, |units| elements(units, how));
    }
}

fn step(u: Units, how: usize) -> Vec<Report> {
    let si = CartPendulum::default();
    let inertia = u.mass * u.length * u.length;
    let scene = CartPendulum {
        cart_mass: si.cart_mass * u.mass,
        link_mass: si.link_mass * u.mass,
        cart_inertia: si.cart_inertia * inertia,
        link_inertia: si.link_inertia * inertia,
        link_length: u.length,
        rail_friction: si.rail_friction * u.mass / u.time,
        hinge_friction: si.hinge_friction * inertia / u.time,
        gravity: si.gravity * u.length / (u.time * u.time),
        ..CartPendulum::with_links(1)
    };
    let system = scene.scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02 * u.time));
    inputs.controls.fill(10.0 * u.mass * u.length / (u.time * u.time));
    let free = f64::INFINITY;
    let settings = Settings { position_tolerance: free, velocity_tolerance: free, ..Settings::default() };
    let motion = simulate(&system, &inputs, settings).unwrap_or_else(|stopped| panic!("{stopped}"));
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let wrong = |mut a: DMatrix<f64>| {
        match how {
            0 => {}
            1 => a = -a,
            2 => a *= 2.0,
            _ => {
                let first = (0..a.len()).find(|&i| a[i] != 0.0).expect("an entry");
                a[first] *= 1.0 + 1e-9;
            }
        }
        a
    };
    let report = check::step(&paper)
        .f_y(F3, Q, |at| wrong(at.terms().mass * at.gamma + at.terms().phi_q_t_sigma_q))
        .f_y(F4, Q, |at| {
            let t = at.terms();
            wrong(t.force_q + (t.force_v + t.phi_q_t_sigma_q) * at.gamma + t.phi_dot_q_t_sigma_q)
        })
        .f_y(F4, Sigma, |at| wrong(at.terms().phi_dot_q.transpose()))
        .f_y_previous(F4, V, |at| wrong(-(at.terms().phi_q_t_sigma_q + at.terms().force_v)))
        .f_y_previous(F5, Q, |at| wrong(at.terms().phi_q * -at.gamma))
        .f_u(F4, |at| wrong(at.terms().force_u))
        .run();
    vec![report]
}

#[test]
fn steps_are_judged_the_same() {
    for how in 0..4 {
        assert_same(how, |units| step(units, how));
    }
}
