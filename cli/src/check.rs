//! `check`: gradients of J and of the outputs, and products of the Hessian of J, against independent references.

use clap::Args;
use hamiltonian_adjoint::check::{self, GradientCheck, GradientReport, Part, Verdict};
use hamiltonian_adjoint::{Error, Solver};
use serde_json::json;

use crate::Failure;
use crate::commands::{Known, Task};
use crate::files::say;

#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    task: Task,
    /// Also compares every single input, with three or more simulations for each
    #[arg(long)]
    complete: bool,
    /// Seed of the random directions
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Largest error of a derivative, relative to the size of its terms
    #[arg(long, default_value = "1e-9", value_name = "X")]
    within: f64,
}

/// Writes the reports as JSON, and as text to standard error.
pub fn run(options: &Check) -> Result<(), Failure> {
    let known = options.task.read()?;
    let failure = |error| known.failure(error);
    let outputs = (0..known.system.outputs()).filter_map(|k| known.scene.output_named(known.system.output_name(k)));
    let mut gradients = Vec::new();
    let mut product = None;
    if known.system.has_cost() {
        gradients.push(options.of_cost(&known).map_err(failure)?);
        let check = check::hessian(&known.system, &known.inputs, known.settings).seed(options.seed);
        product = Some(check.tolerance(options.within).run().map_err(failure)?);
    }
    for output in outputs {
        gradients.push(options.gradient(&known).output(output).run().map_err(failure)?);
    }
    gradients.iter().for_each(|report| say(&report.to_string()));
    product.iter().for_each(|report| say(&report.to_string()));
    let passed = !gradients.is_empty() && gradients.iter().all(passes) && product.iter().all(|of| of.passed());
    let report = json!({ "format": "hamiltonian-adjoint check", "version": 1, "passed": passed, "gradients": gradients, "hessian": product });
    options.task.output.write(&format!("{report:#}"))?;
    if passed { Ok(()) } else { Err(Failure::failed(&known.place, "a derivative is wrong or could not be compared")) }
}

/// True if the gradient is right, and the one without programs wherever a derivative is larger than its rounding error.
fn passes(report: &GradientReport) -> bool {
    let is_right = |verdict| matches!(verdict, Verdict::Right | Verdict::NothingCompared);
    report.own.iter().all(|of| is_right(of.verdict)) && GradientReport { own: Vec::new(), ..report.clone() }.passed()
}

impl Check {
    fn gradient<'k>(&self, known: &'k Known) -> GradientCheck<'k> {
        let check = check::gradient(&known.system, &known.inputs, known.settings);
        let check = check.directions(1, self.seed).tolerance(self.within);
        if self.complete { check.complete() } else { check }
    }

    /// The check of J, also against the gradient without programs, whose formulas dual numbers differentiate at every point.
    fn of_cost(&self, known: &Known) -> Result<GradientReport, Error> {
        let plain = known.scene.clone().compile_without_programs()?;
        let mut solver = Solver::new(&plain, known.settings);
        solver.simulate(&known.inputs)?;
        let of = solver.gradient()?;
        let parts = [
            (Part::Controls, of.controls.as_slice()),
            (Part::Design, of.design.as_slice()),
            (Part::Coordinates, of.start.q().as_slice()),
            (Part::Rates, of.start.rate().as_slice()),
            (Part::Steps, &of.steps[..]),
        ];
        let all = parts.into_iter().filter(|(_, values)| !values.is_empty());
        let check = all
            .fold(self.gradient(known), |check, (part, values)| check.own("without programs", part, values.iter().copied()));
        check.run()
    }
}
