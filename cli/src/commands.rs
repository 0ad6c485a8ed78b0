//! The commands that compute one motion or none.

use std::path::{Path, PathBuf};

use clap::Args;
use hamiltonian_adjoint::{Error, Grid, Inputs, Scene, SceneFile, Settings, Solver, System, Table, Warning};
use serde_json::{Map, json};

use crate::Failure;
use crate::files::{MOST_BYTES, Output, name, read, say};
use crate::settings;

/// A scene and its inputs.
#[derive(Args)]
pub struct Task {
    /// File of the scene; `-` for standard input
    scene: PathBuf,
    /// File of the inputs; `-` for standard input
    inputs: PathBuf,
    #[command(flatten)]
    pub output: Output,
    #[command(flatten)]
    motion: settings::Motion,
}

/// A system with its inputs.
pub struct Known {
    pub scene: Scene,
    pub system: System,
    pub inputs: Inputs,
    pub settings: Settings,
    /// The name of the file of the inputs.
    pub place: String,
}

/// Reads a scene without parts that were left out.
fn scene(path: &Path) -> Result<(Scene, System), Failure> {
    let scene = SceneFile::from_json(&read(path)?).and_then(SceneFile::complete);
    let both = scene.and_then(|scene| Ok((scene.clone(), scene.compile()?)));
    both.map_err(|error| Failure::wrong(name(path), error))
}

impl Task {
    /// Reads both files.
    pub fn read(&self) -> Result<Known, Failure> {
        self.output.check()?;
        let ((scene, system), place) = (scene(&self.scene)?, name(&self.inputs));
        let inputs = Inputs::from_json(&system, &read(&self.inputs)?).map_err(|error| Failure::wrong(&place, error))?;
        Ok(Known { scene, system, inputs, settings: self.motion.settings(), place })
    }

    /// Computes the motion, and writes a result of it; if a step has no solution, only if `is_partial`.
    pub fn run(
        &self,
        known: &Known,
        is_partial: bool,
        result: impl Fn(&System, &mut Solver) -> Result<String, Error>,
    ) -> Result<(), Failure> {
        let mut solver = Solver::new(&known.system, known.settings);
        let simulated = solver.simulate(&known.inputs).map(drop).map_err(|error| known.failure(error));
        let has_result = simulated.is_ok() || (is_partial && solver.trajectory().computed > 0);
        let text = has_result.then(|| result(&known.system, &mut solver)).transpose();
        known.warn(solver.report().warnings.iter().chain(&solver.adjoint_report().warnings));
        text.map_err(|error| known.failure(error))?.map_or(Ok(()), |text| self.output.write(&text))?;
        simulated
    }
}

impl Known {
    /// The failure for an error of a computation; values of settings are wrong arguments.
    pub fn failure(&self, error: Error) -> Failure {
        let is_wrong = matches!(error, Error::Parameter { .. });
        if is_wrong { Failure::wrong(&self.place, error) } else { Failure::failed(&self.place, error) }
    }

    /// Prints warnings.
    pub fn warn<'w>(&self, warnings: impl IntoIterator<Item = &'w Warning>) {
        warnings.into_iter().for_each(|warning| say(&format!("warning: {}: {warning}", self.place)));
    }
}

/// The names and sizes of a scene.
pub fn describe(path: &Path, output: &Output) -> Result<(), Failure> {
    output.check()?;
    let wrong = |error| Failure::wrong(name(path), error);
    let SceneFile { scene, left_out } = SceneFile::from_json(&read(path)?).map_err(wrong)?;
    let system = scene.compile().map_err(wrong)?;
    let list = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>();
    let names = [
        ("coordinates", list(system.n(), &|i| system.coordinate_name(i).into())),
        ("constraints", list(system.m(), &|j| system.equation_name(j).into())),
        ("controls", list(system.k(), &|k| system.control_name(k).into())),
        ("design", list(system.designs(), &|p| system.design_name(p).into())),
        ("outputs", list(system.outputs(), &|k| system.output_name(k).into())),
        ("events", list(system.events(), &|i| system.event_name(i).into())),
    ];
    let without: Map<_, _> = system.without_programs().map(|(name, why)| (name.into(), why.into())).collect();
    let description = json!({
        "format": "hamiltonian-adjoint description",
        "version": 1,
        "sizes": names.iter().map(|(what, names)| (what.to_string(), names.len().into())).collect::<Map<_, _>>(),
        "names": names.into_iter().map(|(what, names)| (what.to_string(), json!(names))).collect::<Map<_, _>>(),
        "has_cost": system.has_cost(),
        "without_programs": without,
        "left_out": left_out,
        "warnings": warnings_at_rest(&system),
    });
    output.write(&format!("{description:#}"))
}

