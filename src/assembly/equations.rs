//! The equations of an assembly on any number type, evaluated with the plain formulas.

use crate::System;
use crate::number::{Real, larger};
use crate::system::{Given, Pair, Sums};

/// The part of hyper-dual numbers that is the mixed second derivative.
const MIXED: usize = 3;

/// w and ν, or v₀ and μ, on any number type; also used for the residuals of their equations.
pub(super) struct Unknowns<R> {
    pub(super) x: Vec<R>,
    pub(super) multipliers: Vec<R>,
}

impl<R: Real> Unknowns<R> {
    pub(super) fn new(x: &[f64], multipliers: &[f64]) -> Self {
        let lift = |x: &[f64]| x.iter().map(|&x| R::from(x)).collect();
        Unknowns { x: lift(x), multipliers: lift(multipliers) }
    }

    pub(super) fn part(&self, k: usize, pair: &mut Pair) {
        pair.v.iter_mut().zip(&self.x).for_each(|(part, x)| *part = x.part(k));
        pair.sigma.iter_mut().zip(&self.multipliers).for_each(|(part, x)| *part = x.part(k));
    }

    pub(super) fn subtract(&mut self, k: usize, pair: &Pair) {
        self.x.iter_mut().zip(&pair.v).for_each(|(x, delta)| x.add_to_part(k, -delta));
        self.multipliers.iter_mut().zip(&pair.sigma).for_each(|(x, delta)| x.add_to_part(k, -delta));
    }
}

/// One of the two systems of equations.
#[derive(Clone, Copy)]
pub(super) enum Equations<'a, R> {
    /// For w, with the guess q̂.
    Coordinates(&'a [R]),
    /// For v₀, with q₀ and the guesses v̂ and q̂.
    Velocities(&'a [R], &'a [R], &'a [R]),
}

impl<R: Real> Equations<'_, R> {
    /// The size of a part of the given values: a solution may be zero up to rounding.
    pub(super) fn size(self, k: usize, given: Given<R>) -> f64 {
        if k == MIXED {
            return self.size(1, given) * self.size(2, given);
        }
        let (first, second) = match self {
            Equations::Coordinates(guess) => (guess, guess),
            // q₀ may not change with q̂.
            Equations::Velocities(_, guess, of_q) => (guess, if k == 0 { guess } else { of_q }),
        };
        let design = if k == 0 { &[][..] } else { given.design };
        first.iter().chain(second).chain(design).fold(0.0, |size, x| larger(size, x.part(k).abs()))
    }

    /// Writes the residuals of the equations, without E κ.
    pub(super) fn residual(self, system: &System, unknowns: &Unknowns<R>, given: Given<R>, left: &mut Unknowns<R>) {
        let Unknowns { x, multipliers } = unknowns;
        let zeros = [vec![R::zero(); x.len()], vec![R::zero(); multipliers.len()]];
        let mut sums = Sums::new(x.len(), multipliers.len());
        let (q, from) = match self {
            Equations::Coordinates(guess) => (sum(guess, x), &zeros[0][..]),
            Equations::Velocities(q, guess, _) => (q.to_vec(), guess),
        };
        system.plain_sums(&given.at(&q, from, &zeros[1]), &mut sums);
        left.x.iter_mut().zip(sums.l_v()).for_each(|(left, l_v)| *left = -*l_v);
        system.plain_sums(&given.at(&q, x, multipliers), &mut sums);
        left.x.iter_mut().zip(sums.l_v()).for_each(|(left, l_v)| *left += *l_v);
        match self {
            Equations::Coordinates(_) => {
                left.multipliers.fill(R::zero());
                system.phi_on(&given.at(&q, x, multipliers), &mut left.multipliers);
            }
            Equations::Velocities(..) => left.multipliers.copy_from_slice(sums.phi_dot()),
        }
    }
}

pub(super) fn sum<R: Real>(q: &[R], w: &[R]) -> Vec<R> {
    q.iter().zip(w).map(|(&q, &w)| q + w).collect()
}
