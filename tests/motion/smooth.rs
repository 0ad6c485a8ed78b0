//! Contacts with a smooth onset: how many steps a plain gradient needs, and how far the law is from the one with a kink.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Gradient, Grid, Inputs, Param, Scalar, Scene, Scheme, Settings, Solver, Sum, System, Warning,
};
use nalgebra::SVector;

struct Height;

impl Cost<1> for Height {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

const DURATION: f64 = 0.8;
const STIFFNESS: f64 = 1e6;
const WEIGHT: f64 = 9.81;

/// A ball of 1 kg that falls 1 m onto a floor; J is its height after 0.8 s.
fn ball(width: f64) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -WEIGHT);
    let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
    let law = [STIFFNESS, 0.0, 0.0, 1.0, width].map(Param::from);
    scene.circle_contact("floor", Body::GROUND.at(0.0, 0.0), std::f64::consts::FRAC_PI_2, ball.point(), 0.0, law);
    scene.cost("height", Height, Sum::Terminal, [ball.coordinates[1]], [], [], []);
    scene.compile().expect("a scene")
}

/// The greatest depth in the floor without a width, its speed at the first touch, and the duration of the contact (Hertz).
fn hertz() -> [f64; 3] {
    let depth = (2.5 * WEIGHT / STIFFNESS).powf(0.4);
    let speed = (2.0 * WEIGHT).sqrt();
    [depth, speed, 2.943 * depth / speed]
}

/// J and its gradient on equal steps.
fn found<'s>(solver: &'s mut Solver, system: &System, steps: usize) -> &'s Gradient {
    solver.simulate(&Inputs::at_rest(system, Grid::uniform(steps, DURATION / steps as f64))).expect("a motion");
    solver.gradient().expect("a gradient")
}

fn solver(system: &System, scheme: Scheme) -> Solver {
    Solver::new(system, Settings { scheme, ..Settings::default() })
}

/// z and dz/dh of the continuous motion.
fn truth(width: f64) -> [f64; 2] {
    let system = ball(width);
    let mut solver = solver(&system, Scheme::ESDIRK5);
    if width > 0.0 {
        let gradient = found(&mut solver, &system, 60_000);
        return [gradient.value, gradient.start.q()[1]];
    }
    let inputs = Inputs::at_rest(&system, Grid::uniform(4000, DURATION / 4000.0));
    let phases = solver.find_phases(&inputs, 2000).expect("phases");
    solver.simulate(&phases).expect("a motion");
    let gradient = solver.gradient().expect("a gradient");
    [gradient.value, gradient.start.q()[1]]
}

/// The number of steps in a contact, and the largest errors on eight grids of about that number: of dz/dh, of dz/dh without a warning, and of dz/dh
/// at frozen grid phase if a warning says so.
type Errors = (f64, [f64; 3]);

fn errors(width: f64, scheme: Scheme) -> Vec<Errors> {
    let (system, [.., contact]) = (ball(width), hertz());
    let mut solver = solver(&system, scheme);
    let exact = truth(width)[1];
    let mut error = |steps: usize| {
        let gradient = found(&mut solver, &system, steps);
        let of = |gradient: &Gradient| (gradient.start.q()[1] / exact - 1.0).abs();
        let warns = gradient.warnings.iter().any(|warning| matches!(warning, Warning::GridPhase { .. }));
        let frozen = gradient.frozen.as_deref().filter(|_| warns).map_or(0.0, of);
        [of(gradient), if warns { 0.0 } else { of(gradient) }, frozen]
    };
    let mut worst = |n: f64| {
        let steps = |phase: usize| (n * DURATION / contact * (1.0 + 0.011 * phase as f64)) as usize;
        let larger = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k].max(b[k]));
        (0..8).map(|phase| error(steps(phase))).fold([0.0; 3], larger)
    };
    (0..18).map(|k| 4.0 * 1.25f64.powi(k)).map(|n| (n, worst(n))).collect()
}

/// The number of steps in a contact from which on no error exceeds the bound.
fn needed(errors: &[Errors], bound: f64) -> f64 {
    let within = errors.iter().rev().take_while(|(_, [plain, ..])| *plain <= bound).last();
    within.map_or(f64::INFINITY, |(n, _)| *n)
}

#[test]
fn ten_steps_while_the_depth_crosses_the_width_give_gradients_without_events() {
    let [depth, speed, contact] = hertz();
    println!("deepest {depth:.4} m, contact {contact:.5} s");
    println!("w/δ, scheme, steps in a contact (while δ crosses w) for 5 % and for 1 %; errors with 12, 24, 48 steps");
    for share in [0.2, 0.5, 1.0, 2.0] {
        for scheme in [Scheme::TRAPEZOIDAL, Scheme::ESDIRK4] {
            let all = errors(share * depth, scheme);
            let crossing = share * depth / speed / contact;
            let [five, one] = [0.05, 0.01].map(|bound| needed(&all, bound));
            let at = [5, 8, 11].map(|k: usize| all[k].1[0]);
            let name = scheme.name;
            println!("{share:4} {name:16} {five:6.1} ({:.1}) {one:6.1} ({:.1}); {at:.4?}", five * crossing, one * crossing);
            assert!(five * crossing < 12.0 && one * crossing < 24.0, "{share} {name}");
            assert!(all.iter().all(|(_, [_, unwarned, _])| *unwarned < 0.05), "{share} {name}: {all:?}");
            // With 12 steps or more in the contact.
            assert!(all[5..].iter().all(|(_, [.., frozen])| *frozen < 0.1), "{share} {name}: {all:?}");
        }
    }
}

#[test]
fn the_smooth_law_is_close_to_the_one_with_a_kink() {
    let ([depth, ..], hard) = (hertz(), truth(0.0));
    assert!((hard[1] - 0.502_377).abs() < 1e-6, "{hard:?}");
    for (share, bound) in [(0.1, 2e-4), (0.5, 2e-4), (1.0, 5e-4), (2.0, 1e-2)] {
        let smooth = truth(share * depth);
        let (z, slope) = (smooth[0] - hard[0], smooth[1] / hard[1] - 1.0);
        println!("w/δ {share}: z off by {z:.1e} m, dz/dh by {:.3} %", 100.0 * slope);
        assert!(slope.abs() < bound && z.abs() < bound, "{share}: {z} {slope}");
    }
}
