//! A solver that has been used once allocates nothing per step, and keeps as many bytes for a node as it says.
#![allow(unsafe_code, reason = "a global allocator that counts")]

#[path = "scenes/structures.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod structures;

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Error, Grid, Inputs, LiftedSolver, ListCost, ListPoint, LongSolver, Scalar, Scene,
    Settings, Solver, Sum, System, gradient,
};
use nalgebra::SVector;
use num_dual::Dual64;
use std::alloc::{GlobalAlloc, Layout, System as Memory};
use std::cell::Cell;
use std::f64::consts::FRAC_PI_2;

thread_local! {
    /// Allocations of this thread: other tests run beside.
    static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes that were ever allocated.
    static TOTAL: Cell<usize> = const { Cell::new(0) };
    /// Bytes that are allocated at present.
    static BYTES: Cell<isize> = const { Cell::new(0) };
    /// The most bytes that were allocated since this was set to `BYTES`.
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn grow(bytes: isize) {
    TOTAL.set(TOTAL.get() + bytes.max(0) as usize);
    BYTES.set(BYTES.get() + bytes);
    PEAK.set(PEAK.get().max(BYTES.get()));
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        grow(layout.size() as isize);
        unsafe { Memory.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        grow(-(layout.size() as isize));
        unsafe { Memory.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // It may have to be moved as a whole.
        TOTAL.set(TOTAL.get() + layout.size());
        grow(size as isize - layout.size() as isize);
        unsafe { Memory.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = COUNT.get();
    work();
    COUNT.get() - before
}

/// Allocations of a simulation, of its gradient and of the second product of its Hessian, when all were made once before, with a grid of so many steps.
fn of_second_call(steps: usize, settings: Settings) -> [usize; 3] {
    of_second_call_with(CartPendulum::default().scene(), steps, settings)
}

fn of_second_call_with(scene: Scene, steps: usize, settings: Settings) -> [usize; 3] {
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.005));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, settings);
    let mut run = || {
        let forward = allocations(|| _ = solver.simulate(&inputs).expect("motion"));
        let gradient = allocations(|| _ = solver.gradient().expect("gradient"));
        let push = inputs.no_change();
        // The first one goes back once more, to keep what products need.
        solver.hessian_product(&push).expect("product");
        [forward, gradient, allocations(|| _ = solver.hessian_product(&push).expect("product"))]
    };
    run();
    run()
}

#[test]
fn the_number_of_allocations_does_not_depend_on_the_number_of_steps() {
    let [short, long] = [50, 500].map(|steps| of_second_call(steps, Settings::default()));
    println!("allocations of simulate, gradient and product: {short:?} for 50 steps, {long:?} for 500");
    assert_eq!(short, long);
}

#[test]
fn restarts_allocate_nothing_in_gradients_that_are_recorded_for_products_nor_in_products() {
    let restarted = Settings { drift_bound: 0.0, rebase_every: 1, ..Settings::default() };
    let [short, long] = [50, 500].map(|steps| of_second_call(steps, restarted));
    println!("allocations of simulate, gradient and product with restarts: {short:?} for 50 steps, {long:?} for 500");
    assert_eq!(short, long);
}

/// v̇² + u̇² + λ².
struct Rates;
impl Cost<1, 1, 1> for Rates {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 1, 1>, _: &SVector<S, 0>) -> S {
        at.v_dot[0].powi(2) + at.u_dot[0].powi(2) + at.lambda[0].powi(2)
    }
}

#[test]
fn costs_on_accelerations_reactions_and_rates_of_controls_allocate_nothing_either() {
    let [short, long] = [50, 500].map(|steps| {
        let mut cart = CartPendulum::default().mechanism();
        let (angle, force) = (cart.links[1].coordinates[2], cart.force);
        cart.scene.cost("rates", Rates, Sum::Integral, [angle], [cart.rail[0]], [force], []);
        of_second_call_with(cart.scene, steps, Settings::default())
    });
    println!("allocations of simulate, gradient and product: {short:?} for 50 steps, {long:?} for 500");
    assert_eq!(short, long);
}

#[test]
fn values_of_costs_and_outputs_allocate_nothing_per_node() {
    assert_values_allocate_nothing(|scene| scene);
}

#[cfg(feature = "files")]
#[test]
fn values_of_costs_from_files_allocate_nothing_per_node() {
    assert_values_allocate_nothing(|scene| {
        let file = scene.to_json().expect("a file");
        hamiltonian_adjoint::SceneFile::from_json(&file).expect("a scene").complete().expect("everything")
    });
}

