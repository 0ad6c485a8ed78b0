//! Located events: where they are found, and what is said where they are not.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Error, Event, Force, ForcePoint, Grid, Inputs, Occurrence, Scalar, Scene, Scheme, Settings, Solver,
    Sum, System, Warning,
};
use nalgebra::SVector;

use crate::common::assert_says;

/// The floor under the height q.
struct Floor(f64);

impl Force<1, 0, 1> for Floor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * (-at.q[0]).max(S::zero()).powf(self.0)])
    }
}

struct Height;

impl Cost<1, 0, 0, 1> for Height {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

/// A ball of 1 kg over an elastic floor with K δ^E; the event is that it touches or leaves the floor.
fn ball(stiffness: f64, exponent: f64) -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let mass = scene.design("mass", 1.0);
    let stiffness = scene.design("stiffness", stiffness);
    let level = scene.design("level", 0.0);
    let ball = scene.particle("ball", mass, [0.0, 1.0]);
    let z = [ball.coordinates[1]];
    scene.force("floor", Floor(exponent), z, [], [stiffness.into()]);
    scene.cost("height", Height, Sum::Terminal, z, [], [], [0.0.into()]);
    scene.event("contact", Height, z, [], [], [level.into()]);
    scene.compile().expect("a scene")
}

fn with_events(system: &System, grid: Grid, nodes: &[usize]) -> Inputs {
    let events = nodes.iter().map(|&node| system.event(0).at(node)).collect();
    Inputs { events, ..Inputs::at_rest(system, grid) }
}

#[test]
fn events_are_found_from_poor_guesses_and_backwards_in_time() -> Result<(), Error> {
    let system = ball(1e4, 1.0);
    let exact = (2.0f64 / 9.81).sqrt();
    for guess in [0.1, 0.3, 0.45, 0.6, 0.75] {
        let grid = Grid::new(0.0, [vec![guess / 20.0; 20], vec![(0.8 - guess) / 40.0; 40]].concat());
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&with_events(&system, grid.clone(), &[20]))?;
        assert!((motion.times[20] - exact).abs() < 1e-13, "{} from {guess}", motion.times[20]);
        let mut back = with_events(&system, grid, &[20]);
        back.grid.steps.iter_mut().for_each(|dt| *dt = -*dt);
        assert!((solver.simulate(&back)?.times[20] + exact).abs() < 1e-13, "backwards from {guess}");
    }
    Ok(())
}

#[test]
fn an_event_that_is_read_and_not_given_is_told() -> Result<(), Error> {
    let mut scene = Scene::new();
    let z = [scene.particle("ball", 1.0, [0.0, 1.0]).coordinates[1]];
    scene.event("contact", Height, z, [], [], [0.0.into()]);
    scene.event_time("lift-off", 1);
    let system = scene.compile()?;
    let given = with_events(&system, Grid::uniform(40, 0.02), &[20]);
    let mut solver = Solver::new(&system, Settings::default());
    assert_says(
        &solver.simulate(&given).expect_err("no lift-off"),
        &["`lift-off`", "reads event 1", "have 1", "find_phases"],
    );
    Ok(())
}

#[test]
fn phases_are_found_along_an_ordinary_motion() -> Result<(), Error> {
    let system = ball(1e4, 1.5);
    let mut solver = Solver::new(&system, Settings::default());
    let given = Inputs::at_rest(&system, Grid::uniform(800, 3.0 / 800.0));
    let phases = solver.find_phases(&given, 16)?;
    // Three bounces.
    assert_eq!(phases.events.len(), 6, "{:?}", phases.events);
    let motion = solver.simulate(&phases)?.clone();
    for Occurrence { node, .. } in &phases.events {
        assert!(motion.q[(1, *node)].abs() < 1e-12, "{:e} at node {node}", motion.q[(1, *node)]);
    }
    assert!((motion.times[motion.last()] - 3.0).abs() < 1e-12);
    assert!(solver.gradient()?.warnings.iter().all(|w| !matches!(w, Warning::KinkBetweenNodes { .. })));
    let estimate = hamiltonian_adjoint::estimate(&system, &phases, Settings::default())?;
    println!("{estimate}");
    assert!(estimate.uncertainty.is_some() && estimate.gradient_uncertainty.is_some());
    Ok(())
}

