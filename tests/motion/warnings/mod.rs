//! What warnings say is so: none where steps resolve a motion, and one, by the element's name, where the gradient is exact and useless.

mod elements;
mod estimates;
mod formulas;
mod lost;
mod motion;
mod tree;
mod work;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Composition, Gradient, Grid, Inputs, LongSolver, Scene, Settings, Solver, Sum, System, Warning, gradient, gradients,
};

use elements::Element;
use motion::{Motion, between};

/// Motions whose gradients change by less than this are resolved …
const RESOLVED: f64 = 0.01;
/// … and by more than this are not.
const UNRESOLVED: f64 = 0.3;

/// The n-th element that steps of 1 ms or a few resolve, of random size.
fn smooth(random: &mut Random, n: usize) -> Element {
    match n % 9 {
        0 => Element::Friction { force: between(random, 0.1, 3.0), speed: between(random, 0.1, 1.0) },
        1 => Element::Sliding { force: between(random, 0.1, 3.0), speed: between(random, 0.1, 1.0) },
        2 => Element::Stop { stiffness: between(random, 10.0, 1e3), gap: random.uniform(0.0, 0.3) },
        3 => Element::Hertz { stiffness: between(random, 10.0, 3e3), gap: random.uniform(0.0, 0.3) },
        4 => Element::Well {
            depth: between(random, 0.1, 2.0),
            at: random.uniform(-0.3, 0.3),
            width: between(random, 0.05, 0.5),
        },
        5 => {
            let (impulse, at, width) = (between(random, 0.1, 2.0), random.uniform(0.3, 0.7), between(random, 0.03, 0.5));
            Element::Pulse { impulse, at, width }
        }
        6 => Element::Drag { linear: between(random, 0.1, 5.0), cubic: between(random, 0.1, 5.0) },
        7 => Element::Gear { ratio: between(random, 0.3, 1.5), width: between(random, 0.1, 1.0) },
        _ => {
            let (speed, at, width) = (between(random, 0.1, 1.0), random.uniform(0.3, 0.7), between(random, 0.05, 0.3));
            Element::Driven { speed, at, width }
        }
    }
}

#[test]
fn five_hundred_motions_that_are_resolved_give_at_most_one_warning() {
    let (mut resolved, mut warned, mut seed) = (0, Vec::new(), 0);
    while resolved < 500 {
        seed += 1;
        let mut random = Random::new(seed);
        let (masses, duration) = (1 + random.below(3), random.uniform(0.8, 2.0));
        let mut what = vec![smooth(&mut random, seed as usize)];
        if random.below(2) == 0 {
            let other = random.below(7);
            what.push(smooth(&mut random, other));
        }
        let steps = (duration / between(&mut random, 1e-3, 6e-3)) as usize;
        let mut motion = Motion::new(&mut random, masses, what, duration, steps);
        match seed % 4 {
            1 => {
                motion.composition = [Composition::Suzuki4, Composition::Yoshida6, Composition::KahanLi6][random.below(3)];
                motion.steps /= 4;
                motion.settings.rebase_every = random.below(3);
            }
            2 => motion.settings.rebase_every = 1 + random.below(5),
            3 if motion.system.m() > 0 => motion.settings.drift_bound = 0.0,
            _ => (),
        }
        if motion.change().is_none_or(|change| change > RESOLVED) {
            continue;
        }
        resolved += 1;
        let warnings = motion.warnings().expect("a motion");
        if !warnings.is_empty() {
            println!("{seed}: {:?}, {} steps, {:?}, {:?}", motion.what, motion.steps, motion.composition, motion.settings);
            warnings.iter().for_each(|warning| println!("    {warning}"));
            warned.push(seed);
        }
    }
    println!("{seed} motions drawn, {resolved} resolved, with warnings: {warned:?}");
    assert!(warned.len() <= 1);
}

