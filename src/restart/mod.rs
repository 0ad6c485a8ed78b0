//! Restarts inside a motion: the position constraints are satisfied again, and the multipliers begin at zero again.
//!
//! The paper's scheme satisfies dΦ/dt = 0 to rounding and lets Φ drift with O(Δt²); and |σ| grows like ∫λ dt, so that p* = M v + Φ_qᵀσ loses
//! digits in the long run. At a restart the state (q⁻, v⁻) of a node is replaced by
//!
//! ```text
//!   projection   q = q⁻ + w  with  M(q) w + Φ_q(q)ᵀ ν = 0,  Φ(q, t) = 0        (only if Φ is to be satisfied)
//!   rebasing     p* = T_v(q, v⁻) + Φ_q(q)ᵀ s,   then v and σ from Eq. (1a) and (1c)
//! ```
//!
//! which is a start as at node 0. Since a step from any (q, p*) is of order two, so is the motion.
//!
//! **Where σ begins.** With s = 0 it would run from 0 to its range R = ∫λ dt until the next restart, r nodes on. A motion looks the same
//! forth and back in time, and its energy does not drift, if σ runs from −½ R to ½ R instead. The r steps S and the reversal ρ: (v, σ) → (−v, −σ) satisfy
//! ρ S ρ = S⁻¹; with F: σ → −σ so does F S, for ρ F in the place of ρ:
//!
//! ```text
//!   ρ S ρ = S⁻¹,  F F = 1,  ρ F = F ρ      ⟹      (ρF) (F S) (ρF) = S⁻¹ F = (F S)⁻¹
//! ```
//!
//! So s = −σ⁻ is reversible whatever r and σ are, once σ has been put in the middle of its range by the first restart:
//!
//! ```text
//!   s = −½ r (σ⁻ − σ₋)     for r = 1, at the first restart, and where |σ⁻| is twice all r |σ⁻ − σ₋| so far     (σ₋: a node before)
//!   s = −σ⁻                at all others
//! ```
//!
//! For r = 1 both are the same to O(Δt²), and the first forgets what happened before. The second does not: forces that change at random make
//! the middle of σ wander, in proportion to the root of the time, which is what the bound is for.
//! The projection is 𝓛_v(q, w, ν) = 0 for a kinetic energy that is quadratic in v, so the
//! same elements serve it, and the adjoint goes back through all of it: with Ĵ_q, π for dJ/dq and dJ/dp* of the restarted motion,
//!
//! ```text
//!   Ĵ_q += 𝓛_vqᵀ π      dJ/dv⁻ = 𝓛_vvᵀ π      dJ/ds = Φ_q π      at (q, v⁻, s),   s = α σ⁻ + β σ₋
//!   (𝓛_vv + 𝓛_vq)ᵀ c + Φ_qᵀ e = −Ĵ_q,      Φ_q c = 0,      dJ/dq⁻ = −𝓛_vvᵀ c      at (q, w, ν)
//! ```

mod adjoint;

use crate::lanes::{larger, largest};
use crate::scalar::Real;
use crate::simulate::Forward;
use crate::step::StepFailure;
use crate::system::{At, Pair};
use crate::trajectory::{column, column_mut};
use crate::{Error, Settings, System};

/// A projection that has not converged after so many corrections does not.
const MOST_CORRECTIONS: usize = 25;
/// So many times the largest range away from zero, σ is put in the middle of its range again.
const WANDERED: f64 = 2.0;
/// Momenta at rest below this fraction of those of the motion are rounding.
const LINEAR: f64 = 1e-12;
/// A correction below this fraction of the largest coordinate is rounding.
const ROUNDING: f64 = 1e-15;

/// The nodes at which a motion was restarted, and what was there before; one run of numbers after the other.
#[derive(Default)]
pub(crate) struct Restarts {
    pub(crate) nodes: Vec<usize>,
    /// Whether Φ = 0 was restored, by restart.
    projected: Vec<bool>,
    q: Vec<f64>,
    v: Vec<f64>,
    p_star_dot: Vec<f64>,
    sigma: Vec<f64>,
    nu: Vec<f64>,
    /// α and β in s = α σ⁻ + β σ₋.
    weights: Vec<[f64; 2]>,
    /// Second derivatives at the end of the step, at (q, v⁻, s) and at (q, w, ν).
    step_blocks: Vec<f64>,
    momentum_blocks: Vec<f64>,
    projection_blocks: Vec<f64>,
}

/// One restart.
#[derive(Clone, Copy)]
pub(crate) struct Restart<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) p_star_dot: &'a [f64],
    pub(crate) sigma: &'a [f64],
    /// α and β in s = α σ⁻ + β σ₋.
    pub(crate) weights: [f64; 2],
    pub(crate) step_blocks: &'a [f64],
    pub(crate) momentum_blocks: &'a [f64],
    /// ν and the second derivatives, if Φ = 0 was restored.
    pub(crate) projection: Option<(&'a [f64], &'a [f64])>,
}

