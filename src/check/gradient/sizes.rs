//! Size of the change of each input, typical of inputs of its kind; and sizes of the terms of derivatives with respect to step lengths and
//! design variables.
//!
//! Coordinates, velocities, momenta and controls have different units, m and rad, N and N m. A small or zero input is compared with the
//! others in units of the masses, in which all of them have the same unit:
//!
//! ```text
//!   q_i  by  max_j √m_j |q_j| / √m_i,   v_i alike,      p*_i  by  √m_i max_j |p*_j| / √m_j,
//!   u_k  by  max_j |ṗ*_j| / √m_j  over  max_j |Q_u,jk| / √m_j
//! ```

use nalgebra::{DMatrix, DVector, DVectorView};
use num_dual::Dual64;

use crate::redundancy::masses;
use crate::system::{NodeValues, NodeView};
use crate::{Inputs, Solver, Start, System};

/// Inputs smaller than this fraction of their reference value get the size of that fraction.
const SMALL: f64 = 0.1;

/// The size of every input of a motion that was computed.
pub(super) fn sizes_of_inputs(system: &System, inputs: &Inputs, solver: &mut Solver) -> Inputs {
    let masses = masses(&solver.forward_mut().stepper.newton.linearisation, system);
    let roots: Vec<f64> = masses.iter().map(|mass| mass.max(0.0).sqrt()).collect();
    let largest = |x: &[f64], power: i32| {
        let entries = x.chunks(roots.len().max(1)).flat_map(|column| column.iter().zip(&roots));
        entries.filter(|(_, root)| **root > 0.0).map(|(x, root)| x.abs() * root.powi(power)).fold(0.0, f64::max)
    };
    let (motion, duration) = (solver.trajectory(), inputs.grid.steps.iter().sum::<f64>().abs());
    let power = if matches!(inputs.start, Start::Momentum { .. }) { -1 } else { 1 };
    // Coordinates that are zero at the start get their size from the whole motion, and velocities of a body at rest from its coordinates.
    let (q, rate) = (inputs.start.q().as_slice(), inputs.start.rate().as_slice());
    let place = first([SMALL * largest(q, 1), largest(motion.q.as_slice(), 1)]);
    let speed = first([largest(motion.v.as_slice(), 1), place / duration]);
    let force = first([largest(motion.p_star_dot.as_slice(), -1), speed / duration]);
    let speed = first([SMALL * largest(rate, power), speed]);
    let by_controls = largest_by_controls(system, inputs, &largest);
    let sized = |x: &DVector<f64>, by: f64, power: i32| {
        DVector::from_fn(x.len(), |i, _| first([x[i].abs().max(by * roots[i].powi(-power)), 1.0]))
    };
    let mut sizes = inputs.no_change();
    sizes.start.q_mut().copy_from(&sized(inputs.start.q(), place, 1));
    sizes.start.rate_mut().copy_from(&sized(inputs.start.rate(), speed, power));
    for (k, mut channel) in sizes.controls.row_iter_mut().enumerate() {
        let own = inputs.controls.row(k).iter().fold(0.0f64, |most, u| most.max(u.abs()));
        let floor = first([SMALL * own, force / by_controls[k], 1.0]);
        channel.iter_mut().zip(inputs.controls.row(k).iter()).for_each(|(size, u)| *size = u.abs().max(floor));
    }
    // Design variables are of different kinds, so each has its own size.
    sizes.design = inputs.design.map(|b| first([b.abs(), 1.0]));
    let longest = inputs.grid.steps.iter().fold(0.0f64, |most, dt| most.max(dt.abs()));
    let floor = first([SMALL * longest, 1.0]);
    sizes.grid.steps.iter_mut().zip(&inputs.grid.steps).for_each(|(size, dt)| *size = dt.abs().max(floor));
    sizes
}