/// Twenty elements that steps of 1 ms do not resolve.
fn sharp() -> Vec<Element> {
    let friction = |force, speed| Element::Friction { force, speed };
    let sliding = |force, speed| Element::Sliding { force, speed };
    vec![
        friction(1.0, 3e-6),
        friction(3.0, 1e-5),
        friction(2.0, 1e-4),
        friction(5.0, 1e-3),
        sliding(1.0, 3e-6),
        sliding(4.0, 3e-4),
        Element::Stop { stiffness: 1e6, gap: 0.1 },
        Element::Stop { stiffness: 1e7, gap: 0.2 },
        Element::Hertz { stiffness: 1e7, gap: 0.1 },
        Element::Hertz { stiffness: 1e9, gap: 0.15 },
        Element::Well { depth: 2.0, at: 0.1, width: 1e-3 },
        Element::Well { depth: 1.0, at: 0.0, width: 5e-4 },
        Element::Well { depth: 0.5, at: 0.05, width: 1e-3 },
        Element::Pulse { impulse: 1.0, at: 0.5, width: 2e-4 },
        Element::Pulse { impulse: 2.0, at: 0.4, width: 5e-4 },
        Element::Drag { linear: 0.1, cubic: 1e5 },
        Element::Drag { linear: 0.1, cubic: 1e4 },
        Element::Gear { ratio: 1.5, width: 1e-3 },
        Element::Gear { ratio: 1.0, width: 5e-4 },
        Element::Gear { ratio: 0.8, width: 2e-4 },
    ]
}

/// A motion that it makes unresolved: the first whose gradient changes enough.
fn unresolved(number: u64, element: Element) -> Motion {
    let made = (0..200).find_map(|seed| {
        let mut random = Random::new(1000 * number + seed);
        let motion = Motion::new(&mut random, 2, vec![element], 1.0, 1000);
        motion.change().is_some_and(|change| change > UNRESOLVED).then_some(motion)
    });
    made.unwrap_or_else(|| panic!("{element:?} is resolved"))
}

#[test]
fn elements_that_change_faster_than_the_steps_are_named() {
    let (mut silent, mut unnamed) = (Vec::new(), Vec::new());
    for (number, element) in sharp().into_iter().enumerate() {
        let motion = unresolved(number as u64, element);
        let warnings = motion.warnings().expect("a motion");
        let named = warnings.iter().any(|warning| match warning {
            Warning::UnresolvedElement { element, step, time, share } => {
                element == "element 0" && (1..=1000).contains(step) && (0.0..=1.0).contains(time) && *share > Warning::BENT
            }
            _ => false,
        });
        println!("{element:?}: change {:.1e}, {warnings:?}", motion.change().unwrap_or(f64::NAN));
        if !named {
            unnamed.push(element);
        }
        if warnings.is_empty() {
            silent.push(element);
        }
    }
    assert!(silent.is_empty(), "{silent:?}");
    // Where what is missed when contact begins is made good when it ends, velocities that jump are warned of all the same.
    assert!(unnamed.len() <= 2 && !unnamed.iter().any(|element| matches!(element, Element::Friction { .. })), "{unnamed:?}");
}

/// A mass that friction holds back, from v₀ by a force that pulls it back: x(T), and dx(T)/dv₀ of the motion that is meant.
///
/// With −μ sign v it slows down with (f + μ)/m, and from v = 0 it goes back with (f − μ)/m: the times there, t₁ = m v₀/(f + μ), and from there on
/// x = v₀ t₁/2 − (f − μ)(T − t₁)²/2m.
#[test]
fn friction_that_turns_within_a_step_is_named_and_its_gradient_is_as_wrong_as_told() {
    let (force, pull, v0, duration) = (1.0, 3.0, 1.3337, 1.0);
    let turn = v0 / (pull + force);
    let expected = turn + (pull - force) * (duration - turn) / (pull + force);
    let of = |speed: f64, steps: usize| {
        let mut scene = Scene::new();
        let x = elements::mass(&mut scene, "block", 1.0.into(), 0.0);
        let u = scene.control("pull");
        elements::drive(&mut scene, x, u);
        Element::Friction { force, speed }.add(&mut scene, "friction", &[x], 0.0);
        elements::aim(&mut scene, "end", Sum::Terminal, x, -10.0);
        let system = scene.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, duration / steps as f64));
        inputs.controls.fill(-pull);
        inputs.start.rate_mut()[0] = v0;
        let mut solver = Solver::new(&system, Settings::default());
        let end = solver.simulate(&inputs).expect("a motion").q[(0, steps)];
        let gradient = solver.gradient().expect("a gradient");
        let of_end = |gradient: &Gradient| gradient.start.rate()[0] / (2.0 * (end + 10.0));
        (of_end(gradient), gradient.frozen.as_deref().map(of_end), gradient.warnings.clone())
    };
    let (wrong, frozen, warnings) = of(3e-6, 1000);
    println!("dx/dv₀ {wrong}, frozen {frozen:?} for {expected}: {warnings:?}");
    assert!((wrong - expected).abs() > 0.3 * expected);
    assert!((frozen.expect("a reversal between two nodes") - expected).abs() < 0.01 * expected);
    let [Warning::GridPhase { element: first, .. }, Warning::UnresolvedElement { element, step, time, .. }] = &warnings[..]
    else {
        panic!("{warnings:?}")
    };
    assert!([first, element].iter().all(|name| *name == "friction"));
    assert!((time - turn).abs() < 2e-3 && step.abs_diff((1000.0 * turn) as usize) <= 2);
    let (right, _, warnings) = of(0.05, 1000);
    println!("dx/dv₀ {right} for {expected}: {warnings:?}");
    assert!((right - expected).abs() < 0.02 * expected && warnings.is_empty());
}

