//! [`Tangent`]: the linearised equations of an assembly, and their transpose.
//!
//! ```text
//!   velocities:    A = [𝓛_vv Φ_qᵀ; Φ_q 0]              at (q₀, v₀, μ)
//!   coordinates:   A = [𝓛_vv + D Φ_qᵀ; Φ_q 0]          at (q₀, w, ν),      D = 𝓛_vq(q₀, w, ν) − 𝓛_vq(q₀, 0, 0)
//! ```

use nalgebra::DVector;

use super::assembler::{Assembler, LEAST_CORRECTIONS_OF_START, MOST_CORRECTIONS_OF_START, UNDERFLOW};
use super::bordered::Bordered;
use crate::motion::{Compliances, OPEN, Which, closed};
use crate::node::Linearisation;
use crate::number::{larger, largest};
use crate::redundancy::masses;
use crate::system::{Covector, NodeView, Pair, StateRows, Sums};
use crate::{Error, System};

/// A correction below this fraction of the solution is rounding.
const ROUNDING: f64 = 1e-16;

/// A at a point, bordered by the held coordinates. GMRES solves with it; the preconditioner is K(0) with |diag D| for D, and with a compliance if
/// constraints depend on each other.
pub(crate) struct Tangent {
    pub(crate) which: Which,
    held: Vec<usize>,
    /// The equations that are open.
    open: Vec<usize>,
    bordered: Bordered,
    /// Second derivatives at (q₀, w, ν) or (q₀, v₀, μ), and at (q₀, 0, 0) or (q₀, v̂, 0).
    pub(crate) moved: Vec<f64>,
    pub(crate) unmoved: Vec<f64>,
}

impl Tangent {
    pub(crate) fn new(
        assembler: &mut Assembler,
        which: Which,
        [moved, unmoved]: [&NodeView<f64>; 2],
        held: &[usize],
        compliances: &Compliances,
    ) -> Result<Self, Error> {
        let mut l_v = vec![0.0; assembler.system.n()];
        let [moved_blocks, unmoved_blocks] = [moved, unmoved].map(|point| {
            assembler.linearisation.l_v(assembler.system, point, &mut l_v, assembler.report);
            assembler.linearisation.evaluation.blocks.clone()
        });
        let bends = match which {
            Which::Coordinates => bends(assembler, [&moved_blocks, &unmoved_blocks]),
            Which::Velocities => Vec::new(),
        };
        let bordered = assembler.factor(moved, held, (compliances, bends))?;
        let open = assembler.open.clone();
        Ok(Tangent { which, held: held.to_vec(), open, bordered, moved: moved_blocks, unmoved: unmoved_blocks })
    }

    /// Computes A x, without the border.
    fn product(&self, system: &System, linearisation: &Linearisation, x: &Pair, sums: &mut Sums<f64>, image: &mut Pair) {
        self.product_of_closed(system, linearisation, x, sums, image);
        self.open.iter().for_each(|&j| image.sigma[j] -= OPEN * x.sigma[j]);
    }

    /// Computes A x, without the border and the compliances of open equations.
    fn product_of_closed(
        &self,
        system: &System,
        linearisation: &Linearisation,
        x: &Pair,
        sums: &mut Sums<f64>,
        image: &mut Pair,
    ) {
        let (none, no_controls) = (vec![0.0; x.v.len()], vec![0.0; system.k()]);
        let along = |q, v, sigma| NodeView::of_equations([q, v, sigma], (&no_controls, 0.0, &[]));
        let evaluation = &linearisation.evaluation;
        if self.which == Which::Velocities {
            evaluation.push_forward(system, &self.moved, &along(&none, &x.v, &x.sigma), sums);
            image.v.copy_from_slice(sums.l_v());
            image.sigma.copy_from_slice(sums.phi_dot());
            return;
        }
        evaluation.push_forward(system, &self.moved, &along(&x.v, &x.v, &x.sigma), sums);
        image.v.copy_from_slice(sums.l_v());
        let no_sigma = vec![0.0; x.sigma.len()];
        evaluation.push_forward(system, &self.unmoved, &along(&x.v, &none, &no_sigma), sums);
        image.v.iter_mut().zip(sums.l_v()).for_each(|(sum, l_v)| *sum -= l_v);
        // dΦ/dt is Φ_q v at this point.
        evaluation.push_forward(system, &self.unmoved, &along(&none, &x.v, &no_sigma), sums);
        image.sigma.copy_from_slice(sums.phi_dot());
    }

