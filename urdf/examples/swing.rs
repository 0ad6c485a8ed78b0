//! The swing of a robot arm from a URDF file with the least torques, from rest in one pose to rest in another one.
//!
//! The torques at all nodes are free within the efforts of the file, and the speeds at all nodes stay within its limits. The program searches from several
//! starts, compares the optima, checks the gradients at the best one, and can write its motion as a page. Gears damp the joints; without them
//! (`--gears 0`) the arm swings like a whip, and the search takes hundreds of iterations.
//!
//! `cargo run --release -p urdf --example swing -- --page swing.html`

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::optimize::{
    Free, Interval, MotionProblem, Options, Outcome, Variables, interior_point, multi_start, silent,
};
use hamiltonian_adjoint::{
    Animation, Control, Coordinate, Cost, CostPoint, EndState, Grid, Inputs, Mechanics, Output, Scalar, Scene, Scheme,
    Settings, Sum, System, Trajectory, check,
};
use nalgebra::{DVector, SVector};
use urdf::{Damping, Moving, Robot};

const HELP: &str = "\
usage: cargo run --release -p urdf --example swing -- [options]

  --urdf FILE      a robot whose joints have one coordinate and an effort each (the arm of this package)
  --from q1,...    the pose at the beginning, rad or m
  --to q1,...      the pose at the end
  --time T         the duration, s (1.2)
  --steps N        the number of time steps, 2 to 1000 (40)
  --gears D        the damping of the gears divided by the effort, s/rad or s/m, in addition to the damping of the file (0.06)
  --starts K       the number of starts, 1 to 1000 (5)
  --page FILE      writes the best motion as a page

The cost is the sum over the joints of the integral of (torque/effort)^2; gravity is -9.81 m/s^2 along z.
exit status: 0; 1 if the file cannot be used or no optimum is found; 2 if the arguments are wrong
";

/// The arguments.
struct Task {
    urdf: PathBuf,
    from: Vec<f64>,
    to: Vec<f64>,
    time: f64,
    steps: usize,
    gears: f64,
    starts: usize,
    page: Option<PathBuf>,
}

/// Reason for an exit with an error.
enum Failure {
    Usage(String),
    Run(String),
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::Run(error.to_string())
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args_os().skip(1).map(|text| text.to_string_lossy().into_owned()).collect();
    let asks_for_help = arguments.iter().any(|argument| argument == "--help");
    let mut text = if asks_for_help { HELP.to_string() } else { String::new() };
    let done = if asks_for_help { Ok(()) } else { task(arguments).and_then(|task| run(&task, &mut text)) };
    // Also what is known before a failure.
    let printed = io::stdout().write_all(text.as_bytes()).map_err(Failure::from);
    let (status, message) = match done.and(printed) {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => (2, format!("{message} (try --help)")),
        Err(Failure::Run(message)) => (1, message),
    };
    // Unlike `eprintln!` this does not panic if standard error is closed.
    let _ = writeln!(io::stderr(), "error: {message}");
    ExitCode::from(status)
}

fn task(arguments: Vec<String>) -> Result<Task, Failure> {
    let mut task = Task {
        urdf: concat!(env!("CARGO_MANIFEST_DIR"), "/robots/arm.urdf").into(),
        from: vec![0.0, 0.6, 0.0, -1.8, 0.0, 1.2, 0.0],
        to: vec![1.2, 0.9, 0.3, -1.1, 0.2, 1.4, 0.5],
        time: 1.2,
        steps: 40,
        gears: 0.06,
        starts: 5,
        page: None,
    };
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let wrong = |what: &str| Failure::Usage(format!("{argument:?} {what}"));
        let mut text = || arguments.next().ok_or_else(|| wrong("needs a value"));
        let number =
            |text: String| text.parse().ok().filter(|x: &f64| (0.0..=1e3).contains(x)).ok_or(wrong("must be 0 to 1000"));
        let count = |text: String| text.parse().ok().filter(|n| (1..=1000).contains(n)).ok_or(wrong("must be 1 to 1000"));
        match argument.as_str() {
            "--urdf" => task.urdf = text()?.into(),
            "--from" => task.from = pose(&text()?).ok_or(wrong("needs finite numbers"))?,
            "--to" => task.to = pose(&text()?).ok_or(wrong("needs finite numbers"))?,
            "--time" => task.time = number(text()?)?,
            "--steps" => task.steps = count(text()?)?,
            "--gears" => task.gears = number(text()?)?,
            "--starts" => task.starts = count(text()?)?,
            "--page" => task.page = Some(text()?.into()),
            _ => return Err(wrong("is unknown")),
        }
    }
    match task.time > 0.0 && task.steps > 1 {
        true => Ok(task),
        false => Err(Failure::Usage("a motion needs some time and two steps".into())),
    }
}

