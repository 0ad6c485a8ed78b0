//! One step of the trapezoidal rule, solved by Newton's method (Eq. 2–4).
//!
//! With the half step h = Δt/2, the step from node i−1 to i reads
//!
//! ```text
//!   E1  q − q₋ − h (v + v₋) = 0          E3  𝓛_v(q, v, σ) − p* = 0           E5  dΦ/dt(q, v) = 0
//!   E2  p* − p*₋ − h (g + g₋) = 0        E4  𝓛_q(q, v, σ) + Q(q, v, u) − g = 0
//! ```
//!
//! E1, E2 and E4 give q, p* and g = ṗ* by insertion. What remains are n + m equations in x = (v, σ),
//!
//! ```text
//!   r_v = 𝓛_v − h (𝓛_q + Q) − (p*₋ + h g₋) = 0,      r_σ = dΦ/dt = 0,      K = ∂(r_v, r_σ)/∂(v, σ)
//! ```
//!
//! Node 0 is the same with h = 0.
//!
//! Newton's method on r = L + N, with L linear and K = L′ + N′: after a correction δ with K δ = −r, the new residual is
//!
//! ```text
//!   r(x + δ) = N(x + δ) − N(x) − N′(x) δ
//! ```
//!
//! and with the factors of an earlier point x₀, K(x₀) δ = −r, the same with N′(x₀).
//!
//! Here L includes the constant k. So it is evaluated once per step, at the first guess; and the unknowns that occur in L alone (condensed ones) are eliminated before the
//! first iteration and found after the last.

use crate::evaluation::Evaluation;
use crate::lanes::{all_finite, larger};
use crate::linear::{BlockLu, Breakdown};
use crate::system::{At, Pair};
use crate::trajectory::Report;
use crate::{Settings, System};

/// A residual below this fraction of its terms, times the root of the number of unknowns, is rounding: errors add up along a chain.
const ROUNDING: f64 = 2e-15;
/// Below this fraction it may be, where the sums are long or the masses far apart.
const STALLED: f64 = 1e-10;
/// Relative corrections below this that have stopped shrinking are rounding, whatever the residual: of stiff springs, of large angles.
pub(crate) const NOISE: f64 = 1e-8;

/// Where a step begins, as far as its equations need it: q₋ + h v₋, p*₋ + h g₋, and h.
#[derive(Clone, Copy)]
pub(crate) struct StepStart<'a> {
    pub(crate) h: f64,
    pub(crate) q: &'a [f64],
    pub(crate) p_star: &'a [f64],
}

/// The unknowns of a step and what follows from them; v and σ hold the first guess.
pub(crate) struct Unknowns<'a> {
    pub(crate) q: &'a mut [f64],
    pub(crate) v: &'a mut [f64],
    pub(crate) sigma: &'a mut [f64],
    /// 𝓛_q + Q.
    pub(crate) p_star_dot: &'a mut [f64],
}

/// What stays the same in a step.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) u: &'a [f64],
    pub(crate) t: f64,
    pub(crate) design: &'a [f64],
}

/// Why a step has no solution.
pub(crate) enum StepFailure {
    Singular(Breakdown),
    Diverged { iterations: usize, residual: f64, unknown: usize },
    NotFinite,
}

/// Newton's method for the steps of one system; all vectors are in the solver's order, the condensed unknowns first.
pub(crate) struct Newton {
    pub(crate) evaluation: Evaluation,
    matrix: BlockLu,
    condensed: usize,
    /// The relative residual below which there is nothing but rounding.
    rounding: f64,
    /// (v, σ) of the iterate, and of the first guess.
    x: Vec<f64>,
    guess: Vec<f64>,
    /// N(x) + N′(x) δ of the iterate before, and N(x).
    expected: Vec<f64>,
    nonlinear: Vec<f64>,
    /// −r, then a correction; and −r at the first guess, reduced.
    delta: Vec<f64>,
    reduced: Vec<f64>,
    /// What makes unknowns of different units comparable, and equations.
    of_unknowns: Weights,
    of_equations: Weights,
    /// |v| and |σ| in the weighted maximum norm, which corrections are compared with.
    size: Sizes,
}

/// Factors for what belongs to velocities (0 for the rest) and for what belongs to multipliers (0 for the rest).
struct Weights {
    v: Vec<f64>,
    sigma: Vec<f64>,
}

