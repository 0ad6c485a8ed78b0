//! A four-bar linkage in space whose rocker is to swing by a given function of the angle of the crank.
//!
//! Lengths and the place of the rocker's pivot are design variables. Every trial is assembled from the same guess; the crank turns once at constant speed.
//!
//! `cargo run --release --example spatial_four_bar -- spatial-four-bar.html`

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, interior_point, silent};
use hamiltonian_adjoint::planar::ConstantSpeed;
use hamiltonian_adjoint::spatial::{Body, Inertia};
use hamiltonian_adjoint::{
    Animation, Coordinate, Cost, CostPoint, Design, Error, Grid, Inputs, Scalar, Scene, Scheme, Settings, Solver, Start,
    Sum, System, Trajectory, check,
};
use nalgebra::SVector;

/// The swing that is wanted, rad, from the middle: a slow way forth and a quick way back.
fn wanted<S: Scalar>(turns: S) -> S {
    let phi = turns * TAU;
    phi.sin() * 0.4 + (phi * 2.0).sin() * 0.08
}

/// (ψ − middle − wanted)²; b = [middle].
struct Miss;

impl Cost<1, 0, 0, 1> for Miss {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        let error = at.q[0] - b[0] - wanted(at.t);
        error * error
    }
}

/// Steps of one turn, which takes 1 s.
const STEPS: usize = 60;
/// The design variables, m and rad: names, values, and bounds.
const DESIGNS: [(&str, f64, [f64; 2]); 7] = [
    ("crank", 0.12, [0.05, 0.3]),
    ("rod", 0.6, [0.2, 1.2]),
    ("rocker", 0.35, [0.1, 0.8]),
    ("y of the pivot", 0.1, [-0.5, 0.5]),
    ("z of the pivot", 0.3, [-0.5, 0.5]),
    ("phase of the crank", 0.0, [-3.2, 3.2]),
    ("middle of the swing", 1.3, [-3.2, 3.2]),
];

struct Linkage {
    system: System,
    designs: [Design; 7],
    middle: Design,
    /// The angle ψ of the rocker.
    rocker: Coordinate,
}

fn linkage() -> Result<Linkage, Error> {
    let mut scene = Scene::new();
    let designs = DESIGNS.map(|(name, value, _)| scene.design(name, value));
    let [crank_length, rod_length, rocker_length, y, z, phase, middle] = designs;
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let lengths = [("crank", crank_length), ("rod", rod_length), ("rocker", rocker_length)];
    let [crank, rod, rocker] = lengths.map(|(name, length)| {
        let inertia = Inertia::cuboid(length * 1.5, (length, 0.03, 0.03)); // 1.5 kg/m
        space.body(name, inertia.centred_at((length * 0.5, 0.0, 0.0)))
    });
    let drive = space.revolute("drive", Body::GROUND.origin(), crank.origin());
    let [back, up, across] = [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let elbow = crank.at((crank_length, 0.0, 0.0)).along_and_toward(back, up);
    space.universal("elbow", elbow, rod.origin().along_and_toward(back, up));
    let pivot = space.revolute("pivot", Body::GROUND.at((0.5, y, z)).along(across), rocker.origin().along(across));
    space.close_ball("end", rod.at((rod_length, 0.0, 0.0)), rocker.at((rocker_length, 0.0, 0.0)));
    scene.driven_axis("motor", drive.angle, ConstantSpeed, [phase.into(), TAU.into()]);
    scene.place(pivot.angle, 1.5);
    scene.cost("error", Miss, Sum::Integral, [pivot.angle], [], [], [middle.into()]);
    Ok(Linkage { system: scene.compile()?, designs, middle, rocker: pivot.angle })
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let page = arguments.next().map_or_else(|| std::env::temp_dir().join("spatial-four-bar.html"), PathBuf::from);
    if arguments.next().is_some() {
        eprintln!("usage: cargo run --release --example spatial_four_bar -- [PAGE]");
        return ExitCode::from(2);
    }
    match run(&page) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// True if the optimum is found and the gradients are right.
fn run(page: &Path) -> Result<bool, Error> {
    let linkage = linkage()?;
    let mut inputs = Inputs::at_rest(&linkage.system, Grid::uniform(STEPS, 1.0 / STEPS as f64));
    inputs.start = Start::assembled(&linkage.system); // The motor determines the angle and the speed of the crank.
    let free = linkage.designs.into_iter().zip(DESIGNS);
    let free = free.map(|(design, (_, _, [least, most]))| Free::design(design).within(least, most)).collect();
    let variables = Variables::new(&linkage.system, &inputs, free)?;
    let mut problem = MotionProblem::new(&linkage.system, settings(), inputs.clone(), variables)?;
    let start = problem.start();
    let best = interior_point(&mut problem, &start, &Options::default(), &mut silent)?;
    println!("{best}");
    let optimum = problem.inputs_at(&best.x);

    let (before, after) = (linkage.errors(&inputs)?, linkage.errors(&optimum)?);
    println!("{:22} {:>9} {:>9}", "m, rad", "before", "after");
    for ((name, before, _), after) in DESIGNS.into_iter().zip(&best.x) {
        println!("{name:22} {before:9.4} {after:9.4}");
    }
    for (k, name) in ["rms error, °", "largest error, °", "gap of the loop, m"].into_iter().enumerate() {
        println!("{name:22} {:9.2e} {:9.2e}", before[k], after[k]);
    }
    let mut passed = best.reason.is_converged();
    for inputs in [&inputs, &optimum] {
        let report = check::gradient(&linkage.system, inputs, settings()).run()?;
        println!("{report}");
        passed &= report.passed();
    }
    linkage.draw(&optimum, page)?;
    println!("page: {}", page.display());
    Ok(passed)
}

/// Of order 4, so that the loop hardly opens by drift.
fn settings() -> Settings {
    Settings { scheme: Scheme::ESDIRK4, ..Settings::default() }
}

impl Linkage {
    /// ψ − middle − wanted at all nodes, °.
    fn error(&self, motion: &Trajectory, inputs: &Inputs) -> Vec<f64> {
        let middle = inputs.design[self.middle.index()];
        let angles = motion.q.row(self.rocker.index());
        motion.times.iter().zip(angles.iter()).map(|(t, angle)| (angle - middle - wanted(*t)).to_degrees()).collect()
    }

    /// Root mean square and maximum of the error, °, and the largest violation of a constraint, m.
    fn errors(&self, inputs: &Inputs) -> Result<[f64; 3], Error> {
        let mut solver = Solver::new(&self.system, settings());
        let motion = solver.simulate(inputs)?.clone();
        let largest = self.error(&motion, inputs).iter().fold(0.0, |most: f64, error| most.max(error.abs()));
        Ok([solver.cost()?.sqrt().to_degrees(), largest, motion.phi(&self.system, inputs)?.amax()])
    }

    fn draw(&self, inputs: &Inputs, page: &Path) -> Result<(), Error> {
        let mut solver = Solver::new(&self.system, settings());
        let motion = solver.simulate(inputs)?;
        let error = self.error(motion, inputs);
        let animation = Animation::new(&self.system, inputs, motion)?.title("A four-bar linkage in space");
        animation.plot("error of the rocker", "°", &error)?.write_html(page)
    }
}
