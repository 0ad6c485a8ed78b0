//! [`Subject`]: the function whose derivatives are checked.

use super::watch::Watch;
use crate::{Error, Gradient, Inputs, LiftedSolver, Output, Real, Settings, Solver, System};

/// The function whose derivatives are checked: J, or an output, of a motion.
#[derive(Clone)]
pub(super) struct Subject<'a> {
    pub system: &'a System,
    pub inputs: &'a Inputs,
    pub settings: Settings,
    /// J (0) or an output (from 1 on).
    pub which: usize,
    pub watch: Watch,
}

impl<'a> Subject<'a> {
    /// Same subject for an output instead of J; an output of another scene gets an index that is out of range.
    pub(super) fn of(self, output: Output) -> Self {
        let beyond = if self.system.owns(output.0) { 0 } else { self.system.outputs() };
        Subject { which: 1 + output.index() + beyond, ..self }
    }

    /// Name of the function in reports.
    ///
    /// # Errors
    /// An output of another scene.
    pub(super) fn name(&self) -> Result<String, Error> {
        match self.which {
            0 => Ok("J".into()),
            k if k <= self.system.outputs() => Ok(format!("output `{}`", self.system.output_name(k - 1))),
            k => Err(Error::Parameter {
                what: "the number of the output".into(),
                value: (k - 1 - self.system.outputs()) as f64,
                must_be: "that of an output of this system's scene",
            }),
        }
    }

    /// A solver with these settings that the check watches.
    pub(super) fn solver(&self, settings: Settings) -> Solver {
        self.watch.over(Solver::new(self.system, settings))
    }

    pub(super) fn solved(&self) -> Result<(Solver, Gradient), Error> {
        let mut solver = self.solver(self.settings);
        solver.simulate(self.inputs)?;
        let gradient = solver.gradient_of(self.which)?.clone();
        Ok((solver, gradient))
    }

    pub(super) fn lifted<R: Real>(&self) -> Result<LiftedSolver<R>, Error> {
        LiftedSolver::near(self.solver(self.settings), self.inputs)
    }
}

/// Warnings of a motion and its gradient, as text.
pub(super) fn warnings_of(solver: &Solver) -> Vec<String> {
    let reports = [solver.report(), solver.adjoint_report()];
    reports.iter().flat_map(|report| &report.warnings).map(ToString::to_string).collect()
}
