//! The assembly of a start: from a guess q̂, v̂ with some coordinates and velocities held to q₀ = q̂ + w and v₀ that satisfy all constraints.
//!
//! ```text
//!   𝓛_v(q₀, w, ν) − 𝓛_v(q₀, 0, 0) + E κ = 0      Φ(q₀, t₀) = 0             Eᵀ w = 0
//!   𝓛_v(q₀, v₀, μ) − 𝓛_v(q₀, v̂, 0) + E κ = 0     dΦ/dt(q₀, v₀, t₀) = 0     Eᵀ (v₀ − v̂) = 0
//! ```
//!
//! E picks what is held. Without it w and v₀ − v̂ are the least changes in the metric of M. Both are solved by Newton's method; its matrix is
//! K(0) = [𝓛_vv Φ_qᵀ; Φ_q 0] bordered by E and, for w, a term that grows with w: products with it come from dual numbers, and K(0) is the
//! preconditioner of GMRES. Constraints that depend on each other get a small compliance in K(0), not in the equations. What solves the equations
//! is differentiated in `adjoint/assembly.rs`.

mod bordered;
mod equations;

pub(crate) use bordered::Bordered;
use equations::{Equations, Tangent, Unknowns, sum};

use nalgebra::DVector;

use crate::forward::rank::Scaled;
use crate::forward::redundancy;
use crate::motion::{Held, Report};
use crate::node::Newton;
use crate::number::{Real, larger, largest};
use crate::system::{Given, KnownPart, NodeView, Pair};
use crate::{Coordinate, Error, Start, System};

const MOST_CORRECTIONS: usize = 50;
/// Multipliers want more than one where K(0) has a compliance, also where coordinates do not move.
pub(crate) const LEAST_CORRECTIONS: usize = 3;
/// A correction below this part of the largest number is rounding …
const ROUNDING: f64 = 1e-15;
/// … and below this one if corrections have stopped shrinking.
const STALLED: f64 = 1e-11;
/// A correction of coordinates is halved so often until Φ gets smaller.
const MOST_HALVINGS: i32 = 12;
/// Below this ratio of a pivot to what was added up in it, constraints may depend on each other.
const SUSPICIOUS: f64 = 1e-10;

/// A start that was assembled, with all that its derivatives need.
pub(crate) struct Assembly {
    /// The guess.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) held: Held,
    /// (w, ν) and (v₀, μ).
    pub(crate) moved: Pair,
    pub(crate) velocity: Pair,
}

/// Where and with what a start is assembled.
pub(crate) struct Assembler<'a> {
    pub(crate) system: &'a System,
    pub(crate) newton: &'a mut Newton,
    pub(crate) report: &'a mut Report,
    /// What may be left of Φ, m or rad.
    pub(crate) tolerance: f64,
}