impl Restarts {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.projected.clear();
        self.weights.clear();
        let lists = [&mut self.q, &mut self.v, &mut self.p_star_dot, &mut self.sigma, &mut self.nu];
        let blocks = [&mut self.step_blocks, &mut self.momentum_blocks, &mut self.projection_blocks];
        lists.into_iter().chain(blocks).for_each(Vec::clear);
    }

    /// The restart at a node.
    pub(crate) fn at(&self, node: usize) -> Option<Restart<'_>> {
        let which = self.nodes.binary_search(&node).ok()?;
        let count = self.nodes.len();
        let part = |list: &'_ Vec<f64>| {
            let len = list.len() / count;
            which * len..(which + 1) * len
        };
        let of = |list| &(list as &Vec<f64>)[part(list)];
        Some(Restart {
            q: of(&self.q),
            v: of(&self.v),
            p_star_dot: of(&self.p_star_dot),
            sigma: of(&self.sigma),
            weights: self.weights[which],
            step_blocks: of(&self.step_blocks),
            momentum_blocks: of(&self.momentum_blocks),
            projection: self.projected[which].then(|| (of(&self.nu), of(&self.projection_blocks))),
        })
    }
}

impl Restart<'_> {
    /// Where σ begins, from σ₋ and σ⁻.
    pub(crate) fn begin<R: Real>(&self, before: R, now: R) -> R {
        now * self.weights[0] + before * self.weights[1]
    }
}

/// Restarts the motion at a node, if it is due there.
pub(crate) fn apply(forward: &mut Forward, system: &System, node: usize, settings: &Settings) -> Result<(), Error> {
    let rebase = settings.rebase_every > 0 && node.is_multiple_of(settings.rebase_every);
    // With a bound of 0.0 at every node, also where rounding happens to leave Φ = 0.
    let may_drift = settings.drift_bound < f64::INFINITY && system.m() > 0;
    let project = may_drift && drift(forward, system, node) >= settings.drift_bound;
    if !rebase && !project {
        return Ok(());
    }
    let result = restart(forward, system, node, project, settings);
    result.map_err(|failure| forward.explain(system, node, failure))?;
    forward.check_compliant(system, node, settings)
}

/// ‖Φ‖∞ at a node.
fn drift(forward: &mut Forward, system: &System, node: usize) -> f64 {
    forward.evaluate_phi(system, node);
    largest(&forward.phi)
}

fn restart(
    forward: &mut Forward,
    system: &System,
    node: usize,
    project: bool,
    settings: &Settings,
) -> Result<(), StepFailure> {
    let k = node - forward.first;
    let weights = weights(forward, system, k, settings);
    forward.trajectory.restarted.push(node);
    let (restarts, y) = (&mut forward.restarts, forward.trajectory.columns(k));
    restarts.weights.push(weights);
    restarts.nodes.push(node);
    restarts.projected.push(project);
    restarts.q.extend_from_slice(y.q);
    restarts.v.extend_from_slice(y.v);
    restarts.p_star_dot.extend_from_slice(y.p_star_dot);
    restarts.sigma.extend_from_slice(y.sigma);
    restarts.step_blocks.extend_from_slice(column(&forward.blocks, k));
    forward.report.restarts += 1;
    let mut at = std::mem::take(&mut forward.restarting);
    at.q.copy_from_slice(column(&forward.trajectory.q, k));
    at.x.v.copy_from_slice(column(&forward.trajectory.v, k));
    at.x.sigma.fill(0.0);
    let projected = if project { projection(forward, system, node, &mut at) } else { Ok(()) };
    if !project {
        // As long as those of a projection, so that all runs of numbers have one length.
        forward.restarts.nu.extend_from_slice(&at.x.sigma);
        forward.restarts.projection_blocks.extend_from_slice(&forward.newton.evaluation.blocks);
    }
    let done = projected.and_then(|()| {
        at.x.v.copy_from_slice(column(&forward.trajectory.v, k));
        for (j, s) in at.x.sigma.iter_mut().enumerate() {
            *s = weights[0] * forward.trajectory.sigma[(j, k)] + weights[1] * forward.trajectory.sigma[(j, k - 1)];
        }
        l_v(forward, system, node, &mut at);
        forward.restarts.momentum_blocks.extend_from_slice(&forward.newton.evaluation.blocks);
        forward.set_start(&at.q, &at.left.v, &at.x.sigma);
        column_mut(&mut forward.trajectory.sigma, k).copy_from_slice(&at.x.sigma);
        forward.solve_node(system, node, 0.0, settings)
    });
    column_mut(&mut forward.trajectory.p_star, k).copy_from_slice(&at.left.v);
    forward.restarting = at;
    forward.smooth_from = node;
    done
}

