//! A solver that has been used once allocates nothing per step.
#![allow(unsafe_code, reason = "a global allocator that counts")]

use hamiltonian_adjoint::{Grid, Inputs, Settings, Solver, scenes::CartPendulum};
use std::alloc::{GlobalAlloc, Layout, System as Memory};
use std::cell::Cell;

thread_local! {
    /// Allocations of this thread: other tests run beside.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        unsafe { Memory.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { Memory.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
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

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0.0f64; 8]))), 1);
}