impl Assembler<'_> {
    /// The start for a guess.
    pub(crate) fn assemble(
        &mut self,
        (q, v, held): (&[f64], &[f64], &Held),
        given: Given,
    ) -> Result<(Start, Assembly), Error> {
        let zeros = [vec![0.0; self.system.n()], vec![0.0; self.system.m()]];
        let mut moved = Unknowns::new(&zeros[0], &zeros[1]);
        self.move_coordinates(q, &indices(&held.coordinates), &mut moved, given)?;
        let q0 = sum(q, &moved.x);
        let mut velocity = Unknowns::new(v, &zeros[1]);
        let bordered = self.factor(&q0, v, &indices(&held.velocities), given)?;
        let equations = Equations::Velocities(&q0, v);
        let tangent = Tangent { bordered, equations, unknowns: Unknowns::new(v, &zeros[1]), given };
        self.correct(&tangent, equations, &mut velocity, given)?;
        let start = Start::Velocity { q: DVector::from_vec(q0), v: DVector::from_column_slice(&velocity.x) };
        let pair = |x: Unknowns<f64>| Pair { v: x.x, sigma: x.multipliers };
        let (moved, velocity) = (pair(moved), pair(velocity));
        Ok((start, Assembly { q: q.to_vec(), v: v.to_vec(), held: held.clone(), moved, velocity }))
    }

    /// The same on other numbers, near a start that was assembled.
    pub(crate) fn lift<R: Real>(
        &mut self,
        (q, v): (&[R], &[R]),
        (assembly, real): (&Assembly, Given),
        given: Given<R>,
    ) -> Result<Start<R>, Error> {
        let near = sum(&assembly.q, &assembly.moved.v);
        let mut moved = Unknowns::new(&assembly.moved.v, &assembly.moved.sigma);
        let bordered = self.factor(&near, &assembly.moved.v, &indices(&assembly.held.coordinates), real)?;
        let (equations, unknowns) =
            (Equations::Coordinates(&assembly.q), Unknowns::new(&assembly.moved.v, &assembly.moved.sigma));
        self.correct(&Tangent { bordered, equations, unknowns, given: real }, Equations::Coordinates(q), &mut moved, given)?;
        let q0 = sum(q, &moved.x);
        let mut velocity = Unknowns::new(&assembly.velocity.v, &assembly.velocity.sigma);
        let held = indices(&assembly.held.velocities);
        // What is held is the guess, derivatives and all.
        held.iter().for_each(|&i| velocity.x[i] = v[i]);
        let bordered = self.factor(&near, &assembly.velocity.v, &held, real)?;
        let unknowns = Unknowns::new(&assembly.velocity.v, &assembly.velocity.sigma);
        let tangent = Tangent { bordered, equations: Equations::Velocities(&near, &assembly.v), unknowns, given: real };
        self.correct(&tangent, Equations::Velocities(&q0, v), &mut velocity, given)?;
        Ok(Start::Velocity { q: DVector::from_vec(q0), v: DVector::from_vec(velocity.x) })
    }

    /// Factors K(0) at a point.
    pub(crate) fn factor(&mut self, q: &[f64], v: &[f64], held: &[usize], given: Given) -> Result<Bordered, Error> {
        let zeros = vec![0.0; self.system.m()];
        factor_state(self.system, self.newton, (&given.at(q, v, &zeros), 0), self.report)?;
        Bordered::new(self.system, self.newton, held)
    }

    /// w and ν from w = 0, with K(0) made anew at every correction.
    fn move_coordinates(&mut self, q: &[f64], held: &[usize], moved: &mut Unknowns<f64>, given: Given) -> Result<(), Error> {
        let (mut left, mut delta) =
            (Unknowns::new(&moved.x, &moved.multipliers), Pair::new(self.system.n(), self.system.m()));
        let (mut worst, mut last) = (self.violation(q, &moved.x, given), f64::INFINITY);
        for corrections in 1..=MOST_CORRECTIONS {
            let bordered = self.factor(&sum(q, &moved.x), &moved.x, held, given)?;
            Equations::Coordinates(q).residual(self.system, moved, given, &mut left);
            left.part(0, &mut delta);
            let unknowns = Unknowns::new(&moved.x, &moved.multipliers);
            let tangent = Tangent { bordered, equations: Equations::Coordinates(q), unknowns, given };
            tangent.solve(self.system, self.newton, &mut delta);
            let step = |share: f64| moved.x.iter().zip(&delta.v).map(|(w, delta)| w - share * delta).collect::<Vec<f64>>();
            let shares = (0..MOST_HALVINGS).map(|k| 0.5f64.powi(k));
            // A comparison is false for a NaN.
            let gets_better = |share: &f64| {
                let after = self.violation(q, &step(*share), given).1;
                after <= worst.1 || after <= self.tolerance
            };
            let Some(share) = shares.into_iter().find(gets_better) else { break };
            let (next, correction) = (step(share), share * largest(&delta.v));
            moved.x.copy_from_slice(&next);
            moved.multipliers.iter_mut().zip(&delta.sigma).for_each(|(nu, delta)| *nu -= delta);
            worst = self.violation(q, &moved.x, given);
            let size = larger(largest(q), largest(&moved.x));
            let is_stalled = correction >= 0.5 * last && correction <= STALLED * size;
            last = correction;
            if corrections >= LEAST_CORRECTIONS && (correction <= ROUNDING * size || is_stalled) {
                break;
            }
        }
        let (equation, violation) = worst;
        // False for a NaN.
        let holds = violation <= self.tolerance;
        if !holds {
            let equation = self.system.equation_name(equation).to_string();
            return Err(Error::Assembly { equation, violation, tolerance: self.tolerance });
        }
        let size = larger(largest(q), largest(&moved.x));
        if last <= STALLED * size { Ok(()) } else { Err(Error::AssemblyStalled { correction: last }) }
    }

    /// The constraint that is violated most at q̂ + w, and by how much.
    fn violation(&self, q: &[f64], w: &[f64], given: Given) -> (usize, f64) {
        let (q, zeros, mut phi) = (sum(q, w), Pair::new(w.len(), self.system.m()), vec![0.0; self.system.m()]);
        self.system.phi(&given.at(&q, &zeros.v, &zeros.sigma), &mut phi);
        let sizes = phi.iter().map(|phi| phi.abs()).enumerate();
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// Corrections of every part by the same tangent until nothing is left but rounding.
    fn correct<R: Real>(
        &mut self,
        tangent: &Tangent,
        equations: Equations<R>,
        unknowns: &mut Unknowns<R>,
        given: Given<R>,
    ) -> Result<(), Error> {
        let (n, m) = (self.system.n(), self.system.m());
        let mut left = Unknowns { x: vec![R::zero(); n], multipliers: vec![R::zero(); m] };
        let (mut delta, mut last) = (Pair::new(n, m), vec![f64::INFINITY; R::PARTS]);
        for corrections in 1..=MOST_CORRECTIONS {
            equations.residual(self.system, unknowns, given, &mut left);
            let mut is_done = true;
            for (k, last) in last.iter_mut().enumerate() {
                left.part(k, &mut delta);
                tangent.solve(self.system, self.newton, &mut delta);
                unknowns.subtract(k, &delta);
                let given = equations.size(k, given);
                let size = unknowns.x.iter().fold(given, |size, x| larger(size, x.part(k).abs()));
                let correction = largest(&delta.v);
                let is_stalled = correction >= 0.5 * *last && correction <= STALLED * size;
                is_done &= correction <= ROUNDING * size || is_stalled;
                *last = correction;
            }
            if corrections >= LEAST_CORRECTIONS && is_done {
                return Ok(());
            }
        }
        Err(Error::AssemblyStalled { correction: largest(&last) })
    }
}