/// Warnings of a motion without steps, or the reason why the scene cannot be at rest at its positions.
fn warnings_at_rest(system: &System) -> Vec<String> {
    let mut solver = Solver::new(system, Settings::default());
    match solver.simulate(&Inputs::at_rest(system, Grid::uniform(0, 1.0))) {
        // A cost at a node needs more steps.
        Ok(_) | Err(Error::Parameter { .. }) => solver.report().warnings.iter().map(ToString::to_string).collect(),
        Err(error) => vec![error.to_string()],
    }
}

/// Options of inputs at rest.
#[derive(Args)]
pub struct AtRest {
    /// File of the scene; `-` for standard input
    scene: PathBuf,
    /// Number of time steps
    #[arg(long, value_name = "N")]
    steps: usize,
    /// Length of a step, s
    #[arg(long, value_name = "DT", allow_negative_numbers = true)]
    dt: f64,
    /// CSV file with the time in the first column and a column for each control; linear between its rows [default: zero]
    #[arg(long, value_name = "FILE")]
    controls: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

/// Inputs at rest, with the controls of a table.
pub fn at_rest(AtRest { scene: path, steps, dt, controls, output }: &AtRest) -> Result<(), Failure> {
    output.check()?;
    let (_, system) = scene(path)?;
    // Each number has a line of the file.
    let most = MOST_BYTES / (32 * (1 + system.k()));
    if *steps > most {
        return Err(Failure::wrong(format!("--steps {steps}"), format!("at most {most} with {} controls", system.k())));
    }
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(*steps, *dt));
    if let Some(file) = controls {
        let wrong = |error| Failure::wrong(name(file), error);
        let table = Table::from_csv(&read(file)?).map_err(wrong)?;
        for k in 0..system.k() {
            let column = table.column(system.control_name(k)).map_err(wrong)?;
            inputs.set_control(system.control(k), |t| table.value(column, t));
        }
    }
    output.write(&inputs.to_json(&system).map_err(|error| Failure::wrong(format!("--steps {steps} --dt {dt:?}"), error))?)
}

/// The inputs on an adaptive grid.
pub fn adapt(task: &Task, within: f64) -> Result<(), Failure> {
    let known = task.read()?;
    let mut solver = Solver::new(&known.system, known.settings);
    let adapted = solver.adapt(&known.inputs, within);
    known.warn(&solver.report().warnings);
    let text = adapted.and_then(|inputs| inputs.to_json(&known.system));
    task.output.write(&text.map_err(|error| known.failure(error))?)
}

/// The outputs and their gradients, by name.
pub fn jacobian(system: &System, solver: &mut Solver) -> Result<String, Error> {
    let gradients = solver.jacobian()?;
    let named =
        gradients.iter().enumerate().map(|(k, of)| Ok(format!("{}: {}", json!(system.output_name(k)), of.to_json(system)?)));
    let outputs = named.collect::<Result<Vec<_>, Error>>()?.join(",\n");
    Ok(format!("{{\"format\": \"hamiltonian-adjoint jacobian\", \"version\": 1, \"outputs\": {{\n{outputs}\n}}}}"))
}

/// The product of the Hessian of J with the direction in a file.
pub fn hessian_product(task: &Task, along: &Path) -> Result<(), Failure> {
    let known = task.read()?;
    let direction = known.inputs.direction_from_json(&known.system, &read(along)?);
    let direction = direction.map_err(|error| Failure::wrong(name(along), error))?;
    task.run(&known, false, |system, solver| solver.hessian_product(&direction)?.to_json(system))
}
