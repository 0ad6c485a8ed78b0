//! A restart in the backward sweep: from dJ/dq and dJ/dp* of the restarted motion to dJ/dq⁻ and dJ/dv⁻ of the step before.

use super::super::Backward;
use super::is_rounding;
use crate::linear::Breakdown;
use crate::motion::Restart;
use crate::node::MOST_CORRECTIONS_OF_PROJECTION;
use crate::number::add;
use crate::system::{Covector, InputRows, NodeView, Pair};

/// Adjoint of p* = 𝓛_v(q, v⁻, s) with s = α σ⁻ + β σ₋.
pub(super) fn momentum(restart: &Restart, of: &mut Backward) {
    let Backward {
        system, motion, happened, linearisation, report, after, end, earlier, u, design, time, zeros, rows, ..
    } = of;
    let numbers = restart.numbers(happened).momentum;
    let with = Covector { c: &after.p_star, d: &zeros.v, e: &zeros.sigma };
    linearisation.evaluation.pull_back(system, numbers.blocks, &with, rows);
    end.v.copy_from_slice(&rows.v);
    add(&mut end.q, &rows.q);
    earlier.node = Some(restart.before);
    let of_s = rows.sigma.iter().zip(&after.sigma).map(|(row, after)| row + after);
    let [now, before] = restart.weights;
    for (of_s, (end, earlier)) in of_s.zip(end.sigma.iter_mut().zip(&mut earlier.rows)) {
        *end = now * of_s;
        *earlier = before * of_s;
    }
    let at = NodeView { v: happened.end.v, sigma: numbers.sigma, ..motion.at(happened.node) };
    let mut inputs = InputRows { u, design, time, evaluations: &mut report.input_evaluations };
    linearisation.evaluation.pull_back_inputs(system, &at, &with, &mut inputs);
}

/// Adjoint of 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0 with q = q⁻ + w, if there was a projection; `less` is subtracted from the right-hand side. The adjoint
/// variables c and e are stored in `own`.
pub(super) fn projection(restart: &Restart, of: &mut Backward, less: Option<&Pair>) -> Result<(), Breakdown> {
    let Some(numbers) = restart.numbers(&of.happened).projection else { return Ok(()) };
    let compliances = of.motion.compliance_of_projection(of.system, of.happened.node);
    of.linearisation.evaluation.set_compliance(&compliances);
    of.rows.q.fill(0.0);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_CORRECTIONS_OF_PROJECTION {
        let Backward { system, linearisation, report, end, own, zeros, rows, right, spare, .. } = of;
        // c of the previous iterate, for the size of the change.
        spare.copy_from_slice(&own.v);
        let positions = system.positions();
        let terms = end.q.iter().zip(&rows.q);
        positions.v.iter().zip(terms).for_each(|(&position, (j_q, row))| right[position] = -(j_q + row));
        positions.sigma.iter().for_each(|&position| right[position] = 0.0);
        if let Some(less) = less {
            positions.v.iter().zip(&less.v).for_each(|(&position, less)| right[position] -= less);
            positions.sigma.iter().zip(&less.sigma).for_each(|(&position, less)| right[position] -= less);
        }
        linearisation.factor_and_solve_transposed(system, 0.0, numbers.blocks, right, report)?;
        own.v.iter_mut().zip(&positions.v).for_each(|(c, &position)| *c = right[position]);
        own.sigma.iter_mut().zip(&positions.sigma).for_each(|(e, &position)| *e = right[position]);
        let with = Covector { c: &own.v, d: &zeros.v, e: &zeros.sigma };
        linearisation.evaluation.pull_back(system, numbers.blocks, &with, rows);
        spare.iter_mut().zip(&own.v).for_each(|(change, c)| *change -= c);
        let change = linearisation.size_of(spare);
        if is_rounding(change, last, linearisation.size_of(&own.v)) {
            break;
        }
        last = change;
    }
    add_inputs_of_projection(of, numbers.sigma);
    Ok(())
}

/// Writes dJ/dq⁻ = −𝓛_vvᵀ c, and adds the derivatives with respect to the inputs.
fn add_inputs_of_projection(of: &mut Backward, nu: &[f64]) {
    let Backward {
        system, motion, happened, linearisation, report, end, u, design, time, own, zeros, rows, spare: w, ..
    } = of;
    end.q.iter_mut().zip(&rows.v).for_each(|(q, row)| *q = -row);
    super::set_displacement(motion, happened, w);
    let at = NodeView { v: w, sigma: nu, ..motion.at(happened.node) };
    let with = Covector { c: &own.v, d: &zeros.v, e: &zeros.sigma };
    let mut inputs = InputRows { u, design, time, evaluations: &mut report.input_evaluations };
    linearisation.evaluation.pull_back_inputs(system, &at, &with, &mut inputs);
    system.placed().for_each(|item| item.pull_back_phi(&at, &own.sigma, &mut inputs));
}
