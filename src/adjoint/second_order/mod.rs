//! Products of the Hessian with a direction: derivatives of the motion and of its adjoint equations along a direction of the inputs.
//!
//! A dot is the derivative along the direction. With ψ = c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt of the gradient's adjoint variables at a stage:
//!
//! ```text
//!   forward    K(h) (v̇, σ̇) = (p̄˙ + ḣ g − D[𝓛_v − h g],  −D dΦ/dt)      D along q̄˙ + ḣ v and the inputs;   q̇ = q̄˙ + ḣ v + h v̇
//!   backward   the adjoint equations of a, b, c, d, e for their derivatives, with S_z in the place of every J_z,
//!              S_z = (J_z)˙ + ∂(Dψ)/∂z  for z = q, v, σ,      less ḣ a in S_v,      S_g = (J_g)˙ − ḣ b
//!   outputs    dJ/du, dJ/db, dJ/dΔt of the backward sweep, and what their formulas change by themselves
//! ```
//!
//! Events (`event/`), assembled starts ([`assembly`]) and costs on accelerations (`accelerations/evaluation.rs`) are differentiated in the same
//! way. A product is exact, symmetric to rounding, and costs about as much as a gradient. Hessians along several directions ([`hessian`]) need no backward
//! sweep.

mod assembly;
mod backward;
mod changes;
mod event;
mod forward;
mod hessian;
mod kept;
mod sources;

use nalgebra::DVector;
use num_dual::Dual64;

use crate::accelerations::AccelerationsOfCosts;
use crate::adjoint::accuracy::Accuracy;
use crate::adjoint::record::Record;
use crate::adjoint::{AdjointSweep, Gradient};
use crate::motion::{Motion, Report};
use crate::node::{Linearisation, PhiAlong, SecondOrderPrograms, SolvedMotion};
use crate::system::{CostFactors, CostRows, Pair, Sums};
use crate::{Error, Inputs, Scheme, Settings, Start, System, Trajectory};
use changes::{AssemblyChange, EventChange};
use hessian::Changes;
use kept::KeptFactors;

/// Workspace for products.
pub(crate) struct SecondOrderSweep {
    /// The derivatives of the motion along the direction, each stored in place of the quantity that it is the derivative of.
    change: Motion,
    /// The step lengths with their derivatives.
    steps: Vec<Dual64>,
    /// The derivatives of the adjoint variables and of the gradient.
    sweep: AdjointSweep,
    programs: SecondOrderPrograms,
    kept: KeptFactors,
    /// Changes along the directions of a Hessian.
    changes: Changes,
    /// Change of the assembly of the start.
    of_assembly: Option<AssemblyChange>,
    /// Directions of the events, in order; in the backward sweep, that of the current node.
    events: Vec<EventChange>,
    ended: Option<EventChange>,
    /// Reusable memory for directions of events.
    unused_events: Vec<EventChange>,
    phi: PhiAlong,
    /// The direction of the multipliers at the beginning of the current step.
    sigma_before: Vec<f64>,
    /// q̄˙ + ḣ v and p̄˙ + ḣ g of the current stage.
    known_q: Vec<f64>,
    known_p: Vec<f64>,
    /// A right-hand side, the solution, h times its velocities, and the residual.
    right: Pair,
    x: Pair,
    x_q: Vec<f64>,
    left: Pair,
    accuracy: Accuracy,
    /// The changes of 𝓛_v, 𝓛_q + Q and dΦ/dt with the known part, and with v̇ and σ̇.
    sums: Sums<f64>,
    of_state: Sums<f64>,
    zeros: Pair,
    no_controls: Vec<f64>,
    /// For costs on u̇: u̇, its change, and J_u̇.
    u_dot: [Vec<f64>; 2],
    first_rows: CostRows,
    /// For costs on v̇ and λ: their values, and their changes.
    accelerations: AccelerationsOfCosts,
    felt: [Pair; 2],
    /// Error for the first formula whose second derivatives are not finite, reported if the product is not finite.
    suspect: Option<Error>,
    report: Report,
}

/// Results of the gradient: the adjoint variables of its sweep, the factors of J and of the outputs, and dJ/dz.
struct First<'a> {
    record: &'a Record,
    factors: &'a CostFactors,
    design: &'a [f64],
}

impl SecondOrderSweep {
    pub(crate) fn new(system: &System, scheme: Scheme) -> Self {
        let (n, m, k) = (system.n(), system.m(), system.k());
        let (pair, sums, zeros) = (|| Pair::new(n, m), || Sums::new(n, m), |len| vec![0.0; len]);
        SecondOrderSweep {
            change: Motion::new(system, scheme),
            steps: Vec::new(),
            sweep: AdjointSweep::new(system, scheme),
            programs: SecondOrderPrograms::default(),
            kept: KeptFactors::default(),
            changes: Changes::default(),
            of_assembly: None,
            events: Vec::new(),
            ended: None,
            unused_events: Vec::new(),
            phi: PhiAlong::new(system),
            sigma_before: zeros(m),
            known_q: zeros(n),
            known_p: zeros(n),
            right: pair(),
            x: pair(),
            x_q: zeros(n),
            left: pair(),
            accuracy: Accuracy::default(),
            sums: sums(),
            of_state: sums(),
            zeros: pair(),
            no_controls: zeros(k),
            u_dot: [zeros(k), zeros(k)],
            first_rows: CostRows::new((n, m, k), system.parameters().len(), system.outputs()),
            accelerations: AccelerationsOfCosts::default(),
            felt: [pair(), pair()],
            suspect: None,
            report: Report::default(),
        }
    }

    /// Begins another motion.
    pub(crate) fn forget(&mut self) {
        self.kept.forget();
    }