#[test]
fn a_kink_that_no_event_locates_is_told() -> Result<(), Error> {
    let system = ball(1e4, 1.5);
    let mut solver = Solver::new(&system, Settings::default());
    let mut given = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(200, 0.004)), 16)?;
    given.events.pop();
    solver.simulate(&given)?;
    let warnings = &solver.gradient()?.warnings;
    let kink = warnings.iter().find(|w| matches!(w, Warning::KinkBetweenNodes { .. })).expect("a warning");
    println!("{kink}");
    Ok(())
}

#[test]
fn what_cannot_be_located_is_said() -> Result<(), Error> {
    let system = ball(1e4, 1.0);
    let simulate = |inputs: &Inputs| Solver::new(&system, Settings::default()).simulate(inputs).map(|_| ());
    let fails = |inputs: &Inputs| simulate(inputs).expect_err("no motion");
    let grid = |end: f64| Grid::uniform(40, end / 40.0);
    // Too short; and a level that is never reached.
    assert_says(
        &fails(&with_events(&system, grid(0.4), &[20])),
        &["`contact`", "node 20", "does not happen", "0.4 s", "2.152e-1"],
    );
    let mut high = with_events(&system, grid(0.8), &[20]);
    high.design[2] = 1.5;
    assert_says(&fails(&high), &["does not happen", "closest to zero"]);
    // Nodes out of order, beyond the end, at the start.
    for (nodes, words) in [([20, 20], "larger than that of the event before it"), ([20, 41], "at most the number of steps")]
    {
        assert_says(&fails(&with_events(&system, grid(0.8), &nodes)), &["`contact`", words]);
    }
    assert_says(&fails(&with_events(&system, grid(0.8), &[0])), &["larger than 0"]);
    let foreign: Event = ball(1e4, 1.0).event(0);
    let other = Inputs { events: vec![foreign.at(3)], ..Inputs::at_rest(&system, grid(0.8)) };
    assert_says(&fails(&other), &["`Inputs::events`", "an event of another scene"]);
    let mut part = with_events(&system, grid(0.8), &[20]);
    part.grid.around = [3, 0];
    assert_says(&fails(&part), &["part of a longer motion"]);
    let composed = Grid::composed(10, 0.08, hamiltonian_adjoint::Composition::Suzuki4);
    assert_says(&fails(&with_events(&system, composed, &[21])), &["end of a macro step"]);
    // The event at the end of the grid, and a second one that does not happen any more.
    let early = with_events(&system, grid(0.8), &[10, 20, 30]);
    assert_says(&fails(&early), &["node 30", "does not happen"]);
    Ok(())
}

#[test]
fn a_grazed_event_is_told() -> Result<(), Error> {
    // Levels just over the deepest point of the ball, and under it.
    let system = ball(1e4, 1.0);
    let mut solver = Solver::new(&system, Settings::default());
    let mut inputs = with_events(&system, Grid::uniform(1800, 0.9 / 1800.0), &[930]);
    let free = Inputs { events: Vec::new(), ..inputs.clone() };
    let deepest = solver.simulate(&free)?.q.row(1).min();
    inputs.design[2] = 0.9999 * deepest;
    let motion = solver.simulate(&inputs)?;
    assert!((motion.q[(1, 930)] - 0.9999 * deepest).abs() < 1e-12);
    let grazed = |w: &&Warning| matches!(w, Warning::Grazed { .. });
    println!("{}", solver.report().warnings.iter().find(grazed).expect("a warning"));
    inputs.design[2] = 1.01 * deepest;
    assert_says(&solver.simulate(&inputs).expect_err("no such depth"), &["closest to zero"]);
    Ok(())
}

