//! Many motions of one system: initial guesses, parameter sets, starts.
//!
//! With the feature `rayon` they are spread over all cores; each thread keeps one [`Solver`], so nothing but the results is allocated
//! per motion after the first.

use crate::{Error, Gradient, Inputs, Settings, Solver, System};

/// J and its derivatives for each of the inputs, in their order; a motion that fails does not stop the others.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, gradients, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let at_rest = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
/// let pushed = |force: f64| {
///     let mut inputs = at_rest.clone();
///     inputs.controls.fill(force);
///     inputs
/// };
/// let guesses: Vec<Inputs> = [5.0, 10.0, 20.0].map(pushed).into();
/// let costs: Vec<f64> = gradients(&system, &guesses, Settings::default()).into_iter().map(|g| g.map(|g| g.value)).collect::<Result<_, _>>()?;
/// assert_eq!(costs.len(), 3);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn gradients(system: &System, inputs: &[Inputs], settings: Settings) -> Vec<Result<Gradient, Error>> {
    let solver = || Solver::new(system, settings);
    let one = |solver: &mut Solver, inputs: &Inputs| {
        solver.simulate(inputs)?;
        solver.gradient().cloned()
    };
    each(inputs, solver, one)
}

#[cfg(feature = "rayon")]
fn each<'s, T: Send>(
    inputs: &[Inputs],
    solver: impl Fn() -> Solver<'s> + Sync + Send,
    one: impl Fn(&mut Solver<'s>, &Inputs) -> T + Sync + Send,
) -> Vec<T> {
    use rayon::prelude::*;
    inputs.par_iter().map_init(solver, |solver, inputs| one(solver, inputs)).collect()
}

#[cfg(not(feature = "rayon"))]
fn each<'s, T>(inputs: &[Inputs], solver: impl Fn() -> Solver<'s>, one: impl Fn(&mut Solver<'s>, &Inputs) -> T) -> Vec<T> {
    let mut solver = solver();
    inputs.iter().map(|inputs| one(&mut solver, inputs)).collect()
}
