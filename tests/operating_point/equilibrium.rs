//! Equilibria against other computations, and their derivatives against new equilibria.

use crate::cases::{all, apart, differences, inputs, parallelogram};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Mechanics, Scene, Start, System};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

/// The angles of a hanging chain of rods between supports, and the force (H, V) on the left one, from the balance of each rod.
fn hanging_chain(rods: usize, length: f64, weight: f64, span: [f64; 2]) -> (Vec<f64>, Vector2<f64>) {
    let angle = |h: f64, v: f64, i: usize| (-(v - (i as f64 + 0.5) * weight)).atan2(h);
    // The gap at the right support, and its derivative by the force on the left one.
    let gap = |force: Vector2<f64>| {
        let (mut end, mut slope) = (Vector2::new(-span[0], -span[1]), Matrix2::zeros());
        for i in 0..rods {
            let (h, down) = (force.x, force.y - (i as f64 + 0.5) * weight);
            let tension = h.hypot(down);
            end += Vector2::new(h, -down) * (length / tension);
            slope += Matrix2::new(down * down, -h * down, h * down, -h * h) * (length / tension.powi(3));
        }
        (end, slope)
    };
    let mut force = Vector2::new(0.3 * weight * rods as f64, 0.5 * weight * rods as f64);
    for _ in 0..60 {
        let (end, slope) = gap(force);
        let by = slope.try_inverse().expect("regular") * end;
        let shares = (0..20).map(|k| 0.5f64.powi(k));
        let share = shares.into_iter().find(|share| gap(force - by * *share).0.norm() < end.norm());
        force -= by * share.unwrap_or(0.0);
    }
    ((0..rods).map(|i| angle(force.x, force.y, i)).collect(), force)
}

/// A chain of rods of 0.3 m and 0.5 kg, from a guess on a straight line.
fn chain(rods: usize, span: [f64; 2]) -> (System, Vec<Body>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let support = [scene.design("x", span[0]), scene.design("y", span[1])];
    let along = |i: usize| (i as f64 + 0.5) / rods as f64;
    let place = |i: usize| [along(i) * span[0], along(i) * span[1] - 0.4 * (3.0 * along(i)).sin(), 0.8 - 1.6 * along(i)];
    let bodies: Vec<Body> = (0..rods).map(|i| scene.body(&format!("rod {i}"), 0.5, 0.004, place(i))).collect();
    let mut last = Body::GROUND.at(0.0, 0.0);
    for (i, body) in bodies.iter().enumerate() {
        scene.revolute(&format!("hinge {i}"), last, body.at(-0.15, 0.0));
        last = body.at(0.15, 0.0);
    }
    scene.revolute("support", last, Body::GROUND.at(support[0], support[1]));
    (scene.compile().expect("a scene"), bodies)
}

#[test]
fn a_hanging_chain_has_the_shape_and_the_forces_of_the_balance_of_its_rods() {
    let (rods, span) = (12, [2.0, 0.5]);
    let (system, bodies) = chain(rods, span);
    let guess = system.initial_coordinates();
    let at = Mechanics::new(&system, guess.as_slice(), &vec![0.0; system.n()]).expect("a guess");
    let found = at.stable_equilibrium(&[]).expect("an equilibrium");
    let (angles, force) = hanging_chain(rods, 0.3, 0.5 * 9.81, span);
    for (body, angle) in bodies.iter().zip(&angles) {
        let ours = found.state.q()[body.coordinates[2].index()];
        assert!((ours - angle).sin().abs() < 1e-13 && (ours - angle).cos() > 0.0, "{ours} {angle}");
    }
    // The first hinge pulls its rod to the left and upwards.
    let reaction = found.state.phi_q().rows(0, 2).transpose() * found.lambda.rows(0, 2);
    let on_first = Vector2::new(-reaction[0], -reaction[1]);
    assert!((on_first - Vector2::new(-force.x, force.y)).norm() < 1e-11, "{on_first} {force}");
    assert!(found.is_stable() && found.eigenvalues.iter().all(|s| s.im.abs() > 1.0));
    // The shape and the forces for other supports.
    for which in 0..2 {
        let moved = |by: f64| {
            let mut span = span;
            span[which] += by;
            let (angles, force) = hanging_chain(rods, 0.3, 0.5 * 9.81, span);
            DVector::from_vec([angles, vec![force.x, -force.y]].concat())
        };
        let expected = differences(moved);
        let of_angles = bodies.iter().map(|body| found.by_design.q[(body.coordinates[2].index(), which)]);
        let reaction = found.state.phi_q().rows(0, 2).transpose() * found.by_design.lambda.view((0, which), (2, 1));
        let ours = DVector::from_iterator(rods + 2, of_angles.chain([reaction[0], reaction[1]]));
        assert!((&ours - &expected).amax() < 1e-8 * expected.amax(), "{ours}{expected}");
    }
}

/// The mechanisms that can be at rest, with a drive at its turning point.
fn at_rest() -> impl Iterator<Item = (&'static str, System, Mechanics)> {
    let can_rest = |name: &str| !["cart", "driven"].contains(&name);
    all().into_iter().filter(move |(name, _, _)| can_rest(name))
}