/// The first of these that is a normal number.
fn first<const N: usize>(sizes: [f64; N]) -> f64 {
    sizes.into_iter().find(|size| size.is_normal()).unwrap_or(0.0)
}

/// The largest force due to a unit of each control, at the start.
fn largest_by_controls(system: &System, inputs: &Inputs, largest: &dyn Fn(&[f64], i32) -> f64) -> Vec<f64> {
    let (zeros, sigma) = (vec![0.0; system.n()], vec![0.0; system.m()]);
    let design = system.parameters().values(inputs.design.as_slice());
    let state = [inputs.start.q().as_slice(), &zeros, &sigma];
    let at = NodeView::of_equations(state, (inputs.controls_at(0), inputs.grid.start, &design));
    let at = &mut NodeValues::of_equations(&at, Dual64::from_re);
    let [_, force, _] = system.columns(System::plain_sums, at, |at| &mut at.u);
    force.column_iter().map(|column| largest(column.as_slice(), -1)).collect()
}

/// Sizes of the terms of derivatives: rounding of a, b, v and ṗ* changes dJ by 1e-16 of them. If a mechanism is at rest under its weight, the
/// terms of dJ/dΔt cancel and leave rounding; if a mass scales inertia and weight alike, so do those of dJ/db.
///
/// ```text
///   dJ/dΔt_i = −½ (a·(v₋ + v) + b·(ṗ*₋ + ṗ*)) + …      |b·ṗ*| ≤ ‖b‖ ‖ṗ*‖ with Σ m b² and Σ ṗ*²/m, independent of units; |a·v| alike
///   dJ/db    = −½ Σ Δt_i (… + b·(∂Q₋/∂b + ∂Q/∂b)) + …  of the same size over that of b if b is a factor of forces or of masses
/// ```
pub(super) struct Terms {
    /// For each given step, the size of the terms of dJ/dΔt_i.
    by_step: Vec<f64>,
    /// Sum of these times the lengths of the steps.
    of_motion: f64,
    /// The size of the change of each design variable.
    designs: Vec<f64>,
}

impl Terms {
    pub(super) fn new(system: &System, sizes: &Inputs, solver: &mut Solver) -> Self {
        let by_step = terms_by_step(system, solver);
        let of_motion = by_step.iter().zip(&sizes.grid.steps).map(|(size, dt)| size * dt).sum();
        Terms { by_step, of_motion, designs: sizes.design.as_slice().to_vec() }
    }

    /// The size of the terms of dJ along a direction.
    pub(super) fn along(&self, direction: &Inputs) -> f64 {
        let by_steps = self.by_step.iter().zip(&direction.grid.steps).map(|(size, d)| size * d);
        let by_designs = self.designs.iter().zip(direction.design.iter()).map(|(size, d)| self.of_motion * d / size);
        by_steps.chain(by_designs).map(|term| term * term).sum::<f64>().sqrt()
    }
}

fn terms_by_step(system: &System, solver: &mut Solver) -> Vec<f64> {
    let masses = masses(&solver.forward_mut().stepper.newton.linearisation, system);
    let (motion, refinement) = (solver.trajectory(), solver.refinement());
    let taken = solver.inputs().grid.steps.len();
    let mut sizes = vec![0.0; taken - motion.inserted.len()];
    let Some(adjoint) = solver.adjoint_variables() else { return sizes };
    let norm = |x: DVectorView<f64>, power: i32| {
        let terms = x.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(x, mass)| x * x * mass.powi(power));
        terms.sum::<f64>().sqrt()
    };
    for node in 1..=taken {
        let both = |x: &DMatrix<f64>, power| 0.5 * (norm(x.column(node - 1), power) + norm(x.column(node), power));
        let of_a = norm(adjoint.a.column(node), -1) * both(&motion.v, 1);
        let of_b = norm(adjoint.b.column(node), 1) * both(&motion.p_star_dot, -1);
        sizes[refinement.given_step(node) - 1] += of_a + of_b;
    }
    sizes
}
