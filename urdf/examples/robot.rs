//! A robot from a URDF file under constant torques: prints the state at the end, a cost with its gradient, and run times as one JSON object.
//!
//! `cargo run --release -p urdf --example robot -- --urdf FILE --steps 100 --dt 0.01`

use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::{
    Control, Coordinate, Error, Grid, Inputs, ListCost, ListPoint, Scalar, Scene, Scheme, Settings, Solver, Sum, System,
};
use serde_json::{Value, json};
use urdf::{Added, Base, Damping, Options, Robot};

const HELP: &str = "\
usage: cargo run --release -p urdf --example robot -- --urdf FILE --steps N --dt DT [options]

  --urdf FILE         the robot; gravity is -9.81 m/s^2 along z
  --steps N --dt DT   number and length of the time steps, s
  --floating          the base moves freely
  --lock NAME=VALUE   the joint keeps this value, rad or m; may be repeated
  --start q1,q2,...   initial values of the joints with one coordinate (0)
  --torque t1,...     constant torques or forces of these joints, N m or N (0)
  --damping d1,...    their damping, instead of none; `--damping file` for that of the file
  --target q1,...     the cost at the end is |q - target|^2/2 + 0.005 |v|^2 (0)
  --scheme NAME       trapezoidal, TR-BDF2, ESDIRK3, ESDIRK4 or ESDIRK5 (trapezoidal)
  --repeat R          number of repetitions; the times are medians (1)

The gradient contains the derivatives of the cost by the constant torques. `instructions` contains the lengths of the programs of the robot.
";

/// ½ |q − target|² + 0.005 |v|², b = target.
struct Miss;

impl ListCost for Miss {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        let square = |x: S| x * x;
        let position: S = at.q.iter().zip(at.b).map(|(q, target)| square(*q - *target)).sum();
        let velocity: S = at.v.iter().map(|v| square(*v)).sum();
        position * 0.5 + velocity * 0.005
    }
}

/// The arguments.
struct Task {
    file: String,
    steps: usize,
    dt: f64,
    options: Options,
    start: Vec<f64>,
    torque: Vec<f64>,
    damping: Option<Vec<f64>>,
    target: Vec<f64>,
    scheme: Scheme,
    repeat: usize,
}

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.is_empty() || arguments.iter().any(|argument| argument == "--help") {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    match task(arguments).and_then(|task| run(&task)) {
        Ok(answer) => println!("{answer}"),
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn task(arguments: Vec<String>) -> Result<Task, Failure> {
    let mut task = Task {
        file: String::new(),
        steps: 0,
        dt: 0.0,
        options: Options::default(),
        start: Vec::new(),
        torque: Vec::new(),
        damping: None,
        target: Vec::new(),
        scheme: Scheme::TRAPEZOIDAL,
        repeat: 1,
    };
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let mut text = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--urdf" => task.file = text()?,
            "--steps" => task.steps = text()?.parse()?,
            "--dt" => task.dt = text()?.parse()?,
            "--floating" => task.options.base = Base::Floating,
            "--lock" => {
                let text = text()?;
                let (name, value) = text.split_once('=').ok_or("--lock needs NAME=VALUE")?;
                task.options.locked.push((name.into(), value.parse()?));
            }
            "--start" => task.start = list(&text()?)?,
            "--torque" => task.torque = list(&text()?)?,
            "--damping" => {
                task.options.damping = Damping::File;
                let text = text()?;
                task.damping = if text == "file" { None } else { Some(list(&text)?) };
            }
            "--target" => task.target = list(&text()?)?,
            "--scheme" => {
                let text = text()?;
                let found = Scheme::ALL.into_iter().find(|scheme| scheme.name.split(' ').next() == Some(text.as_str()));
                task.scheme = found.ok_or("unknown scheme")?;
            }
            "--repeat" => task.repeat = text()?.parse::<usize>()?.max(1),
            _ => return Err(format!("unknown argument `{argument}` (try --help)").into()),
        }
    }
    Ok(task)
}

fn list(text: &str) -> Result<Vec<f64>, Failure> {
    Ok(text.split(',').map(|number| number.trim().parse()).collect::<Result<_, _>>()?)
}

/// The numbers given for the joints, or zeros.
fn of_joints(what: &str, given: &[f64], joints: usize) -> Result<Vec<f64>, Failure> {
    match given.len() {
        0 => Ok(vec![0.0; joints]),
        found if found == joints => Ok(given.to_vec()),
        found => Err(format!("{what} has {found} numbers instead of {joints}").into()),
    }
}

