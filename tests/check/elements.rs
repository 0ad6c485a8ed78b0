//! Right hand-derived blocks pass in any units; if the references or the inputs are at fault, the report says so.

use crate::hand::*;
use hamiltonian_adjoint::check::{self, Random, Report, Verdict};
use hamiltonian_adjoint::element::{Constraint, Cost, CostPoint};
use hamiltonian_adjoint::planar::{Damper, Distance, LinearSpring, Revolute};
use hamiltonian_adjoint::{PotentialEnergy, Scalar};
use nalgebra::SVector;

/// Lengths are measured in `length`, forces (or masses) in `force`, times in `time`, all relative to SI.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: f64,
    force: f64,
    time: f64,
}

fn units(random: &mut Random) -> Units {
    // Metres and kilograms, millimetres and tonnes, kilometres, micrometres, and 1e±6 in everything.
    let lengths = [1.0, 1e3, 1e-3, 1e6, 1e-6];
    let forces = [1.0, 1e-3, 1e3, 1e6, 1e-6];
    let times = [1.0, 1e3, 1e-3];
    Units { length: lengths[random.below(5)], force: forces[random.below(5)], time: times[random.below(3)] }
}

/// Sizes of two bodies' coordinates: x, y, φ each.
fn bodies(check: f64, angle: f64) -> SVector<f64, 6> {
    SVector::from([check, check, angle, check, check, angle])
}

fn seed(random: &mut Random) -> u64 {
    random.below(usize::try_from(1u64 << 40).unwrap_or(usize::MAX)) as u64
}

fn hinge(random: &mut Random) -> Report {
    let u = units(random);
    let b: [f64; 4] = std::array::from_fn(|_| random.uniform(-1.0, 1.0) * u.length);
    check::constraint(&Revolute, b)
        .random_points(4, seed(random))
        .magnitudes(|m| {
            m.q = bodies(u.length, 1.0);
            m.v = bodies(u.length, 1.0) / u.time;
            m.sigma.fill(u.force * u.time);
        })
        .phi_q(|at| hinge_q(&at.q, at.b.as_slice()))
        .phi_b(|at| hinge_b(&at.q))
        .phi_q_v_q(|at| hinge_q_v_q(&at.q, &at.v, at.b.as_slice()))
        .phi_q_t_sigma_q(|at| hinge_t_sigma_q(&at.q, &at.sigma, at.b.as_slice()))
        .phi_dot_q_t_sigma_q(|at| hinge_dot_t_sigma_q(&at.q, &at.v, &at.sigma, at.b.as_slice()))
        .run()
}

fn rod(random: &mut Random) -> Report {
    let u = units(random);
    let b: [f64; 5] = std::array::from_fn(|_| random.away_from_zero(1.0).abs() * u.length);
    check::constraint(&Distance, b)
        .random_points(4, seed(random))
        .magnitudes(|m| (m.q, m.v) = (bodies(u.length, 1.0), bodies(u.length, 1.0) / u.time))
        .vary_constants(0.2)
        .phi_q(|at| rod_q(&at.q, at.b.as_slice()))
        .phi_q_v_q(|at| rod_q_v_q(&at.q, &at.v, at.b.as_slice()))
        .run()
}

fn spring_and_damper(random: &mut Random) -> Vec<Report> {
    let u = units(random);
    let arm: [f64; 4] = std::array::from_fn(|_| random.uniform(-0.5, 0.5) * u.length);
    let stiffness = random.uniform(1.0, 100.0) * u.force / u.length;
    let spring = [arm[0], arm[1], arm[2], arm[3], stiffness, 0.3 * u.length];
    let damper = [arm[0], arm[1], arm[2], arm[3], stiffness * u.time];
    let apart = |q: &Six| between(q, &arm).norm() > 0.1 * u.length;
    let spring = check::potential_energy(&LinearSpring, spring)
        .random_points(4, seed(random))
        .magnitudes(|m| m.q = bodies(u.length, 1.0))
        .admissible(|at| apart(&at.q))
        .v_q(|at| spring_q(&at.q, at.b.as_slice()))
        .v_qq(|at| spring_qq(&at.q, at.b.as_slice()))
        .run();
    let damper = check::force(&Damper, damper)
        .random_points(4, seed(random))
        .magnitudes(|m| (m.q, m.v) = (bodies(u.length, 1.0), bodies(u.length, 1.0) / u.time))
        .admissible(|at| apart(&at.q))
        .q_v(|at| damper_v(&at.q, at.b.as_slice()))
        .q_q(|at| damper_q(&at.q, &at.v, at.b.as_slice()))
        .run();
    vec![spring, damper]
}

fn pendulum(random: &mut Random) -> Vec<Report> {
    let u = units(random);
    let mass = u.force * u.time * u.time / u.length;
    let size = |random: &mut Random| random.away_from_zero(1.0).abs();
    let b = [size(random) * mass, size(random) * mass, size(random) * u.length, size(random) * u.length];
    let kinetic = check::kinetic_energy(&DoublePendulum, b)
        .random_points(4, seed(random))
        .magnitudes(|m| m.v.fill(1.0 / u.time))
        .mass(|at| pendulum_mass(&at.q, &at.b))
        .mass_v_q(|at| pendulum_mass_v_q(&at.q, &at.v, &at.b))
        .t_q(|at| pendulum_t_q(&at.q, &at.v, &at.b))
        .t_qq(|at| pendulum_t_qq(&at.q, &at.v, &at.b))
        .run();
    let potential = check::potential_energy(&DoublePendulum, b)
        .random_points(4, seed(random))
        .v_q(|at| pendulum_v_q(&at.q, &at.b))
        .run();
    vec![kinetic, potential]
}

