//! What must hold for every scene: errors are typed, numbers are finite, and the adjoint gradient is that of complex step.

use hamiltonian_adjoint::check::{Input, Random};
use hamiltonian_adjoint::{
    Cx, Error, Gradient, Hyper, Inputs, LiftedSolver, Real, Report, Solver, System, Trajectory, Warning,
};

use crate::build;
use crate::description::Description;

/// Step of the complex step.
const STEP: f64 = 1e-30;

/// A motion and its gradient, all of it finite.
pub struct Moved {
    pub system: System,
    pub inputs: Inputs,
    pub gradient: Gradient,
}

/// Compiles, simulates and differentiates; `Ok(Err)` is a typed error.
/// A step may be halved, so the motion may have more nodes than its description.
///
/// # Errors
/// What is not finite.
pub fn run(description: &Description) -> Result<Result<Moved, Error>, String> {
    let built = build::scene(description);
    let start = built.scene.compile().and_then(|system| {
        let inputs = build::inputs(&description.run, &system, &built.inertia)?;
        Ok((system, inputs))
    });
    let (system, inputs) = match start {
        Ok(start) => start,
        Err(error) => return Ok(Err(error)),
    };
    let mut solver = Solver::new(&system, description.run.settings);
    let adapted = description.run.tolerance.map(|tolerance| solver.adapt(&inputs, tolerance));
    let inputs = match adapted {
        Some(Err(error)) => return Ok(Err(error)),
        Some(Ok(adapted)) => adapted,
        None => inputs,
    };
    let simulated = solver.simulate(&inputs).map(|_| ());
    let computed = solver.trajectory().computed;
    all_finite(solver.trajectory(), computed)?;
    if let Err(error) = simulated {
        return Ok(Err(error));
    }
    let motion = solver.trajectory();
    match (motion.phi(&system, solver.inputs()), motion.phi_dot(&system, solver.inputs())) {
        (Ok(phi), Ok(phi_dot)) => {
            finite("Φ", phi.as_slice())?;
            finite("dΦ/dt", phi_dot.as_slice())?;
        }
        (Err(error), _) | (_, Err(error)) => return Ok(Err(error)),
    }
    let gradient = match solver.gradient() {
        Ok(gradient) => gradient.clone(),
        Err(error) => return Ok(Err(error)),
    };
    finite("J", &[gradient.value])?;
    finite("dJ/du", gradient.controls.as_slice())?;
    finite("dJ/db", gradient.design.as_slice())?;
    finite("dJ/dq0", gradient.start.q().as_slice())?;
    finite("dJ/dv0 or dJ/dp*0", gradient.start.rate().as_slice())?;
    finite("dJ/dΔt", &gradient.steps)?;
    drop(solver);
    Ok(Ok(Moved { system, inputs, gradient }))
}

fn all_finite(motion: &Trajectory, nodes: usize) -> Result<(), String> {
    finite("t", &motion.times[..nodes])?;
    for (name, matrix) in
        [("q", &motion.q), ("v", &motion.v), ("p*", &motion.p_star), ("dp*/dt", &motion.p_star_dot), ("σ", &motion.sigma)]
    {
        finite(name, &matrix.as_slice()[..matrix.nrows() * nodes])?;
    }
    Ok(())
}

fn finite(what: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(format!("{what}: entry {at} is {}", values[at])),
        None => Ok(()),
    }
}

type Belongs = fn(&Input) -> bool;

/// The inputs of one kind, which a direction moves together.
const KINDS: [(&str, Belongs); 5] = [
    ("controls", |input| matches!(input, Input::Control { .. })),
    ("design variables", |input| matches!(input, Input::Design(_))),
    ("q0", |input| matches!(input, Input::Coordinate(_))),
    ("v0 or p*0", |input| matches!(input, Input::Rate(_))),
    ("step lengths", |input| matches!(input, Input::Step(_))),
];

/// Derivatives of one kind that are smaller than this share of all together are compared with this share …
const SHARE: f64 = 1e-2;
/// … and with this: the costs of the scenes are of order one, and what should be zero is their rounding, up to 1e-13.
const SMALL: f64 = 1e-4;
/// Where dependent constraints lock a mechanism, its derivatives are those of the compliance, about 1e-9; what cancels in them is of order one, and
/// 1e-12 of that is rounding.
const SMALL_WITH_COMPLIANCE: f64 = 1e-3;
/// Reactions are shared by the compliance with five digits, and what they do to derivatives cancels only as far: all are compared with all together.
const SHARE_WITH_COMPLIANCE: f64 = 1.0;

