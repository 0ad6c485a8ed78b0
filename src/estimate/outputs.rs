//! The errors of J and of the outputs that the grid causes, by the difference to the motion whose steps are all divided.
//!
//! An output may be read at a single node, so every second node has no motion with the same outputs. The finer grid keeps the given nodes. With the order
//! p of the scheme, a motion with steps divided by k has lost 1 − k⁻ᵖ of the error.

use crate::motion::Refinement;
use crate::{Error, Inputs, Settings, Solver, System};

/// Values of the continuous motion minus those on a grid, estimated.
pub(crate) struct GridErrors {
    /// Of J.
    pub value: f64,
    /// Of the outputs.
    pub outputs: Vec<f64>,
}

/// The errors of a value of J and of outputs, from steps divided into so many parts. Controls are linear between the given nodes. `None` for composed
/// grids, and if parts have to be halved again.
///
/// # Errors
/// No motion with divided steps.
pub(crate) fn grid_errors(
    system: &System,
    (inputs, parts): (&Inputs, usize),
    settings: Settings,
    (value, outputs): (f64, &[f64]),
) -> Result<Option<GridErrors>, Error> {
    if inputs.grid.stages > 1 {
        return Ok(None);
    }
    // Steps of length zero have no middle.
    let (mut steps, mut inserted, mut nodes) = (Vec::new(), Vec::new(), vec![0]);
    for &step in &inputs.grid.steps {
        let part = step / parts as f64;
        for _ in 1..if step == 0.0 { 1 } else { parts } {
            steps.push(part);
            inserted.push(steps.len());
        }
        steps.push(part);
        nodes.push(steps.len());
    }
    let mut finer = Refinement::new((&steps, &[]), inputs.grid.around, &inserted).refine(inputs);
    finer.events.iter_mut().for_each(|event| event.node = nodes[event.node]);
    let mut solver = Solver::new(system, settings);
    let mut motion = solver.simulate(&finer)?.clone();
    if !motion.inserted.is_empty() {
        return Ok(None);
    }
    // Costs are then read at the given nodes.
    motion.inserted = inserted;
    let taken = Inputs { events: inputs.events.clone(), ..solver.inputs().clone() };
    let (of_value, of_outputs) = (motion.cost(system, &taken)?, motion.outputs(system, &taken)?);
    let error = |finer: f64, given: f64| (finer - given) / (1.0 - (parts as f64).powi(-(settings.scheme.order as i32)));
    let of_outputs = of_outputs.iter().zip(outputs).map(|(finer, given)| error(*finer, *given));
    Ok(Some(GridErrors { value: error(of_value, value), outputs: of_outputs.collect() }))
}
