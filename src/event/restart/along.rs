//! Second derivatives of a restart: its equations along a direction, and those of its adjoint.
//!
//! ```text
//!   (𝓛_vv + 𝓛_vq) ẇ + Φ_qᵀ ν̇ = −D 𝓛_v,   Φ_q ẇ = −D Φ     D along q̇⁻ and the inputs, at (q, w, ν);     q̇ = q̇⁻ + ẇ
//!   ṗ* = D 𝓛_v(q, v⁻, s)                                   D along q̇, v̇⁻, ṡ = α σ̇⁻ + β σ̇₋ and the inputs
//! ```

use super::super::{Along, BackwardAlong, Tools};
use super::{OfPoint, backward, is_rounding, set_displacement};
use crate::linear::Breakdown;
use crate::motion::{Restart, column};
use crate::node::{ALONG, MOST_CORRECTIONS_OF_PROJECTION};
use crate::number::{Real, add};
use crate::system::{Covector, NodeView, Pair};

/// The directions of w, ν, q after the projection, and s, stored one after another for the backward sweep.
struct Change<'a> {
    w: &'a [f64],
    nu: &'a [f64],
    q: &'a [f64],
    s: &'a [f64],
}

impl<'a> Change<'a> {
    fn of(numbers: &'a [f64], n: usize) -> Self {
        let (moved, rest) = numbers.split_at(numbers.len() / 2);
        let ((w, nu), (q, s)) = (moved.split_at(n), rest.split_at(n));
        Change { w, nu, q, s }
    }
}

/// Computes the direction of (q, p̄, s).
pub(super) fn reset(restart: &Restart, mut of: Along) -> Result<(), Breakdown> {
    let (n, m) = (of.system.n(), of.system.m());
    let own = restart.numbers(&of.happened);
    let mut numbers = std::mem::take(of.numbers);
    numbers.clear();
    numbers.resize(2 * (n + m), 0.0);
    let (moved, rest) = numbers.split_at_mut(n + m);
    let (q, s) = rest.split_at_mut(n);
    if let Some(point) = own.projection {
        project(&mut of, point, moved.split_at_mut(n))?;
    }
    let Along { system, motion, happened, linearisation, change, after, tools, .. } = of;
    let end = change.at(happened.node);
    q.iter_mut().zip(end.q.iter().zip(&*moved)).for_each(|(q, (before, w))| *q = before + w);
    let ends = column(&change.trajectory.sigma, restart.before).iter().zip(end.sigma);
    s.iter_mut().zip(ends).for_each(|(s, (before, now))| *s = restart.begin(*before, *now));
    let at = NodeView { v: happened.end.v, sigma: own.momentum.sigma, ..motion.at(happened.node) };
    let along = NodeView { q, v: end.v, sigma: s, ..end };
    tools.programs.changes((system, &linearisation.evaluation), (&at, own.momentum.blocks), &along, tools.sums);
    after.q.copy_from_slice(q);
    after.p_star.copy_from_slice(tools.sums.l_v());
    after.sigma.copy_from_slice(s);
    *of.numbers = numbers;
    Ok(())
}

/// Computes ẇ and ν̇, by corrections with K(0) as the projection itself.
fn project(of: &mut Along, point: OfPoint, (w_dot, nu_dot): (&mut [f64], &mut [f64])) -> Result<(), Breakdown> {
    let Along { system, motion, happened, linearisation, report, change, tools, .. } = of;
    let Tools { programs, phi, sums, right, left, spare: w, zeros, no_controls, .. } = tools;
    let end = change.at(happened.node);
    set_displacement(motion, happened, w);
    let at = NodeView { v: w, sigma: point.sigma, ..motion.at(happened.node) };
    let along = NodeView { q: end.q, v: &zeros.v, sigma: &zeros.sigma, ..end };
    programs.changes((system, &linearisation.evaluation), (&at, point.blocks), &along, sums);
    right.v.iter_mut().zip(sums.l_v()).for_each(|(right, l_v)| *right = -l_v);
    phi.set(&at, &along);
    right.sigma.iter_mut().zip(phi.evaluate(system)).for_each(|(right, phi)| *right = -phi.part(ALONG));

    linearisation.evaluation.set_compliance(&motion.compliance_of_projection(system, happened.node));
    linearisation.factor(system, 0.0, point.blocks, report)?;
    let mut last = f64::INFINITY;
    left.v.copy_from_slice(&right.v);
    left.sigma.copy_from_slice(&right.sigma);
    for _ in 0..MOST_CORRECTIONS_OF_PROJECTION {
        linearisation.solve(system, left);
        add(w_dot, &left.v);
        add(nu_dot, &left.sigma);
        let correction = linearisation.size_of(&left.v);
        if is_rounding(correction, last, linearisation.size_of(w_dot)) {
            break;
        }
        last = correction;
        let of_x = NodeView::of_equations([&*w_dot, &*w_dot, &*nu_dot], (*no_controls, 0.0, &[]));
        linearisation.evaluation.push_forward(system, point.blocks, &of_x, sums);
        left.v.copy_from_slice(sums.l_v());
        // Φ_q w is the change of dΦ/dt with v along w.
        let of_w = NodeView::of_equations([&zeros.v, &*w_dot, &zeros.sigma], (*no_controls, 0.0, &[]));
        linearisation.evaluation.push_forward(system, point.blocks, &of_w, sums);
        left.sigma.copy_from_slice(sums.phi_dot());
        linearisation.evaluation.compliance().iter().for_each(|&(j, mu)| left.sigma[j] -= mu * nu_dot[j]);
        left.subtract_from(right);
    }
    Ok(())
}