/// Four blocks, each with drag and friction that is resolved but for one of them.
#[test]
fn the_element_at_fault_is_named_among_others_of_its_kind() {
    for (culprit, programs) in (0..4).flat_map(|culprit| [(culprit, true), (culprit, false)]) {
        let mut scene = Scene::new();
        for k in 0..4 {
            let x = elements::mass(&mut scene, &format!("block {k}"), 1.0.into(), 0.0);
            if k == culprit {
                let u = scene.control("pull");
                elements::drive(&mut scene, x, u);
            }
            Element::Drag { linear: 0.1, cubic: 0.1 }.add(&mut scene, &format!("drag {k}"), &[x], 0.0);
            let speed = if k == culprit { 3e-6 } else { 0.05 };
            Element::Friction { force: 1.0, speed }.add(&mut scene, &format!("friction {k}"), &[x], 0.0);
            elements::aim(&mut scene, &format!("end {k}"), Sum::Terminal, x, -10.0);
        }
        let system = if programs { scene.compile() } else { scene.compile_without_programs() }.expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(1000, 1e-3));
        inputs.controls.fill(-3.0);
        inputs.start.rate_mut().fill(1.3337);
        let warnings = gradient(&system, &inputs, Settings::default()).expect("a gradient").warnings;
        let of_phase = if programs { 1 } else { 0 };
        let [Warning::UnresolvedElement { element, .. }] = &warnings[of_phase..] else { panic!("{culprit}: {warnings:?}") };
        assert_eq!(*element, format!("friction {culprit}"));
        assert!(warnings[..of_phase].iter().all(|of| matches!(of, Warning::GridPhase { element: of, .. } if of == element)));
    }
}

#[test]
fn warnings_are_the_same_whatever_computes_the_gradient() {
    for (number, element) in [(0, sharp()[0]), (6, sharp()[6]), (17, sharp()[17])] {
        let mut motion = unresolved(number, element);
        for (composition, rebase_every) in [
            (Composition::Trapezoidal, 0),
            (Composition::Trapezoidal, 1),
            (Composition::Suzuki4, 5),
            (Composition::KahanLi6, 0),
        ] {
            motion.composition = composition;
            motion.settings.rebase_every = rebase_every;
            let (system, inputs, settings) = (&motion.system, motion.inputs(1), motion.settings);
            let Ok(stored) = gradient(system, &inputs, settings) else { continue };
            let is_unresolved =
                composition == Composition::Trapezoidal && motion.change().is_some_and(|change| change > UNRESOLVED);
            println!("{element:?}, {composition:?}, {rebase_every}: {:?}", stored.warnings);
            let is_named = |warning: &Warning| matches!(warning, Warning::UnresolvedElement { .. } | Warning::Rough { .. });
            assert!(stored.warnings.iter().any(is_named) || !is_unresolved);
            let many = gradients(system, &[inputs.clone(), inputs.clone()], settings);
            assert!(many.iter().flatten().all(|gradient| gradient.warnings == stored.warnings));
            let mut long = LongSolver::new(system, settings, 900_000);
            assert_eq!(long.gradient(&inputs).expect("a motion").warnings, stored.warnings);
        }
    }
}

