//! The errors of J and of the outputs that the grid causes, by the difference to the motion whose steps are all halved.
//!
//! An output may be read at a single node, so every second node has no motion with the same outputs. The halved grid keeps the given nodes. With the
//! order p of the scheme, a motion with halved steps has lost 1 − 2⁻ᵖ of the error.

use crate::motion::Refinement;
use crate::{Error, Inputs, Settings, Solver, System};

/// Values of the continuous motion minus those on a grid, estimated.
pub(crate) struct GridErrors {
    /// Of J.
    pub value: f64,
    /// Of the outputs.
    pub outputs: Vec<f64>,
}

/// The errors of a value of J and of outputs. Controls are linear between the given nodes. `None` for composed grids, and if halved steps have to be
/// halved again.
///
/// # Errors
/// No motion with halved steps.
pub(crate) fn grid_errors(
    system: &System,
    inputs: &Inputs,
    settings: Settings,
    (value, outputs): (f64, &[f64]),
) -> Result<Option<GridErrors>, Error> {
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
    let (of_value, of_outputs) = (motion.cost(system, &taken)?, motion.outputs(system, &taken)?);
    let error = |halved: f64, given: f64| (halved - given) / (1.0 - 0.5f64.powi(settings.scheme.order as i32));
    let of_outputs = of_outputs.iter().zip(outputs).map(|(halved, given)| error(*halved, *given));
    Ok(Some(GridErrors { value: error(of_value, value), outputs: of_outputs.collect() }))
}
