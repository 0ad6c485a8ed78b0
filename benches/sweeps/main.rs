//! Wall time of simulations and gradients, by size, element, feature and structure of a scene.
//!
//! `cargo bench` runs everything (some minutes), `cargo bench -- quick` one row of each group, `cargo bench -- element` a group.
//! The times are those of one thread, after the scene was compiled and everything allocated; `--features rayon` adds a group with all threads.

#[path = "../../tests/scenes/elements.rs"]
mod elements;
mod features;
#[path = "../../tests/scenes/formulas.rs"]
mod formulas;
#[path = "../../tests/scenes/hinges.rs"]
mod hinges;
mod newton;
#[path = "../../tests/scenes/pairs.rs"]
mod pairs;
#[path = "../../tests/scenes/pantograph.rs"]
mod pantograph;
#[path = "../../tests/scenes/ready_parts.rs"]
mod ready_parts;
#[path = "../../tests/scenes/relative.rs"]
mod relative;
#[path = "../../tests/scenes/seven_bodies.rs"]
#[allow(dead_code)]
mod seven_bodies;
mod space;
#[path = "../../tests/scenes/structures.rs"]
mod structures;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use hamiltonian_adjoint::Scene;
use std::time::Duration;

use benches::Row;

/// The paper's example has Δt = 0.02; longer chains move faster.
fn step_length(links: usize) -> f64 {
    if links <= 3 { 0.02 } else { 0.01 }
}

/// Adds "quick" to the names that `cargo bench -- quick` selects.
fn mark(name: impl std::fmt::Display, quick: bool) -> String {
    if quick { format!("{name} (quick)") } else { name.to_string() }
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    group
}

/// The cart with k links: simulation, gradient after it, both, and a product of the Hessian.
fn links(criterion: &mut Criterion) {
    let mut group = group(criterion, "cart with k links, 100 steps");
    for links in [3, 10, 30, 100] {
        let row = Row::new(structures::chain(links), 100, step_length(links), 10.0);
        let name = mark(format!("k = {links}"), links == 3);
        row.simulate(&mut group, "simulate", &name);
        row.gradient(&mut group, "gradient", &name);
        row.both(&mut group, "value + gradient", &name);
        row.product(&mut group, "product of the Hessian", &name);
    }
    group.finish();
}

/// The cart with three links over the number of steps.
fn steps(criterion: &mut Criterion) {
    let mut group = group(criterion, "cart with 3 links, N steps");
    for steps in [100, 1000, 10_000] {
        // All motions last two seconds, so that Newton iterations per step depend on the step length alone.
        let row = Row::new(structures::chain(3), steps, 2.0 / steps as f64, 10.0);
        group.throughput(Throughput::Elements(steps as u64));
        row.both(&mut group, "value + gradient", &mark(format!("N = {steps}"), steps == 1000));
    }
    group.finish();
}

/// Two arms and one kind of element, 100 steps.
fn elements(criterion: &mut Criterion) {
    let mut group = group(criterion, "element");
    for (name, scene) in elements::all().into_iter().chain(ready_parts::all()) {
        let row = Row::new(scene, 100, 0.01, 1.0);
        row.both(&mut group, "value + gradient", &mark(name, name == "revolute joint"));
    }
    group.finish();
}

/// User-defined formulas, 100 steps: with programs, and with dual numbers at every point.
fn programs(criterion: &mut Criterion) {
    let mut group = group(criterion, "formulas");
    for ((name, scene, dt), (_, again, _)) in formulas::all().into_iter().zip(formulas::all()) {
        let name = mark(name, name == "seven bodies as one element");
        let row = Row::new(scene, 100, dt, 1.0);
        row.both(&mut group, "by programs", &name);
        row.product(&mut group, "product of the Hessian", &name);
        let plain = again.compile_without_programs().expect("a scene");
        Row::of(plain, 100, dt, 1.0).both(&mut group, "by dual numbers", &name);
    }
    group.finish();
}

/// Optional features of a scene, with and without each, 100 steps.
fn pairs(criterion: &mut Criterion) {
    let mut group = group(criterion, "with and without");
    for comparison in pairs::all() {
        let quick = comparison.thing == "running cost";
        for (name, scene) in comparison.rows {
            Row::new(scene, 100, 0.01, 1.0).both(&mut group, comparison.thing, &mark(name, quick));
        }
    }
    group.finish();
}

/// Time per body and step: the throughput counts bodies times steps. At 1 ms one correction per step is enough for all chains; a longer chain
/// under its weight is stiffer, and at 2 ms the links near the top of a thousand need two.
fn structure(criterion: &mut Criterion) {
    let mut group = group(criterion, "structure, 100 steps");
    for links in [10, 30, 100, 300, 1000] {
        structure_row(&mut group, "chain", &mark(format!("{links} links"), links == 30), (structures::chain(links), 0.001));
    }
    structure_row(&mut group, "chain", "1000 links in steps of 2 ms", (structures::chain(1000), 0.002));
    for levels in [4, 7, 10] {
        let bodies = 2usize.pow(levels) - 1;
        structure_row(&mut group, "binary tree", &format!("{bodies} bodies"), (structures::binary_tree(levels), 0.002));
    }
    for loops in [3, 30, 300] {
        let name = mark(format!("{loops} loops"), loops == 3);
        structure_row(&mut group, "ladder", &name, (structures::ladder(loops), 0.002));
    }
    group.finish();
}

fn structure_row(group: &mut BenchmarkGroup<WallTime>, kind: &str, name: &str, (scene, dt): (Scene, f64)) {
    const STEPS: usize = 100;
    let row = Row::new(scene, STEPS, dt, 1.0);
    group.throughput(Throughput::Elements((row.bodies() * STEPS) as u64));
    row.both(group, kind, name);
}

/// Compiling a scene: recording its elements and choosing the order of elimination.
fn compile(criterion: &mut Criterion) {
    let mut group = group(criterion, "compile a chain");
    group.sample_size(10);
    for links in [3, 30, 300] {
        group.bench_function(mark(format!("{links} links"), links == 3), |bencher| {
            bencher.iter_with_large_drop(|| structures::chain(links).compile())
        });
    }
    group.finish();
}

/// Formulas of lists and of fixed lengths: compiling them, and 100 steps.
fn lists(criterion: &mut Criterion) {
    let mut group = group(criterion, "formulas of many coordinates");
    let names = [
        "arm of 7 joints, by lists",
        "arm of 7 joints, by a fixed length",
        "tree of 30 bodies as one list",
        "tree of 30 bodies, each a list",
    ];
    for (i, name) in names.into_iter().enumerate() {
        let scene = || if i < 2 { relative::arm(i == 0) } else { relative::tree(30, i == 2) };
        let name = mark(name, true);
        group.bench_function(criterion::BenchmarkId::new("compile", &name), |bencher| {
            bencher.iter_with_large_drop(|| scene().compile())
        });
        Row::new(scene(), 100, 0.005, 1.0).both(&mut group, "value + gradient", &name);
    }
    group.finish();
}

criterion_group!(
    all,
    links,
    steps,
    elements,
    programs,
    pairs,
    structure,
    compile,
    lists,
    newton::first_guess,
    newton::iterations,
    newton::half_steps,
    space::chains,
    space::compile,
    features::lengths,
    features::restarts,
    features::memory,
    features::outputs,
    features::redundancy,
    features::threads
);
criterion_main!(all);
