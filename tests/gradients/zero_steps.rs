//! Steps of length zero, at which controls jump.

use hamiltonian_adjoint::check::Input;
use hamiltonian_adjoint::optimize::{Free, MotionProblem, Problem, Quantity, Variables};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Composition, Cost, CostPoint, Error, Force, ForcePoint, Gradient, Grid, Inputs, PotentialEnergy, Scalar, Scene, Scheme,
    Settings, Solver, Sum, System, Trajectory, Warning, Withdrawn, estimate, gradient, simulate,
};
use nalgebra::{DMatrix, SVector};

use crate::common::{assert_gradient_is_exact_with, assert_order, assert_says, relative_error};
use crate::grid_phase::{self, Extra};
use crate::located::{self, assert_products_are_exact, rod, touching};

/// The inputs with `count` steps of length zero after a node, behind which the control differs. An event at the node remains there, or is moved to
/// the end of these steps.
fn with_jump(inputs: &Inputs, (node, count): (usize, usize), (jump, is_after): (f64, bool)) -> Inputs {
    let mut jumping = inputs.clone();
    jumping.grid.steps.splice(node..node, vec![0.0; count]);
    let given = |k: usize| if k <= node { k } else { node.max(k - count) };
    jumping.controls = DMatrix::from_fn(inputs.controls.nrows(), inputs.controls.ncols() + count, |channel, k| {
        inputs.controls[(channel, given(k))] + if k == node + count { jump } else { 0.0 }
    });
    jumping
        .events
        .iter_mut()
        .filter(|event| event.node >= node + usize::from(!is_after))
        .for_each(|event| event.node += count);
    jumping
}

/// Right before the second event, within the phase before it, and right after the first event.
fn jumping(inputs: &Inputs, count: usize) -> Inputs {
    let [first, second] = [0, 1].map(|k| inputs.events[k].node);
    let middle = first + (second - first) / 2 / count * count;
    let jumping = with_jump(inputs, (second, count), (0.7, true));
    with_jump(&with_jump(&jumping, (middle, count), (-1.1, false)), (first, count), (0.4, false))
}

#[test]
fn gradients_are_those_of_complex_step() {
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..Settings::default() };
    for hinges in [1, 2] {
        // Not where the force δ^1.5 of the floor begins: the derivative by a step of length zero there would contain √δ of a rounding error δ.
        let system = touching(0.02, hinges, false);
        let inputs = jumping(&located::inputs(&system, located::grid(26), &[(0, 12), (1, 17), (0, 22)]), 1);
        for scheme in Scheme::ALL {
            for settings in [Settings::default(), restarted] {
                let what = format!("zero steps: {}, {hinges} hinges, restarts {}", scheme.name, settings.rebase_every);
                assert_gradient_is_exact_with(&what, &system, &inputs, Settings { scheme, ..settings });
            }
        }
        let composed = Grid::composed(8, 0.56 / 8.0, Composition::Suzuki4);
        let inputs = jumping(&located::inputs(&system, composed, &[(0, 15), (1, 25), (0, 30)]), 5);
        for settings in [Settings::default(), restarted] {
            let what = format!("zero steps: composed, {hinges} hinges, restarts {}", settings.rebase_every);
            assert_gradient_is_exact_with(&what, &system, &inputs, settings);
        }
    }
}

#[test]
fn the_node_of_a_jump_stays_at_frozen_grid_phase() -> Result<(), Error> {
    // A reading at the node, of hardly any weight, keeps it where it is, too.
    let system = grid_phase::rod(&[28], Extra::default());
    let inputs = with_jump(&grid_phase::inputs(&system, grid_phase::grid(200)), (28, 1), (2.0, false));
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let mut frozen = |weight: f64| -> Result<Vec<f64>, Error> {
        let gradient = solver.weighted_gradient(1.0, &[weight])?;
        let frozen = gradient.frozen.as_ref().expect("kinks");
        Ok(Input::all(&inputs).iter().map(|input| input.in_gradient(frozen)).collect())
    };
    let error = relative_error(&frozen(0.0)?, &frozen(1e-13)?);
    assert!(error < 1e-11, "{error:e}");
    Ok(())
}

