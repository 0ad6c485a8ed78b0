//! A minimum on a grid on which the steps with the largest errors are halved: the same problem with more controls, and what is known of its minimum.

use nalgebra::DMatrix;

use super::super::free::{Free, Quantity};
use super::super::{MotionProblem, Variables};
use super::attempt::Known;
use super::guess::Line;
use super::reach::Reach;
use crate::motion::Refinement;
use crate::scheme::local_error;
use crate::{Sum, System};

/// The errors of all steps that are not halved are together at most this fraction of those of all steps: halves have about this fraction of the errors by
/// a scheme of order 4.
const KEPT: f64 = 1.0 / 16.0;
/// Momenta below this fraction of the largest one are rounding.
const ROUNDING: f64 = 1e-9;

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
        let halving = Halving::new(problem, &grid.steps);
        let (steps, inserted) = (halving.steps(), halving.inserted());
        let finer = Refinement::new((&steps, &[]), grid.around, &inserted).refine(&inputs);
        let variables = Variables::new(system, &finer, problem.free().free().to_vec()).ok()?;
        let refined = |at: &[f64], of: &dyn Fn(&[f64]) -> Vec<f64>| -> Vec<f64> {
            let parts = problem.free().parts();
            parts.flat_map(|(free, range)| if is_at_nodes(free) { of(&at[range]) } else { at[range].to_vec() }).collect()
        };
        let x = refined(&problem.start(), &|of| halving.between(&row(of)).as_slice().to_vec());
        let problem_there = problem.statement().with(finer, variables).and_then(|there| there.started_at(&x)).ok()?;
        let Line { coordinates, q, v, .. } = &known.line;
        let (q, v) = (halving.between(q), halving.between(v));
        let line = Line { coordinates: coordinates.clone(), q, v, reach: Reach::Found };
        let mut near = known.near.clone();
        near.slopes = refined(&near.slopes, &|of| halving.slopes(of));
        Some(Halved { problem: problem_there, known: Known { line, near, segments: known.segments } })
    }
}

/// Steps of a grid, and which of them are halved.
struct Halving<'g> {
    given: &'g [f64],
    is_halved: Vec<bool>,
}

impl<'g> Halving<'g> {
    /// The steps with the largest errors in the last motion of a problem; all of them if its scheme does not estimate errors.
    fn new(problem: &MotionProblem, given: &'g [f64]) -> Self {
        let errors = errors(problem, given).filter(|errors| errors.iter().sum::<f64>() > 0.0);
        let Some(errors) = errors else { return Halving { given, is_halved: vec![true; given.len()] } };
        let (mut order, total): (Vec<usize>, f64) = ((0..given.len()).collect(), errors.iter().sum());
        order.sort_by(|&i, &j| errors[i].total_cmp(&errors[j]));
        let (mut is_halved, mut kept) = (vec![false; given.len()], 0.0);
        for step in order {
            kept += errors[step];
            is_halved[step] = kept > KEPT * total;
        }
        Halving { given, is_halved }
    }

    fn steps(&self) -> Vec<f64> {
        let parts = |(step, is_halved): (&f64, &bool)| if *is_halved { vec![0.5 * step; 2] } else { vec![*step] };
        self.given.iter().zip(&self.is_halved).flat_map(parts).collect()
    }

    /// For each node of the new grid, the given node, or the middle of the given step that ends there.
    fn nodes(&self) -> impl Iterator<Item = (usize, bool)> + '_ {
        let of_step = |step: usize| self.is_halved[step].then_some((step + 1, true)).into_iter().chain([(step + 1, false)]);
        std::iter::once((0, false)).chain((0..self.given.len()).flat_map(of_step))
    }

    /// The nodes of the new grid in the middle of given steps.
    fn inserted(&self) -> Vec<usize> {
        self.nodes().enumerate().filter(|(_, (_, is_middle))| *is_middle).map(|(node, _)| node).collect()
    }

    /// Values at the nodes of the new grid, linear between the given ones.
    fn between(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let columns = self.nodes().map(|(node, is_middle)| match is_middle {
            true => 0.5 * (values.column(node - 1) + values.column(node)),
            false => values.column(node).into_owned(),
        });
        DMatrix::from_columns(&columns.collect::<Vec<_>>())
    }

    /// Derivatives by a control at the nodes of the new grid: they are proportional to the lengths of the steps beside them.
    fn slopes(&self, given: &[f64]) -> Vec<f64> {
        let densities: Vec<f64> = given.iter().zip(lengths(self.given)).map(|(slope, length)| slope / length).collect();
        let densities = self.between(&row(&densities));
        densities.iter().zip(lengths(&self.steps())).map(|(density, length)| density * length).collect()
    }
}

/// The lengths of the steps beside each node together.
fn lengths(steps: &[f64]) -> Vec<f64> {
    let length = |step: Option<usize>| step.and_then(|step| steps.get(step)).unwrap_or(&0.0);
    (0..=steps.len()).map(|node| length(node.checked_sub(1)) + length(Some(node))).collect()
}

/// The estimated errors of the steps of the last motion, relative to coordinates of at least 1 m or rad and to the largest momenta; `None` if there are no
/// estimates of a single step.
fn errors(problem: &MotionProblem, steps: &[f64]) -> Option<Vec<f64>> {
    let motion = problem.solver.trajectory();
    if motion.scheme.embedded.is_empty() || motion.times.len() != steps.len() + 1 {
        return None;
    }
    let least = (ROUNDING * motion.p_star.amax()).max(f64::MIN_POSITIVE);
    let momenta: Vec<f64> = motion.p_star.row_iter().map(|row| row.amax().max(least)).collect();
    let mut delta = vec![0.0; momenta.len()];
    let mut error = |(step, dt): (usize, &f64)| {
        let node = step + 1;
        local_error(&motion.scheme, *dt, |s| motion.rates(node, s).0, None, &mut delta);
        let of_q = (0..delta.len()).map(|i| delta[i].abs() / motion.q[(i, node)].abs().max(1.0)).fold(0.0, f64::max);
        local_error(&motion.scheme, *dt, |s| motion.rates(node, s).1, None, &mut delta);
        of_q + delta.iter().zip(&momenta).map(|(error, p)| error.abs() / p).fold(0.0, f64::max)
    };
    Some(steps.iter().enumerate().map(&mut error).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_inserted_in_halved_steps_alone() {
        let halving = Halving { given: &[0.2, 0.4, 0.1], is_halved: vec![true, false, true] };
        assert_eq!(halving.steps(), [0.1, 0.1, 0.4, 0.05, 0.05]);
        assert_eq!(halving.inserted(), [1, 4]);
        assert_eq!(halving.between(&row(&[1.0, 3.0, 5.0, 9.0])).as_slice(), [1.0, 2.0, 3.0, 5.0, 7.0, 9.0]);
        // Of a control that adds 2 per second everywhere.
        let slopes = halving.slopes(&[0.2, 0.6, 0.5, 0.1]);
        let expected = [0.1, 0.2, 0.5, 0.45, 0.1, 0.05];
        slopes.iter().zip(expected).for_each(|(x, of)| assert!((x - of).abs() < 1e-15, "{slopes:?}"));
    }
}