    /// Computes Aᵀ (c, e), without the border.
    pub(crate) fn transposed_product(
        &self,
        system: &System,
        linearisation: &Linearisation,
        x: &Pair,
        rows: &mut StateRows,
        image: &mut Pair,
    ) {
        let (none, no_e) = (vec![0.0; x.v.len()], vec![0.0; x.sigma.len()]);
        let evaluation = &linearisation.evaluation;
        if self.which == Which::Velocities {
            evaluation.pull_back(system, &self.moved, &Covector { c: &x.v, d: &none, e: &x.sigma }, rows);
            image.v.copy_from_slice(&rows.v);
            image.sigma.copy_from_slice(&rows.sigma);
            self.open.iter().for_each(|&j| image.sigma[j] -= OPEN * x.sigma[j]);
            return;
        }
        let of_c = Covector { c: &x.v, d: &none, e: &no_e };
        evaluation.pull_back(system, &self.moved, &of_c, rows);
        image.v.iter_mut().zip(rows.v.iter().zip(&rows.q)).for_each(|(sum, (v, q))| *sum = v + q);
        image.sigma.copy_from_slice(&rows.sigma);
        self.open.iter().for_each(|&j| image.sigma[j] -= OPEN * x.sigma[j]);
        evaluation.pull_back(system, &self.unmoved, &of_c, rows);
        image.v.iter_mut().zip(&rows.q).for_each(|(sum, q)| *sum -= q);
        evaluation.pull_back(system, &self.unmoved, &Covector { c: &none, d: &none, e: &x.sigma }, rows);
        image.v.iter_mut().zip(&rows.v).for_each(|(sum, v)| *sum += v);
    }

    /// Solves with the factors alone, without D.
    pub(super) fn step(&self, system: &System, linearisation: &mut Linearisation, left: &mut Pair) {
        self.bordered.solve(system, linearisation, left);
    }

    /// Solves for a correction, which replaces the residual.
    pub(super) fn correct(&self, system: &System, linearisation: &mut Linearisation, left: &mut Pair) {
        let mut sums = Sums::new(system.n(), system.m());
        self.bordered.solve_close(system, linearisation, left, |linearisation, x, image| {
            self.product(system, linearisation, x, &mut sums, image);
        });
    }

    /// Solves for a correction, without the rounding error of dependent constraints, which no motion can correct: their multipliers would grow with
    /// each correction, and derivatives of higher order would never converge.
    pub(super) fn correct_in_range(&self, system: &System, linearisation: &mut Linearisation, left: &mut Pair) {
        let mut within = left.clone();
        self.correct(system, linearisation, left);
        let compliances: Vec<(usize, f64)> = closed(linearisation.evaluation.compliance()).collect();
        if compliances.is_empty() {
            return;
        }
        compliances.iter().for_each(|&(j, mu)| within.sigma[j] += mu * left.sigma[j]);
        *left = within;
        self.correct(system, linearisation, left);
    }

    /// If corrections have stopped shrinking, they are rounding below this fraction of the corrected values.
    pub(super) fn stalled(&self) -> f64 {
        self.bordered.stalled()
    }

    /// The held coordinate with the least freedom.
    pub(super) fn least_free(&self) -> Option<usize> {
        self.bordered.least_free()
    }

