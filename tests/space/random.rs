//! Random scenes in space beside chains of transforms that are differentiated along curves.
//!
//! `RANDOM_SCENES=1000 cargo test --release --all-features --test space random -- --nocapture` tries more of them, and `RANDOM_FIRST=10000` others.

mod build;
mod chain;
mod conservation;
mod cuts;
mod derivatives;
#[cfg(feature = "files")]
mod files;
mod loops;
mod plan;

use std::collections::BTreeMap;
use std::ops::Range;

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Error, Grid, Inputs, Mechanics, Settings, Solver, Start, System};
use nalgebra::{DVector, Vector3};
use num_dual::Dual2_64;

use build::{Built, QUANTITIES, build};
use chain::{Chain, Motion};
use plan::{Plan, Scope, plan};

const TREES: Scope = Scope { loads: true, conservative: false, afloat: false, loops: false };

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|number| number.parse().ok())
}

/// The number of scenes for each property.
fn cases() -> u64 {
    number("RANDOM_SCENES").unwrap_or(60)
}

/// The seeds of the scenes for one property.
fn seeds(from: u64, count: u64) -> Range<u64> {
    let first = number("RANDOM_FIRST").unwrap_or(0) + from;
    first..first + count
}

/// Whether the frame of a direction is found from −z.
fn is_below(z: [f64; 3]) -> bool {
    Vector3::from(z).normalize().z < -0.9
}

/// The largest of each kind of number, and the count of each event.
#[derive(Default)]
struct Tally {
    largest: BTreeMap<String, (f64, u64)>,
    counts: BTreeMap<String, u64>,
    failures: Vec<String>,
    seed: u64,
}

impl Tally {
    fn count(&mut self, what: &str) {
        *self.counts.entry(what.into()).or_default() += 1;
    }

    fn refused(&mut self, error: &Error) {
        let whole = format!("{error:?}");
        self.count(whole.split([' ', '{', '(']).next().unwrap_or_default());
    }

    fn begin(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// Notes an error, and whether it is within a bound.
    fn note(&mut self, what: &str, error: f64, bound: f64) {
        let (largest, seed) = self.largest.entry(what.into()).or_insert((0.0, self.seed));
        if error > *largest {
            (*largest, *seed) = (error, self.seed);
        }
        if error.is_nan() || error > bound {
            self.failures.push(format!("seed {}: {what}: {error:e}", self.seed));
        }
    }

    /// Prints everything, and asserts that all errors were within their bounds.
    fn finish(&self, title: &str) {
        println!("{title}");
        self.counts.iter().for_each(|(what, count)| println!("  {count:6} {what}"));
        self.largest.iter().for_each(|(what, (error, seed))| println!("  {what}: at most {error:.1e} (seed {seed})"));
        assert!(self.failures.is_empty(), "{:#?}", self.failures);
    }

    fn of(&self, what: &str) -> u64 {
        self.counts.get(what).copied().unwrap_or(0)
    }
}

fn relative<'a>(ours: impl IntoIterator<Item = &'a f64>, truth: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (ours, truth): (Vec<f64>, Vec<f64>) = (ours.into_iter().copied().collect(), truth.into_iter().copied().collect());
    crate::common::largest_difference(&ours, &truth) / truth.iter().fold(1.0, |size: f64, x| size.max(x.abs()))
}

fn controls(count: usize) -> Vec<f64> {
    (0..count).map(|k| 0.7 - 0.4 * k as f64).collect()
}

fn chain<'a>(plan: &'a Plan, built: &'a Built, (designs, u): (&'a [f64], &'a [f64])) -> Chain<'a> {
    let Built { of_links, of_flat, others, .. } = built;
    Chain { plan, designs, of_links, of_flat, others, u }
}

/// The inputs of a short motion from the state of a scene.
fn inputs(system: &System, built: &Built, grid: Grid) -> Inputs {
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.start = Start::Velocity { q: built.q.clone().into(), v: built.v.clone().into() };
    let u = controls(system.k());
    inputs.controls.column_iter_mut().for_each(|mut column| column.copy_from_slice(&u));
    inputs
}

