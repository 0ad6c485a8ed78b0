//! Validation of the sums, states and variables for multiple shooting.

use super::super::free::{Free, Quantity};
use crate::{Coordinate, Error, Inputs, Mechanics, System};

/// For each output, true if segments before the last one may contribute to it.
pub(super) fn running_outputs(system: &System) -> Vec<bool> {
    (0..system.outputs()).map(|k| !system.is_terminal(k)).collect()
}

/// Rejects states that do not determine the start of a segment.
fn check_states(system: &System, inputs: &Inputs, states: &[Coordinate]) -> Result<(), Error> {
    for (k, &q) in states.iter().enumerate() {
        if !system.owns(q.0) {
            return Err(Error::NoSuchInput { input: format!("the state of coordinate {}", q.index()) });
        }
        if states[..k].contains(&q) {
            let what = format!("the number of states of `{}`", system.coordinate_name(q.index()));
            return Err(Error::Parameter { what, value: 2.0, must_be: "1" });
        }
    }
    let fewest = system.n().saturating_sub(system.m());
    let freedoms = match system.loop_equations() {
        [] => fewest,
        // Not every dependent constraint removes a degree of freedom. A start that cannot be assembled is reported when it is evaluated.
        _ => Mechanics::at_start(system, inputs).map_or(fewest, |at| at.degrees_of_freedom()),
    };
    if states.len() < freedoms {
        let (what, value) = ("the number of states".to_string(), states.len() as f64);
        return Err(Error::Parameter { what, value, must_be: "at least the number of degrees of freedom" });
    }
    Ok(())
}

/// Rejects features that segments do not support.
pub(super) fn check(
    system: &System,
    inputs: &Inputs,
    free: &[Free],
    states: &[Coordinate],
    segments: usize,
) -> Result<(), Error> {
    let steps = inputs.grid.macro_ends().count();
    if segments == 0 || segments > steps {
        let (what, value) = ("the number of segments".to_string(), segments as f64);
        return Err(Error::Parameter { what, value, must_be: "at least 1 and at most the number of (macro) steps" });
    }
    if let Some(name) = system.cost_of_multipliers().filter(|_| segments > 1) {
        let why = "it depends on σ, p* or dp*/dt, which restart with every segment; use accelerations and reactions λ, which do not restart";
        return Err(Error::NotInSegments { what: format!("`{name}`"), why });
    }
    check_states(system, inputs, states)?;
    let named = |of: &Free, form: &str, why| {
        let name = of.quantity.name(system, inputs.grid.steps.len())?;
        Err(Error::NotInSegments { what: format!("{form} `{name}`"), why })
    };
    if let Some(of) = free.iter().find(|of| matches!(of.quantity, Quantity::StepLength(_))) {
        return named(of, "the free", "step lengths can be free only through their sum, the duration");
    }
    let signs = |is_one: fn(&f64) -> bool| inputs.grid.steps.iter().any(is_one);
    let is_coarse = |of: &&Free| of.quantity.control().is_some() && !matches!(of.quantity, Quantity::Control(_));
    if let Some(of) = free.iter().find(is_coarse).filter(|_| signs(|dt| *dt > 0.0) && signs(|dt| *dt < 0.0)) {
        let why = "some steps go forward and some back in time, so knots are not in the order of the nodes; free the control at all nodes";
        return named(of, "knots of the control", why);
    }
    let is_duration = |of: &Free| of.quantity == Quantity::Duration;
    if let Some(name) = system.timed().filter(|_| segments > 1 && free.iter().any(is_duration)) {
        let why = "it depends explicitly on time, and a change of the duration would change the start times of the segments; fix the duration";
        return Err(Error::NotInSegments { what: format!("`{name}` and a free duration"), why });
    }
    Ok(())
}
