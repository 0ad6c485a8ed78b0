//! Effect of step lengths, projection, rebasing, checkpoints, dependent constraints and threads on run times.

use criterion::Criterion;
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Settings, Sum};

use crate::{group, mark, pantograph, step_length, structures};
use benches::Row;

/// Rebasing and projection: at every node, less often, and with a bound that is not reached.
pub fn restarts(criterion: &mut Criterion) {
    let mut group = group(criterion, "restarts, 1000 steps");
    let plain = Settings::default();
    let all = [
        ("none", plain),
        ("rebased every 100 nodes", Settings { rebase_every: 100, ..plain }),
        ("rebased at every node", Settings { rebase_every: 1, ..plain }),
        ("a bound that is not reached", Settings { drift_bound: 1.0, ..plain }),
        ("projected where Φ exceeds 1e-6", Settings { drift_bound: 1e-6, ..plain }),
        ("projected at every node", Settings { drift_bound: 0.0, ..plain }),
    ];
    for links in [3, 30] {
        for (what, settings) in all {
            let row = Row { settings, ..Row::new(structures::chain(links), 1000, 0.002, 10.0) };
            row.both(&mut group, "value + gradient", &mark(format!("{links} links, {what}"), links == 3));
        }
    }
    group.finish();
}

/// Equal steps, and steps that all differ, as in grids by tolerance, for which the linear part is computed anew in each step.
pub fn lengths(criterion: &mut Criterion) {
    let mut group = group(criterion, "lengths of steps, 100 steps");
    for links in [3, 30] {
        for (what, share) in [("one length", 0.0), ("a hundred lengths", 0.1)] {
            let mut row = Row::new(structures::chain(links), 100, step_length(links), 10.0);
            let steps = row.inputs.grid.steps.iter_mut().enumerate();
            steps.for_each(|(k, step)| *step *= 1.0 + share * (0.7 * k as f64).sin());
            row.both(&mut group, "value + gradient", &mark(format!("{links} links, {what}"), links == 3));
        }
    }
    group.finish();
}

/// One gradient with all nodes stored, and with one and two levels of checkpoints.
pub fn memory(criterion: &mut Criterion) {
    let mut group = group(criterion, "memory, 3 links, 10000 steps");
    let row = Row::new(structures::chain(3), 10_000, 2e-4, 10.0);
    row.both(&mut group, "value + gradient", &mark("Solver", true));
    for (what, bytes) in [("all stored", 20_000_000), ("one level", 1_500_000), ("two levels", 540_000)] {
        row.both_within(&mut group, "value + gradient", &mark(format!("LongSolver, {what}, {bytes} bytes"), true), bytes);
    }
    group.finish();
}

/// One cost and three outputs that depend on the ends of the links.
pub fn outputs(criterion: &mut Criterion) {
    let mut group = group(criterion, "outputs, 100 steps");
    for links in [3, 10] {
        let cart = CartPendulum::with_links(links).mechanism();
        let mut scene = cart.scene;
        for (k, link) in cart.links.iter().take(3).enumerate() {
            let (angle, target) = ([link.coordinates[2]], [1.5.into()]);
            let output = scene.output(&format!("angle {k}"));
            scene.cost(&format!("cost {k}"), AngleError, Sum::Terminal, angle, [], [], target);
            scene.term(output, &format!("term {k}"), AngleError, Sum::Terminal, angle, [], [], target);
        }
        let row = Row::new(scene, 100, step_length(links), 10.0);
        let name = mark(format!("{links} links"), links == 3);
        row.both(&mut group, "value + gradient", &name);
        row.jacobian(&mut group, "three values + gradients", &name);
    }
    group.finish();
}

/// A chain of bars with every hinge doubled; a motion of one step shows the cost of detecting the dependencies at a start. Also pantographs side by side, whose
/// positions drift apart, so that equations are left out and chosen anew during the motion.
pub fn redundancy(criterion: &mut Criterion) {
    let mut group = group(criterion, "dependent constraints");
    for bars in [3, 30] {
        for (what, hinges) in [("plain", 1), ("doubled hinges", 2)] {
            for steps in [1, 100] {
                let row = Row::new(structures::string(bars, hinges), steps, 0.01, 1.0);
                let name = mark(format!("{bars} bars, {what}, N = {steps}"), bars == 3);
                row.both(&mut group, "value + gradient", &name);
            }
        }
    }
    for count in [1, 64] {
        for (what, across) in [("plain", false), ("a bar too many each", true)] {
            let row = Row::new(pantograph::pantographs(count, across, 40.0).0, 100, 0.005, 4.0);
            row.simulate(&mut group, "simulate", &mark(format!("{count} pantographs, {what}"), count == 1));
        }
    }
    group.finish();
}

/// Sixteen gradients on one thread and on all threads.
#[cfg(feature = "rayon")]
pub fn threads(criterion: &mut Criterion) {
    use criterion::{BenchmarkId, Throughput};
    use hamiltonian_adjoint::{Inputs, gradients};

    let mut group = group(criterion, "16 gradients, 100 steps");
    group.throughput(Throughput::Elements(16));
    for links in [3, 30] {
        let row = Row::new(structures::chain(links), 100, 0.01, 0.0);
        let pushed = |force: usize| {
            let mut inputs = row.inputs.clone();
            inputs.controls.fill(force as f64);
            inputs
        };
        let guesses: Vec<Inputs> = (0..16).map(pushed).collect();
        let all = std::thread::available_parallelism().map_or(1, usize::from);
        for threads in [1, all] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let name = mark(format!("{links} links, {threads} threads"), links == 3);
            group.bench_function(BenchmarkId::new("value + gradient", name), |bencher| {
                bencher.iter(|| pool.install(|| gradients(&row.system, &guesses, row.settings)))
            });
        }
    }
    group.finish();
}

/// Without the feature only one thread is used.
#[cfg(not(feature = "rayon"))]
pub fn threads(_criterion: &mut Criterion) {}
