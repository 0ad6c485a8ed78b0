//! Checks of derivatives say the same in all units: powers of two as factors change no digit.

use hamiltonian_adjoint::check::{self, Input, Mistake, Part, Verdict};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Cost, CostPoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Start, Sum, System, gradient};
use nalgebra::SVector;

/// The units of mass, length, time and cost, in parts of which all numbers are given.
#[derive(Clone, Copy, Debug)]
struct Units {
    mass: f64,
    length: f64,
    time: f64,
    cost: f64,
}

const SI: Units = Units { mass: 1.0, length: 1.0, time: 1.0, cost: 1.0 };

/// Each by itself by 2^±10, 2^±20, 2^±40, and some together.
fn others() -> Vec<Units> {
    let mut all = Vec::new();
    for exponent in [-40, -20, -10, 10, 20, 40] {
        let factor = 2f64.powi(exponent);
        all.extend([
            Units { mass: factor, ..SI },
            Units { length: factor, ..SI },
            Units { time: factor, ..SI },
            Units { cost: factor, ..SI },
            Units { mass: factor, length: factor.recip(), time: factor, cost: factor },
        ]);
    }
    all
}

impl Units {
    fn velocity(self) -> f64 {
        self.length / self.time
    }

    fn force(self) -> f64 {
        self.mass * self.length / (self.time * self.time)
    }

    fn energy(self) -> f64 {
        self.force() * self.length
    }
}

/// h = c (a + (x/ℓ)² + φ² + ε (v/ν)² + ε (F/f)² + ε (M/m)²); b = [c, a, ℓ, ν, f, m].
struct Motion;
impl Cost<2, 0, 2, 6> for Motion {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 2>, b: &SVector<S, 6>) -> S {
        let state = (at.q[0] / b[2]).powi(2) + at.q[1] * at.q[1] + (at.v[0] / b[3]).powi(2) * 0.01;
        let effort = (at.u[0] / b[4]).powi(2) + (at.u[1] / b[5]).powi(2);
        b[0] * (b[1] + state + effort * 0.01)
    }
}

/// A cart on a rail with a pendulum, a force, a torque and a spring.
fn system(units: Units, offset: f64) -> System {
    let mut scene = Scene::new();
    let acceleration = units.velocity() / units.time;
    scene.gravity(0.0, -9.81 * acceleration);
    let mass = scene.design("mass of the link", 0.7 * units.mass);
    let stiffness = scene.design("stiffness", 30.0 * units.force() / units.length);
    let length = scene.design("free length", 0.4 * units.length);
    let inertia = units.mass * units.length * units.length;
    let cart = scene.body("cart", 1.3 * units.mass, inertia, [0.3 * units.length, 0.0, 0.0]);
    let link = scene.body("link", mass, 0.06 * inertia, [0.3 * units.length, -0.5 * units.length, -1.2]);
    let origin = Body::GROUND.at(0.0, 0.0);
    scene.prismatic("rail", origin, 0.0, cart.at(0.0, 0.0), 0.0);
    let hinge = scene.at_world(link, 0.3 * units.length, 0.0);
    scene.revolute("hinge", cart.at(0.0, 0.0), hinge);
    let anchor = Body::GROUND.at(units.length, -units.length);
    let damping = 0.3 * units.force() / units.velocity();
    scene.spring_damper("spring", anchor, link.at(0.1 * units.length, 0.0), stiffness, length, damping);
    let [force, torque] = ["force", "torque"].map(|name| scene.control(name));
    scene.actuator("push", origin, 0.0, cart.at(0.0, 0.0), force);
    scene.torque_actuator("turn", cart, link, torque);
    let constants = [units.cost / units.time, offset, units.length, units.velocity(), units.force(), units.energy()];
    let of = [cart.coordinates[0], link.coordinates[2]];
    scene.cost("motion", Motion, Sum::Trapezoidal, of, [], [force, torque], constants.map(Into::into));
    scene.compile().expect("a scene")
}

fn inputs(units: Units, system: &System, at_rest: bool) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(30, 0.02 * units.time));
    if at_rest {
        return inputs;
    }
    for node in 0..inputs.grid.nodes() {
        inputs.controls[(0, node)] = (0.3 * node as f64).sin() * units.force();
        inputs.controls[(1, node)] = (0.2 * node as f64).cos() * units.energy();
    }
    let mut v = nalgebra::DVector::zeros(6);
    (v[0], v[3]) = (0.5 * units.velocity(), 0.5 * units.velocity());
    inputs.start = Start::Velocity { q: system.initial_coordinates(), v };
    inputs
}

/// A row of a report, without units.
#[derive(Debug)]
struct Said {
    name: String,
    verdict: Verdict,
    /// Of dJ, or of how many numbers are wrong.
    size: f64,
    mistakes: Vec<Mistake>,
}

/// What a check says of the library's gradient, and of gradients of one's own.
fn said(units: Units, offset: f64, at_rest: bool, own: &[Own]) -> Vec<Said> {
    let system = system(units, offset);
    let inputs = inputs(units, &system, at_rest);
    let right = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let mut check = check::gradient(&system, &inputs, Settings::default());
    for (name, part, change) in own {
        let all = Input::all(&inputs).into_iter().filter(|input| is_of(*part, input));
        let values = all.enumerate().map(|(j, input)| change(j, input.in_gradient(&right)));
        check = check.own(name, *part, values);
    }
    let report = check.run().expect("a motion");
    let rows = report.directions.iter().map(|row| {
        let (name, size) = (row.name.clone(), row.size / units.cost);
        Said { name, verdict: row.verdict, size, mistakes: Vec::new() }
    });
    let own = report.own.iter().map(|own| {
        let mistakes = own.diagnoses.iter().map(|diagnosis| diagnosis.mistake).collect();
        Said { name: own.name.clone(), verdict: own.verdict, size: own.wrong_entries as f64, mistakes }
    });
    let whole = Said { name: "all".into(), verdict: report.verdict(), size: 0.0, mistakes: Vec::new() };
    rows.chain(own).chain([whole]).collect()
}

