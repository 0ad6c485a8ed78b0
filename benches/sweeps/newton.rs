//! Effect of the choices in Newton's iteration that inputs and settings can switch.
//!
//! | choice | switched by |
//! |---|---|
//! | first guess extrapolated through 1 … 5 nodes | motions of j steps from many states: j nodes precede the end of the j-th step |
//! | stop by the estimated next correction | a tolerance of zero, which leaves only the criterion "the residual is rounding"; the usual criterion "the last correction is below the tolerance" would take one more correction per step and is not available |
//! | constants of several half steps kept | seven stages of four lengths, compared with seven that differ in their last digits |
//! | old factors for the last correction | no switch: the counter shows the number of factorisations saved |

use criterion::{BenchmarkId, Criterion};
use hamiltonian_adjoint::{Composition, Grid, Inputs, Settings, Solver, Start};

use crate::{group, mark, step_length, structures};
use benches::Row;

const STEPS: usize = 100;

fn cart(links: usize) -> Row {
    Row::new(structures::chain(links), STEPS, step_length(links), 10.0)
}

/// Motions of 1 … 5 steps from every state of a motion: the initial guess of the last step of each row is extrapolated through as many nodes
/// as the row has steps.
pub fn first_guess(criterion: &mut Criterion) {
    let mut group = group(criterion, "first guess, motions of j steps from 90 states");
    for links in [3, 30] {
        let mut row = cart(links);
        // The states of a motion have drifted from their position constraints.
        row.settings = Settings { position_tolerance: 0.1, ..row.settings };
        let mut before = Work::of(&row, &from_every_state(&row, 0));
        for steps in 1..=5 {
            let motions = from_every_state(&row, steps);
            let work = Work::of(&row, &motions);
            let [corrections, factorisations] = work.since(before).map(|count| count as f64 / motions.len() as f64);
            println!(
                "{links} links, guess through {steps} nodes: {corrections:.2} corrections per step, {factorisations:.2} factorisations"
            );
            before = work;
            let mut solver = Solver::new(&row.system, row.settings);
            let name = mark(format!("{links} links, j = {steps}"), links == 3);
            group.bench_function(BenchmarkId::new("simulate", name), |bencher| {
                bencher
                    .iter(|| motions.iter().map(|inputs| solver.simulate(inputs).expect("a motion").computed).sum::<usize>())
            });
        }
    }
    group.finish();
}

/// The motion's last 90 nodes as starts.
fn from_every_state(row: &Row, steps: usize) -> Vec<Inputs> {
    let mut solver = Solver::new(&row.system, row.settings);
    let motion = solver.simulate(&row.inputs).expect("a motion");
    let start = |i: usize| {
        let (q, p_star) = (motion.q.column(i).into_owned(), motion.p_star.column(i).into_owned());
        let dt = row.inputs.grid.steps[0];
        let mut inputs = Inputs::at_rest(&row.system, Grid::uniform(steps, dt));
        inputs.controls.fill(10.0);
        Inputs { start: Start::Momentum { q, p_star }, ..inputs }
    };
    (STEPS - 90..STEPS).map(start).collect()
}

/// Work of Newton's method in several motions.
#[derive(Clone, Copy)]
struct Work {
    corrections: usize,
    factorisations: usize,
}

impl Work {
    fn of(row: &Row, motions: &[Inputs]) -> Self {
        let mut solver = Solver::new(&row.system, row.settings);
        let mut work = Work { corrections: 0, factorisations: 0 };
        for inputs in motions {
            solver.simulate(inputs).expect("a motion");
            work.corrections += solver.report().newton_iterations;
            work.factorisations += solver.report().factorisations;
        }
        work
    }

    fn since(self, before: Work) -> [usize; 2] {
        [self.corrections - before.corrections, self.factorisations - before.factorisations]
    }
}

/// The stopping criterion, smooth and rough controls, and step lengths for which fewer nodes can be used.
pub fn iterations(criterion: &mut Criterion) {
    let mut group = group(criterion, "Newton, 100 steps");
    for links in [3, 30] {
        let name = |what: &str| mark(format!("{links} links, {what}"), links == 3);
        cart(links).simulate_and_count(&mut group, "criterion", &name("the next correction, by its estimate"));
        let mut row = cart(links);
        row.settings = Settings { tolerance: 0.0, ..row.settings };
        row.simulate_and_count(&mut group, "criterion", &name("the residual is rounding"));

        // Short steps, for which the initial guess is nearly right.
        for (what, tolerance) in [("short steps, by its estimate", 1e-14), ("short steps, the residual is rounding", 0.0)] {
            row = Row::new(structures::chain(links), STEPS, 0.1 * step_length(links), 10.0);
            row.settings = Settings { tolerance, ..row.settings };
            row.simulate_and_count(&mut group, "criterion", &name(what));
        }

        row = cart(links);
        let dt = row.inputs.grid.steps[0];
        row.inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 10.0 + 5.0 * (i as f64 * dt).cos());
        row.simulate_and_count(&mut group, "controls", &name("smooth"));
        row.inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = if i % 2 == 0 { 15.0 } else { 5.0 });
        row.simulate_and_count(&mut group, "controls", &name("up and down at every node"));

        row = cart(links);
        row.inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= if i % 2 == 0 { 1.5 } else { 0.5 });
        row.simulate_and_count(&mut group, "steps", &name("1 : 3 in turn"));
    }
    group.finish();
}

/// Yoshida's seven stages have four lengths, whose condensed constants are all kept.
pub fn half_steps(criterion: &mut Criterion) {
    let mut group = group(criterion, "seven stages, 20 macro steps");
    for links in [3, 30] {
        let name = |what: &str| mark(format!("{links} links, {what}"), links == 3);
        let mut row = cart(links);
        row.inputs.grid = Grid::composed(20, 2.0 * step_length(links), Composition::Yoshida6);
        row.inputs.controls = nalgebra::DMatrix::from_element(1, row.inputs.grid.nodes(), 10.0);
        row.simulate_and_count(&mut group, "constants", &name("kept"));
        let stages = Composition::Yoshida6.stages();
        row.inputs.grid.steps.iter_mut().enumerate().for_each(|(i, dt)| *dt *= 1.0 + 1e-12 * (i % stages) as f64);
        row.simulate_and_count(&mut group, "constants", &name("made anew at every stage"));
    }
    group.finish();
}