/// The largest velocity and the largest multiplier, or the largest residuals of their equations.
#[derive(Clone, Copy, Default)]
struct Sizes {
    v: f64,
    sigma: f64,
}

impl Sizes {
    /// This relative to another, the larger of the two ratios.
    fn relative_to(self, other: Sizes) -> f64 {
        let ratio = |x: f64, to: f64| if x == 0.0 { 0.0 } else { x / to };
        ratio(self.v, other.v).max(ratio(self.sigma, other.sigma))
    }
}

impl Weights {
    fn new(len: usize) -> Self {
        Weights { v: vec![0.0; len], sigma: vec![0.0; len] }
    }

    /// The largest weighted entries from position `first` on.
    fn sizes(&self, first: usize, x: &[f64]) -> Sizes {
        let ((v, v_rest), (sigma, sigma_rest)) = (self.v[first..].as_chunks::<2>(), self.sigma[first..].as_chunks::<2>());
        let (x, x_rest) = x[first..].as_chunks::<2>();
        let (mut of_v, mut of_sigma) = ([0.0; 2], [0.0; 2]);
        for (x, (v, sigma)) in x.iter().zip(v.iter().zip(sigma)) {
            for k in 0..2 {
                of_v[k] = larger(of_v[k], (x[k] * v[k]).abs());
                of_sigma[k] = larger(of_sigma[k], (x[k] * sigma[k]).abs());
            }
        }
        for (x, (v, sigma)) in x_rest.iter().zip(v_rest.iter().zip(sigma_rest)) {
            of_v[0] = larger(of_v[0], (x * v).abs());
            of_sigma[0] = larger(of_sigma[0], (x * sigma).abs());
        }
        Sizes { v: larger(of_v[0], of_v[1]), sigma: larger(of_sigma[0], of_sigma[1]) }
    }
}

impl Newton {
    pub(crate) fn new(system: &System) -> Self {
        let zeros = || vec![0.0; system.n() + system.m()];
        Newton {
            evaluation: Evaluation::new(system),
            matrix: BlockLu::new(system.symbolic()),
            condensed: system.symbolic().condensed(),
            rounding: ROUNDING * ((system.n() + system.m()) as f64).sqrt(),
            x: zeros(),
            guess: zeros(),
            expected: zeros(),
            nonlinear: zeros(),
            delta: zeros(),
            reduced: zeros(),
            of_unknowns: Weights::new(system.n() + system.m()),
            of_equations: Weights::new(system.n() + system.m()),
            size: Sizes::default(),
        }
    }

    /// Assembles K(h) from given derivatives and factors it.
    pub(crate) fn factor(&mut self, system: &System, h: f64, blocks: &[f64], report: &mut Report) -> Result<(), Breakdown> {
        self.evaluation.set_step(system, h, &mut self.matrix)?;
        self.evaluation.assemble(system, h, blocks, &mut self.matrix);
        report.factorisations += 1;
        self.matrix.factor(system.symbolic())?;
        report.worst_pivot = report.worst_pivot.min(self.matrix.worst_pivot());
        Ok(())
    }

