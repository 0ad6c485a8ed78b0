//! Derivatives of motions with located events.
//!
//! Let Δt be the steps of a motion, τ_k the times of its events, g_k their functions and J(x, Δt) a cost or an output with the other inputs x. In phase
//! k the steps are s_k = T_k/G_k times the given ones, T_k = τ_k − τ_{k−1} their sum and G_k that of the given ones; after the last event T is what
//! is left until the end of the grid, τ. With D_i = dL/dΔt_i and the mean M_k = Σ Δt_i D_i/T_k over the steps of phase k,
//!
//! ```text
//!   L = J + Σ μ_j g_j,     dL/dτ_k = M_k − M_{k+1} = 0,     dJ/dx = L_x,     dJ/dΔt_i (given) = s_k (D_i − M_k) + M of the rest
//! ```
//!
//! Controls that are functions of time ([`Timed`]) are u_i(t_i; U, τ), with t_i = Σ Δt and the given times τ. All D contain Σ ∂u_i/∂t_i dJ/du_i; at
//! the end, dJ/du_i becomes dJ/dU, and dJ/dτ adds to dJ/dΔt (given).
//!
//! The derivatives of g_j by τ_k vanish for k > j, so the μ_j follow one after the other, from the last event backwards. Along a direction, the τ̇_k
//! follow from ġ_k = 0, and products with the Hessian are those of L, with μ̇_j from the derivative of M_k − M_{k+1} = 0.

use nalgebra::DMatrix;
use num_dual::Dual64;

use crate::adjoint::Gradient;
use crate::motion::{ByKnots, Motion, Phases, Timed, passed};
use crate::number::{Real, dot};
use crate::{Error, Inputs, System, Warning};

/// The events of a motion with the derivatives of their functions.
pub(crate) struct Located {
    phases: Phases,
    /// The lengths of the given steps in the motion, and their factors s.
    steps: Vec<f64>,
    factors: Vec<f64>,
    timed: Option<Timed>,
    /// The derivatives of the functions of the events, with all steps as inputs.
    rows: Vec<Gradient>,
    /// dg_j/dτ_k in row k and column j.
    by_time: DMatrix<f64>,
    /// A kink that no event locates.
    unlocated: Option<Warning>,
    /// D and dL/du of the Lagrangian that was differentiated last.
    lagrangian: Option<(Vec<f64>, DMatrix<f64>)>,
}

impl Located {
    /// From the derivatives of the functions of all events of a motion, and a kink that none of them locates.
    pub(crate) fn new(
        system: &System,
        motion: &Motion,
        (rows, unlocated): (Vec<Gradient>, Option<Warning>),
    ) -> Result<Self, Error> {
        let refinement = motion.refinement();
        let mut steps = vec![0.0; motion.nodes() - 1 - motion.trajectory.inserted.len()];
        (1..motion.nodes()).for_each(|node| steps[refinement.given_step(node) - 1] += motion.length(node));
        let phases = Phases::new(&motion.inputs.events, &steps);
        let factors = motion.scales.factors.clone();
        let count = rows.len();
        let mut located = Located {
            phases,
            steps,
            factors,
            timed: motion.scales.timed.clone(),
            rows,
            by_time: DMatrix::zeros(count, count),
            lagrangian: None,
            unlocated,
        };
        let Located { timed, steps, rows, .. } = &mut located;
        rows.iter_mut().for_each(|row| add_times(timed, steps, &row.controls, &mut row.steps));
        for j in 0..count {
            let column = located.by_times(&located.steps, &located.rows[j].steps);
            located.by_time.column_mut(j).copy_from_slice(&column);
            let slope = column[j];
            if slope == 0.0 || !slope.is_finite() {
                let event = motion.inputs.events[j];
                let time = motion.inputs.grid.time(motion.trajectory.column_of(event.node));
                let event = system.event_name(event.event.index()).into();
                return Err(Error::EventGrazed { event, node: motion.inputs.events[j].node, time, slope });
            }
        }
        Ok(located)
    }

    /// M_k of all phases.
    fn means<R: Real>(&self, steps: &[R], by_steps: &[R]) -> Vec<R> {
        let of_phase = |phase| {
            let terms = self.phases.steps(phase).map(|i| steps[i] * by_steps[i]);
            terms.fold(R::zero(), |sum, term| sum + term) / self.phases.length(phase, steps)
        };
        (0..self.phases.count()).map(of_phase).collect()
    }