/// How far adjoint and complex step are apart.
pub struct Disagreement {
    /// Relative to the gradient.
    pub error: f64,
    /// What the report says that it may be, by the smallest pivot, or because the motion is not resolved, and so blows up.
    pub bound: f64,
    pub what: String,
}

/// How many roundings may add up in a derivative, where each of them is magnified by a small pivot.
const ROUNDINGS: f64 = 64.0;
/// What is exact where no digits are lost.
const EXACT: f64 = 1e-9;
/// Rounding of a motion that blows up within some steps may make this of derivatives that are not wrong.
const NOT_WRONG: f64 = 1e-2;

/// True if the largest velocity of a motion leaves too few digits to the others, which are of order one: Newton's method stops at rounding relative
/// to the size of all velocities. Dampers cause such motions in long steps backward in time, which composed grids contain, too.
fn runs_away(motion: &Trajectory) -> bool {
    ROUNDINGS * f64::EPSILON * motion.v.amax() > EXACT
}

/// Whether a warning says that the motion, and so its gradient, is not to be trusted.
fn says_not_to_trust(warning: &Warning) -> bool {
    matches!(warning, Warning::Unresolved { .. } | Warning::Drift { .. } | Warning::Rough { .. })
}

impl Disagreement {
    pub fn is_exact(&self) -> bool {
        self.error <= EXACT
    }

    /// Digits are gone, but no more than the report says.
    pub fn is_told(&self) -> bool {
        self.error <= self.bound
    }
}

/// Whether a motion moves smoothly with inputs of this kind. Initial coordinates and constants that make dependent constraints contradict
/// each other change their multipliers by 1/μ of the change, see [`Trajectory::compliance`], and rounding by as much.
fn is_smooth(kind: &str, description: &Description) -> bool {
    description.redundant.is_empty() || !matches!(kind, "q0" | "design variables")
}

/// The largest difference of adjoint and complex step in random directions of every kind of input, relative to the gradient; none for a
/// motion that runs away.
///
/// # Errors
/// Those of the complex simulation.
pub fn disagreement(description: &Description, moved: &Moved) -> Result<Option<Disagreement>, Error> {
    let Moved { system, inputs, gradient } = moved;
    let mut random = Random::new(description.run.seed as u64);
    let mut solver = LiftedSolver::<Cx>::new(system, inputs, description.run.settings)?;
    let all = Input::all(inputs);
    let direction: Vec<f64> = all.iter().map(|&input| random.away_from_zero(size(input, inputs))).collect();
    let terms = |belongs: Belongs| -> Vec<f64> {
        let of_kind = all.iter().zip(&direction).filter(|(input, _)| belongs(input));
        of_kind.map(|(input, d)| input.in_gradient(gradient) * d).collect()
    };
    let kinds = KINDS.into_iter().filter(|(name, _)| is_smooth(name, description));
    let total: f64 = kinds.map(|(_, belongs)| sum_of_sizes(&terms(belongs))).sum();
    let (share, small) =
        if description.redundant.is_empty() { (SHARE, SMALL) } else { (SHARE_WITH_COMPLIANCE, SMALL_WITH_COMPLIANCE) };
    let mut worst = Disagreement { error: 0.0, bound: 0.0, what: String::new() };
    for (name, belongs) in KINDS.into_iter().filter(|(name, _)| is_smooth(name, description)) {
        let mut perturbed = inputs.lift::<Cx>();
        for (input, d) in all.iter().zip(&direction).filter(|(input, _)| belongs(input)) {
            *input.of(&mut perturbed) += Cx::new(0.0, d * STEP);
        }
        solver.simulate(&perturbed)?;
        let reference = solver.cost()?.0.im / STEP;
        let terms = terms(belongs);
        let (adjoint, scale) = (terms.iter().sum::<f64>(), sum_of_sizes(&terms));
        let error = (adjoint - reference).abs() / (scale + share * total + small);
        if error.is_nan() || error > worst.error {
            let what = format!("{name}: adjoint {adjoint:e}, complex step {reference:e}, scale {scale:e} of {total:e}");
            worst = Disagreement { error, what, ..worst };
        }
    }
    if runs_away(solver.real().trajectory()) {
        return Ok(None);
    }
    let Report { worst_pivot, warnings, .. } = solver.real().report();
    // K⁻¹ occurs twice in its own derivative, but refined solutions lose the digits of one, counted from all derivatives together; so does
    // the complex step.
    let by_pivot = ROUNDINGS * f64::EPSILON / (worst_pivot * share);
    let is_warned = warnings.iter().any(says_not_to_trust);
    worst.bound = if is_warned { NOT_WRONG } else { by_pivot };
    worst.what = format!("{}; smallest pivot {worst_pivot:.1e}, {warnings:?}", worst.what);
    Ok(Some(worst))
}