    /// Computes A⁻¹ r.
    pub(crate) fn solve(&self, system: &System, linearisation: &mut Linearisation, right: &Pair) -> Result<Pair, Error> {
        let mut sums = Sums::new(system.n(), system.m());
        let product = |linearisation: &Linearisation, x: &Pair, image: &mut Pair| {
            self.product(system, linearisation, x, &mut sums, image)
        };
        self.solve_with(system, linearisation, right, product).map(|(x, _)| x)
    }

    /// Computes (c, e) = A⁻ᵀ r, and E k, the residual in the rows of held coordinates.
    pub(crate) fn solve_transposed(
        &self,
        system: &System,
        linearisation: &mut Linearisation,
        right: &Pair,
    ) -> Result<(Pair, DVector<f64>), Error> {
        let mut rows = StateRows::new(system.n(), system.m());
        let product = |linearisation: &Linearisation, x: &Pair, image: &mut Pair| {
            self.transposed_product(system, linearisation, x, &mut rows, image);
        };
        let (x, left) = self.solve_with(system, linearisation, right, product)?;
        let mut of_held = DVector::zeros(system.n());
        self.held.iter().for_each(|&i| of_held[i] = left.v[i]);
        Ok((x, of_held))
    }

    /// Computes a solution and its residual.
    fn solve_with(
        &self,
        system: &System,
        linearisation: &mut Linearisation,
        right: &Pair,
        mut product: impl FnMut(&Linearisation, &Pair, &mut Pair),
    ) -> Result<(Pair, Pair), Error> {
        let (mut x, mut left) = (Pair::new(system.n(), system.m()), right.clone());
        // Velocities that the right-hand side would cause without constraints: the solution may be zero up to rounding.
        let masses = masses(linearisation, system);
        let sizes = right.v.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(r, mass)| (r / mass).abs());
        let given = sizes.fold(0.0, larger);
        let mut last = f64::INFINITY;
        for corrections in 1..=MOST_CORRECTIONS_OF_START {
            self.bordered.solve_close(system, linearisation, &mut left, &mut product);
            let correction = largest(&left.v);
            x.add(&left);
            product(linearisation, &x, &mut left);
            left.subtract_from(right);
            let size = larger(given, largest(&x.v));
            let is_stalled = correction >= 0.5 * last && correction <= self.stalled() * size;
            let is_done = correction <= larger(ROUNDING * size, UNDERFLOW) || is_stalled;
            if corrections >= LEAST_CORRECTIONS_OF_START && is_done {
                return Ok((x, left));
            }
            last = correction;
        }
        Err(Error::AssemblyStalled { correction: last })
    }
}

/// |D_ii| of the coordinates with D_ii ≠ 0, from the second derivatives at both points.
fn bends(assembler: &Assembler, blocks: [&[f64]; 2]) -> Vec<(usize, f64)> {
    let (system, evaluation) = (assembler.system, &assembler.linearisation.evaluation);
    let (mut sums, zeros, no_controls) =
        (Sums::new(system.n(), system.m()), Pair::new(system.n(), system.m()), vec![0.0; system.k()]);
    let (mut unit, mut bends) = (zeros.v.clone(), Vec::new());
    for uncoupled in system.uncoupled_by_energies_and_constraints() {
        uncoupled.iter().for_each(|&i| unit[i] = 1.0);
        let along = NodeView::of_equations([&unit, &zeros.v, &zeros.sigma], (&no_controls, 0.0, &[]));
        let [moved, unmoved] = blocks.map(|blocks| {
            evaluation.push_forward(system, blocks, &along, &mut sums);
            sums.l_v().to_vec()
        });
        bends.extend(uncoupled.iter().map(|&i| (i, (moved[i] - unmoved[i]).abs())).filter(|(_, bend)| *bend != 0.0));
        uncoupled.iter().for_each(|&i| unit[i] = 0.0);
    }
    bends
}
