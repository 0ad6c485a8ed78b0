//! What is computed, counted: what a scene does not need is not evaluated, and no step costs more than it must.

use crate::scenes::{elements, pairs, structures};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Report, Scene, Settings, Solver};

const STEPS: usize = 100;

/// Reports of a simulation and of the adjoint sweep after it, from rest with constant controls.
fn reports(scene: Scene, dt: f64, control: f64) -> (Report, Report) {
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, dt));
    inputs.controls.fill(control);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    solver.gradient().expect("a gradient");
    (solver.report().clone(), solver.adjoint_report().clone())
}

/// How often the equations were evaluated: at the first guess of every step, three times at node 0 (p* from v; is it regular; then its
/// solution), and after every correction.
fn evaluations(report: &Report) -> usize {
    STEPS + 3 + report.newton_iterations
}

/// Asserts how many elements (by dual numbers) and angles (by their sines) every evaluation takes, and what follows from that.
fn assert_work(name: &str, scene: Scene, differentiated: usize, angles: usize) {
    let (forward, adjoint) = reports(scene, 0.01, 1.0);
    println!("{name} {forward:?}");
    let evaluations = evaluations(&forward);
    assert_eq!(forward.element_evaluations, differentiated * evaluations, "{name}: elements");
    assert_eq!(forward.sine_evaluations, angles * evaluations, "{name}: angles");
    let solved = forward.factorisations + forward.reused_factors;
    assert_eq!(solved, forward.newton_iterations + 1, "{name}: factorisations");
    assert!(forward.factorisations > STEPS, "{name}: every step has factors of its own");
    // The sweep back lives on what the simulation left.
    let work = (adjoint.factorisations, adjoint.element_evaluations, adjoint.sine_evaluations, adjoint.newton_iterations);
    assert_eq!(work, (STEPS + 1, 0, 0, 0), "{name}: adjoint");
}

#[test]
fn the_papers_example_takes_two_iterations_a_step_and_no_dual_number() {
    for (links, dt, factorisations) in [(3, 0.02, 105), (10, 0.01, 105)] {
        let (forward, adjoint) = reports(CartPendulum::with_links(links).scene(), dt, 10.0);
        assert_eq!((forward.newton_iterations, forward.most_iterations), (2 * STEPS + 1, 2));
        // One for node 0 and one a step; most second corrections do with the factors of the first.
        assert_eq!(forward.factorisations, factorisations);
        assert_eq!(forward.factorisations + forward.reused_factors, 2 * STEPS + 2);
        assert_eq!(forward.element_evaluations, 0);
        assert_eq!(forward.sine_evaluations, links * (3 * STEPS + 4));
        assert_eq!((adjoint.factorisations, adjoint.element_evaluations, adjoint.sine_evaluations), (STEPS + 1, 0, 0));
        assert_eq!(adjoint.refined_solutions, 1, "one in 128 is looked at, and no digits are lost");
    }
}

#[test]
fn every_kind_of_element_costs_what_its_formula_asks_for() {
    let expected = [
        ("revolute joint", 0, 2),
        ("prismatic joint between moving bodies", 1, 1),
        ("weld", 0, 2),
        ("distance", 1, 1),
        ("driven angle", 1, 2),
        ("spring and damper", 2, 2),
        ("torsional spring and damper", 0, 2),
        ("friction in a joint", 0, 2),
        ("friction of sliding on a moving body", 1, 2),
        ("actuator on a moving body", 1, 2),
        ("torque actuator", 0, 2),
        ("constraint of one's own", 1, 2),
        ("force of one's own", 1, 2),
        ("potential energy of one's own", 1, 2),
        // The weight is not linear in the angles; the kinetic energy adds nothing unless M depends on q.
        ("kinetic energy with constant M", 1, 0),
        ("kinetic energy with M(q)", 2, 0),
    ];
    let all = elements::all();
    assert_eq!(all.len(), expected.len());
    for ((name, scene), (expected_name, differentiated, angles)) in all.into_iter().zip(expected) {
        assert_eq!(name, expected_name);
        assert_work(name, scene, differentiated, angles);
    }
}

#[test]
fn a_thing_that_a_scene_lacks_costs_nothing() {
    let links = pairs::LINKS;
    // Elements by dual numbers, and angles, of every row.
    let expected: [(&str, &[(usize, usize)]); 11] = [
        ("constraints", &[(0, 0), (0, links)]),
        ("loops", &[(0, 12), (0, 12)]),
        ("coordinates of a joint", &[(0, links), (0, links), (links / 2, links), (links / 2, links)]),
        ("mass that depends on q", &[(1, 0), (2, 0)]),
        ("forces of v", &[(0, links), (0, links), (links, links)]),
        ("forces of q", &[(0, links), (0, links), (links - 1, links)]),
        ("control", &[(0, links), (0, links)]),
        ("ten more controls", &[(0, links); 3]),
        ("design variables", &[(0, links); 4]),
        ("running cost", &[(0, links); 4]),
        ("time", &[(0, links), (1, links), (1, links)]),
    ];
    let all = pairs::all();
    assert_eq!(all.len(), expected.len());
    for (comparison, (thing, rows)) in all.into_iter().zip(expected) {
        assert_eq!((comparison.thing, comparison.rows.len()), (thing, rows.len()));
        for ((name, scene), &(differentiated, angles)) in comparison.rows.into_iter().zip(rows) {
            assert_work(&format!("{thing}: {name}"), scene, differentiated, angles);
        }
    }
}