    /// The derivatives with respect to the times of all events.
    fn by_times<R: Real>(&self, steps: &[R], by_steps: &[R]) -> Vec<R> {
        let means = self.means(steps, by_steps);
        (0..self.phases.located).map(|k| means.get(k + 1).map_or(means[k], |next| means[k] - *next)).collect()
    }

    /// μ for these derivatives with respect to the times of the events.
    fn multipliers(&self, by_times: &[f64]) -> Vec<f64> {
        let mut mu = vec![0.0; by_times.len()];
        for k in (0..mu.len()).rev() {
            let later: f64 = (k + 1..mu.len()).map(|j| self.by_time[(k, j)] * mu[j]).sum();
            mu[k] = -(by_times[k] + later) / self.by_time[(k, k)];
        }
        mu
    }

    /// Replaces the derivatives of J with all steps as inputs by those with the given steps, whose events are located.
    pub(crate) fn complete(&self, gradient: &mut Gradient) {
        self.add_events(gradient);
        self.finish(gradient);
    }

    /// As [`complete`](Self::complete), for a function whose Hessian is needed. Returns the μ.
    pub(crate) fn complete_lagrangian(&mut self, gradient: &mut Gradient) -> Vec<f64> {
        let mu = self.add_events(gradient);
        self.lagrangian = Some((gradient.steps.clone(), gradient.controls.clone()));
        self.finish(gradient);
        mu
    }

    /// From the derivatives of J to those of L; returns the μ.
    fn add_events(&self, gradient: &mut Gradient) -> Vec<f64> {
        gradient.warnings.extend(self.unlocated.clone());
        add_times(&self.timed, &self.steps, &gradient.controls, &mut gradient.steps);
        let mu = self.multipliers(&self.by_times(&self.steps, &gradient.steps));
        mu.iter().zip(&self.rows).for_each(|(mu, row)| gradient.add_multiple(*mu, row));
        mu
    }

    /// From the derivatives with respect to the steps and controls of the motion to those with respect to the given ones.
    fn finish(&self, gradient: &mut Gradient) {
        gradient.steps = self.by_given_steps(&self.steps, &self.factors, &gradient.steps);
        if let Some(timed) = &self.timed {
            let ByKnots { values, times } = timed.by_knots(&passed(&self.steps), &gradient.controls);
            gradient.controls = values;
            add_sums_behind(&times, &mut gradient.steps);
        }
    }

    /// True after [`complete_lagrangian`](Self::complete_lagrangian), so that products can be completed.
    pub(crate) fn has_lagrangian(&self) -> bool {
        self.lagrangian.is_some()
    }

    /// s (D − M) + M of the rest, for all given steps.
    fn by_given_steps<R: Real>(&self, steps: &[R], factors: &[R], by_steps: &[R]) -> Vec<R> {
        let means = self.means(steps, by_steps);
        let of_rest = if self.phases.has_rest() { means[means.len() - 1] } else { R::zero() };
        let mut given = by_steps.to_vec();
        for phase in 0..self.phases.count() {
            given[self.phases.steps(phase)].iter_mut().for_each(|d| *d = factors[phase] * (*d - means[phase]) + of_rest);
        }
        given
    }

    /// The direction of the inputs with that of all steps, from one with that of the given steps.
    pub(crate) fn direction(&self, given: &Inputs) -> Inputs {
        let mut direction = given.clone();
        for phase in 0..self.phases.count() {
            let (range, factor) = (self.phases.steps(phase), self.factors[phase]);
            let change = factor * self.phases.length(phase, &given.grid.steps) / self.phases.length(phase, &self.steps);
            range.for_each(|i| direction.grid.steps[i] = factor * given.grid.steps[i] - change * self.steps[i]);
        }
        // Controls at the times of events that do not move.
        self.write_controls(given, &vec![0.0; self.steps.len()], &mut direction.controls);
        let mut times: Vec<f64> = Vec::with_capacity(self.phases.count());
        for (k, row) in self.rows.iter().enumerate() {
            let earlier: f64 = (0..k).map(|j| self.by_time[(j, k)] * times[j]).sum();
            times.push(-(row.along(&direction) + earlier) / self.by_time[(k, k)]);
        }
        if self.phases.has_rest() {
            times.push(given.grid.steps.iter().sum());
        }
        for (phase, time) in times.iter().enumerate() {
            let before = phase.checked_sub(1).map_or(0.0, |before| times[before]);
            let change = (time - before) / self.phases.length(phase, &self.steps);
            self.phases.steps(phase).for_each(|i| direction.grid.steps[i] += change * self.steps[i]);
        }
        self.write_controls(given, &direction.grid.steps, &mut direction.controls);
        direction
    }

