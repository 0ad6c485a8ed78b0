//! Motions with restarts, halved steps, composed grids and steps by tolerance, drawn together: features that each work may fail as a pair.

use hamiltonian_adjoint::{Composition, Error, LongSolver, Settings};
use proptest::prelude::*;
use proptest::sample::select;

use crate::description::Description;
use crate::exact::Moved;
use crate::regular;

/// A scene that simulates, but for accidents, in steps so long that some are halved.
pub fn description() -> impl Strategy<Value = Description> {
    use Composition::*;
    let scene = prop_oneof![4 => regular::description(), 1 => regular::redundant()];
    let restarts = (0..4usize, prop_oneof![2 => Just(f64::INFINITY), 1 => Just(1e-7), 1 => Just(0.0)]);
    let composition = prop_oneof![Just(None), select(vec![Trapezoidal, Suzuki4, Yoshida6, KahanLi6]).prop_map(Some)];
    let tolerance = prop_oneof![Just(None), (-7.0..-3.0).prop_map(|digits| Some(f64::powf(10.0, digits)))];
    (scene, restarts, 0..8usize, composition, tolerance, 1.0..15.0).prop_map(
        |(mut description, (rebase_every, drift_bound), max_halvings, composition, tolerance, stretch)| {
            let run = &mut description.run;
            run.steps.iter_mut().for_each(|step| *step *= stretch);
            run.settings = Settings { rebase_every, drift_bound, max_halvings, ..run.settings };
            let is_one_way = run.steps.iter().all(|step| step.signum() == run.steps[0].signum());
            run.composition = composition;
            run.tolerance = tolerance.filter(|_| is_one_way && composition.is_none());
            description
        },
    )
}

/// The gradient from checkpoints is the stored one to the last bit, however much memory there is.
///
/// # Errors
/// What differs.
pub fn compare_with_checkpoints(description: &Description, moved: &Moved) -> Result<usize, String> {
    let Moved { system, inputs, gradient } = moved;
    let settings = description.run.settings;
    let all = inputs.grid.nodes() * (system.bytes_per_node(&settings) + 16 * (1 + system.k()) + 60);
    let mut fitting = 0;
    for share in [0.25, 0.5, 1.0, 4.0] {
        let bytes = (share * all as f64) as usize;
        match LongSolver::new(system, settings, bytes).gradient(inputs) {
            Ok(long) if long == gradient => fitting += 1,
            Ok(long) => return Err(format!("{bytes} bytes of {all}: J {:e} for {:e}", long.value, gradient.value)),
            Err(Error::Memory { .. }) => {}
            Err(error) => return Err(format!("{bytes} bytes of {all}: {error}")),
        }
    }
    Ok(fitting)
}