    /// The product of a direction with the Hessian of the function that the sweep differentiates.
    pub(crate) fn run(
        &mut self,
        system: &System,
        (mut solved, first): (SolvedMotion, &mut AdjointSweep),
        settings: &Settings,
        direction: &Inputs,
    ) -> Result<&Gradient, Error> {
        check(solved.motion, direction)?;
        let first = recorded(first, system, &mut solved, settings)?;
        let SolvedMotion { motion, linearisation, .. } = solved;
        let unit = unit_of(direction);
        let scaled = (unit != 1.0).then(|| direction.along(direction, |d, _| d / unit));
        let direction = scaled.as_ref().unwrap_or(direction);
        self.begin(system, motion, linearisation)?;
        self.follow(system, motion, direction);
        self.along_assembly(system, motion, linearisation, direction)?;
        self.forward(system, motion, linearisation, 0)?;
        self.backward(system, motion, (linearisation, &first), direction)?;
        if unit != 1.0 {
            self.sweep.gradient.multiply(unit);
        }
        Ok(&self.sweep.gradient)
    }

    /// The change of the trajectory along the last direction.
    pub(crate) fn change(&self) -> &Trajectory {
        &self.change.trajectory
    }

    /// The last product.
    pub(crate) fn product_mut(&mut self) -> &mut Gradient {
        &mut self.sweep.gradient
    }

    /// The changes of the outputs along a direction.
    pub(crate) fn outputs(
        &mut self,
        system: &System,
        SolvedMotion { motion, linearisation, .. }: SolvedMotion,
        direction: &Inputs,
    ) -> Result<DVector<f64>, Error> {
        check(motion, direction)?;
        self.begin(system, motion, linearisation)?;
        self.follow(system, motion, direction);
        self.along_assembly(system, motion, linearisation, direction)?;
        self.forward(system, motion, linearisation, 0)?;
        let inputs = motion.inputs.along(&self.change.inputs, Dual64::new);
        let trajectory = motion.trajectory.zip_map(&self.change.trajectory, Dual64::new);
        self.accelerations.by_programs = true;
        let factors = CostFactors::of_outputs(system.outputs());
        let sums = trajectory.sums_of_costs(system, &inputs, (factors, &mut self.accelerations))?;
        Ok(DVector::from_iterator(system.outputs(), sums[1..].iter().map(|sum| sum.eps)))
    }

    /// Makes room for changes of a motion.
    fn begin(&mut self, system: &System, motion: &Motion, linearisation: &mut Linearisation) -> Result<(), Error> {
        let change = &mut self.change;
        let (nodes, scheme) = (motion.trajectory.times.len(), motion.trajectory.scheme);
        if change.trajectory.times.len() != nodes || change.trajectory.scheme != scheme {
            change.trajectory = Trajectory::zeros(system, nodes, scheme);
        }
        self.accuracy = Accuracy::default();
        self.kept.fit(system, motion);
        if let Some(accelerations) = &mut self.accelerations.own {
            accelerations.begin();
        }
        self.programs.prepare(system, &linearisation.evaluation, &motion.at(0))
    }

    /// Sets the direction on the computed grid.
    fn follow(&mut self, system: &System, motion: &Motion, direction: &Inputs) {
        let change = &mut self.change;
        change.inputs = motion.refinement().refine(direction);
        change.design = system.parameters().along(motion.inputs.design.as_slice(), direction.design.as_slice());
        self.steps = dual(&motion.inputs.grid.steps, &change.inputs.grid.steps);
    }
}

/// Repeats the sweep of the gradient, if its adjoint variables have not been recorded.
fn recorded<'a>(
    first: &'a mut AdjointSweep,
    system: &System,
    solved: &mut SolvedMotion,
    settings: &Settings,
) -> Result<First<'a>, Error> {
    if !first.is_recorded {
        first.record.get_or_insert_default();
        let factors = first.cost.factors.clone();
        let again = |_, of: &mut CostFactors| of.copy_from(&factors);
        AdjointSweep::run(std::slice::from_mut(first), system, solved, settings, again)?;
    }
    let AdjointSweep { record, cost, design, .. } = first;
    Ok(First { record: record.get_or_insert_default(), factors: &cost.factors, design })
}

/// A power of two by which a direction is divided, so that products neither underflow nor overflow; usually 1.
fn unit_of(direction: &Inputs) -> f64 {
    let Inputs { grid, start, controls, design, .. } = direction;
    let lists = [&grid.steps, start.q().as_slice(), start.rate().as_slice(), controls.as_slice(), design.as_slice()];
    let largest = lists.into_iter().flatten().fold(0.0f64, |most, d| most.max(d.abs()));
    let is_moderate = largest == 0.0 || (1e-100..1e100).contains(&largest);
    if is_moderate { 1.0 } else { 2f64.powi((largest.log2() as i32).clamp(-1000, 1000)) }
}

/// Checks that the motion is complete, and that the direction fits its inputs.
pub(crate) fn check(motion: &Motion, direction: &Inputs) -> Result<(), Error> {
    let Motion { trajectory, inputs, assembly, .. } = motion;
    trajectory.check_complete(inputs)?;
    let inserted = trajectory.inserted.len();
    match (assembly, &inputs.start) {
        // The guess, which the start was assembled from.
        (Some(assembly), Start::Velocity { q, v }) => {
            let start = Start::Assembled { q: q.clone(), v: v.clone(), held: assembly.held.clone() };
            Inputs { start, ..inputs.clone() }.check_direction(direction, inserted)
        }
        _ => inputs.check_direction(direction, inserted),
    }
}

/// Dual numbers from values and derivatives.
fn dual(x: &[f64], dot: &[f64]) -> Vec<Dual64> {
    x.iter().zip(dot).map(|(x, dot)| Dual64::new(*x, *dot)).collect()
}