/// The scene called so among the rows of a thing that a scene may lack.
fn pair(thing: &str, row: &str) -> Scene {
    let comparison = pairs::all().into_iter().find(|comparison| comparison.thing == thing).expect("a thing");
    comparison.rows.into_iter().find(|(name, _)| *name == row).expect("a row").1
}

#[test]
fn the_sweep_back_evaluates_costs_where_they_count_and_elements_for_inputs_that_ask_for_it() {
    const NODES: usize = STEPS + 1;
    // Costs at the end on all angles.
    let end = pairs::LINKS;
    // At every node, and once more for p*₀ = T_v(q₀, v₀; b).
    let each = NODES + 1;
    let expected = [
        ("running cost", "without", end, 0),
        ("running cost", "of u", end + NODES, 0),
        ("running cost", "of all angles", end + end * NODES, 0),
        ("running cost", "of all accelerations", end + end * NODES, 0),
        ("design variables", "unused", end, 0),
        ("design variables", "one stiffness", end, each),
        // The inertia and the weight of every link.
        ("design variables", "all masses", end, 2 * pairs::LINKS * each),
        ("time", "in a force", end, each),
        ("time", "in a constraint", end, each),
        ("ten more controls", "used", end, 0),
        ("forces of v", "nonlinear", end, 0),
    ];
    for (thing, row, costs, inputs) in expected {
        let (forward, adjoint) = reports(pair(thing, row), 0.01, 1.0);
        assert_eq!((forward.cost_evaluations, forward.input_evaluations), (0, 0), "{thing}: {row}");
        assert_eq!((adjoint.cost_evaluations, adjoint.input_evaluations), (costs, inputs), "{thing}: {row}");
    }
    // One control that acts along an axis that turns: Q_u is not constant.
    let actuator = elements::all().into_iter().find(|(name, _)| *name == "actuator on a moving body").expect("an actuator");
    let (_, adjoint) = reports(actuator.1, 0.01, 1.0);
    assert_eq!((adjoint.cost_evaluations, adjoint.input_evaluations), (1, each));
}

#[test]
fn a_linear_mechanism_without_constraints_is_solved_by_one_correction_a_step_with_constant_factors() {
    let Some(free) = pairs::all().into_iter().next().and_then(|comparison| comparison.rows.into_iter().next()) else {
        panic!("no scene")
    };
    let system = free.1.compile().expect("a scene");
    assert_eq!((system.n(), system.m()), (33, 0));
    // Every unknown is condensed: nothing is left to be factored at an iteration.
    assert!(system.elimination().is_empty());
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, 0.01));
    inputs.controls.fill(1.0);
    let mut solver = Solver::new(&system, Settings::default());
    assert_eq!(solver.simulate(&inputs).expect("a motion").sigma.shape(), (0, STEPS + 1));
    let report = solver.report();
    assert_eq!((report.newton_iterations, report.most_iterations, report.factorisations), (STEPS + 1, 1, STEPS + 2));
    assert_eq!((report.element_evaluations, report.sine_evaluations), (0, 0));
}

#[test]
fn a_second_run_does_the_same_work_as_the_first() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(STEPS, 0.02));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings::default());
    let mut run = || {
        solver.simulate(&inputs).expect("a motion");
        solver.gradient().expect("a gradient");
        (solver.report().clone(), solver.adjoint_report().clone())
    };
    assert_eq!(run(), run());
}

/// The condensed unknowns, and of each size of node how many there are and how wide the widest is.
fn elimination(scene: Scene) -> (usize, Vec<(usize, usize, usize)>) {
    let system = scene.compile().expect("a scene");
    let nodes = system.elimination();
    let condensed = system.n() + system.m() - nodes.iter().map(|[size, _]| size).sum::<usize>();
    let mut kinds = std::collections::BTreeMap::new();
    for [size, width] in nodes {
        let (count, widest) = kinds.entry(size).or_insert((0, 0));
        (*count, *widest) = (*count + 1, width.max(*widest));
    }
    (condensed, kinds.into_iter().map(|(size, (count, widest))| (size, count, widest)).collect())
}

#[test]
fn a_link_of_a_chain_keeps_its_angle_and_the_two_multipliers_of_its_hinge() {
    for links in [2, 3, 10, 100, 1000] {
        // x and y of the links, and all of the cart and its rail: 3 + 2. Each but the last has one neighbour left.
        assert_eq!(elimination(structures::chain(links)), (2 * links + 5, vec![(3, links, 3)]));
    }
}

