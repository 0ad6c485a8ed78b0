//! The equations of an assembly on any numbers, and their tangent.

use num_dual::Dual64;

use super::bordered::Bordered;
use crate::System;
use crate::node::Newton;
use crate::number::{Real, larger};
use crate::system::{Given, Pair, Sums};

/// The part of hyper-dual numbers that belongs to both directions.
const MIXED: usize = 3;

/// w and ν, or v₀ and μ, on any numbers; or what is left of their equations.
pub(super) struct Unknowns<R> {
    pub(super) x: Vec<R>,
    pub(super) multipliers: Vec<R>,
}

impl Unknowns<f64> {
    /// With the derivative along a direction.
    fn along(&self, direction: &Pair) -> Unknowns<Dual64> {
        let lift = |x: &[f64], dx: &[f64]| x.iter().zip(dx).map(|(&x, &dx)| Dual64::new(x, dx)).collect();
        Unknowns { x: lift(&self.x, &direction.v), multipliers: lift(&self.multipliers, &direction.sigma) }
    }
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
    /// For v₀, with q₀ and the guess v̂.
    Velocities(&'a [R], &'a [R]),
}

impl<R: Real> Equations<'_, R> {
    /// How large a part of what they depend on is: a solution may vanish but for its rounding.
    pub(super) fn size(self, k: usize, given: Given<R>) -> f64 {
        if k == MIXED {
            return self.size(1, given) * self.size(2, given);
        }
        let (first, second) = match self {
            Equations::Coordinates(guess) => (guess, guess),
            Equations::Velocities(q, guess) => (guess, if k == 0 { guess } else { q }),
        };
        let design = if k == 0 { &[][..] } else { given.design };
        first.iter().chain(second).chain(design).fold(0.0, |size, x| larger(size, x.part(k).abs()))
    }

    /// What is left of them, but for E κ.
    pub(super) fn residual(self, system: &System, unknowns: &Unknowns<R>, given: Given<R>, left: &mut Unknowns<R>) {
        let Unknowns { x, multipliers } = unknowns;
        let zeros = [vec![R::zero(); x.len()], vec![R::zero(); multipliers.len()]];
        let mut sums = Sums::new(x.len(), multipliers.len());
        let (q, from) = match self {
            Equations::Coordinates(guess) => (sum(guess, x), &zeros[0][..]),
            Equations::Velocities(q, guess) => (q.to_vec(), guess),
        };
        system.plain_sums(&given.at(&q, from, &zeros[1]), &mut sums);
        left.x.iter_mut().zip(sums.l_v()).for_each(|(left, l_v)| *left = -*l_v);
        system.plain_sums(&given.at(&q, x, multipliers), &mut sums);
        left.x.iter_mut().zip(sums.l_v()).for_each(|(left, l_v)| *left += *l_v);
        match self {
            Equations::Coordinates(_) => {
                left.multipliers.fill(R::zero());
                system.phi(&given.at(&q, x, multipliers), &mut left.multipliers);
            }
            Equations::Velocities(..) => left.multipliers.copy_from_slice(sums.phi_dot()),
        }
    }
}

pub(super) fn sum<R: Real>(q: &[R], w: &[R]) -> Vec<R> {
    q.iter().zip(w).map(|(&q, &w)| q + w).collect()
}

/// The tangent of one of the systems of equations at a point, bordered by what is held.
pub(super) struct Tangent<'a> {
    pub(super) bordered: Bordered,
    pub(super) equations: Equations<'a, f64>,
    pub(super) unknowns: Unknowns<f64>,
    pub(super) given: Given<'a>,
}

impl Tangent<'_> {
    /// Solves for a correction in the place of the residual.
    pub(super) fn solve(&self, system: &System, newton: &mut Newton, left: &mut Pair) {
        let lift = |x: &[f64]| x.iter().map(|&x| Dual64::from_re(x)).collect::<Vec<Dual64>>();
        let (u, design) = (lift(self.given.u), lift(self.given.design));
        let given = Given { u: &u, t: Dual64::from_re(self.given.t), design: &design };
        let (first, second) = match self.equations {
            Equations::Coordinates(guess) => (lift(guess), Vec::new()),
            Equations::Velocities(q, guess) => (lift(q), lift(guess)),
        };
        let equations = match self.equations {
            Equations::Coordinates(_) => Equations::Coordinates(&first),
            Equations::Velocities(..) => Equations::Velocities(&first, &second),
        };
        let mut moved = Unknowns::<Dual64>::new(&self.unknowns.x, &self.unknowns.multipliers);
        self.bordered.solve_close(system, newton, left, |_, x, product| {
            equations.residual(system, &self.unknowns.along(x), given, &mut moved);
            moved.part(1, product);
        });
    }
}