/// Factors K(0) at a state with σ = 0, with compliances if constraints depend on each other; returns the smallest pivot ratio.
pub(crate) fn factor_state(
    system: &System,
    newton: &mut Newton,
    (at, node): (&NodeView<f64>, usize),
    report: &mut Report,
) -> Result<f64, Error> {
    let from = KnownPart { h: 0.0, q: at.q, p_star: &[], sigma: at.sigma };
    let given = Given::from(*at);
    let mut own = Report { worst_pivot: 1.0, ..Report::default() };
    newton.evaluation.set_compliance(&[]);
    let mut factored = newton.factor_at(system, &from, given, (at.v, at.sigma), &mut own);
    if factored.is_err() || own.worst_pivot < SUSPICIOUS {
        let compliances = redundancy::compliances(newton, system, at);
        newton.evaluation.set_compliance(&compliances);
        factored = newton.factor_at(system, &from, given, (at.v, at.sigma), &mut own);
    }
    report.factorisations += own.factorisations;
    factored.map(|()| own.worst_pivot).map_err(|breakdown| {
        let cause = system.find_not_finite(at, node).or_else(|| Scaled::at(system, at)?.explain(system, at.t));
        cause.unwrap_or_else(|| system.singular_step(&breakdown, node, at.t))
    })
}

pub(crate) fn indices(coordinates: &[Coordinate]) -> Vec<usize> {
    coordinates.iter().map(|q| q.index()).collect()
}