fn pose(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|number| number.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// The speed of a joint.
struct Speed;

impl Cost<1> for Speed {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v[0]
    }
}

/// A joint in the scene.
struct Axis {
    joint: Moving,
    q: Coordinate,
    control: Control,
    effort: f64,
    end: EndState,
    /// At the nodes between the first and the last one.
    speeds: Vec<Output>,
}

/// The arm at its start.
fn arm(task: &Task) -> Result<(System, Vec<Axis>), Failure> {
    let mut robot = Robot::read(&task.urdf)?;
    for joint in &mut robot.joints {
        joint.damping += task.gears * joint.limit.and_then(|limit| limit.effort).unwrap_or(0.0);
    }
    let mut scene = Scene::new();
    scene.spatial().gravity([0.0, 0.0, -9.81]);
    let added = robot.add_to(&mut scene, &urdf::Options { damping: Damping::File, ..urdf::Options::default() })?;
    let controls = added.drive(&mut scene);
    let n = controls.len();
    if n == 0 || n != added.joints.len() {
        return Err(Failure::Run("the robot has no joint that moves, or joints with several coordinates".into()));
    }
    for (name, pose) in [("--from", &task.from), ("--to", &task.to)] {
        if pose.len() != n {
            return Err(Failure::Usage(format!("{name} has {} numbers for {n} joints", pose.len())));
        }
    }
    let mut axes = Vec::with_capacity(n);
    for (k, (joint, q)) in added.drivable().enumerate() {
        let (name, control) = (&joint.name, controls[k]);
        let effort = joint.limit.and_then(|limit| limit.effort).filter(|effort| *effort > 0.0);
        let effort = effort.ok_or_else(|| Failure::Run(format!("joint {name:?} has no effort")))?;
        scene.place(q, task.from[k]);
        scene.effort(&format!("effort of {name}"), control, 1.0 / (effort * effort));
        let speeds = (1..task.steps).map(|node| {
            let name = format!("speed of {name} at node {node}");
            let output = scene.output(&name);
            scene.term(output, &name, Speed, Sum::Node(node), [q], [], [], []);
            output
        });
        let speeds = speeds.collect();
        axes.push(Axis { joint: joint.clone(), q, control, effort, end: scene.end_state(q), speeds });
    }
    Ok((scene.compile()?, axes))
}

/// An L-stable scheme: the damped wrist is stiff.
fn settings() -> Settings {
    Settings { scheme: Scheme::TR_BDF2, ..Settings::default() }
}

fn problem(task: &Task, system: &System, axes: &[Axis]) -> Result<MotionProblem, hamiltonian_adjoint::Error> {
    let inputs = Inputs::at_rest(system, Grid::uniform(task.steps, task.time / task.steps as f64));
    let free = axes.iter().map(|axis| Free::control(axis.control).within(-axis.effort, axis.effort).scaled(axis.effort));
    let variables = Variables::new(system, &inputs, free.collect())?;
    let mut problem = MotionProblem::new(system, settings(), inputs, variables)?;
    for (axis, to) in axes.iter().zip(&task.to) {
        problem.constrain(axis.end.position, Interval::equal(*to));
        problem.constrain(axis.end.rate, Interval::equal(0.0));
        let most = axis.joint.limit.and_then(|limit| limit.velocity).unwrap_or(f64::INFINITY);
        axis.speeds.iter().for_each(|speed| problem.constrain(*speed, Interval::new(-most, most)));
    }
    Ok(problem)
}

