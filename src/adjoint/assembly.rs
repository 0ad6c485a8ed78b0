//! Back through the assembly of a start: from dJ/dq₀ and dJ/dv₀ to the guess and to the parameters, by its equations (`forward/assembly/`).
//!
//! ```text
//!   velocities:   [𝓛_vv Φ_qᵀ E; Φ_q 0 0; Eᵀ 0 0] (c, e, k) = (v̄, 0, 0)       dJ/dv̂ = 𝓛_vv c + E k
//!                 q̄ −= (𝓛_vq(q₀, v₀, μ) − 𝓛_vq(q₀, v̂, 0))ᵀ c + (dΦ/dt)_qᵀ e
//!   coordinates:  the same with 𝓛_vv + Dᵀ in the place of 𝓛_vv, and q̄,        dJ/dq̂ = 𝓛_vv c + E k
//!                 D = 𝓛_vq(q₀, w, ν) − 𝓛_vq(q₀, 0, 0)
//! ```
//!
//! Solved by GMRES with the bordered K(0) as preconditioner, which has neither D nor is without a compliance where constraints depend on each other.

use nalgebra::DVector;

use super::sweep::AdjointSweep;
use crate::forward::assembly::{Assembler, Bordered, LEAST_CORRECTIONS, indices};
use crate::forward::redundancy::masses;
use crate::forward::{Assembly, Motion};
use crate::node::Newton;
use crate::number::{larger, largest};
use crate::system::{Covector, Given, InputRows, NodeView, Pair, StateRows};
use crate::{Error, Start, System};

const MOST_CORRECTIONS: usize = 50;
const ROUNDING: f64 = 1e-16;
/// Corrections that stop shrinking above this part of the solution do not converge.
const STALLED: f64 = 1e-10;

/// The second derivatives at the two points of one system of equations.
struct Blocks {
    moved: Vec<f64>,
    unmoved: Vec<f64>,
}

impl AdjointSweep {
    /// Replaces the derivatives with respect to q₀ and v₀ by those with respect to the guess.
    pub(super) fn through_assembly(&mut self, system: &System, motion: &Motion, newton: &mut Newton) -> Result<(), Error> {
        let Some(assembly) = &motion.assembly else { return Ok(()) };
        let mut q_bar = self.gradient.start.q().clone();
        let v_bar = self.gradient.start.rate().clone();
        let v = self.through_velocities(system, motion, (newton, assembly), v_bar.as_slice(), q_bar.as_mut_slice())?;
        let q = self.through_coordinates(system, motion, (newton, assembly), q_bar.as_slice())?;
        newton.evaluation.set_compliance(&motion.trajectory.compliance);
        let held = assembly.held.clone();
        self.gradient.start = Start::Assembled { q: DVector::from_vec(q), v: DVector::from_vec(v), held };
        Ok(())
    }

    fn through_velocities(
        &mut self,
        system: &System,
        motion: &Motion,
        (newton, assembly): (&mut Newton, &Assembly),
        v_bar: &[f64],
        q_bar: &mut [f64],
    ) -> Result<Vec<f64>, Error> {
        let (n, m) = (system.n(), system.m());
        let (here, none) = (motion.at(0), vec![0.0; m]);
        let q0 = motion.inputs.start.q().as_slice();
        let moved = NodeView { q: q0, v: &assembly.velocity.v, sigma: &assembly.velocity.sigma, ..here };
        let unmoved = NodeView { v: &assembly.v, sigma: &none, ..moved };
        let blocks = self.blocks_at(system, newton, [&moved, &unmoved]);
        let held = indices(&assembly.held.velocities);
        let bordered = self.factor(system, newton, (q0, &assembly.velocity.v, &held), here.into())?;
        let mut rows = StateRows::new(n, m);
        let zeros = vec![0.0; n];
        let product = |newton: &Newton, x: &Pair, product: &mut Pair| {
            let with = Covector { c: &x.v, d: &zeros, e: &x.sigma };
            newton.evaluation.pull_back(system, &blocks.moved, &with, &mut rows);
            product.v.copy_from_slice(&rows.v);
            product.sigma.copy_from_slice(&rows.sigma);
        };
        let (x, k) = solve(system, newton, (&bordered, &held), v_bar, product)?;
        let mut rows = StateRows::new(n, m);
        newton.evaluation.pull_back(system, &blocks.moved, &Covector { c: &x.v, d: &zeros, e: &x.sigma }, &mut rows);
        q_bar.iter_mut().zip(&rows.q).for_each(|(q, row)| *q -= row);
        newton.evaluation.pull_back(system, &blocks.unmoved, &Covector { c: &x.v, d: &zeros, e: &none }, &mut rows);
        q_bar.iter_mut().zip(&rows.q).for_each(|(q, row)| *q += row);
        let minus = x.negative();
        self.add_parameters(system, newton, &moved, &Covector { c: &minus.v, d: &zeros, e: &minus.sigma });
        self.add_parameters(system, newton, &unmoved, &Covector { c: &x.v, d: &zeros, e: &none });
        Ok(with_held(rows.v, &held, &k))
    }