    /// Writes the changes of controls that are functions of time, with those of their knots and of the steps.
    fn write_controls(&self, given: &Inputs, steps: &[f64], controls: &mut DMatrix<f64>) {
        let Some(timed) = &self.timed else { return };
        let times = passed(&duals(&self.steps, steps));
        let mut all = controls.map(|change| Dual64::new(0.0, change));
        timed.along(given).write(&times, 0..times.len(), &mut all);
        controls.zip_apply(&all, |change, control| *change = control.eps);
    }

    /// Completes a product of the Hessian of L with such a direction.
    pub(crate) fn complete_product(&self, product: &mut Gradient, given: &Inputs, direction: &Inputs) {
        let Some((first, by_controls)) = &self.lagrangian else { return };
        let taken = duals(&self.steps, &direction.grid.steps);
        let (timed, times) = (self.timed.as_ref().map(|timed| timed.along(given)), passed(&taken));
        let by_controls = |product: &DMatrix<f64>| by_controls.zip_map(product, Dual64::new);
        if let Some(timed) = &timed {
            add_sums_behind(&changes(&timed.by_times(&times, &by_controls(&product.controls))), &mut product.steps);
        }
        let of_given = |phase: usize| {
            let range = self.phases.steps(phase);
            let given = range.clone().map(|i| Dual64::new(self.steps[i] / self.factors[phase], given.grid.steps[i]));
            self.phases.length(phase, &taken) / given.fold(Dual64::new(0.0, 0.0), |sum, dt| sum + dt)
        };
        let factors: Vec<Dual64> = (0..self.phases.count()).map(of_given).collect();
        let by_times = self.by_times(&taken, &duals(first, &product.steps));
        let mu = self.multipliers(&changes(&by_times));
        mu.iter().zip(&self.rows).for_each(|(mu, row)| product.add_multiple(*mu, row));
        let by_given = self.by_given_steps(&taken, &factors, &duals(first, &product.steps));
        product.steps = changes(&by_given);
        if let Some(timed) = &timed {
            let by = timed.by_knots(&times, &by_controls(&product.controls));
            product.controls = by.values.map(|by_value| by_value.eps);
            add_sums_behind(&changes(&by.times), &mut product.steps);
        }
    }
}

fn duals(x: &[f64], change: &[f64]) -> Vec<Dual64> {
    x.iter().zip(change).map(|(x, change)| Dual64::new(*x, *change)).collect()
}

fn changes(x: &[Dual64]) -> Vec<f64> {
    x.iter().map(|x| x.eps).collect()
}

/// Adds the derivatives with respect to the times of nodes to those with respect to the steps before them.
fn add_sums_behind(by_times: &[f64], by_steps: &mut [f64]) {
    let mut sum = 0.0;
    for (by_step, by_time) in by_steps.iter_mut().zip(&by_times[1..]).rev() {
        sum += by_time;
        *by_step += sum;
    }
}

/// Adds Σ ∂u_i/∂t_i dJ/du_i to dJ/dΔt.
fn add_times(timed: &Option<Timed>, steps: &[f64], by_controls: &DMatrix<f64>, by_steps: &mut [f64]) {
    if let Some(timed) = timed {
        add_sums_behind(&timed.by_times(&passed(steps), by_controls), by_steps);
    }
}

impl Gradient {
    /// Adds a multiple of the derivatives of another function of the same inputs.
    fn add_multiple(&mut self, factor: f64, other: &Gradient) {
        self.controls += factor * &other.controls;
        self.design += factor * &other.design;
        *self.start.q_mut() += factor * other.start.q();
        *self.start.rate_mut() += factor * other.start.rate();
        self.steps.iter_mut().zip(&other.steps).for_each(|(sum, x)| *sum += factor * x);
    }

    /// The derivative along a direction.
    fn along(&self, direction: &Inputs) -> f64 {
        let of_start = self.start.q().dot(direction.start.q()) + self.start.rate().dot(direction.start.rate());
        let of_inputs = self.controls.dot(&direction.controls) + self.design.dot(&direction.design);
        of_start + of_inputs + dot(&self.steps, &direction.grid.steps)
    }
}