/// The differences between a second derivative along two random directions by products of the Hessian and by hyper-dual numbers, relative to the terms
/// of it; none for what has no products, and for a motion that runs away.
///
/// # Errors
/// Those of the simulations.
pub fn disagreement_of_products(description: &Description, moved: &Moved) -> Result<Option<Disagreement>, Error> {
    let Moved { system, inputs, .. } = moved;
    let mut random = Random::new(description.run.seed as u64);
    let all = Input::all(inputs);
    let is_smooth = |input: &Input| {
        let of = |(name, belongs): &(&str, Belongs)| is_smooth(name, description) || !belongs(input);
        KINDS.iter().all(of) && (description.redundant.is_empty() || !matches!(input, Input::Rate(_)))
    };
    let mut direction = || {
        let mut direction = inputs.no_change();
        for &input in &all {
            let d = random.away_from_zero(size(input, inputs));
            *input.of(&mut direction) = if is_smooth(&input) { d } else { 0.0 };
        }
        direction
    };
    let (mut first, mut second) = (direction(), direction());
    let mut solver = Solver::new(system, description.run.settings);
    if runs_away(solver.simulate(inputs)?) {
        return Ok(None);
    }
    let mut product = |of: &Inputs| solver.hessian_product(of).cloned();
    let (of_first, of_second) = (product(&first)?, product(&second)?);
    let terms = |gradient: &Gradient, direction: &mut Inputs| {
        all.iter().map(|&input| input.in_gradient(gradient) * *input.of(direction)).collect::<Vec<f64>>()
    };
    let (of_first, of_second) = (terms(&of_first, &mut second), terms(&of_second, &mut first));
    let mut lifted = LiftedSolver::<Hyper>::new(system, inputs, description.run.settings)?;
    let mut perturbed = inputs.lift::<Hyper>();
    for (part, direction) in [(1, &mut first), (2, &mut second)] {
        all.iter().for_each(|input| input.of(&mut perturbed).add_to_part(part, *input.of(direction)));
    }
    lifted.simulate(&perturbed)?;
    let reference = match lifted.cost() {
        // Costs on accelerations have none.
        Err(Error::NoSecondDerivatives { .. }) => return Ok(None),
        cost => cost?.part(3),
    };
    let [one, other] = [&of_first, &of_second].map(|terms| terms.iter().sum::<f64>());
    let scale = sum_of_sizes(&of_first).max(sum_of_sizes(&of_second)) + SMALL;
    let error = (one - other).abs().max((one - reference).abs()) / scale;
    let Report { worst_pivot, warnings, .. } = lifted.real().report();
    // Two more solutions with K, each of which loses the digits of a small pivot.
    let by_pivot = ROUNDINGS * ROUNDINGS * f64::EPSILON / (worst_pivot * SHARE);
    let bound = if warnings.iter().any(says_not_to_trust) { NOT_WRONG } else { by_pivot };
    let what =
        format!("{one:e}, {other:e}, hyper-dual {reference:e}, scale {scale:e}; pivot {worst_pivot:.1e}, {warnings:?}");
    Ok(Some(Disagreement { error, bound, what }))
}

fn sum_of_sizes(terms: &[f64]) -> f64 {
    terms.iter().map(|term| term.abs()).sum()
}

/// A change of an input that is neither large nor small.
fn size(input: Input, inputs: &Inputs) -> f64 {
    match input {
        Input::Design(p) => inputs.design[p].abs(),
        Input::Step(i) => inputs.grid.steps[i - 1].abs(),
        _ => 1.0,
    }
}
