//! The consistent start: p*₀ from the given state, then v₀ and σ₀ from Eq. (1a) and (1c), with checks of the start.

use super::given_start;
use crate::error::quoted;
use crate::forward::ForwardSweep;
use crate::motion::{column, column_mut};
use crate::number::all_finite;
use crate::redundancy::{SUSPICIOUS, Scaled, can_be_met, is_singular};
use crate::system::{NodeView, Pair};
use crate::{Error, Settings, Start, System, Warning, redundancy};

/// Solves node 0: with h = 0 the equations of a step are Eq. (1a) and (1c).
pub(crate) fn solve(forward: &mut ForwardSweep, system: &System, settings: &Settings) -> Result<(), Error> {
    let (n, m) = (system.n(), system.m());
    let q = forward.motion.inputs.start.q().as_slice().to_vec();
    let rate = forward.motion.inputs.start.rate().as_slice().to_vec();
    let given_velocity = matches!(forward.motion.inputs.start, Start::Velocity { .. });
    column_mut(&mut forward.motion.trajectory.sigma, 0).fill(0.0);
    let v = column_mut(&mut forward.motion.trajectory.v, 0);
    if given_velocity {
        v.copy_from_slice(&rate);
    } else {
        v.fill(0.0);
    }
    // Momenta at a later node are those of a motion that has drifted, or were found with the coordinates.
    let is_given = forward.motion.assembly.is_none() && (given_velocity || forward.motion.inputs.grid.around[0] == 0);
    if is_given || given_velocity {
        check_position(forward, system, &q, settings)?;
    }
    forward.motion.given_start = if is_given { given_start::find(system, &point(forward, &q)) } else { None };
    let mut p_star = rate;
    if given_velocity {
        let mut left = Pair::new(n, m);
        let (u, design) = (forward.motion.inputs.controls_at(0), forward.motion.design.as_slice());
        let sigma = column(&forward.motion.trajectory.sigma, 0);
        let at = NodeView::of_equations([&q, &p_star, sigma], (u, forward.motion.trajectory.times[0], design));
        forward.stepper.newton.linearisation.l_v_and_phi_dot(system, &at, &mut left, &mut forward.monitor.report);
        forward.motion.start_blocks.clone_from(&forward.stepper.newton.linearisation.evaluation.blocks);
        check_velocity(forward, system, [&q, &p_star], &mut left.sigma, settings)?;
        // σ₀ = 0, so 𝓛_v is T_v.
        p_star = left.v;
    }
    if let Some((what, value)) = p_star.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        let unknown = || Error::Model {
            element: format!("the kinetic energy of `{}`", system.coordinate_name(what)),
            arguments: format!("p* = {value}"),
            node: 0,
            time: forward.motion.trajectory.times[0],
        };
        return Err(system.find_not_finite(&point(forward, &q), 0).unwrap_or_else(unknown));
    }
    forward.stepper.set_start(&q, &p_star, &vec![0.0; m]);
    // A recomputed motion already has pivots from later steps.
    let worst = std::mem::replace(&mut forward.monitor.report.worst_pivot, 1.0);
    check_regular(forward, system, &q)?;
    forward.warn_of_lost_digits(system, 0, worst);
    forward.monitor.report.worst_pivot = worst.min(forward.monitor.report.worst_pivot);
    if forward.stepper.newton.linearisation.has_negative_mass(system) {
        note_negative_mass(forward, system, &q);
    }
    forward.dependent(system).weigh();
    let solved = forward.solve_node(system, 0, 0.0, settings);
    solved.map_err(|failure| forward.explain(system, 0, failure))?;
    // K(0) does not contain derivatives of forces, with which the first step begins.
    if !all_finite(&forward.stepper.newton.linearisation.evaluation.blocks)
        && let Some(error) = system.find_not_finite(&forward.motion.at(0), 0)
    {
        return Err(error);
    }
    forward.check_compliant(system, 0, settings)?;
    forward.motion.trajectory.computed = 1;
    Ok(())
}

fn point<'a>(forward: &'a ForwardSweep, q: &'a [f64]) -> NodeView<'a, f64> {
    NodeView { q, ..forward.motion.at(0) }
}

fn check_position(forward: &ForwardSweep, system: &System, q: &[f64], settings: &Settings) -> Result<(), Error> {
    let (at, tolerance, mut phi) = (point(forward, q), settings.position_tolerance, vec![0.0; system.m()]);
    system.phi(&at, &mut phi);
    forward.motion.open_from(0).for_each(|j| phi[j] = 0.0);
    let Some((j, violation)) = worst_but_rounding(system, (&at, q), &mut phi, tolerance) else { return Ok(()) };
    if !violation.is_finite() {
        return Err(system.constraint_not_finite(&point(forward, q), j));
    }
    let clash = Scaled::at(system, &at).and_then(|here| {
        let clash = here.contradiction(system, &phi, at.t)?;
        (!can_be_met(&here, system, &at)).then_some(clash)
    });
    let equation = system.equation_name(j).into();
    Err(clash.unwrap_or(Error::InitialPosition { equation, violation, tolerance }))
}

