//! Grids by tolerance: their steps and errors, compared with those of uniform grids.

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Error, Grid, Inputs, Scheme, Settings, Solver, System};
use serde::Serialize;

use super::reference::{END, FORCE};
use crate::resolved::{self, Exact};

/// One grid by tolerance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Tolerance {
    pub motion: &'static str,
    pub scheme: &'static str,
    pub tolerance: f64,
    /// Steps of the grid.
    pub steps: usize,
    /// The largest error of a coordinate at any node, in m, rad or relative to coordinates that are larger.
    pub error: f64,
    /// Steps of the uniform grid with that error.
    pub uniform: usize,
}

type Motion = fn() -> Result<(System, Inputs), Error>;

const MOTIONS: [(&str, Motion); 3] = [
    ("slider-crank of SUNDIALS", resolved::slider_crank),
    ("stick-slip", resolved::stick_slip),
    ("cart with 3 links", cart),
];

pub fn measure(short: bool) -> Result<Vec<Tolerance>, Error> {
    let tolerances: &[f64] = if short { &[1e-5] } else { &[1e-3, 1e-5, 1e-7] };
    let mut rows = Vec::new();
    for (motion, build) in MOTIONS {
        let (system, inputs) = build()?;
        let exact = Exact::new(&system, &inputs)?;
        for (scheme, &tolerance) in Scheme::ALL.iter().flat_map(|scheme| tolerances.iter().map(move |t| (scheme, t))) {
            let mut solver = Solver::new(&system, Settings { scheme: *scheme, ..Settings::default() });
            let adapted = solver.adapt(&inputs, tolerance)?;
            let error = exact.error(solver.simulate(&adapted)?);
            let uniform = exact.steps_of_uniform(&mut solver, &inputs, error);
            rows.push(Tolerance { motion, scheme: scheme.name, tolerance, steps: adapted.grid.steps.len(), error, uniform });
        }
    }
    Ok(rows)
}

impl Tolerance {
    /// A row of the table.
    pub fn cells(&self) -> Vec<String> {
        let Tolerance { motion, scheme, tolerance, steps, error, uniform } = self;
        let (tolerance, error) = (format!("{tolerance:.0e}"), format!("{error:.1e}"));
        vec![motion.to_string(), scheme.to_string(), tolerance, steps.to_string(), error, uniform.to_string()]
    }
}

/// The example under the constant force at which its optimisation starts.
fn cart() -> Result<(System, Inputs), Error> {
    let system = CartPendulum::default().scene().compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, END));
    inputs.controls.fill(FORCE);
    Ok((system, inputs))
}