/// Adjoint equations of a restart, along a direction.
pub(super) fn backward(restart: &Restart, mut of: BackwardAlong) -> Result<(), Breakdown> {
    momentum_back(restart, &mut of);
    projection_back(restart, &mut of)
}

/// Adjoint of p* = 𝓛_v(q, v⁻, s).
fn momentum_back(restart: &Restart, along: &mut BackwardAlong) {
    backward::momentum(restart, &mut along.of);
    let (happened, numbers) = (along.of.happened, restart.numbers(&along.of.happened).momentum);
    let change = Change::of(along.numbers, happened.end.q.len());
    let direction = along.direction([change.q, along.end.v, change.s]);
    let BackwardAlong { of, first, tools, .. } = &mut *along;
    let Tools { programs, rows, right, zeros, .. } = tools;
    right.v.iter_mut().zip(&first.b).for_each(|(pi, b)| *pi = -b);
    let at = NodeView { v: happened.end.v, sigma: numbers.sigma, ..of.motion.at(happened.node) };
    let with = Covector { c: &right.v, d: &zeros.v, e: &zeros.sigma };
    programs.rows_along((of.system, &of.linearisation.evaluation), (&at, numbers.blocks), &direction, &with, rows);
    add(&mut of.end.q, &rows.q);
    add(&mut of.end.v, &rows.v);
    let [now, before] = restart.weights;
    add_multiple(&mut of.end.sigma, now, &rows.sigma);
    add_multiple(&mut of.earlier.rows, before, &rows.sigma);
    along.add_inputs();
}

/// Adjoint of 𝓛_v(q, w, ν) = 0 and Φ(q, t) = 0, if there was a projection.
fn projection_back(restart: &Restart, along: &mut BackwardAlong) -> Result<(), Breakdown> {
    let happened = along.of.happened;
    let Some(numbers) = restart.numbers(&happened).projection else { return Ok(()) };
    let here = along.of.motion.at(happened.node);
    let change = Change::of(along.numbers, happened.end.q.len());
    let direction = along.direction([change.q, change.w, change.nu]);
    let BackwardAlong { of, first_own: Pair { v: c, sigma: e }, tools, .. } = &mut *along;
    let Tools { programs, phi, rows, left: less, spare: w, zeros, .. } = tools;
    set_displacement(of.motion, &happened, w);
    let at = NodeView { v: w, sigma: numbers.sigma, ..here };
    let of_e = Covector { c: &zeros.v, d: &zeros.v, e };
    programs.rows_along((of.system, &of.linearisation.evaluation), (&at, numbers.blocks), &direction, &of_e, rows);
    less.v.copy_from_slice(&rows.v);
    let of_c = Covector { c, d: &zeros.v, e: &zeros.sigma };
    programs.rows_along((of.system, &of.linearisation.evaluation), (&at, numbers.blocks), &direction, &of_c, rows);
    add(&mut less.v, &rows.v);
    add(&mut less.v, &rows.q);
    less.sigma.copy_from_slice(&rows.sigma);
    backward::projection(restart, of, Some(less))?;
    add_multiple(&mut of.end.q, -1.0, &rows.v);
    phi.set(&here, &direction);
    phi.add_change(of.system, (e, 1.0), (of.design, of.time));
    along.add_inputs();
    Ok(())
}

fn add_multiple(sum: &mut [f64], factor: f64, x: &[f64]) {
    sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
}