#[test]
fn an_adaptive_grid_keeps_the_events() -> Result<(), Error> {
    let system = ball(1e4, 1.5);
    let settings = Settings { scheme: Scheme::ESDIRK5, ..Settings::default() };
    let mut solver = Solver::new(&system, settings);
    let given = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(200, 0.004)), 8)?;
    let adapted = solver.adapt(&given, 1e-9)?;
    assert_eq!(adapted.events.len(), 2);
    let motion = solver.simulate(&adapted)?;
    let exact = [(2.0f64 / 9.81).sqrt(), 0.512_538_925_4];
    for (Occurrence { node, .. }, exact) in adapted.events.iter().zip(exact) {
        assert!((motion.times[*node] - exact).abs() < 1e-6, "{} for {exact}", motion.times[*node]);
    }
    Ok(())
}

#[test]
fn checks_of_gradients_know_events() -> Result<(), Error> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let [mass, stiffness] = [scene.design("mass", 1.0), scene.design("stiffness", 1e4)];
    let ball = scene.particle("ball", mass, [0.0, 1.0]);
    let law = [stiffness.into(), 0.0.into(), 0.0.into(), 1.0.into()];
    scene.contact("floor", Body::GROUND.at(0.0, 0.0), std::f64::consts::FRAC_PI_2, ball.point(), law);
    scene.cost("height", Height, Sum::Terminal, [ball.coordinates[1]], [], [], [0.0.into()]);
    let system = scene.compile()?;
    let mut solver = Solver::new(&system, Settings::default());
    let given = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(200, 0.004)), 16)?;
    assert_eq!(given.events, [system.event(0).at(116), system.event(0).at(132)]);
    let report = hamiltonian_adjoint::check::gradient(&system, &given, Settings::default()).run()?;
    println!("{report}");
    report.assert_passed();
    Ok(())
}

/// Functions that are hard to locate, of the height z of a ball that falls from 1 m past 0.5 m, and of time.
struct Hard(usize);

impl Cost<1> for Hard {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        let (x, t) = (at.q[0] - 0.5, at.t);
        match self.0 {
            0 => x * 1e-200,
            1 => x * 1e200,
            // Not defined beyond its zero.
            2 => x.sqrt() - 0.1,
            // Zero at the start, too.
            3 => t * (t - 0.3),
            4 => x + (t * 2000.0).sin() * 1e-3,
            5 => at.q[0] - 1.0,
            // A pole, jumps, and no zero at all.
            6 => S::from(1.0) / x,
            7 => {
                if x.re() > 0.0 {
                    x + 1.0
                } else {
                    x - 1.0
                }
            }
            8 => x.ln(),
            _ => x * x + 0.1,
        }
    }
}

#[test]
fn hard_functions_are_located_at_their_first_zero_or_refused() {
    let crossing = (1.0f64 / 9.81).sqrt();
    let near = |low: f64, high: f64| Some(low..high);
    let zeros = [
        near(crossing, crossing),
        near(crossing, crossing),
        near((0.98f64 / 9.81).sqrt(), (0.98f64 / 9.81).sqrt()),
        near(0.3, 0.3),
        near(crossing - 5e-4, crossing + 5e-4),
    ];
    for (which, guess, steps, rest) in (0..10).flat_map(|which| {
        let guesses = [0.1, 0.5, 0.9, 1.1, 2.0, 5.0].into_iter();
        guesses.flat_map(move |guess| [10, 20].into_iter().flat_map(move |n| [0, 30].map(|rest| (which, guess, n, rest))))
    }) {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let ball = scene.particle("ball", 1.0, [0.0, 1.0]);
        let z = [ball.coordinates[1]];
        scene.cost("height", Height, Sum::Terminal, z, [], [], [0.0.into()]);
        scene.event("hard", Hard(which), z, [], [], []);
        let system = scene.compile().expect("a scene");
        let dts = [vec![guess * crossing / steps as f64; steps], vec![2.0 / 30.0; rest]].concat();
        let mut solver = Solver::new(&system, Settings::default());
        let result = solver.simulate(&with_events(&system, Grid::new(0.0, dts), &[steps])).map(|motion| motion.times[steps]);
        let what = format!("{which} from {guess} with {steps} steps and {rest}: {result:?}");
        match (result, zeros.get(which)) {
            (Ok(time), Some(Some(zero))) => assert!(zero.start - 1e-12 < time && time < zero.end + 1e-12, "{what}"),
            (Err(error), None) => assert!(
                matches!(error, Error::EventNotReached { .. } | Error::EventNotLocated { .. } | Error::NotFinite { .. }),
                "{what}"
            ),
            _ => panic!("{what}"),
        }
    }
}