    fn through_coordinates(
        &mut self,
        system: &System,
        motion: &Motion,
        (newton, assembly): (&mut Newton, &Assembly),
        q_bar: &[f64],
    ) -> Result<Vec<f64>, Error> {
        let (n, m) = (system.n(), system.m());
        let (here, zeros) = (motion.at(0), Pair::new(n, m));
        let q0 = motion.inputs.start.q().as_slice();
        let moved = NodeView { q: q0, v: &assembly.moved.v, sigma: &assembly.moved.sigma, ..here };
        let unmoved = NodeView { v: &zeros.v, sigma: &zeros.sigma, ..moved };
        let blocks = self.blocks_at(system, newton, [&moved, &unmoved]);
        let held = indices(&assembly.held.coordinates);
        let bordered = self.factor(system, newton, (q0, &assembly.moved.v, &held), here.into())?;
        let mut rows = StateRows::new(n, m);
        let product = |newton: &Newton, x: &Pair, product: &mut Pair| {
            let of_c = Covector { c: &x.v, d: &zeros.v, e: &zeros.sigma };
            newton.evaluation.pull_back(system, &blocks.moved, &of_c, &mut rows);
            product.v.iter_mut().zip(rows.v.iter().zip(&rows.q)).for_each(|(sum, (v, q))| *sum = v + q);
            product.sigma.copy_from_slice(&rows.sigma);
            newton.evaluation.pull_back(system, &blocks.unmoved, &of_c, &mut rows);
            product.v.iter_mut().zip(&rows.q).for_each(|(sum, q)| *sum -= q);
            let of_e = Covector { c: &zeros.v, d: &zeros.v, e: &x.sigma };
            newton.evaluation.pull_back(system, &blocks.unmoved, &of_e, &mut rows);
            product.v.iter_mut().zip(&rows.v).for_each(|(sum, v)| *sum += v);
        };
        let (x, k) = solve(system, newton, (&bordered, &held), q_bar, product)?;
        let mut rows = StateRows::new(n, m);
        let of_c = Covector { c: &x.v, d: &zeros.v, e: &zeros.sigma };
        newton.evaluation.pull_back(system, &blocks.moved, &of_c, &mut rows);
        let minus = x.negative();
        self.add_parameters(system, newton, &moved, &Covector { c: &minus.v, d: &zeros.v, e: &zeros.sigma });
        self.add_parameters(system, newton, &unmoved, &of_c);
        let of_phi = |rows: &mut InputRows| {
            system.batches().iter().for_each(|batch| batch.pull_back_phi(&unmoved, &minus.sigma, rows));
        };
        self.with_parameters(system, of_phi);
        Ok(with_held(rows.v, &held, &k))
    }

    fn blocks_at(&mut self, system: &System, newton: &mut Newton, points: [&NodeView<f64>; 2]) -> Blocks {
        let mut l_v = vec![0.0; system.n()];
        let [moved, unmoved] = points.map(|point| {
            newton.l_v(system, point, &mut l_v, &mut self.report);
            newton.evaluation.blocks.clone()
        });
        Blocks { moved, unmoved }
    }

    fn factor(
        &mut self,
        system: &System,
        newton: &mut Newton,
        (q, v, held): (&[f64], &[f64], &[usize]),
        given: Given,
    ) -> Result<Bordered, Error> {
        Assembler { system, newton, report: &mut self.report, tolerance: 0.0 }.factor(q, v, held, given)
    }

    /// Adds derivatives with respect to parameters alone: the controls and the time of a start are no guess.
    fn with_parameters(&mut self, system: &System, add: impl FnOnce(&mut InputRows)) {
        let (mut u, mut time) = (vec![0.0; system.k()], 0.0);
        let (design, evaluations) = (self.design.as_mut_slice(), &mut self.report.input_evaluations);
        add(&mut InputRows { u: &mut u, design, time: &mut time, evaluations });
    }

    fn add_parameters(&mut self, system: &System, newton: &mut Newton, at: &NodeView<f64>, with: &Covector) {
        self.with_parameters(system, |rows| newton.evaluation.pull_back_inputs(system, at, with, rows));
    }
}

fn with_held(mut row: Vec<f64>, held: &[usize], k: &DVector<f64>) -> Vec<f64> {
    held.iter().zip(k).for_each(|(&i, k)| row[i] += k);
    row
}

/// (c, e) and k for a right-hand side (r, 0, 0), given the product of the matrix without E with (c, e).
fn solve(
    system: &System,
    newton: &mut Newton,
    (bordered, held): (&Bordered, &[usize]),
    right: &[f64],
    mut product: impl FnMut(&Newton, &Pair, &mut Pair),
) -> Result<(Pair, DVector<f64>), Error> {
    let (n, m) = (system.n(), system.m());
    let right = Pair { v: right.to_vec(), sigma: vec![0.0; m] };
    let (mut x, mut left) = (Pair::new(n, m), right.clone());
    // The velocities that the right-hand side makes without constraints: the solution may vanish but for its rounding.
    let masses = masses(newton, system);
    let sizes = right.v.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(r, mass)| (r / mass).abs());
    let given = sizes.fold(0.0, larger);
    let mut last = f64::INFINITY;
    for corrections in 1..=MOST_CORRECTIONS {
        bordered.solve_close(system, newton, &mut left, &mut product);
        let correction = largest(&left.v);
        x.add(&left);
        product(newton, &x, &mut left);
        left.subtract_from(&right);
        let size = larger(given, largest(&x.v));
        let is_done = correction <= ROUNDING * size || correction >= 0.5 * last && correction <= STALLED * size;
        if corrections >= LEAST_CORRECTIONS && is_done {
            // E k makes up for what is left in the rows of what is held.
            let k = DVector::from_iterator(held.len(), held.iter().map(|&i| left.v[i]));
            return Ok((x, k));
        }
        last = correction;
    }
    Err(Error::AssemblyStalled { correction: last })
}
