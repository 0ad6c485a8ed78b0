//! The errors of outputs that the grid causes, by the difference to the motion whose steps are all halved.
//!
//! An output may be read at a single node, so every second node has no motion with the same outputs. The halved grid keeps the given nodes. With the
//! order p of the scheme, a motion with halved steps has lost 1 − 2⁻ᵖ of the error.

use crate::motion::Refinement;
use crate::{Error, Inputs, Settings, Solver, System};

/// Outputs of the continuous motion minus these outputs, estimated. Controls are linear between the given nodes. `None` for composed grids, and if
/// halved steps have to be halved again.
///
/// # Errors
/// No motion with halved steps.
pub(crate) fn errors_of_outputs(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    outputs: &[f64],
) -> Result<Option<Vec<f64>>, Error> {
    if inputs.grid.stages > 1 {
        return Ok(None);
    }
    // Steps of length zero have no middle.
    let (mut halves, mut inserted, mut nodes) = (Vec::new(), Vec::new(), vec![0]);
    for &step in &inputs.grid.steps {
        if step != 0.0 {
            halves.push(0.5 * step);
            inserted.push(halves.len());
        }
        halves.push(0.5 * step);
        nodes.push(halves.len());
    }
    let mut halved = Refinement::new((&halves, &[]), inputs.grid.around, &inserted).refine(inputs);
    halved.events.iter_mut().for_each(|event| event.node = nodes[event.node]);
    let mut solver = Solver::new(system, settings);
    let mut motion = solver.simulate(&halved)?.clone();
    if !motion.inserted.is_empty() {
        return Ok(None);
    }
    // Costs are then read at the given nodes.
    motion.inserted = inserted;
    let taken = Inputs { events: inputs.events.clone(), ..solver.inputs().clone() };
    let known = motion.outputs(system, &taken)?;
    let lost = 1.0 - 0.5f64.powi(settings.scheme.order as i32);
    Ok(Some(known.iter().zip(outputs).map(|(halved, given)| (halved - given) / lost).collect()))
}