#[test]
fn a_body_of_a_tree_keeps_x_and_y_only_where_it_branches() {
    assert_eq!(elimination(structures::binary_tree(1)), (2, vec![(3, 1, 0)]));
    for levels in [3, 7, 10] {
        let leaves = 2usize.pow(levels - 1);
        let nodes = vec![(3, leaves, 5), (5, leaves - 1, 5)];
        assert_eq!(elimination(structures::binary_tree(levels)), (2 * leaves, nodes));
    }
}

#[test]
fn a_closed_loop_adds_one_small_node_and_the_widths_stay_bounded() {
    for loops in [2, 3, 10, 30, 300] {
        let (condensed, nodes) = elimination(structures::ladder(loops));
        // The hinge that closes a loop; the rungs and the last bar of each string; the other bars, where three hinges meet.
        let counts: Vec<_> = nodes.iter().map(|&(size, count, _)| (size, count)).collect();
        assert_eq!((condensed, counts), (2 * loops + 4, vec![(2, loops), (3, loops + 2), (5, 2 * loops - 2)]));
        let widest = nodes.iter().map(|&(_, _, width)| width).max();
        println!("{loops} loops: nodes of (size, count, width) {nodes:?}");
        assert!(widest <= Some(13), "{nodes:?}");
    }
}

/// The multiplications of one factorisation.
fn factorisation_work(scene: Scene) -> usize {
    scene.compile().expect("a scene").elimination().iter().map(|[size, width]| size * (size + width).pow(2)).sum()
}

/// Asserts that every body or loop more costs the same.
fn assert_linear(name: &str, scene: impl Fn(usize) -> Scene, sizes: &[usize]) {
    let work: Vec<usize> = sizes.iter().map(|&size| factorisation_work(scene(size))).collect();
    let slope = |i: usize| (work[i + 1] - work[i]) as f64 / (sizes[i + 1] - sizes[i]) as f64;
    println!("{name}: {work:?} for {sizes:?}");
    for i in 1..sizes.len() - 1 {
        assert_eq!(slope(i), slope(0), "{name}: {work:?} for {sizes:?}");
    }
}

#[test]
fn the_work_of_a_factorisation_grows_linearly() {
    assert_linear("chain", structures::chain, &[10, 30, 100, 300, 1000]);
    assert_linear("ladder", structures::ladder, &[10, 30, 100, 300]);
    assert_linear("open ladder", structures::open_ladder, &[3, 10, 30, 100, 300]);
    assert_linear("doubled hinges", |bars| structures::string(bars, 2), &[3, 10, 30, 100, 300]);
    let levels = |bodies: usize| (bodies + 1).ilog2();
    assert_linear("tree", |bodies| structures::binary_tree(levels(bodies)), &[15, 127, 1023]);
}

#[test]
fn the_memory_of_a_node_grows_linearly() {
    let bytes = |scene: Scene, settings| scene.compile().expect("a scene").bytes_per_node(&settings);
    let plain = Settings::default();
    for links in [1, 3, 10, 100, 1000] {
        assert_eq!(bytes(structures::chain(links), plain), 152 * links + 120);
    }
    for loops in [3, 30, 300] {
        assert_eq!(bytes(structures::ladder(loops), plain), 472 * loops + 8);
    }
    let chain = |settings| bytes(structures::chain(3), settings);
    assert_eq!(chain(Settings { keep_adjoint: true, ..plain }) - chain(plain), 8 * (10 * 12 + 3 * 8));
    assert_eq!(chain(Settings { rebase_every: 9, ..plain }) - chain(plain), 16 * (3 * 12 + 3 * 8 + 3 * 15 + 6));
}

/// The corrections of 100 steps of a hanging chain that is pulled at its upper end.
fn corrections(links: usize, dt: f64) -> usize {
    let system = CartPendulum::with_links(links).scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, dt));
    inputs.controls.fill(1.0);
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    solver.report().newton_iterations
}

/// The reactions of 300 links are a thousand times their momenta, and so is what is left of them in the residual.
#[test]
fn rounding_of_large_multipliers_is_not_iterated() {
    let count = corrections(300, 0.002);
    assert!(count <= 130, "{count}");
}

#[test]
fn the_work_of_a_motion_grows_linearly_with_its_steps() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    for steps in [100, 1000] {
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2e-3));
        inputs.controls.fill(10.0);
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&inputs).expect("a motion");
        solver.gradient().expect("a gradient");
        assert!(solver.report().newton_iterations <= 2 * steps + 1);
        assert_eq!(solver.adjoint_report().factorisations, steps + 1);
    }
}

/// What a link costs is linear work times corrections; of waves that steps resolve well, the first guess is good enough for one.
#[test]
fn a_step_takes_one_correction_however_long_the_chain_is() {
    let counts = [10, 100, 1000].map(|links| corrections(links, 0.001));
    println!("corrections in 100 steps of 10, 100 and 1000 links: {counts:?}");
    assert!(counts.iter().all(|&count| count <= 130), "{counts:?}");
}