#[test]
fn a_thousand_right_blocks_in_all_units_pass() {
    let mut random = Random::new(2024);
    let mut blocks = 0;
    let (mut wrong, mut undecided) = (0, 0);
    let mut worst: f64 = 0.0;
    while blocks < 1000 {
        let (hinge, rod) = (hinge(&mut random), rod(&mut random));
        let reports = [vec![hinge, rod], spring_and_damper(&mut random), pendulum(&mut random)].concat();
        for report in reports {
            for block in &report.blocks {
                blocks += 1;
                worst = worst.max(block.relative_error);
                wrong += usize::from(block.verdict == Verdict::Wrong);
                undecided += usize::from(!matches!(block.verdict, Verdict::Right | Verdict::Wrong));
            }
            if !report.passed() {
                println!("{report}");
            }
        }
    }
    println!(
        "{blocks} right blocks: {wrong} called wrong, {undecided} undecided; the largest relative error is {worst:.1e}"
    );
    assert_eq!((wrong, undecided), (0, 0));
}

#[test]
fn a_check_of_nothing_fails() {
    let report = check::constraint(&Revolute, [0.0; 4]).run();
    assert_eq!(report.verdict(), Verdict::NothingCompared);
    let report = check::constraint(&Revolute, [0.0; 4]).random_points(0, 1).phi_q(|at| hinge_q(&at.q, &[0.0; 4])).run();
    assert_eq!(report.verdict(), Verdict::NothingCompared);
    let never = check::constraint(&Revolute, [0.0; 4]).admissible(|_| false).phi_q(|at| hinge_q(&at.q, &[0.0; 4])).run();
    assert!(!never.passed(), "{never}");
    println!("{report}{never}");
}

/// A gradient may be written as a column, also where nothing explains the mistake and the check looks for where it vanishes.
#[test]
fn a_gradient_by_hand_may_be_a_column() {
    let report = check::kinetic_energy(&DoublePendulum, [0.8, 0.4, 1.1, 0.9])
        .t_q(|at| pendulum_t_q(&at.q, &at.v, &at.b) + Two::new(at.q[0].exp() * at.v[1], 0.0))
        .run();
    println!("{report}");
    assert_eq!(report.verdict(), Verdict::Wrong);
}

/// Φ = |x|: no derivative at 0, and a formula that loses the derivative of its second coordinate.
struct Kink;
impl Constraint<1, 1> for Kink {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, _: S) -> SVector<S, 1> {
        SVector::from([q[0].abs()])
    }
}

struct Loses;
impl PotentialEnergy<2> for Loses {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, _: &SVector<S, 0>, _: S) -> S {
        q[0] * q[0] * S::from(q[1].re().sin())
    }
}

struct Root;
impl Cost<1> for Root {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0].sqrt()
    }
}

#[test]
fn the_formula_is_blamed_where_the_formula_is_wrong() {
    let at = |x: f64| check::Point::<1, 1>::zero([]).with_q([x]);
    let kink = check::constraint(&Kink, []).at(at(0.0)).phi_q(|at| at.q[0].signum()).run();
    println!("{kink}");
    assert_eq!(kink.verdict(), Verdict::ReferencesDisagree);
    assert!(kink.blocks[0].notes[0].contains("kink"));

    let beside = check::constraint(&Kink, []).at(at(0.0)).at(at(0.3)).at(at(-0.2)).phi_q(|at| at.q[0].signum()).run();
    println!("{beside}");
    assert!(beside.passed());
    assert_eq!((beside.blocks[0].points, beside.blocks[0].set_aside), (2, 1));

    let loses = check::potential_energy(&Loses, [])
        .v_q(|at| [2.0 * at.q[0] * at.q[1].sin(), at.q[0] * at.q[0] * at.q[1].cos()])
        .v_qq(|at| [[2.0 * at.q[1].sin(), 0.0], [0.0, 0.0]])
        .run();
    println!("{loses}");
    assert!(loses.blocks.iter().all(|block| block.verdict == Verdict::ReferencesDisagree));

    // (Φ_q v)_q of |x| is zero on both sides of its kink; the kink is found in Φ itself.
    let below = check::constraint(&Kink, []).at(at(0.0).with_v([1.0])).phi_q_v_q(|_| 0.0).run();
    println!("{below}");
    assert_eq!(below.verdict(), Verdict::ReferencesDisagree);

    let root = check::cost(&Root, []).at(check::Point::zero([])).h_q(|_| 0.0).run();
    println!("{root}");
    assert_eq!(root.verdict(), Verdict::ReferencesDisagree);
    // Negative arguments are drawn again.
    check::cost(&Root, []).h_q(|at| 0.5 / at.q[0].sqrt()).run().assert_passed();
}
