//! A solver that has been used once allocates nothing per step, and keeps as many bytes for a node as it says.
#![allow(unsafe_code, reason = "a global allocator that counts")]

use hamiltonian_adjoint::{Grid, Inputs, LongSolver, Settings, Solver, System, scenes::CartPendulum};
use std::alloc::{GlobalAlloc, Layout, System as Memory};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread: other tests run beside.
    static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes that are allocated at present.
    static BYTES: Cell<isize> = const { Cell::new(0) };
    /// The most bytes that were allocated since this was set to `BYTES`.
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn grow(bytes: isize) {
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

/// Allocations of the second simulation and the second gradient with a grid of so many steps.
fn of_second_call(steps: usize) -> [usize; 2] {
    let system = CartPendulum::default().scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.005));
    inputs.controls.fill(10.0);
    let mut solver = Solver::new(&system, Settings::default());
    let mut run = || {
        let forward = allocations(|| _ = solver.simulate(&inputs).expect("motion"));
        [forward, allocations(|| _ = solver.gradient().expect("gradient"))]
    };
    run();
    run()
}

#[test]
fn the_number_of_allocations_does_not_depend_on_the_number_of_steps() {
    let (short, long) = (of_second_call(50), of_second_call(500));
    println!("allocations of simulate and gradient: {short:?} for 50 steps, {long:?} for 500");
    assert_eq!(short, long);
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
        let workspace = bytes_held(&system, settings, 1);
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

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0.0f64; 8]))), 1);
    PEAK.set(BYTES.get());
    let before = BYTES.get();
    drop(std::hint::black_box(vec![0.0f64; 8]));
    assert_eq!((BYTES.get() - before, PEAK.get() - before), (0, 64));
}