fn assert_values_allocate_nothing(change: impl Fn(Scene) -> Scene) {
    let [short, long] = [50, 500].map(|steps| {
        let mut cart = CartPendulum::default().mechanism();
        let ([.., angle], output) = (cart.links[1].coordinates, cart.scene.output("angle"));
        cart.scene.cost("angle", AngleError, Sum::Integral, [angle], [], [], [0.1.into()]);
        cart.scene.term(output, "term", AngleError, Sum::Integral, [angle], [], [], [0.1.into()]);
        let system = change(cart.scene).compile().expect("a scene");
        let mut solver = Solver::new(&system, Settings::default());
        solver.simulate(&Inputs::at_rest(&system, Grid::uniform(steps, 0.005))).expect("a motion");
        [allocations(|| _ = solver.cost().expect("J")), allocations(|| _ = solver.outputs().expect("outputs"))]
    });
    println!("allocations of cost and outputs: {short:?} for 50 steps, {long:?} for 500");
    assert_eq!(short, long);
}

#[test]
fn clones_of_a_system_share_its_data() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    assert_eq!(allocations(|| _ = std::hint::black_box(system.clone())), 0);
}

/// The bytes that a solver holds after a motion of so many steps.
fn bytes_held(system: &System, settings: Settings, steps: usize) -> isize {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.005));
    inputs.controls.fill(10.0);
    let before = BYTES.get();
    let mut solver = Solver::new(system, settings);
    solver.simulate(&inputs).expect("motion");
    if settings.keep_adjoint {
        solver.gradient().expect("gradient");
    }
    BYTES.get() - before
}

#[test]
fn a_node_takes_the_memory_that_the_system_says() {
    for links in [1, 3, 10] {
        let system = CartPendulum::with_links(links).scene().compile().expect("scene");
        for keep_adjoint in [false, true] {
            let settings = Settings { keep_adjoint, ..Settings::default() };
            let held = [100, 300].map(|steps| bytes_held(&system, settings, steps));
            let per_node = (held[1] - held[0]) / 200;
            // The inputs besides: a step length and a control; and as much for the gradient.
            let inputs = if keep_adjoint { 32 } else { 16 };
            println!("{links} links: {per_node} bytes a node, adjoint variables kept: {keep_adjoint}");
            assert_eq!(per_node, system.bytes_per_node(&settings) as isize + inputs);
        }
        // What restarts need is a bound: their lists grow by doubling.
        let restarted = Settings { rebase_every: 1, ..Settings::default() };
        let per_node = (bytes_held(&system, restarted, 1300) - bytes_held(&system, restarted, 300)) / 1000;
        println!("{links} links: {per_node} bytes a node, restarted at every node");
        assert!(per_node <= system.bytes_per_node(&restarted) as isize + 16);
    }
}

#[test]
fn a_long_solver_keeps_to_the_bytes_it_is_given() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(4000, 0.0005));
    inputs.controls.fill(10.0);
    for settings in [Settings::default(), Settings { rebase_every: 1, ..Settings::default() }] {
        // With the solver itself: a long one keeps its sweeps in a list.
        let workspace = bytes_held(&system, settings, 1) + size_of::<Solver>() as isize;
        for bytes in [3_000_000, 1_000_000, 400_000, 250_000] {
            let before = BYTES.get();
            PEAK.set(before);
            let mut long = LongSolver::new(&system, settings, bytes as usize);
            long.gradient(&inputs).expect("gradient");
            let held = PEAK.get() - before;
            println!("{bytes} bytes given, at most {held} held, workspace {workspace}");
            assert!(held <= bytes + workspace, "{held} of {bytes}");
        }
    }
}

/// A pendulum that bounces on a floor.
fn with_kinks() -> System {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let rod = scene.body("rod", 1.0, 0.1, [0.5, 0.0, 0.0]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0));
    let law = [1e4.into(), 0.1.into(), 0.0.into(), 1.0.into()];
    scene.contact("floor", Body::GROUND.at(0.0, -0.5), FRAC_PI_2, rod.at(0.5, 0.0), law);
    scene.cost("end", AngleError, Sum::Terminal, [rod.coordinates[2]], [], [], [0.3.into()]);
    scene.compile().expect("a scene")
}