#[test]
fn forces_balance_and_derivatives_are_those_of_new_equilibria_for_mechanisms_of_every_kind() {
    for (name, system, at) in at_rest() {
        let found = at.stable_equilibrium(&[]).expect(name);
        assert!(found.state.phi().iter().enumerate().all(|(j, phi)| is_open(&at, j) || phi.abs() < 1e-12), "{name}");
        assert!(found.state.v().iter().all(|v| *v == 0.0) && found.holding.amax() == 0.0);
        let (v_dot, lambda) = found.state.accelerations().expect(name);
        assert!(v_dot.amax() < 1e-9, "{name}: {v_dot}");
        let reaction = |lambda: &DVector<f64>| found.state.phi_q().tr_mul(lambda);
        assert!((reaction(&lambda) - reaction(&found.lambda)).amax() < 1e-9, "{name}");
        let again = |u: &[f64], design: &DVector<f64>| {
            let mut inputs = inputs(&system, &at, u, design);
            inputs.start = Start::Assembled {
                q: DVector::from_column_slice(found.state.q()),
                v: DVector::zeros(system.n()),
                held: Default::default(),
            };
            let near = Mechanics::at_start(&system, &inputs).expect(name).equilibrium(&[]).expect(name);
            // Reactions on the coordinates are unique even if constraints depend on each other.
            let reaction = near.state.phi_q().tr_mul(&near.lambda);
            DVector::from_vec([near.state.q(), reaction.as_slice()].concat())
        };
        let ours = |of: &hamiltonian_adjoint::Sensitivity, j: usize| {
            let (q, lambda) = (of.q.column(j).into_owned(), of.lambda.column(j).into_owned());
            // (Φ_qᵀ λ)' along q' by differences of Φ_q at constant λ, and with λ'.
            let turned = differences(|by| {
                let q: Vec<f64> = found.state.q().iter().zip(q.iter()).map(|(q, dot)| q + by * dot).collect();
                let design = system.design_values()
                    + unit(system.designs(), j, if std::ptr::eq(of, &found.by_design) { by } else { 0.0 });
                let there = Mechanics::new(&system, &q, &vec![0.0; system.n()]).expect(name);
                there.with_design(design.as_slice()).expect(name).phi_q().tr_mul(&found.lambda)
            });
            DVector::from_vec([q.as_slice(), (turned + reaction(&lambda)).as_slice()].concat())
        };
        let (u, design) = (at.controls().to_vec(), system.design_values());
        for j in 0..u.len() {
            let expected =
                differences(|by| again((DVector::from_column_slice(&u) + unit(u.len(), j, by)).as_slice(), &design));
            let ours = ours(&found.by_controls, j);
            assert!((&ours - &expected).amax() < 1e-7 * expected.amax().max(1.0), "{name}, control {j}: {ours}{expected}");
        }
        let mut most = 0.0f64;
        for j in 0..design.len() {
            let expected = differences(|by| again(&u, &(&design + unit(design.len(), j, by))));
            let ours = ours(&found.by_design, j);
            assert!((&ours - &expected).amax() < 1e-7 * expected.amax().max(1.0), "{name}, design {j}: {ours}{expected}");
            most = most.max(expected.amax());
        }
        assert!(most > 1e-3, "{name}: the test is empty");
    }
}

fn unit(len: usize, j: usize, by: f64) -> DVector<f64> {
    DVector::from_fn(len, |i, _| if i == j { by } else { 0.0 })
}

fn is_open(at: &Mechanics, j: usize) -> bool {
    at.open().iter().any(|open| open.index() == j)
}

#[test]
fn eigenvalues_are_those_of_the_linear_model_there() {
    for (name, _, at) in at_rest() {
        let found = at.stable_equilibrium(&[]).expect(name);
        let linear = found.state.linear_model(&[]).expect(name);
        let most = linear.eigenvalues.iter().map(|s| s.norm()).fold(0.0, f64::max);
        assert_eq!(found.eigenvalues.len(), linear.eigenvalues.len(), "{name}");
        for s in &found.eigenvalues {
            let nearest = linear.eigenvalues.iter().map(|other| (other - s).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9 * most, "{name}: {s} {:?}", linear.eigenvalues);
        }
        assert!(found.is_stable(), "{name}");
    }
}

#[test]
fn a_massless_crank_that_makes_constraints_dependent_changes_no_equilibrium() {
    let [few, many] = [2, 3].map(|cranks| {
        let (system, [crank, coupler]) = parallelogram(cranks, 0.0);
        let q = system.initial_coordinates();
        let at = Mechanics::new(&system, q.as_slice(), &vec![0.0; system.n()]).expect("a state");
        let found = at.with_controls(&[2.0]).expect("a torque").equilibrium(&[]).expect("an equilibrium");
        let rows = [crank.coordinates[2].index(), coupler.coordinates[0].index(), coupler.coordinates[1].index()];
        let of = |matrix: &DMatrix<f64>| DMatrix::from_fn(3, matrix.ncols(), |i, j| matrix[(rows[i], j)]);
        let q = DMatrix::from_column_slice(system.n(), 1, found.state.q());
        assert_eq!(found.eigenvalues.len(), 2);
        ([of(&q), of(&found.by_controls.q), of(&found.by_design.q)], found.eigenvalues[0], [system.n(), system.m()])
    });
    assert_eq!((few.2, many.2), ([9, 8], [12, 12]));
    few.0.iter().zip(&many.0).for_each(|(few, many)| assert!(apart(few, many) < 1e-12, "{few}{many}"));
    assert!((few.1 - many.1).norm() < 1e-11 * few.1.norm());
}