#[test]
fn a_kink_at_the_node_of_an_event_is_located_beside_a_jump() -> Result<(), Error> {
    let system = rod(1, false);
    for nodes in
        [[(0, 24), (1, 34), (0, 44)], [(0, 23), (1, 33), (0, 44)], [(0, 22), (1, 32), (0, 40)], [(0, 25), (1, 35), (0, 45)]]
    {
        let given = jumping(&located::inputs(&system, located::grid(50), &nodes), 1);
        for is_after in [false, true] {
            let inputs = with_jump(&given, (nodes[2].1 + 3, 1), (20.0, is_after));
            let told = gradient(&system, &inputs, Settings::default())?.warnings;
            assert!(told.iter().all(|warning| matches!(warning, Warning::CoarseSteps { .. })), "{nodes:?}: {told:?}");
        }
    }
    Ok(())
}

#[test]
fn products_jacobians_and_checkpoints_are_exact() -> Result<(), Error> {
    let restarted = Settings { rebase_every: 1, drift_bound: 0.0, ..Settings::default() };
    let fine = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    for (settings, hinges) in [(Settings::default(), 1), (restarted, 1), (fine, 1), (Settings::default(), 2)] {
        let system = touching(0.02, hinges, false);
        let given = jumping(&located::inputs(&system, located::grid(50), &located::ALL), 1);
        assert_products_are_exact(&system, &given, settings)?;
    }
    Ok(())
}

#[test]
fn a_step_of_length_zero_without_a_jump_changes_nothing() -> Result<(), Error> {
    let (rod, pendulum) = (rod(1, false), CartPendulum::default().scene().compile()?);
    let mut smooth = Inputs::at_rest(&pendulum, located::grid(50));
    smooth.controls.fill(3.0);
    let located = located::inputs(&rod, located::grid(50), &located::ALL);
    // A reading keeps node 28 where it is, as the jump does, so that both motions have the same derivatives at frozen grid phase.
    let floor = grid_phase::rod(&[], Extra { reading: Some(28), ..Extra::default() });
    let falling = grid_phase::inputs(&floor, grid_phase::grid(200));
    for (system, inputs, scheme) in [
        (&floor, &falling, Scheme::TRAPEZOIDAL),
        (&pendulum, &smooth, Scheme::TRAPEZOIDAL),
        (&pendulum, &smooth, Scheme::ESDIRK4),
        (&rod, &located, Scheme::TRAPEZOIDAL),
        (&rod, &located, Scheme::ESDIRK3),
    ] {
        let settings = Settings { scheme, ..Settings::default() };
        let jumping = with_jump(inputs, (28, 1), (0.0, false));
        let all = |motion: &Trajectory| [motion.q.clone(), motion.v.clone(), motion.p_star.clone(), motion.sigma.clone()];
        let [known, other] = [inputs, &jumping].map(|inputs| simulate(system, inputs, settings).map(|motion| all(&motion)));
        for (known, other) in known?.into_iter().zip(other?) {
            let error = relative_error(other.remove_column(29).as_slice(), known.as_slice());
            assert!(error < 1e-12, "{}: {error:e}", scheme.name);
        }
        let (known, other) = (gradient(system, inputs, settings)?, gradient(system, &jumping, settings)?);
        // Coarse steps are judged by samples.
        let told = |of: &Gradient| of.warnings.iter().filter(|told| !matches!(told, Warning::CoarseSteps { .. })).count();
        assert_eq!(told(&other), told(&known), "{}: {:?}", scheme.name, other.warnings);
        assert_eq!(known.frozen.is_some(), std::ptr::eq(system, &floor));
        let both =
            |of: &Gradient| [Some(of.clone()), of.frozen.as_deref().cloned()].into_iter().flatten().collect::<Vec<_>>();
        for (known, mut other) in both(&known).into_iter().zip(both(&other)) {
            let sum = other.controls.column(28) + other.controls.column(29);
            other.controls.set_column(28, &sum);
            other.controls = other.controls.remove_column(29);
            other.steps.remove(28);
            let list = |of: &Gradient| Input::all(inputs).iter().map(|input| input.in_gradient(of)).collect::<Vec<f64>>();
            let error = relative_error(&list(&other), &list(&known));
            assert!(error < 1e-12, "{}: gradient {error:e}", scheme.name);
        }
    }
    Ok(())
}

/// A spring of stiffness 3 N/m, and the place less a parameter.
struct Spring;

impl PotentialEnergy<1> for Spring {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, _: S) -> S {
        q[0] * q[0] * 1.5
    }
}

impl Cost<1, 0, 0, 1> for Spring {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

/// A force that only pushes.
struct Push;

impl Force<1, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0].max(S::zero())])
    }
}