/// A name, a part of the inputs, and what is made of the right derivatives.
type Own = (&'static str, Part, Change);
type Change = fn(usize, f64) -> f64;

fn is_of(part: Part, input: &Input) -> bool {
    match input {
        Input::Control { .. } => part == Part::Controls,
        Input::Design(_) => part == Part::Design,
        Input::Coordinate(_) => part == Part::Coordinates,
        Input::Rate(_) => part == Part::Rates,
        Input::Step(_) => part == Part::Steps,
    }
}

const PARTS: [Part; 5] = [Part::Controls, Part::Design, Part::Coordinates, Part::Rates, Part::Steps];

/// The same rows in all units; returns them.
fn assert_same(offset: f64, at_rest: bool, own: &[Own]) -> Vec<Said> {
    let plain = said(SI, offset, at_rest, own);
    for units in others() {
        let found = said(units, offset, at_rest, own);
        for (found, plain) in found.iter().zip(&plain) {
            let is_same = (&found.name, found.verdict, &found.mistakes) == (&plain.name, plain.verdict, &plain.mistakes);
            let is_as_large = (found.size - plain.size).abs() <= 1e-6 * plain.size;
            assert!(is_same && is_as_large, "{units:?}: {found:?} is not {plain:?}");
        }
    }
    plain
}

#[test]
fn right_gradients_are_right_and_wrong_ones_wrong() {
    let mistakes: [(&str, Change); 5] = [
        ("sign", |_, g| -g),
        ("twice", |_, g| 2.0 * g),
        ("first", |j, g| if j == 0 { g * (1.0 + 1e-5) } else { g }),
        ("second", |j, g| if j == 1 { g * (1.0 + 1e-5) } else { g }),
        ("third", |j, g| if j == 2 { g * (1.0 + 1e-5) } else { g }),
    ];
    let of_part = |part: Part| {
        // y and φ of the cart are held by the rail: nothing depends on them.
        let all = if matches!(part, Part::Coordinates | Part::Rates) { 3 } else { 5 };
        mistakes[..all].iter().map(move |&(name, change)| (name, part, change))
    };
    let wrong: Vec<Own> = PARTS.into_iter().flat_map(of_part).collect();
    let right: Vec<Own> = PARTS.map(|part| -> Own { ("right", part, |_, g| g) }).into();
    for at_rest in [false, true] {
        assert!(assert_same(0.0, at_rest, &right).iter().all(|said| said.verdict == Verdict::Right));
        let found = assert_same(0.0, at_rest, &wrong);
        assert_eq!(found.iter().filter(|said| said.verdict == Verdict::Wrong).count(), wrong.len() + 1, "{found:?}");
    }
}

/// A cost that is all but constant: its derivatives are known to all digits nevertheless.
#[test]
fn wrong_gradients_of_costs_with_an_offset_are_wrong() {
    for offset in [1e3, 1e12, 1e17] {
        let own: [Own; 2] = [("right", Part::Controls, |_, g| g), ("sign", Part::Coordinates, |_, g| -g)];
        let found = assert_same(offset, false, &own);
        let verdict = |name: &str| found.iter().find(|said| said.name.starts_with(name)).map(|said| said.verdict);
        assert_eq!(
            (verdict("right"), verdict("sign")),
            (Some(Verdict::Right), Some(Verdict::Wrong)),
            "{offset:e}: {found:?}"
        );
    }
}

/// A product of the Hessian, right and with one number wrong.
#[test]
fn products_of_the_hessian_are_judged_the_same() {
    for units in std::iter::once(SI).chain(others()) {
        for at_rest in [false, true] {
            let system = system(units, 0.0);
            let inputs = inputs(units, &system, at_rest);
            let mut along = inputs.no_change();
            along.start.q_mut()[5] = 1.0;
            let mut solver = Solver::new(&system, Settings::default());
            solver.simulate(&inputs).expect("a motion");
            solver.gradient().expect("a gradient");
            let right = solver.hessian_product(&along).expect("a product").start.q().clone();
            let mut check = check::hessian(&system, &inputs, Settings::default());
            let (x, of_link) = (0, [3, 4, 5]);
            for j in of_link.into_iter().chain([x]) {
                let wrong = (0..6).map(|i| if i == j { right[i] * (1.0 + 1e-5) } else { right[i] });
                check = check.own("wrong", Part::Coordinates, along.clone(), wrong);
            }
            let report =
                check.own("right", Part::Coordinates, along.clone(), right.iter().copied()).run().expect("a motion");
            assert!(report.rows.iter().all(|row| row.verdict == Verdict::Right), "{units:?}: {report}");
            let wrong: Vec<usize> = report.own.iter().map(|own| own.wrong_entries).collect();
            assert_eq!(wrong, [1, 1, 1, 1, 0], "{units:?}: {report}");
        }
    }
}
