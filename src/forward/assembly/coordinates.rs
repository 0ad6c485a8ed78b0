//! The coordinates of a start: w and ν by Newton's method, with loops that are softer the farther they are from closing.

use super::equations::{Unknowns, sum};
use super::{Assembler, LEAST_CORRECTIONS_OF_START, MOST_CORRECTIONS_OF_START, ROUNDING, Tangent, UNDERFLOW, Which};
use crate::forward::redundancy::{self, COMPLIANCE};
use crate::number::{larger, largest};
use crate::system::{Given, NodeView, Pair};
use crate::{Error, System};

/// A correction is halved so often until Φ gets smaller.
const MOST_HALVINGS: i32 = 12;
/// The largest compliance of a loop, in units of its own flexibility.
const SOFTEST: f64 = 1e-1;

/// √(Φ_q M⁻¹ Φ_qᵀ)_jj of all equations, and the largest √m |q| of a guess, with M's diagonal.
struct Sizes {
    equations: Vec<f64>,
    guess: f64,
}

impl Assembler<'_> {
    /// w and ν from w = 0.
    pub(super) fn move_coordinates(
        &mut self,
        q: &[f64],
        held: &[usize],
        moved: &mut Pair,
        given: Given,
    ) -> Result<(), Error> {
        let zeros = moved.clone();
        let found = self.approach((q, held), moved, given, SOFTEST);
        if found.is_ok() || self.system.loop_equations().is_empty() {
            return found;
        }
        // From far away corrections of the full length lead farther, unless constraints depend on each other.
        *moved = zeros;
        self.approach((q, held), moved, given, 0.0).or(found)
    }

    /// With K(0) made anew at every correction, and loops that are that soft at most.
    fn approach(
        &mut self,
        (q, held): (&[f64], &[usize]),
        moved: &mut Pair,
        given: Given,
        softest: f64,
    ) -> Result<(), Error> {
        let zeros = moved.clone();
        let (mut left, mut delta) = (Unknowns::new(&zeros.v, &zeros.sigma), zeros.clone());
        let (mut sizes, mut last, mut stalled) = (None, f64::INFINITY, 0.0);
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
                self.newton.weigh(self.system);
            }
            self.residual((Which::Coordinates, &l_v), &at, &mut left);
            left.part(0, &mut delta);
            tangent.correct(self.system, self.newton, &mut delta);
            let step = |share: f64| moved.v.iter().zip(&delta.v).map(|(w, delta)| w - share * delta).collect::<Vec<f64>>();
            let shares = (0..MOST_HALVINGS).map(|k| 0.5f64.powi(k));
            // A comparison is false for a NaN.
            let gets_better = |share: &f64| {
                let after = self.phi(q, &step(*share), given);
                sizes.violation(&after) <= violation || largest_of(&after).1 <= self.tolerance
            };
            let Some(share) = shares.into_iter().find(gets_better) else { break };
            let (next, correction) = (step(share), share * self.newton.size_of(&delta.v));
            moved.v.copy_from_slice(&next);
            moved.sigma.iter_mut().zip(&delta.sigma).for_each(|(nu, delta)| *nu -= delta);
            let size = larger(self.newton.size_of(q), self.newton.size_of(&moved.v));
            let is_stalled = correction >= 0.5 * last && correction <= stalled * size;
            last = correction;
            let is_rounding = correction <= larger(ROUNDING * size, UNDERFLOW);
            if corrections >= LEAST_CORRECTIONS_OF_START && (is_rounding || is_stalled) {
                break;
            }
        }
        self.see_that_it_closes((q, held), &moved.v, given)?;
        let size = larger(self.newton.size_of(q), self.newton.size_of(&moved.v));
        if last <= stalled * size { Ok(()) } else { Err(Error::AssemblyStalled { correction: largest(&delta.v) }) }
    }

    /// Refuses coordinates that violate a constraint.
    fn see_that_it_closes(&self, (q, held): (&[f64], &[usize]), w: &[f64], given: Given) -> Result<(), Error> {
        let (q0, mut phi, zeros) = (sum(q, w), self.phi(q, w, given), Pair::new(self.system.n(), self.system.m()));
        let at = given.at(&q0, &zeros.v, &zeros.sigma);
        if largest_of(&phi).1 > self.tolerance {
            self.system.take_rounding(&at, &q0, &mut phi);
        }
        let (equation, violation) = largest_of(&phi);
        if !violation.is_finite() {
            return Err(self.system.constraint_not_finite(&at, equation));
        }
        if violation > self.tolerance {
            let (equation, holds) = (self.system.equation_name(equation).to_string(), !held.is_empty());
            return Err(Error::Assembly { equation, violation, tolerance: self.tolerance, holds });
        }
        Ok(())
    }

    /// With the masses at a point where the evaluation stands.
    fn sizes(&self, q: &[f64], at: &NodeView<f64>) -> Sizes {
        let masses = redundancy::masses(self.newton, self.system);
        let flexibilities = redundancy::flexibilities(self.system, at, &masses);
        let of_guess = q.iter().zip(&masses).filter(|(_, mass)| **mass > 0.0).map(|(q, mass)| q.abs() * mass.sqrt());
        Sizes {
            equations: flexibilities.iter().map(|flexibility| flexibility.sqrt()).collect(),
            guess: of_guess.fold(0.0, larger),
        }
    }

    /// Φ at q̂ + w.
    fn phi(&self, q: &[f64], w: &[f64], given: Given) -> Vec<f64> {
        let (q, zeros, mut phi) = (sum(q, w), Pair::new(w.len(), self.system.m()), vec![0.0; self.system.m()]);
        self.system.phi(&given.at(&q, &zeros.v, &zeros.sigma), &mut phi);
        phi
    }
}

impl Sizes {
    /// The length of Φ in units of what moves the coordinates; NaN if an entry is.
    fn violation(&self, phi: &[f64]) -> f64 {
        let violations = phi.iter().zip(&self.equations).map(|(phi, size)| if *size > 0.0 { phi / size } else { *phi });
        violations.map(|violation| violation * violation).sum::<f64>().sqrt()
    }

    /// Compliances of loops at this violation: constraints that depend on each other where they hold contradict each other elsewhere. With its square
    /// Newton's corrections converge quadratically all the same (Levenberg's method; N. Yamashita and M. Fukushima, 2001).
    fn soft(&self, system: &System, violation: f64, softest: f64) -> Vec<(usize, f64)> {
        let softness = (violation / self.guess).powi(2).min(softest);
        let is_far = violation > 0.0 && softness > COMPLIANCE;
        let loops = if is_far { system.loop_equations() } else { &[] };
        loops.iter().map(|&j| (j, softness * self.equations[j].powi(2))).collect()
    }
}

/// The equation that is violated most, and by how much.
fn largest_of(phi: &[f64]) -> (usize, f64) {
    let sizes = phi.iter().map(|phi| phi.abs()).enumerate();
    sizes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}