    /// Takes the roots of the last pivots p for the sizes of unknowns and equations: √p v, σ/√p and so on have one unit, √J, whatever
    /// the units of the coordinates are.
    pub(crate) fn weigh(&mut self, system: &System) {
        let Weights { v, sigma } = &mut self.of_equations;
        v.fill(0.0);
        let roots = self.matrix.reciprocal_pivots(system.symbolic()).map(|reciprocal| reciprocal.abs().sqrt());
        sigma.iter_mut().zip(roots).for_each(|(weight, root)| *weight = root);
        for &position in &system.positions().v {
            v[position] = std::mem::take(&mut sigma[position]);
        }
        let invert = |from: &[f64], to: &mut [f64]| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = if *from > 0.0 { from.recip() } else { 0.0 });
        };
        invert(v, &mut self.of_unknowns.v);
        invert(sigma, &mut self.of_unknowns.sigma);
    }

    /// Factors K(h) at any v and σ.
    pub(crate) fn factor_at(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        (v, sigma): (&[f64], &[f64]),
        report: &mut Report,
    ) -> Result<(), Breakdown> {
        self.load(system, v, sigma);
        self.evaluation.nonlinear_residual(system, from, given, &self.x, &mut self.nonlinear, report);
        let blocks = std::mem::take(&mut self.evaluation.blocks);
        let result = self.factor(system, from.h, &blocks, report);
        self.evaluation.blocks = blocks;
        result
    }

    fn load(&mut self, system: &System, v: &[f64], sigma: &[f64]) {
        let positions = system.positions();
        positions.v.iter().zip(v).for_each(|(&position, &v)| self.x[position] = v);
        positions.sigma.iter().zip(sigma).for_each(|(&position, &sigma)| self.x[position] = sigma);
    }

    /// Solves K x = r in place.
    pub(crate) fn solve(&mut self, system: &System, x: &mut Pair) {
        x.store(system.positions(), &mut self.delta);
        self.matrix.solve(system.symbolic(), &mut self.delta);
        x.load(system.positions(), &self.delta);
    }

    /// Solves Kᵀ x = r for x = (c, e).
    pub(crate) fn solve_transposed(&mut self, system: &System, r: &Pair, c: &mut [f64], e: &mut [f64]) {
        let positions = system.positions();
        r.store(positions, &mut self.delta);
        self.matrix.solve_transposed(system.symbolic(), &mut self.delta);
        c.iter_mut().zip(&positions.v).for_each(|(c, &at)| *c = self.delta[at]);
        e.iter_mut().zip(&positions.sigma).for_each(|(e, &at)| *e = self.delta[at]);
    }

    /// Solves a step; on return `y` is its solution and the evaluation's blocks belong to it.
    pub(crate) fn solve_step(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        y: &mut Unknowns,
        settings: &Settings,
        report: &mut Report,
    ) -> Result<(), StepFailure> {
        let mut scale = self.begin(system, from, given, y, report)?;
        let mut last = f64::INFINITY;
        let mut sizes = self.of_equations.sizes(self.condensed, &self.delta);
        let mut residual = f64::INFINITY;
        let mut reuse = false;
        for iteration in 1..=settings.max_iterations {
            let correction = self.correct(system, from.h, reuse, report)?;
            self.next_residual(system, from, given, report);
            report.newton_iterations += 1;
            report.most_iterations = report.most_iterations.max(iteration);
            if scale == 0.0 {
                // From rest, without forces: what there is of momentum comes from driven joints.
                scale = self.of_equations.sizes(self.condensed, &self.expected).v;
            }
            // Momentum equations against their terms, velocity constraints against the velocities.
            let terms = Sizes { v: scale, sigma: self.size.v };
            let before =
                std::mem::replace(&mut sizes, self.of_equations.sizes(self.condensed, &self.delta)).relative_to(terms);
            residual = sizes.relative_to(terms);
            // The next correction would be smaller than this one as the residual is.
            let next = if residual == 0.0 { 0.0 } else { correction * (residual / before) };
            // Once there is nothing but rounding in the residual, or corrections stop shrinking close to that, nothing is left to gain.
            let is_stalled = correction > 0.25 * last && before <= STALLED || correction >= last && correction <= NOISE;
            let is_rounding = residual <= self.rounding || is_stalled;
            if next <= settings.tolerance || is_rounding {
                report.worst_correction = report.worst_correction.max(next);
                report.worst_residual = report.worst_residual.max(residual);
                return self.finish(system, from, given, y);
            }
            last = correction;
            // The ratio is half the relative change of K, and that is what the old factors would leave of the next correction.
            let left = 2.0 * residual / before;
            reuse = !reuse && (left * next <= settings.tolerance || left * residual <= self.rounding);
        }
        Err(self.diverged(system, settings.max_iterations, residual))
    }

    /// −r at the first guess, reduced; returns the size of the terms in r, p*₋ + h g₋.
    fn begin(
        &mut self,
        system: &System,
        from: &StepStart,
        given: Given,
        y: &Unknowns,
        report: &mut Report,
    ) -> Result<f64, StepFailure> {
        self.load(system, y.v, y.sigma);
        self.size = self.of_unknowns.sizes(0, &self.x);
        self.guess.copy_from_slice(&self.x);
        self.evaluation.set_step(system, from.h, &mut self.matrix).map_err(StepFailure::Singular)?;
        self.evaluation.linear_residual(system, from, given, &self.x, &mut self.delta);
        self.nonlinear.fill(0.0);
        self.evaluation.nonlinear_residual(system, from, given, &self.x, &mut self.nonlinear, report);
        for (r, n) in self.delta.iter_mut().zip(&self.nonlinear) {
            *r = -(*r + n);
        }
        self.matrix.reduce(system.symbolic(), &mut self.delta);
        self.reduced[..self.condensed].copy_from_slice(&self.delta[..self.condensed]);
        let terms = system.positions().v.iter().zip(from.p_star);
        Ok(terms.fold(0.0, |size, (&position, p)| larger(size, (p * self.of_equations.v[position]).abs())))
    }

    /// One correction of the unknowns that are not condensed, K δ = −r and x += δ; returns its relative size.
    ///
    /// K is that of the present point, or, if its factors will do, of the point before.
    fn correct(&mut self, system: &System, h: f64, old_factors: bool, report: &mut Report) -> Result<f64, StepFailure> {
        if old_factors {
            report.reused_factors += 1;
            self.matrix.solve_reduced(system.symbolic(), &mut self.delta);
        } else {
            self.evaluation.assemble(system, h, &self.evaluation.blocks, &mut self.matrix);
            self.evaluation.keep_blocks();
            report.factorisations += 1;
            let solved = self.matrix.factor_and_solve_reduced(system.symbolic(), &mut self.delta);
            solved.map_err(StepFailure::Singular)?;
            report.worst_pivot = report.worst_pivot.min(self.matrix.worst_pivot());
        }
        let free = self.condensed..;
        self.x[free.clone()].iter_mut().zip(&self.delta[free.clone()]).for_each(|(x, delta)| *x += delta);
        if self.size.v == 0.0 || self.size.sigma == 0.0 {
            self.size = self.of_unknowns.sizes(self.condensed, &self.x);
        }
        let correction = self.of_unknowns.sizes(self.condensed, &self.delta).relative_to(self.size);
        self.expected[free.clone()].copy_from_slice(&self.nonlinear[free]);
        self.evaluation.multiply(system, h, &self.delta, &mut self.expected);
        Ok(correction)
    }

    /// −r = N(x − δ) + N′(x − δ) δ − N(x).
    fn next_residual(&mut self, system: &System, from: &StepStart, given: Given, report: &mut Report) {
        let free = self.condensed..;
        self.nonlinear[free.clone()].fill(0.0);
        self.evaluation.nonlinear_residual(system, from, given, &self.x, &mut self.nonlinear, report);
        let terms = self.expected[free.clone()].iter().zip(&self.nonlinear[free.clone()]);
        for (r, (expected, now)) in self.delta[free].iter_mut().zip(terms) {
            *r = expected - now;
        }
    }

    /// The condensed unknowns, q and 𝓛_q + Q at the solution.
    fn finish(&mut self, system: &System, from: &StepStart, given: Given, y: &mut Unknowns) -> Result<(), StepFailure> {
        let (condensed, total) = self.delta.split_at_mut(self.condensed);
        condensed.copy_from_slice(&self.reduced[..self.condensed]);
        for ((total, x), guess) in total.iter_mut().zip(&self.x[self.condensed..]).zip(&self.guess[self.condensed..]) {
            *total = x - guess;
        }
        self.matrix.expand(system.symbolic(), &mut self.delta);
        for (x, delta) in self.x[..self.condensed].iter_mut().zip(&self.delta) {
            *x += delta;
        }
        let positions = system.positions();
        for ((v, q), (&position, start)) in y.v.iter_mut().zip(y.q.iter_mut()).zip(positions.v.iter().zip(from.q)) {
            *v = self.x[position];
            *q = start + from.h * *v;
        }
        y.sigma.iter_mut().zip(&positions.sigma).for_each(|(sigma, &position)| *sigma = self.x[position]);
        y.p_star_dot.fill(0.0);
        let at = At { q: y.q, v: y.v, sigma: y.sigma, u: given.u, t: given.t, design: given.design };
        self.evaluation.add_force(&at, y.p_star_dot);
        let finite = all_finite(y.p_star_dot) && all_finite(y.q) && all_finite(y.sigma);
        if finite { Ok(()) } else { Err(StepFailure::NotFinite) }
    }

    fn diverged(&self, system: &System, iterations: usize, residual: f64) -> StepFailure {
        let size = |position: &usize| self.delta[*position].abs();
        let free = self.condensed..self.delta.len();
        let worst = free.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let positions = system.positions();
        let all = positions.v.iter().chain(&positions.sigma);
        let unknown = all.clone().position(|&position| position == worst).unwrap_or(0);
        StepFailure::Diverged { iterations, residual, unknown }
    }
}
