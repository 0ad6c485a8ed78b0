//! The coordinates of a start: Newton's method for w and ν, with loops that have the more compliance the farther they are from closing.

use std::ops::Range;

use super::assembler::{Assembler, LEAST_CORRECTIONS_OF_START, MOST_CORRECTIONS_OF_START, ROUNDING, UNDERFLOW};
use super::equations::{Unknowns, sum};
use super::tangent::Tangent;
use crate::motion::Which;
use crate::number::{larger, largest};
use crate::redundancy::{self, COMPLIANCE};
use crate::system::{Given, NodeView, Pair};
use crate::{Error, System};

/// Largest number of halvings of a correction until Φ decreases.
const MOST_HALVINGS: i32 = 12;
/// Largest compliance of a loop, relative to its own flexibility.
pub(super) const SOFTEST: f64 = 1e-1;

/// How the corrections to a start were made.
pub(super) enum Way {
    /// All corrections had full length.
    Straight,
    /// Some corrections were shortened.
    Halved,
}

/// √(Φ_q M⁻¹ Φ_qᵀ)_jj of all equations, and the largest √m |q| of the guess, with the diagonal of M.
pub(super) struct Sizes {
    equations: Vec<f64>,
    guess: f64,
}

impl Assembler<'_> {
    /// Solves for w and ν, starting from w = 0.
    pub(super) fn move_coordinates(
        &mut self,
        q: &[f64],
        held: &[usize],
        moved: &mut Pair,
        given: Given,
    ) -> Result<(), Error> {
        let (zeros, mut far) = (moved.clone(), moved.clone());
        let direct = match self.approach((q, held), moved, given, SOFTEST) {
            Ok(Way::Straight) => return Ok(()),
            Err(error) if !matches!(error, Error::Assembly { .. } | Error::AssemblyStalled { .. }) => return Err(error),
            direct => direct,
        };
        // Shortened corrections may have led to a distant solution.
        let around = self.come_from_far((q, held), &mut far, given);
        let is_nearer =
            around.is_ok() && (direct.is_err() || self.square(q, &far.v, given) < self.square(q, &moved.v, given));
        if is_nearer {
            moved.clone_from(&far);
        }
        if is_nearer || direct.is_ok() {
            return Ok(());
        }
        moved.clone_from(&zeros);
        self.approach((q, held), moved, given, 0.0).map(|_| ()).or(around)
    }

    /// wᵀM w at q̂ + w.
    fn square(&mut self, q: &[f64], w: &[f64], given: Given) -> f64 {
        let (q0, zeros) = (sum(q, w), Pair::new(self.system.n(), self.system.m()));
        let (momentum, at_rest) =
            (self.l_v(&given.at(&q0, w, &zeros.sigma)), self.l_v(&given.at(&q0, &zeros.v, &zeros.sigma)));
        w.iter().zip(momentum.iter().zip(&at_rest)).map(|(w, (p, at_rest))| w * (p - at_rest)).sum()
    }

    /// Solves for w and ν, starting from the given ones, with a new K(0) at every correction and compliances of loops up to `softest`.
    pub(super) fn approach(
        &mut self,
        (q, held): (&[f64], &[usize]),
        moved: &mut Pair,
        given: Given,
        softest: f64,
    ) -> Result<Way, Error> {
        let zeros = Pair::new(self.system.n(), self.system.m());
        let (mut left, mut delta) = (Unknowns::new(&zeros.v, &zeros.sigma), zeros.clone());
        let (mut sizes, mut last, mut stalled, mut way) = (None, f64::INFINITY, 0.0, Way::Straight);
        for corrections in 1..=MOST_CORRECTIONS_OF_START {
            let q0 = sum(q, &moved.v);
            let [at, from] = [given.at(&q0, &moved.v, &moved.sigma), given.at(&q0, &zeros.v, &zeros.sigma)];
            let (phi, l_v) = (self.phi(q, &moved.v, given), self.l_v(&from));
            let sizes = &*sizes.get_or_insert_with(|| self.sizes(q, &from));
            let violation = sizes.violation(&phi);
            let soft = sizes.soft(self.system, violation, softest);
            let tangent = Tangent::new(self, Which::Coordinates, [&at, &from], held, &soft)?;
            stalled = tangent.stalled();
            if corrections == 1 {
                self.linearisation.weigh(self.system);
            }
            self.residual((Which::Coordinates, &l_v), &at, &mut left);
            self.open.iter().for_each(|&j| left.multipliers[j] = 0.0);
            left.part(0, &mut delta);
            tangent.correct(self.system, self.linearisation, &mut delta);
            let step = |share: f64| moved.v.iter().zip(&delta.v).map(|(w, delta)| w - share * delta).collect::<Vec<f64>>();
            let shares = (0..MOST_HALVINGS).map(|k| 0.5f64.powi(k));
            // Comparisons with NaN are false.
            let gets_better = |share: &f64| {
                let after = self.phi(q, &step(*share), given);
                sizes.violation(&after) <= violation || largest_of(&after).1 <= self.tolerance
            };
            let Some(share) = shares.into_iter().find(gets_better) else { break };
            way = if share < 1.0 { Way::Halved } else { way };
            let (next, correction) = (step(share), share * self.linearisation.size_of(&delta.v));
            moved.v.copy_from_slice(&next);
            moved.sigma.iter_mut().zip(&delta.sigma).for_each(|(nu, delta)| *nu -= delta);
            let size = larger(self.linearisation.size_of(q), self.linearisation.size_of(&moved.v));
            let is_stalled = correction >= 0.5 * last && correction <= stalled * size;
            last = correction;
            let is_rounding = correction <= larger(ROUNDING * size, UNDERFLOW);
            if corrections >= LEAST_CORRECTIONS_OF_START && (is_rounding || is_stalled) {
                break;
            }
        }
        self.see_that_it_closes((q, held), &moved.v, given)?;
        let size = larger(self.linearisation.size_of(q), self.linearisation.size_of(&moved.v));
        if last <= stalled * size { Ok(way) } else { Err(Error::AssemblyStalled { correction: largest(&delta.v) }) }
    }

    /// Returns an error if the coordinates violate a constraint.
    pub(super) fn see_that_it_closes(&self, (q, held): (&[f64], &[usize]), w: &[f64], given: Given) -> Result<(), Error> {
        let (q0, mut phi, zeros) = (sum(q, w), self.phi(q, w, given), Pair::new(self.system.n(), self.system.m()));
        let at = given.at(&q0, &zeros.v, &zeros.sigma);
        if largest_of(&phi).1 > self.tolerance {
            self.system.take_rounding(&at, &q0, &mut phi);
        }
        let (equation, most) = largest_of(&phi);
        if !most.is_finite() {
            return Err(self.system.constraint_not_finite(&at, equation));
        }
        if most <= self.tolerance {
            return Ok(());
        }
        // The distance between two points that should coincide has several components.
        let length = |equations: Range<usize>| phi[equations].iter().fold(0.0, |length: f64, phi| length.hypot(*phi));
        let whole = self.system.vector_equations().find(|equations| equations.contains(&equation));
        let (equation, holds) = (self.system.equation_name(equation).to_string(), !held.is_empty());
        Err(Error::Assembly { equation, violation: whole.map_or(most, length), tolerance: self.tolerance, holds })
    }

    /// Computes the sizes with the masses at the point of the last evaluation.
    pub(super) fn sizes(&self, q: &[f64], at: &NodeView<f64>) -> Sizes {
        let masses = redundancy::apparent_masses(self.linearisation, self.system, at);
        let mut flexibilities = redundancy::flexibilities(self.system, at, &masses);
        // One size for all components of a vector, so that the violation of a loop is a distance in any direction.
        for equations in self.system.vector_equations() {
            let most = flexibilities[equations.clone()].iter().copied().fold(0.0, larger);
            flexibilities[equations].fill(most);
        }
        let of_guess = q.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(q, mass)| q.abs() * mass.sqrt());
        Sizes {
            equations: flexibilities.iter().map(|flexibility| flexibility.sqrt()).collect(),
            guess: of_guess.fold(0.0, larger),
        }
    }

    /// Φ at q̂ + w.
    pub(super) fn phi(&self, q: &[f64], w: &[f64], given: Given) -> Vec<f64> {
        let (q, zeros, mut phi) = (sum(q, w), Pair::new(w.len(), self.system.m()), vec![0.0; self.system.m()]);
        self.system.phi(&given.at(&q, &zeros.v, &zeros.sigma), &mut phi);
        self.open.iter().for_each(|&j| phi[j] = 0.0);
        phi
    }
}

impl Sizes {
    /// The length of Φ in units of the masses; NaN if an entry is NaN.
    pub(super) fn violation(&self, phi: &[f64]) -> f64 {
        let violations = phi.iter().zip(&self.equations).map(|(phi, size)| if *size > 0.0 { phi / size } else { *phi });
        violations.map(|violation| violation * violation).sum::<f64>().sqrt()
    }

    /// Compliances of loops at this violation: constraints that depend on each other at a solution contradict each other elsewhere. With compliances
    /// proportional to its square, Newton's corrections still converge quadratically (Levenberg's method; N. Yamashita and M. Fukushima, 2001).
    pub(super) fn soft(&self, system: &System, violation: f64, softest: f64) -> Vec<(usize, f64)> {
        let softness = (violation / self.guess).powi(2).min(softest);
        let is_far = violation > 0.0 && softness > COMPLIANCE;
        let loops = if is_far { system.loop_equations() } else { &[] };
        loops.iter().map(|&j| (j, softness * self.equations[j].powi(2))).collect()
    }
}

/// The equation with the largest violation, and the violation.
fn largest_of(phi: &[f64]) -> (usize, f64) {
    let sizes = phi.iter().map(|phi| phi.abs()).enumerate();
    sizes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}