/// A rod that falls from the side.
fn pendulum() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rod = scene.body("rod", 1.0, 1.0 / 12.0, [0.5, 0.0, 0.0]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    elements::aim(&mut scene, "angle", Sum::Terminal, rod.coordinates[2], 1.0);
    scene.compile().expect("a scene")
}

#[test]
fn a_smooth_motion_on_any_grid_with_any_restarts_is_not_rough() {
    let system = pendulum();
    for composition in Composition::ALL {
        for rebase_every in [0, 1, 5, 9] {
            for drift_bound in [f64::INFINITY, 0.0] {
                for steps in [50, 100, 200, 400] {
                    for push in [0.0, 1e-3, 0.1] {
                        let mut inputs = Inputs::at_rest(&system, Grid::composed(steps, 2.0 / steps as f64, composition));
                        let v = inputs.start.rate_mut();
                        (v[1], v[2]) = (0.5 * push, push);
                        let settings = Settings { rebase_every, drift_bound, ..Settings::default() };
                        let warnings = gradient(&system, &inputs, settings).expect("a motion").warnings;
                        assert!(warnings.is_empty(), "{composition:?}, {steps} steps, {settings:?}, {push}: {warnings:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_motion_that_is_resolved_is_hardly_looked_at() {
    let mut random = Random::new(3);
    let what = vec![Element::Friction { force: 1.0, speed: 0.5 }, Element::Well { depth: 1.0, at: 0.1, width: 0.3 }];
    for steps in [1000, 4000] {
        let motion = Motion::new(&mut random, 2, what.clone(), 1.0, steps);
        let mut solver = Solver::new(&motion.system, motion.settings);
        solver.simulate(&motion.inputs(1)).expect("a motion");
        solver.gradient().expect("a gradient");
        let (looked, evaluated) = (solver.adjoint_report().chord_evaluations, solver.report().element_evaluations);
        println!("{steps} steps: {looked} evaluations beside {evaluated}");
        assert!(looked <= 20 && evaluated > 8 * steps);
    }
}

#[test]
fn an_aim_that_is_reached_is_no_growth_and_a_motion_that_amplifies_changes_is() {
    // (x − x₁)² has no derivative where x₁ is reached, at the end of a motion that is costly before.
    let growth = |aim: f64, stiffness: f64| {
        let mut scene = Scene::new();
        let x = elements::mass(&mut scene, "mass", 1.0.into(), 0.5);
        elements::anchor(&mut scene, x, [stiffness, 0.0].map(Into::into));
        elements::aim(&mut scene, "way", Sum::Trapezoidal, x, 0.0);
        elements::aim(&mut scene, "end", Sum::Terminal, x, aim);
        let system = scene.compile().expect("a scene");
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&Inputs::at_rest(&system, Grid::uniform(4000, 0.005))).expect("a motion");
        let end = motion.q[(0, 4000)];
        let gradient = solver.gradient().expect("a gradient");
        let told = gradient.warnings.iter().any(|warning| matches!(warning, Warning::AdjointGrowth { .. }));
        (end, solver.adjoint_report().adjoint_growth, told)
    };
    // ω = 2 rad/s: 40 rad in all.
    let (end, ..) = growth(0.0, 4.0);
    for aim in [0.0, end, end + 1e-9] {
        let (_, factor, told) = growth(aim, 4.0);
        println!("aim {aim}: {factor:.1e}");
        assert!(factor < 100.0 && !told);
    }
    // e^{2 · 20} from the top of a hill.
    let (_, factor, told) = growth(0.0, -4.0);
    println!("hill: {factor:.1e}");
    assert!(factor > 1e8 && told);
}

#[test]
fn rounding_errors_of_a_motion_at_rest_do_not_oscillate() {
    for links in 1..5 {
        let system = CartPendulum::with_links(links).scene().compile().expect("a system");
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&Inputs::at_rest(&system, Grid::uniform(200, 0.02))).expect("a motion");
        assert!(solver.report().warnings.is_empty(), "{:?}", solver.report().warnings);
    }
}