/// A cart of 2 kg on the spring.
fn cart() -> System {
    let mut scene = Scene::new();
    let (cart, force) = (scene.body("cart", 2.0, 0.1, [0.0; 3]), scene.control("force"));
    let x = [cart.coordinates[0]];
    scene.force("motor", Push, x, [force], []);
    scene.potential_energy("spring", Spring, x, []);
    scene.cost("place", Spring, Sum::Terminal, x, [], [], [0.0.into()]);
    let end = scene.output("end");
    scene.term(end, "end", Spring, Sum::Terminal, x, [], [], [0.0.into()]);
    scene.event("arrives", Spring, x, [], [], [1.0.into()]);
    scene.compile().expect("a scene")
}

/// Pushed until x = 1 and then left alone, for 2 s, with so many macro steps before and after the event.
fn pushed_by(system: &System, steps: usize, composition: Composition) -> Inputs {
    let jump = Grid::new(0.0, vec![0.0; composition.stages()]);
    let [before, after] = [0.8, 1.2].map(|time| Grid::composed(steps, time / steps as f64, composition));
    let mut inputs = Inputs::at_rest(system, before.then(&jump).then(&after));
    let node = steps * composition.stages();
    inputs.controls.fill(OFF);
    inputs.controls.columns_mut(0, node + 1).fill(FORCE);
    inputs.events = vec![system.event(0).at(node)];
    inputs
}

fn pushed(system: &System, steps: usize) -> Inputs {
    pushed_by(system, steps, Composition::Trapezoidal)
}

const FORCE: f64 = 4.0;
/// A control without a force.
const OFF: f64 = -1.0;

/// The place at the end, and its derivative by the force: x = F/k (1 − cos ωt) until x = 1, m v²/2 + k x²/2 = F x there.
fn exact() -> [f64; 2] {
    let (m, k, f): (f64, f64, f64) = (2.0, 3.0, FORCE);
    let omega = (k / m).sqrt();
    let time = (1.0 - k / f).acos() / omega;
    let v = f / k * omega * (omega * time).sin();
    let (sin, cos) = (omega * (2.0 - time)).sin_cos();
    let [time_f, v_f] = [-k / (f * f) / (omega * (omega * time).sin()), 1.0 / (m * v)];
    [cos + v / omega * sin, (omega * sin - v * cos) * time_f + sin / omega * v_f]
}

#[test]
fn a_force_that_is_switched_off_at_an_event_keeps_the_order() -> Result<(), Error> {
    let system = cart();
    let (trapezoidal, plain) = (Scheme::TRAPEZOIDAL, Composition::Trapezoidal);
    for (scheme, composition, steps, within) in [
        (trapezoidal, plain, [16, 32, 64, 128], 0.05),
        (Scheme::ESDIRK4, plain, [4, 8, 16, 32], 0.3),
        (trapezoidal, Composition::Suzuki4, [4, 8, 16, 32], 0.3),
    ] {
        let (settings, stages) = (Settings { scheme, ..Settings::default() }, composition.stages());
        let errors = |steps: usize| -> Result<[f64; 2], Error> {
            let of = gradient(&system, &pushed_by(&system, steps, composition), settings)?;
            assert!(of.warnings.is_empty() && of.frozen.is_none(), "{:?}", of.warnings);
            let [value, slope] = exact();
            Ok([(of.value - value).abs(), (of.controls.columns(0, steps * stages + 1).sum() - slope).abs()])
        };
        let all = steps.map(errors).into_iter().collect::<Result<Vec<_>, Error>>()?;
        for (k, what) in ["J", "dJ/dF"].into_iter().enumerate() {
            let errors: Vec<f64> = all.iter().map(|errors| errors[k]).collect();
            let order = scheme.order.max(composition.order()) as f64;
            assert_order(&format!("{}, {composition:?}: {what}", scheme.name), &errors, order, within);
        }
    }
    Ok(())
}

#[test]
fn a_force_that_jumps_without_an_event_is_resolved() -> Result<(), Error> {
    let system = cart();
    for composition in [Composition::Trapezoidal, Composition::Suzuki4] {
        let (steps, count) = (32 / composition.stages(), composition.stages());
        let node = (steps + 1 + steps / 2) * count;
        let mut inputs = with_jump(&pushed_by(&system, steps, composition), (node, count), (0.0, false));
        inputs.controls.columns_range_mut(node + count..).fill(20.0);
        assert_eq!(gradient(&system, &inputs, Settings::default())?.warnings, [], "{composition:?}");
    }
    Ok(())
}