#[test]
fn a_long_solver_keeps_to_the_bytes_it_is_given_where_gradients_follow_kinks() {
    let system = with_kinks();
    let inputs = Inputs::at_rest(&system, Grid::uniform(4000, 0.0005));
    let settings = Settings::default();
    let expected = gradient(&system, &inputs, settings).expect("a gradient");
    assert!(expected.frozen.is_some());
    // The sweeps that follow kinks have workspaces of their own.
    let workspace = 3 * (bytes_held(&system, settings, 1) + size_of::<Solver>() as isize);
    for bytes in [3_000_000, 1_000_000, 400_000] {
        let before = BYTES.get();
        PEAK.set(before);
        let mut long = LongSolver::new(&system, settings, bytes as usize);
        let result = long.gradient(&inputs).expect("a gradient");
        let held = PEAK.get() - before;
        assert!(held <= bytes + workspace, "{held} of {bytes}");
        assert_eq!(*result, expected, "{bytes}");
    }
}

#[test]
fn gradients_that_follow_kinks_allocate_nothing_in_their_steps() {
    let system = with_kinks();
    let bytes_of = |steps: usize| {
        let inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
        let mut solver = Solver::new(&system, Settings::default());
        for _ in 0..2 {
            solver.simulate(&inputs).expect("a motion");
            assert!(solver.gradient().expect("a gradient").frozen.is_some());
        }
        solver.simulate(&inputs).expect("a motion");
        allocations(|| _ = solver.gradient().is_ok())
    };
    let [few, many] = [1000, 4000].map(bytes_of);
    println!("{few} allocations with 1,000 steps, {many} with 4,000");
    assert!(few.max(many) < 30);
}

/// The cart with so many steps, of which every fifth is far too long for one iteration matrix.
fn with_long_steps(system: &System, steps: usize) -> (Inputs, Settings) {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(steps, 0.005));
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 10.0 * (0.02 * i as f64).sin());
    inputs.grid.steps.iter_mut().skip(3).step_by(5).for_each(|dt| *dt = 0.4);
    (inputs, Settings { max_iterations: 4, rebase_every: 1, ..Settings::default() })
}

#[test]
fn a_long_solver_keeps_to_the_bytes_it_is_given_where_steps_are_halved() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    for (steps, rebase_every) in [(300, 0), (300, 1), (2000, 0)] {
        let (inputs, settings) = with_long_steps(&system, steps);
        let settings = Settings { rebase_every, ..settings };
        // With the solver itself: a long one keeps its sweeps in a list.
        let workspace = bytes_held(&system, settings, 1) + size_of::<Solver>() as isize;
        let (mut fits, mut bytes) = (0, 5_000);
        while bytes < 20_000_000 {
            let before = BYTES.get();
            PEAK.set(before);
            let mut long = LongSolver::new(&system, settings, bytes as usize);
            let result = long.gradient(&inputs).map(|_| ()).and_then(|()| long.cost());
            let held = PEAK.get() - before;
            println!("{bytes} bytes given, at most {held} held, workspace {workspace}: {result:?}");
            assert!(held <= bytes + workspace, "{held} of {bytes}");
            assert!(matches!(result, Ok(_) | Err(Error::Memory { .. })), "{result:?}");
            fits += usize::from(result.is_ok());
            bytes = bytes * 3 / 2;
        }
        assert!(fits > 5, "{fits}");
    }
}

/// Bytes that were allocated on the way, those that were given back too.
fn bytes_of(work: impl FnOnce()) -> usize {
    let before = TOTAL.get();
    work();
    TOTAL.get() - before
}

#[test]
fn the_bytes_that_halved_steps_take_grow_like_their_number() {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let of = |steps: usize| {
        let (inputs, settings) = with_long_steps(&system, steps);
        let mut inserted = 0;
        let mut solver = Solver::new(&system, Settings { rebase_every: 0, ..settings });
        let bytes = bytes_of(|| {
            inserted = solver.simulate(&inputs).expect("a motion").inserted.len();
            solver.gradient().expect("a gradient");
        });
        (inserted, bytes)
    };
    let [(few, of_few), (many, of_many)] = [of(200), of(2500)];
    let ratio = of_many as f64 / of_few as f64 * few as f64 / many as f64;
    println!("{of_few} bytes for {few} inserted nodes, {of_many} for {many}: {ratio:.2}");
    assert!(few > 50 && many > 10 * few && ratio < 2.0, "{ratio}");
}

#[test]
fn the_bytes_that_the_values_of_readings_take_grow_like_their_number() {
    let [few, many] = [100, 800].map(|count| {
        let mut cart = CartPendulum::with_links(1).mechanism();
        let angle = cart.links[0].coordinates[2];
        for node in 1..=count {
            let output = cart.scene.output(&format!("output {node}"));
            let sum = Sum::Node(node);
            cart.scene.term(output, &format!("reading {node}"), AngleError, sum, [angle], [], [], [0.1.into()]);
        }
        let system = cart.scene.compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(count, 0.001));
        let mut lifted = LiftedSolver::<Dual64>::new(&system, &inputs, Settings::default()).expect("a motion");
        lifted.simulate(&inputs.lift()).expect("the same motion");
        bytes_of(|| assert_eq!(lifted.outputs().expect("readings").len(), count))
    });
    let ratio = many as f64 / few as f64 / 8.0;
    println!("{few} bytes for 100 readings, {many} for 800: {ratio:.2}");
    assert!(ratio < 1.5, "{ratio}");
}