/// Asserts that masses, momenta, energies, accelerations and multipliers at a state are those of the chain.
fn compare_mechanics(
    tally: &mut Tally,
    here: &Mechanics,
    chain: &Chain,
    built: &Built,
    [q, v]: [&[f64]; 2],
) -> Result<(), Error> {
    let mass = chain.mass(q);
    let momenta = &mass * DVector::from_column_slice(v);
    tally.note("mass matrix", relative(&here.mass(), &mass), 1e-13);
    // Velocities of joints may cancel in the momenta.
    let terms = (0..q.len()).map(|i| (0..q.len()).map(|j| (mass[(i, j)] * v[j]).abs()).sum()).fold(1.0, f64::max);
    let error = crate::common::largest_difference(here.momenta().as_slice(), momenta.as_slice());
    tally.note("momenta", error / terms, 1e-13);
    let kinetic = 0.5 * momenta.dot(&DVector::from_column_slice(v));
    tally.note("kinetic energy", relative(&[here.kinetic_energy()], &[kinetic]), 1e-13);
    tally.note("potential energy", relative(&[here.potential_energy()], &[chain.potential(q)]), 1e-12);
    let (v_dot, lambda) = here.accelerations()?;
    let own: Vec<f64> = built.multipliers.iter().map(|multiplier| lambda[multiplier.index()]).collect();
    tally.note("imbalance", chain.imbalance([q, v, v_dot.as_slice()], &own), 1e-12);
    let curve = |i: usize| Dual2_64::new(q[i], v[i], v_dot[i]);
    let square = v_dot.amax() + v.iter().map(|v| v * v).sum::<f64>();
    for first in chain.quaternions() {
        let e = [0, 1, 2, 3].map(|k| curve(first + k));
        let second = e.iter().map(|e| e.re * e.v2 + e.v1 * e.v1).sum::<f64>() / square;
        tally.note("quaternions", second.abs(), 1e-12);
    }
    for phi in chain.phi(&curve) {
        tally.note("constraints", (phi.v2 / square).abs(), 1e-10);
    }
    Ok(())
}

/// Asserts that outputs at the end of a motion are those of the chain.
fn compare_outputs(
    tally: &mut Tally,
    (system, inputs): (&System, &Inputs),
    chain: &Chain,
    settings: Settings,
) -> Result<(), Error> {
    let mut solver = Solver::new(system, settings);
    solver.simulate(inputs)?;
    let (values, motion) = (solver.outputs()?, solver.trajectory());
    let last = motion.last();
    let here = Mechanics::at_node(system, solver.inputs(), motion, last)?;
    let (v_dot, _) = here.accelerations()?;
    let curve = |i: usize| Dual2_64::new(motion.q[(i, last)], motion.v[(i, last)], v_dot[i]);
    let Motion { place, velocity, acceleration, turn, spin, faster } =
        chain.marker(&chain.poses(&curve), chain.plan.tip).motion();
    let axis = |k: usize| turn.column(k).into_owned();
    let truth = [place, velocity, acceleration, axis(0), axis(1), axis(2), spin, faster];
    // The sizes of the terms: velocities of joints may cancel.
    let [q, v, v_dot] = [motion.q.column(last).amax(), motion.v.column(last).amax(), v_dot.amax()];
    let sizes = [q, v, v_dot + v * v, 0.0, 0.0, 0.0, v, v_dot + v * v];
    for (((quantity, own), truth), size) in QUANTITIES.iter().zip(values.as_slice().chunks(3)).zip(truth).zip(sizes) {
        let error = crate::common::largest_difference(own, truth.as_slice()) / (1.0 + size);
        tally.note(&format!("{quantity:?}"), error, 1e-12);
    }
    Ok(())
}

fn compare_one(tally: &mut Tally, seed: u64, scope: Scope) -> Result<(), Error> {
    let mut random = Random::new(seed);
    let plan = plan(&mut random, scope);
    let built = build(&plan, &mut random);
    let system = built.scene.clone().compile()?;
    let (u, state) = (controls(system.k()), [&built.q[..], &built.v]);
    let here = Mechanics::new(&system, state[0], state[1])?.with_controls(&u)?;
    compare_mechanics(tally, &here, &chain(&plan, &built, (&plan.designs, &u)), &built, state)?;
    let others: Vec<f64> = plan.designs.iter().enumerate().map(|(k, x)| x * (1.0 + 0.01 * k as f64)).collect();
    let there = here.with_design(&others)?;
    compare_mechanics(tally, &there, &chain(&plan, &built, (&others, &u)), &built, state)?;
    let inputs = inputs(&system, &built, Grid::uniform(10, 0.002));
    compare_outputs(tally, (&system, &inputs), &chain(&plan, &built, (&plan.designs, &u)), Settings::default())?;
    tally.count("compared");
    Ok(())
}

#[test]
fn random_trees_move_like_chains_of_transforms() {
    let mut tally = Tally::default();
    for seed in seeds(0, cases()) {
        tally.begin(seed);
        if let Err(error) = compare_one(&mut tally, seed, TREES) {
            println!("seed {seed}: {error}");
            tally.refused(&error);
        }
    }
    tally.finish("random trees");
    assert!(tally.of("compared") as f64 >= 0.9 * cases() as f64);
}
