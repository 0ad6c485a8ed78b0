//! A minimum on a grid with all steps halved: the same problem with more controls, and what is known of its minimum.

use nalgebra::DMatrix;

use super::super::free::{Free, Quantity};
use super::super::{MotionProblem, Variables};
use super::attempt::Known;
use super::guess::Line;
use super::reach::Reach;
use crate::motion::Refinement;
use crate::{Sum, System};

/// A problem on a grid with halved steps, at the same controls as functions of time, and the minimum on the given grid as it appears there.
pub(super) struct Halved {
    pub(super) problem: MotionProblem,
    pub(super) known: Known,
}

impl Halved {
    /// `None` if the problem has quantities that belong to single nodes or steps, or steps that have no middle.
    pub(super) fn new(problem: &MotionProblem, known: &Known) -> Option<Self> {
        let (system, inputs) = (problem.solver.system(), problem.inputs_at(&problem.start()));
        let grid = &inputs.grid;
        let is_divisible = grid.stages == 1 && inputs.events.is_empty() && grid.steps.iter().all(|step| *step != 0.0);
        // Between pieces, a control changes within one step: with halved steps it would be another function of time.
        let is_of_step = |of: &Free| matches!(of.quantity, Quantity::StepLength(_) | Quantity::PiecewiseControl(..));
        if !is_divisible || belongs_to_nodes(system) || problem.free().free().iter().any(is_of_step) {
            return None;
        }
        let steps: Vec<f64> = grid.steps.iter().flat_map(|step| [0.5 * step; 2]).collect();
        let inserted: Vec<usize> = (0..grid.steps.len()).map(|step| 2 * step + 1).collect();
        let finer = Refinement::new((&steps, &[]), grid.around, &inserted).refine(&inputs);
        let variables = Variables::new(system, &finer, problem.free().free().to_vec()).ok()?;
        let refined = |at: &[f64], of: fn(&[f64]) -> Vec<f64>| -> Vec<f64> {
            let parts = problem.free().parts();
            parts.flat_map(|(free, range)| if is_at_nodes(free) { of(&at[range]) } else { at[range].to_vec() }).collect()
        };
        let x = refined(&problem.start(), |of| between(&row(of)).as_slice().to_vec());
        let problem_there = problem.statement().with(finer, variables).and_then(|there| there.started_at(&x)).ok()?;
        let Line { coordinates, q, v, .. } = &known.line;
        let line = Line { coordinates: coordinates.clone(), q: between(q), v: between(v), reach: Reach::Found };
        let mut near = known.near.clone();
        // Derivatives by a control at a node are proportional to the lengths of the steps beside it.
        near.slopes = refined(&near.slopes, |of| (0.5 * between(&row(of))).as_slice().to_vec());
        Some(Halved { problem: problem_there, known: Known { line, near, segments: known.segments } })
    }
}

/// True for quantities with a variable for each node.
fn is_at_nodes(free: &Free) -> bool {
    matches!(free.quantity, Quantity::Control(_))
}

fn row(of: &[f64]) -> DMatrix<f64> {
    DMatrix::from_row_slice(1, of.len(), of)
}

/// True if J or an output is a sum over nodes, or is evaluated at a node or an event: it would be another one on another grid.
fn belongs_to_nodes(system: &System) -> bool {
    let is_of_nodes = |sum: Sum| !matches!(sum, Sum::Integral | Sum::Terminal | Sum::Trapezoidal | Sum::Rectangle);
    (0..=system.outputs()).any(|which| system.sums(which).any(|(sum, _)| is_of_nodes(sum)))
}

/// Values at the nodes of halved steps, linear between the given ones.
fn between(values: &DMatrix<f64>) -> DMatrix<f64> {
    let nodes = 2 * values.ncols() - 1;
    DMatrix::from_fn(values.nrows(), nodes, |i, k| 0.5 * (values[(i, k / 2)] + values[(i, k.div_ceil(2))]))
}