/// (Σ q²)ᵖ.
struct Squares(i32);
impl ListCost for Squares {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.q.iter().map(|q| *q * *q).sum::<S>().powi(self.0)
    }
}

/// The cart with a cost on the angles of all its links.
fn on_all_angles(links: usize, cost: Squares) -> Scene {
    let mut cart = CartPendulum::with_links(links).mechanism();
    let angles: Vec<Coordinate> = cart.links.iter().map(|link| link.coordinates[2]).collect();
    cart.scene.list_cost("angles", cost, Sum::Integral, &angles, &[], &[], &[]);
    cart.scene
}

#[test]
fn the_bytes_that_compiling_takes_grow_like_the_scene() {
    type Sized = fn(usize) -> Scene;
    let doubled: Sized = |bars| structures::string(bars, 2);
    let tree: Sized = |bodies| structures::binary_tree(bodies.ilog2());
    let squares: Sized = |links| on_all_angles(links, Squares(1));
    let coupled: Sized = |links| on_all_angles(links, Squares(2));
    let scenes = [
        ("chain", structures::chain as Sized),
        ("ladder", structures::ladder),
        ("doubled", doubled),
        ("tree", tree),
        ("sum of squares", squares),
        ("square of a sum of squares", coupled),
    ];
    for (name, scene) in scenes {
        let [few, many] = [128, 2048].map(|size| {
            let scene = scene(size);
            bytes_of(|| drop(scene.compile().expect("a scene")))
        });
        let ratio = many as f64 / few as f64 / 16.0;
        println!("{name}: {few} and {many} bytes, {ratio:.2}");
        assert!(ratio < 1.5, "{name}: {ratio}");
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0.0f64; 8]))), 1);
    PEAK.set(BYTES.get());
    let before = BYTES.get();
    drop(std::hint::black_box(vec![0.0f64; 8]));
    assert_eq!((BYTES.get() - before, PEAK.get() - before), (0, 64));
}

/// An angle of a link.
struct Level;
impl Cost<1> for Level {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _: &SVector<S, 0>) -> S {
        at.q[0] + 1.9
    }
}

/// The cart with an event that its link is at this angle, in so many steps.
fn with_event(steps: usize) -> (System, Inputs) {
    let mut cart = CartPendulum::default().mechanism();
    let angle = cart.links[1].coordinates[2];
    cart.scene.event("level", Level, [angle], [], [], []);
    let system = cart.scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 4.0 / steps as f64));
    inputs.controls.fill(10.0);
    inputs.events = vec![system.event(0).at(steps / 10)];
    (system, inputs)
}

#[test]
fn located_events_allocate_nothing_in_their_steps_and_a_long_solver_keeps_to_its_bytes() {
    let count = |steps: usize| {
        let (system, inputs) = with_event(steps);
        let mut solver = Solver::new(&system, Settings::default());
        let mut run = || {
            let motion = allocations(|| _ = solver.simulate(&inputs).expect("a motion"));
            [motion, allocations(|| _ = solver.gradient().expect("a gradient"))]
        };
        run();
        run()
    };
    let [few, many] = [400, 4000].map(count);
    println!("allocations of simulate and gradient: {few:?} for 400 steps, {many:?} for 4,000");
    assert!(few[0].max(many[0]) < 150 && few[1].max(many[1]) < 60);
    let (system, inputs) = with_event(4000);
    let expected = gradient(&system, &inputs, Settings::default()).expect("a gradient");
    let workspace = 2 * (bytes_held(&system, Settings::default(), 1) + size_of::<Solver>() as isize);
    for bytes in [3_000_000, 1_000_000, 500_000, 400_000] {
        let before = BYTES.get();
        PEAK.set(before);
        let mut long = LongSolver::new(&system, Settings::default(), bytes as usize);
        let result = long.gradient(&inputs).expect("a gradient");
        let held = PEAK.get() - before;
        println!("{bytes} bytes given, at most {held} held, workspace {workspace}");
        assert!(held <= bytes + workspace, "{held} of {bytes}");
        assert_eq!(*result, expected, "{bytes}");
    }
}