/// α and β of the restart at column k.
fn weights(forward: &mut Forward, system: &System, k: usize, settings: &Settings) -> [f64; 2] {
    let every = settings.rebase_every.max(1) as f64;
    let [before, now] = [k - 1, k].map(|k| column(&forward.trajectory.sigma, k));
    let (weights, positions) = (&forward.newton.weights, system.positions());
    let range = weights.of_multipliers(positions, now.iter().zip(before).map(|(now, before)| every * (now - before)));
    let size = weights.of_multipliers(positions, now.iter().copied());
    forward.most_range = larger(forward.most_range, range);
    let is_first = forward.trajectory.restarted.is_empty();
    let anew = every == 1.0 || is_first || size > WANDERED * forward.most_range;
    if anew { [-0.5 * every, 0.5 * every] } else { [-1.0, 0.0] }
}

/// A point (q, x), and 𝓛_v and Φ there.
#[derive(Default)]
pub(crate) struct Point {
    pub(crate) q: Vec<f64>,
    pub(crate) x: Pair,
    pub(crate) left: Pair,
}

impl Point {
    pub(crate) fn new(n: usize, m: usize) -> Self {
        Point { q: vec![0.0; n], x: Pair::new(n, m), left: Pair::new(n, m) }
    }
}

fn l_v(forward: &mut Forward, system: &System, node: usize, at: &mut Point) {
    let (u, t) = (column(&forward.inputs.controls, node), forward.trajectory.times[node - forward.first]);
    let point = At { q: &at.q, v: &at.x.v, sigma: &at.x.sigma, u, t, design: forward.inputs.design.as_slice() };
    forward.newton.l_v(system, &point, &mut at.left.v, &mut forward.report);
}

/// q = q⁻ + w, by corrections with K(0) at q⁻.
fn projection(forward: &mut Forward, system: &System, node: usize, at: &mut Point) -> Result<(), StepFailure> {
    let k = node - forward.first;
    l_v(forward, system, node, at);
    let blocks = std::mem::take(&mut forward.newton.evaluation.blocks);
    let factored = forward.newton.factor(system, 0.0, &blocks, &mut forward.report);
    forward.newton.evaluation.blocks = blocks;
    factored.map_err(StepFailure::Singular)?;
    let momentum = largest(&at.left.v);
    at.x.v.fill(0.0);
    let mut last = f64::INFINITY;
    for corrections in 0..MOST_CORRECTIONS {
        l_v(forward, system, node, at);
        if corrections == 0 {
            check_quadratic(&at.left.v, momentum)?;
        }
        at.left.sigma.fill(0.0);
        let (t, design) = (forward.trajectory.times[k], forward.inputs.design.as_slice());
        system.phi(&At { q: &at.q, v: &at.x.v, sigma: &at.x.sigma, u: &[], t, design }, &mut at.left.sigma);
        for &(j, mu) in &forward.trajectory.compliance {
            at.left.sigma[j] -= mu * at.x.sigma[j];
        }
        forward.newton.solve(system, &mut at.left);
        let correction = largest(&at.left.v);
        let is_rounding = correction <= ROUNDING * largest(&at.q);
        if is_rounding || corrections > 3 && correction >= 0.5 * last {
            // The blocks are those of this point.
            forward.restarts.nu.extend_from_slice(&at.x.sigma);
            forward.restarts.projection_blocks.extend_from_slice(&forward.newton.evaluation.blocks);
            column_mut(&mut forward.trajectory.q, k).copy_from_slice(&at.q);
            return if is_rounding || correction <= 1e-13 * largest(&at.q) {
                Ok(())
            } else {
                Err(failed(corrections, correction))
            };
        }
        last = correction;
        let before = column(&forward.trajectory.q, k);
        for (i, w) in at.x.v.iter_mut().enumerate() {
            *w -= at.left.v[i];
            at.q[i] = before[i] + *w;
        }
        at.x.sigma.iter_mut().zip(&at.left.sigma).for_each(|(nu, delta)| *nu -= delta);
    }
    Err(failed(MOST_CORRECTIONS, last))
}

/// Refuses T_v(q, 0) ≠ 0, by which q would be moved though Φ = 0.
fn check_quadratic(at_rest: &[f64], momentum: f64) -> Result<(), StepFailure> {
    let linear = |p: &f64| p.abs() > LINEAR * momentum;
    let Some(first) = at_rest.iter().position(linear) else { return Ok(()) };
    let larger = |most: usize, i: usize| if at_rest[i].abs() > at_rest[most].abs() { i } else { most };
    let coordinate = (0..at_rest.len()).fold(first, larger);
    Err(StepFailure::LinearEnergy { coordinate, momentum: at_rest[coordinate] })
}

fn failed(iterations: usize, correction: f64) -> StepFailure {
    StepFailure::Projection { iterations, correction }
}
