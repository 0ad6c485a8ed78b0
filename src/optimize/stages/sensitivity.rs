//! Derivatives of a minimum by quantities of its problem: with the gradient g by y, the residuals r and the KKT matrix K of the last Newton step,
//!
//! ```text
//!   K (dy/dp, dw/dp) = −(∂g/∂p, ∂r/∂p)
//! ```
//!
//! A moved bound changes the distances of the barrier; a moved target changes a residual; a variable with equal bounds changes everything that it affects.

use nalgebra::DMatrix;

use super::super::multiple_shooting::MultipleShooting;
use super::super::{Options, Reason, silent};
use super::Nearby;
use super::method::Method;
use super::newton::{Newton, Step};
use super::problem::{Multipliers, Residuals};
use super::run::Run;
use super::shooting::Segments;
use crate::Error;

/// A change of a problem.
#[derive(Clone, Copy)]
pub(in super::super) enum Change {
    /// The interval of an output moves.
    Output(usize),
    /// The bounds of a variable move.
    Variable(usize),
}

/// The derivatives of the variables and of f.
pub(in super::super) struct Derivative {
    pub x: Vec<f64>,
    pub value: f64,
}

/// Where a change acts.
enum Place {
    Row {
        stage: usize,
        row: usize,
    },
    Variable {
        stage: usize,
        at: usize,
    },
    /// The output is not constrained.
    Nowhere,
}

/// The derivatives of the minimum near a start.
///
/// # Errors
/// A start that is not near a minimum, or a minimum at which second-order conditions do not hold; problems without Hessian products.
pub(in super::super) fn derivatives(
    problem: &mut MultipleShooting,
    (start, near): (&[f64], &Nearby),
    changes: &[Change],
    options: &Options,
) -> Result<Vec<Derivative>, Error> {
    options.fit(problem, start)?;
    let mut segments = Segments::new(problem);
    let mut v = segments.point(start);
    segments.with_sums(&mut v)?;
    let begin = segments.begin(Some(near), options);
    let places: Vec<Place> = changes.iter().map(|change| segments.place(*change)).collect();
    let mut method = Method::new(&mut segments, &v, &begin)?;
    let mut watch = silent;
    let mut run = Run::new(options, &mut watch);
    let reason = run.along_lines(&mut method, true)?;
    if reason != Reason::Stationary {
        let last = run.history.last().map_or(String::new(), |last| {
            format!(" (stationarity {:.1e}, violation {:.1e})", last.stationarity, last.violation)
        });
        return Err(run.first_failure.unwrap_or(Error::NoMinimum { why: format!("{reason}{last}") }));
    }
    let hessians = method.problem.hessians(method.scale, &method.multipliers)?;
    let kkt = method.kkt_of(hessians.clone(), method.barrier.curvature(&method.y));
    let newton = kkt.factors().ok_or_else(|| Error::NoMinimum {
        why: "its Hessian is not positive definite along the constraints, so it is not unique".into(),
    })?;
    Ok(places.iter().map(|place| derivative(&method, &newton, &hessians, place)).collect())
}

fn derivative(method: &Method<'_>, newton: &Newton<'_>, hessians: &[DMatrix<f64>], place: &Place) -> Derivative {
    let mut gradient = vec![0.0; method.y.len()];
    let mut residuals = Residuals::of(Multipliers::zeros(method.problem.shape()));
    let curvature = method.barrier.curvature(&method.y);
    let mut held = None;
    match *place {
        Place::Row { stage, row } => match method.inequalities.iter().position(|at| (at.stage, at.row) == (stage, row)) {
            Some(i) => gradient[method.slack(i)] = -curvature[method.slack(i)],
            None => residuals.rows[stage][row] = -1.0,
        },
        Place::Variable { stage, at } if method.is_held(stage, at) => {
            held = Some(method.first[stage] + at);
            let here = gradient[method.first[stage]..].iter_mut();
            here.zip(hessians[stage].column(at).iter()).for_each(|(g, h)| *g = *h);
            residuals.rows[stage] = method.linear[stage].rows.column(at).into_owned();
            if let Some(defect) = residuals.defects.get_mut(stage) {
                *defect = method.linear[stage].dynamics.column(at).into_owned();
            }
        }
        Place::Variable { stage, at } => {
            let at = method.first[stage] + at;
            gradient[at] = -curvature[at];
        }
        Place::Nowhere => {}
    }
    let Step { mut y, .. } = newton.solve(method, &gradient, &residuals);
    if let Some(at) = held {
        y[at] = 1.0;
    }
    let v = method.v(&y);
    let value = v.iter().zip(&method.linear).map(|(v, of)| v.dot(&of.gradient)).sum();
    Derivative { x: method.problem.x(&v), value }
}

impl Segments<'_> {
    fn place(&self, change: Change) -> Place {
        let found = match change {
            Change::Output(output) => self.at.row(output).map(|(stage, row)| Place::Row { stage, row }),
            // The first stage that contains a variable; those after it contain copies.
            Change::Variable(variable) => {
                self.of.segments.iter().zip(&self.at.places).enumerate().find_map(|(stage, (segment, places))| {
                    let i = segment.places.iter().position(|at| *at == variable)?;
                    Some(Place::Variable { stage, at: places[i] })
                })
            }
        };
        found.unwrap_or(Place::Nowhere)
    }
}