fn check_velocity(
    forward: &ForwardSweep,
    system: &System,
    [q, v]: [&[f64]; 2],
    phi_dot: &mut [f64],
    settings: &Settings,
) -> Result<(), Error> {
    let (at, tolerance) = (point(forward, q), settings.velocity_tolerance);
    forward.motion.open_from(0).for_each(|j| phi_dot[j] = 0.0);
    let Some((j, violation)) = worst_but_rounding(system, (&at, v), phi_dot, tolerance) else { return Ok(()) };
    if !violation.is_finite() {
        return Err(system.constraint_not_finite(&point(forward, q), j));
    }
    // No other velocities satisfy the equations either, since dΦ/dt is linear in v.
    let clash = Scaled::at(system, &at).and_then(|here| here.contradiction(system, phi_dot, at.t));
    let equation = system.equation_name(j).into();
    Err(clash.unwrap_or(Error::InitialVelocity { equation, violation, tolerance }))
}

/// The largest violation beyond the tolerance, without the rounding of large coordinates or velocities.
fn worst_but_rounding(
    system: &System,
    (at, of): (&NodeView<f64>, &[f64]),
    values: &mut [f64],
    tolerance: f64,
) -> Option<(usize, f64)> {
    worst(values, tolerance)?;
    system.take_rounding(at, of, values);
    worst(values, tolerance)
}

/// The largest violation, or NaN, if it is beyond the tolerance.
fn worst(values: &[f64], tolerance: f64) -> Option<(usize, f64)> {
    // In the total order, NaN without its sign is above infinity.
    let worst = values.iter().copied().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    worst.filter(|(_, violation)| violation.is_nan() || violation.abs() > tolerance)
}

/// Factors K(0) = [M Φ_qᵀ; Φ_q 0]; dependent loops get a compliance, other breakdowns are explained.
fn check_regular(forward: &mut ForwardSweep, system: &System, q: &[f64]) -> Result<(), Error> {
    if forward.dependent(system).relax_again(q) {
        return Ok(());
    }
    let result = forward.dependent(system).factor_start();
    if result.is_ok() && forward.monitor.report.worst_pivot > SUSPICIOUS && !system.has_still_loops() {
        return Ok(());
    }
    let time = forward.motion.trajectory.times[0];
    if let Some(error) = system.find_not_finite(&point(forward, q), 0) {
        return Err(error);
    }
    let v = column(&forward.motion.trajectory.v, 0).to_vec();
    let sigma = vec![0.0; system.m()];
    let design = forward.motion.design.clone();
    let u = column(&forward.motion.inputs.controls, 0).to_vec();
    let at = NodeView::of_equations([q, &v, &sigma], (&u, time, &design));
    let scaled = Scaled::at(system, &at);
    if let Some(error) = scaled.as_ref().and_then(|scaled| is_singular(scaled, system, &at)) {
        return Err(error);
    }
    let explained = scaled.as_ref().and_then(|scaled| scaled.explain(system, &at));
    forward.monitor.report.worst_pivot = 1.0;
    // Nearly dependent constraints belong to a nearly singular configuration and are not changed.
    let may_depend = scaled.is_none() || explained.is_some();
    if may_depend && forward.dependent(system).relax(&at, scaled.as_ref()) {
        return Ok(());
    }
    match (explained, result) {
        (Some(error), _) => Err(error),
        (None, Ok(())) => {
            forward.dependent(system).factor_start().map_err(|breakdown| system.singular_step(&breakdown, 0, time))
        }
        (None, Err(breakdown)) => Err(system.singular_step(&breakdown, 0, time)),
    }
}

/// Warns of admissible velocities with negative kinetic energy, by the coordinates with M_ii < 0 if there are any.
#[cold]
fn note_negative_mass(forward: &mut ForwardSweep, system: &System, q: &[f64]) {
    let (masses, at) = (redundancy::masses(&forward.stepper.newton.linearisation, system), point(forward, q));
    let is_negative = |i: &usize| masses[*i] < 0.0;
    let known = Scaled::at(system, &at).map(|scaled| scaled.negative(system, &at));
    let mut found: Vec<usize> = known.clone().unwrap_or_else(|| (0..system.n()).collect());
    found.retain(is_negative);
    if found.is_empty() {
        found = known.unwrap_or_default();
    }
    let Some(mass) = found.iter().map(|&i| masses[i]).reduce(f64::min) else { return };
    let coordinates = found.iter().map(|&i| quoted(system.coordinate_name(i))).collect();
    let time = at.t;
    forward.monitor.report.replace(Warning::NegativeMass { coordinates, mass, time });
}