fn run(task: &Task) -> Result<Value, Failure> {
    let mut robot = Robot::read(&task.file)?;
    if let Some(damping) = &task.damping {
        let added = robot.add_to(&mut Scene::new(), &task.options)?;
        robot.joints.iter_mut().for_each(|joint| joint.damping = 0.0);
        let values = of_joints("--damping", damping, added.drivable().count())?;
        for ((moving, _), value) in added.drivable().zip(values) {
            robot.joints.iter_mut().filter(|joint| joint.name == moving.name).for_each(|joint| joint.damping = value);
        }
    }
    let mut scene = Scene::new();
    scene.spatial().gravity([0.0, 0.0, -9.81]);
    let added = robot.add_to(&mut scene, &task.options)?;
    let controls = added.drive(&mut scene);
    let q: Vec<Coordinate> = added.drivable().map(|(_, coordinate)| coordinate).collect();
    let start = of_joints("--start", &task.start, q.len())?;
    q.iter().zip(start).for_each(|(coordinate, value)| scene.place(*coordinate, value));
    let target: Vec<_> = of_joints("--target", &task.target, q.len())?.into_iter().map(Into::into).collect();
    scene.list_cost("miss", Miss, Sum::Terminal, &q, &[], &[], &target);
    let begin = Instant::now();
    let system = scene.compile()?;
    let compiled = begin.elapsed().as_secs_f64();
    let torque = of_joints("--torque", &task.torque, q.len())?;
    let inputs = inputs(&system, task, &controls, &torque);
    let (times, answer) = motion(&system, task, &inputs, &q)?;
    let [forward, both] = times.map(median);
    let names: Vec<&str> = added.drivable().map(|(joint, _)| joint.name.as_str()).collect();
    let locked: Vec<_> = added.locked.iter().map(|joint| (&joint.name, joint.value)).collect();
    Ok(json!({
        "joints": names, "locked": locked, "q": answer.q, "v": answer.v, "cost": answer.cost, "gradient": answer.gradient,
        "compile_s": compiled, "forward_s": forward, "value_and_gradient_s": both, "instructions": instructions(&system, &added),
    }))
}

fn inputs(system: &System, task: &Task, controls: &[Control], torque: &[f64]) -> Inputs {
    let mut inputs = Inputs::at_rest(system, Grid::uniform(task.steps, task.dt));
    controls.iter().zip(torque).for_each(|(control, torque)| inputs.set_control(*control, |_| *torque));
    inputs
}

struct Answer {
    q: Vec<f64>,
    v: Vec<f64>,
    cost: f64,
    gradient: Vec<f64>,
}

/// The times of the motions, and of motion and gradient; the state at the end; the cost and its derivatives by the constant controls.
fn motion(system: &System, task: &Task, inputs: &Inputs, q: &[Coordinate]) -> Result<([Vec<f64>; 2], Answer), Error> {
    let mut solver = Solver::new(system, Settings { scheme: task.scheme, ..Settings::default() });
    let (mut forward, mut both) = (Vec::new(), Vec::new());
    for _ in 0..task.repeat {
        let begin = Instant::now();
        solver.simulate(inputs)?;
        forward.push(begin.elapsed().as_secs_f64());
        solver.gradient()?;
        both.push(begin.elapsed().as_secs_f64());
    }
    let motion = solver.trajectory();
    let last = |matrix: &nalgebra::DMatrix<f64>| q.iter().map(|q| matrix[(q.index(), matrix.ncols() - 1)]).collect();
    let (q, v) = (last(&motion.q), last(&motion.v));
    let gradient = solver.gradient()?;
    let rows = gradient.controls.row_iter().map(|row| row.sum()).collect();
    Ok(([forward, both], Answer { q, v, cost: gradient.value, gradient: rows }))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The lengths of the programs of the trees of bodies, which have the names of their first links.
fn instructions(system: &System, added: &Added) -> Value {
    let names = added.links.iter().flat_map(|(link, _)| ["motion", "weight"].map(|what| format!("{what} of {link}")));
    let heading = |line: &str| {
        let (what, rest) = line.split_once(": ")?;
        let count: u64 = rest.split_once(" instructions")?.0.parse().ok()?;
        Some((what.to_string(), count.into()))
    };
    let programs = names.filter_map(|name| system.program(&name));
    programs.flat_map(|text| text.lines().filter_map(heading).collect::<Vec<(String, Value)>>()).collect()
}