/// A start: the torques along a path from pose to pose, with a detour of up to 0.3 rad (or m) unless it is the first start.
fn guess(task: &Task, problem: &MotionProblem, axes: &[Axis], which: usize) -> Result<Vec<f64>, Failure> {
    let detour = |k: usize| if which == 0 { 0.0 } else { 0.3 * ((which * (k + 2) * 7) as f64).sin() };
    let mut inputs = problem.inputs_at(&problem.start());
    for node in 0..=task.steps {
        // A step from 0 to 1 and a bump with their first two derivatives, which vanish at both ends.
        let t = node as f64 / task.steps as f64;
        let r = 1.0 - t;
        let step = [t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * (t * r).powi(2), 60.0 * t * r * (r - t)];
        let bump = [64.0 * (t * r).powi(3), 192.0 * (t * r).powi(2) * (r - t), 384.0 * t * r * (1.0 - 5.0 * t * r)];
        let path = |order: usize, k: usize| {
            let way = (task.to[k] - task.from[k]) * step[order] + detour(k) * bump[order];
            way / task.time.powi(order as i32)
        };
        let q = DVector::from_fn(axes.len(), |k, _| task.from[k] + path(0, k));
        let [v, v_dot] = [1, 2].map(|order| DVector::from_fn(axes.len(), |k, _| path(order, k)));
        // τ = M (v̇ − v̇₀), where v̇₀ are the accelerations without torques.
        let at = Mechanics::new(problem.solver.system(), q.as_slice(), v.as_slice())?;
        let torques = at.mass() * (v_dot - at.accelerations()?.0);
        for (axis, torque) in axes.iter().zip(torques.iter()) {
            inputs.controls[(axis.control.index(), node)] = torque.clamp(-axis.effort, axis.effort);
        }
    }
    Ok(problem.free().of(&inputs))
}

fn run(task: &Task, text: &mut String) -> Result<(), Failure> {
    let begin = Instant::now();
    let (system, axes) = arm(task)?;
    let new = || problem(task, &system, &axes);
    let mut problem = new()?;
    let starts = (0..task.starts).map(|which| guess(task, &problem, &axes, which)).collect::<Result<Vec<_>, _>>()?;
    writeln!(text, "{} joints, {} free torques", axes.len(), starts[0].len())?;
    let options = Options { iterations: 200, stationarity: 1e-6, ..Options::default() };
    let outcomes = multi_start(&starts, new, |problem, start| interior_point(problem, start, &options, &mut silent));
    let optima = outcomes.iter().flatten().filter(|outcome| outcome.reason.is_converged());
    let best = optima.min_by(|one, other| one.value.total_cmp(&other.value));
    for (k, outcome) in outcomes.iter().enumerate() {
        match outcome {
            Ok(outcome) => writeln!(text, "start {}: {outcome}", k + 1)?,
            Err(error) => writeln!(text, "start {}: {error}", k + 1)?,
        }
        if let (Ok(outcome), Some(best)) = (outcome, best) {
            writeln!(text, "    {}", compared(outcome, best))?;
        }
    }
    let best = best.ok_or_else(|| Failure::Run("no start leads to an optimum".into()))?;
    let optimum = problem.inputs_at(&best.x);
    let motion = problem.solver.simulate(&optimum)?.clone();
    writeln!(text, "least cost {:.7}, after {:.1} s", best.value, begin.elapsed().as_secs_f64())?;
    *text += &table(&axes, &optimum, &motion);
    for check in [
        check::gradient(&system, &optimum, settings()),
        check::gradient(&system, &optimum, settings()).output(axes[0].end.rate),
    ] {
        let report = check.run()?;
        writeln!(text, "{report}")?;
        if !report.passed() {
            return Err(Failure::Run("a gradient is wrong".into()));
        }
    }
    if let Some(page) = &task.page {
        Animation::new(&system, &optimum, &motion)?.title("Swing with the least torques").write_html(page)?;
        writeln!(text, "page: {}", page.display())?;
    }
    Ok(())
}

/// The difference of an outcome from the best one.
fn compared(outcome: &Outcome, best: &Outcome) -> String {
    let apart = outcome.x.iter().zip(&best.x).fold(0.0f64, |most, (x, best)| most.max((x - best).abs()));
    let which = if apart < 1e-4 { "the best optimum" } else { "not the best optimum" };
    format!("{which}: torques differ by {apart:.1e} of the efforts, the cost by {:.1e}", outcome.value - best.value)
}

/// The largest torques and speeds, and the coordinates, beside the limits of the file.
fn table(axes: &[Axis], inputs: &Inputs, motion: &Trajectory) -> String {
    let mut text = "joint          torque  of at most    speed  of at most   coordinate    within\n".to_string();
    for Axis { joint, q, control, effort, .. } in axes {
        let limit = joint.limit.unwrap_or_default();
        let (u, q, v) = (inputs.controls.row(control.index()), motion.q.row(q.index()), motion.v.row(q.index()));
        text += &format!("{:12} {:8.2} {effort:11.2}", joint.name, u.amax());
        text += &format!(" {:8.2} {:11.2}", v.amax(), limit.velocity.unwrap_or(f64::INFINITY));
        text += &format!("   {:.2} … {:.2}   {:.2} … {:.2}\n", q.min(), q.max(), limit.lower, limit.upper);
    }
    text
}