#[test]
fn errors_of_the_grid_are_estimated_beside_jumps() -> Result<(), Error> {
    let (system, [value, _]) = (cart(), exact());
    let own = estimate(&system, &pushed(&system, 32), Settings::default())?;
    let (error, bound) = ((own.value - value).abs(), own.uncertainty.expect("an estimate"));
    println!("{own}; error {error:.1e}");
    assert!(error < bound && bound < 5.0 * error, "{error:e} within {bound:e}");
    assert!((own.corrected.expect("corrected").value - value).abs() < 0.05 * error);
    assert!((own.residual.expect("residuals") - (value - own.value)).abs() < 0.05 * error);
    let variables = Variables::new(&system, &pushed(&system, 32), vec![Free::new(Quantity::Duration)])?;
    let mut problem = MotionProblem::new(&system, Settings::default(), pushed(&system, 32), variables)?;
    problem.evaluate(&problem.start(), &mut [0.0])?;
    let of_output = problem.grid_errors()?.expect("errors of outputs")[0];
    assert!((of_output - (value - own.value)).abs() < 0.05 * error, "{of_output:e}");
    let odd = estimate(&system, &pushed(&system, 30), Settings::default())?;
    assert_eq!(odd.withdrawn, Some(Withdrawn::NoCoarserGrid));
    Ok(())
}

#[test]
fn jumps_remain_on_other_grids() -> Result<(), Error> {
    let (system, [value, _]) = (cart(), exact());
    let mut solver = Solver::new(&system, Settings::default());
    let given = pushed(&system, 50);
    solver.simulate(&given)?;
    let located = solver.inputs().clone();
    let (phases, adapted) = (solver.find_phases(&located, 60)?, solver.adapt(&given, 1e-6)?);
    let restless = solver.find_phases(&Inputs { events: Vec::new(), ..given }, 60)?;
    for (inputs, events) in [(&phases, 1), (&adapted, 1), (&restless, 1)] {
        let zeros: Vec<usize> = (0..inputs.grid.steps.len()).filter(|&k| inputs.grid.steps[k] == 0.0).collect();
        assert!(zeros.len() == 1 && inputs.events.len() == events, "{zeros:?}");
        let u = inputs.controls.as_slice();
        assert!(u[..=zeros[0]].iter().all(|u| *u == FORCE) && u[zeros[0] + 1..].iter().all(|u| *u == OFF), "{u:?}");
    }
    for inputs in [&phases, &adapted] {
        assert_eq!(inputs.grid.steps[inputs.events[0].node], 0.0);
        let error = (solver.simulate(inputs)?.q[(0, inputs.grid.steps.len())] - value).abs();
        assert!(error < 2e-4, "{error:e}");
    }
    Ok(())
}

/// A cost on du/dt.
struct Rate;

impl Cost<0, 0, 1> for Rate {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u_dot[0] * at.u_dot[0]
    }
}

#[test]
fn steps_of_length_zero_without_a_meaning_are_refused() -> Result<(), Error> {
    let system = cart();
    let refused = |change: &dyn Fn(&mut Inputs)| {
        let mut inputs = pushed(&system, 4);
        change(&mut inputs);
        gradient(&system, &inputs, Settings::default()).expect_err("refused")
    };
    let none = |inputs: &mut Inputs| (inputs.grid.steps, inputs.grid.around) = (vec![0.0; 9], [7, 0]);
    assert_eq!(refused(&|inputs| inputs.grid.steps[0] = 0.0), Error::TimeStep { step: 1, length: 0.0 });
    assert_eq!(refused(&|inputs| (inputs.events.clear(), none(inputs)).1), Error::TimeStep { step: 8, length: 0.0 });
    let empty = refused(&|inputs| {
        inputs.events.push(inputs.events[0].event.at(6));
        inputs.grid.steps[4..6].fill(0.0);
    });
    assert_says(&empty, &["the time between nodes 4 and 6", "longer than steps of length zero"]);
    let inputs = Inputs { events: Vec::new(), ..pushed(&system, 4) };
    let motion = simulate(&system, &inputs, Settings::default())?;
    assert!(matches!(PaperSystem::new(&system, &inputs, &motion), Err(Error::TimeStep { step: 5, .. })));
    let mut scene = Scene::new();
    let (cart, force) = (scene.body("cart", 2.0, 0.1, [0.0; 3]), scene.control("force"));
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), force);
    scene.cost("rate", Rate, Sum::Integral, [], [], [force], []);
    let system = scene.compile()?;
    let error = gradient(&system, &inputs, Settings::default()).expect_err("du/dt");
    assert_says(&error, &["time step 5 has length 0 s", "du/dt"]);
    Ok(())
}
