//! Check that constraints do not determine the free quantities of a given start, which include design variables such as a length in a joint.
//!
//! ```text
//!   A = ∂(Φ, dΦ/dt)/∂x    of the free coordinates, velocities and design variables x at the start
//! ```
//!
//! x_i is held if every z with A z = 0 has z_i = 0: every other value of x_i then violates a constraint, whatever the others are.

use nalgebra::DMatrix;
use num_dual::Dual64;

use super::free::{Free, Quantity};
use crate::redundancy::{RANK, null_space};
use crate::system::{NodeValues, NodeView, Sums};
use crate::{Error, Inputs, Settings, Start, System};

/// Change of a variable, relative to its unit or to the distance between its bounds; a held variable must then violate a tolerance.
const SMALL: f64 = 1e-2;
/// Components of a variable in the motions allowed by the constraints are rounding error below this.
const ROUNDING: f64 = 1e-6;

/// Rejects free quantities that constraints determine in a start that is not assembled.
///
/// # Errors
/// Such a coordinate, velocity or design variable, with the constraint that it would violate most.
pub(super) fn check(system: &System, settings: &Settings, inputs: &Inputs, free: &[Free]) -> Result<(), Error> {
    let is_given = matches!(inputs.start, Start::Velocity { .. });
    let of_start = |free: &&Free| match free.quantity {
        Quantity::Coordinate(_) | Quantity::Design(_) => true,
        // Momenta are not velocities: v₀ follows from them and the constraints.
        Quantity::Rate(_) => is_given,
        _ => false,
    };
    let is_asked = !matches!(inputs.start, Start::Assembled { .. }) && free.iter().any(|of| of_start(&of));
    if system.m() == 0 || !is_asked {
        return Ok(());
    }
    let moves: Vec<&Free> = free.iter().filter(of_start).collect();
    let violations = violations(system, settings, inputs, &moves);
    // The simulation reports values that are not finite.
    if violations.iter().any(|x| !x.is_finite()) {
        return Ok(());
    }
    let mut columns = violations.clone();
    columns.column_iter_mut().filter(|column| column.amax() > 0.0).for_each(|mut column| column /= column.amax());
    let allowed = null_space(&columns, RANK);
    for (k, free) in moves.iter().enumerate() {
        let (row, violation) = violations.column(k).abs().argmax();
        if violation > 1.0 && allowed.row(k).norm() <= ROUNDING {
            let name = system.equation_name(row % system.m());
            let equation = if row < system.m() { name.to_string() } else { format!("the rate of {name}") };
            let quantity = free.quantity.name(system, inputs.grid.steps.len())?;
            return Err(Error::NotFree { quantity, equation });
        }
    }
    Ok(())
}

/// Changes of Φ and dΦ/dt, in units of their tolerances, due to a small change of each variable; zero for dΦ/dt if momenta are given.
fn violations(system: &System, settings: &Settings, inputs: &Inputs, moves: &[&Free]) -> DMatrix<f64> {
    let m = system.m();
    let (q, zeros) = (inputs.start.q().as_slice(), vec![0.0; system.n().max(m)]);
    let (v, velocity_tolerance) = match &inputs.start {
        Start::Velocity { v, .. } => (v.as_slice(), settings.velocity_tolerance),
        _ => (&zeros[..system.n()], f64::INFINITY),
    };
    let design = system.parameters().values(inputs.design.as_slice());
    let at = NodeView::of_equations([q, v, &zeros[..m]], (inputs.controls_at(0), inputs.grid.start, &design));
    let (mut phi, mut sums) = (vec![Dual64::from_re(0.0); m], Sums::new(system.n(), m));
    let mut violations = DMatrix::zeros(2 * m, moves.len());
    for (free, mut column) in moves.iter().zip(violations.column_iter_mut()) {
        let mut there = NodeValues::of_equations(&at, Dual64::from_re);
        move_along(system, inputs, free, &mut there);
        system.phi_on(&there.view(), &mut phi);
        system.plain_sums(&there.view(), &mut sums);
        let of_phi = phi.iter().map(|phi| (phi.eps, settings.position_tolerance));
        let of_rate = sums.phi_dot().iter().map(|rate| (rate.eps, velocity_tolerance));
        column.iter_mut().zip(of_phi.chain(of_rate)).for_each(|(x, (change, tolerance))| {
            *x = if change == 0.0 { 0.0 } else { change / tolerance };
        });
    }
    violations
}

/// Sets the dual parts of the arguments to a small change along a variable.
fn move_along(system: &System, inputs: &Inputs, free: &Free, there: &mut NodeValues<Dual64>) {
    let small = |value: f64| {
        let unit = free.slope(free.to_variable(value)).abs();
        SMALL * unit.min(free.bounds.most - free.bounds.least)
    };
    match free.quantity {
        Quantity::Coordinate(q) => there.q[q.index()].eps = small(inputs.start.q()[q.index()]),
        Quantity::Rate(q) => there.v[q.index()].eps = small(inputs.start.rate()[q.index()]),
        Quantity::Design(design) => {
            let mut direction = vec![0.0; inputs.design.len()];
            direction[design.index()] = small(inputs.design[design.index()]);
            let changes = system.parameters().along(inputs.design.as_slice(), &direction);
            there.design.iter_mut().zip(changes).for_each(|(value, change)| value.eps = change);
        }
        _ => {}
    }
}