#[test]
fn lifted_motions_need_the_events_of_the_real_one() -> Result<(), Error> {
    let system = ball(1e4, 1.0);
    let given = with_events(&system, Grid::uniform(40, 0.02), &[20]);
    for (nodes, words) in [(&[][..], "events: expected 1"), (&[21], "node of this event in the real motion")] {
        let mut lifted =
            hamiltonian_adjoint::LiftedSolver::<hamiltonian_adjoint::Cx>::new(&system, &given, Settings::default())?;
        let other = with_events(&system, given.grid.clone(), nodes);
        assert_says(&lifted.simulate(&other.lift()).expect_err("other events"), &[words]);
    }
    let mut turning = given.clone();
    turning.grid.steps[5] = -0.01;
    assert_says(
        &Solver::new(&system, Settings::default()).simulate(&turning).expect_err("no order"),
        &["step 6", "same sign"],
    );
    Ok(())
}

#[test]
fn phases_end_at_events_at_the_end_of_the_grid_and_at_simultaneous_events() -> Result<(), Error> {
    let system = ball(1e4, 1.5);
    let mut solver = Solver::new(&system, Settings::default());
    let exact = (2.0f64 / 9.81).sqrt();
    for end in [exact, exact * (1.0 + 1e-15)] {
        let phases = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(64, end / 64.0)), 8)?;
        assert_eq!((phases.events.len(), phases.grid.steps.len()), (1, phases.events[0].node));
        assert!((solver.simulate(&phases)?.times[phases.events[0].node] - exact).abs() < 1e-13);
    }
    let nothing = solver.find_phases(&Inputs::at_rest(&system, Grid::uniform(0, 0.1)), 8);
    assert_says(&nothing.expect_err("no steps"), &["1 or more"]);
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    for name in ["left", "right"] {
        let ball = scene.particle(name, 1.0, [0.0, 1.0]);
        scene.event(name, Height, [ball.coordinates[1]], [], [], [0.5.into()]);
    }
    let system = scene.compile()?;
    let mut solver = Solver::new(&system, Settings::default());
    let mut both = Inputs::at_rest(&system, Grid::uniform(64, 0.01));
    let phases = solver.find_phases(&both, 8)?;
    assert_eq!(phases.events.len(), 1);
    solver.simulate(&phases)?;
    both.events = vec![system.event(0).at(30), system.event(1).at(32)];
    assert_says(&solver.simulate(&both).expect_err("no time between them"), &["`right`", "does not happen"]);
    Ok(())
}

#[test]
fn events_are_located_at_late_times_as_at_early_ones() -> Result<(), Error> {
    let system = ball(1e4, 1.5);
    for start in [0.0, 1e3, 1e6, 1e9] {
        let mut late = with_events(&system, Grid::uniform(60, 0.02), &[20]);
        late.grid.start = start;
        let height = Solver::new(&system, Settings::default()).simulate(&late)?.q[(1, 20)];
        assert!(height.abs() < 1e-14, "{height:e} at {start:e} s");
    }
    Ok(())
}
