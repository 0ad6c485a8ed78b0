//! Where an element is evaluated: all arguments that any element can have, by name and in one list.

use nalgebra::SVector;
use std::ops::Range;

use super::random::Random;
use crate::Scalar;

/// The arguments of an element with N coordinates, M equations, K controls and P constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<const N: usize, const M: usize = 0, const K: usize = 0, const P: usize = 0, S = f64> {
    /// Coordinates.
    pub q: SVector<S, N>,
    /// Velocities.
    pub v: SVector<S, N>,
    /// Augmented momenta (costs only).
    pub p_star: SVector<S, N>,
    /// Their rates (costs only).
    pub p_star_dot: SVector<S, N>,
    /// Multipliers.
    pub sigma: SVector<S, M>,
    /// Controls.
    pub u: SVector<S, K>,
    /// Time.
    pub t: S,
    /// The element's constants.
    pub b: SVector<S, P>,
}

impl<const N: usize, const M: usize, const K: usize, const P: usize, S: Scalar> Point<N, M, K, P, S> {
    /// The point whose arguments stand one after another in a list.
    pub(crate) fn from_list(x: &[S]) -> Self {
        let at = Places { n: N, m: M, k: K, p: P };
        fn part<S: Scalar, const L: usize>(x: &[S], range: Range<usize>) -> SVector<S, L> {
            SVector::from_fn(|i, _| x[range.start + i])
        }
        Point {
            q: part(x, at.q()),
            v: part(x, at.v()),
            p_star: part(x, at.p_star()),
            p_star_dot: part(x, at.p_star_dot()),
            sigma: part(x, at.sigma()),
            u: part(x, at.u()),
            t: x[at.t()],
            b: part(x, at.b()),
        }
    }
}

impl<const N: usize, const M: usize, const K: usize, const P: usize> Point<N, M, K, P> {
    /// All arguments zero, with these constants.
    pub fn zero(b: [f64; P]) -> Self {
        Point {
            q: SVector::zeros(),
            v: SVector::zeros(),
            p_star: SVector::zeros(),
            p_star_dot: SVector::zeros(),
            sigma: SVector::zeros(),
            u: SVector::zeros(),
            t: 0.0,
            b: b.into(),
        }
    }

    /// The same with other coordinates.
    pub fn with_q(mut self, q: [f64; N]) -> Self {
        self.q = q.into();
        self
    }

    /// The same with other velocities.
    pub fn with_v(mut self, v: [f64; N]) -> Self {
        self.v = v.into();
        self
    }

    /// Of size 1 in everything.
    pub(crate) fn ones(b: [f64; P]) -> Self {
        let one = || SVector::from_element(1.0);
        Point {
            q: one(),
            v: one(),
            p_star: one(),
            p_star_dot: one(),
            sigma: SVector::from_element(1.0),
            u: SVector::from_element(1.0),
            t: 1.0,
            b: b.into(),
        }
    }

    /// A random point of these magnitudes, none of whose arguments is near zero; the constants are kept.
    pub(crate) fn random(magnitudes: &Self, random: &mut Random) -> Self {
        fn draw<const L: usize>(size: &SVector<f64, L>, random: &mut Random) -> SVector<f64, L> {
            size.map(|size| random.away_from_zero(1.5 * size))
        }
        Point {
            q: draw(&magnitudes.q, random),
            v: draw(&magnitudes.v, random),
            p_star: draw(&magnitudes.p_star, random),
            p_star_dot: draw(&magnitudes.p_star_dot, random),
            sigma: draw(&magnitudes.sigma, random),
            u: draw(&magnitudes.u, random),
            t: random.uniform(0.1, 2.0) * magnitudes.t,
            b: magnitudes.b,
        }
    }

    /// All arguments in one list, and the 1 that values are multiplied by where they are compared.
    pub(crate) fn list(&self) -> Vec<f64> {
        let states = [&self.q, &self.v, &self.p_star, &self.p_star_dot];
        let states = states.into_iter().flat_map(|x| x.iter().copied());
        states
            .chain(self.sigma.iter().copied())
            .chain(self.u.iter().copied())
            .chain([self.t])
            .chain(self.b.iter().copied())
            .chain([1.0])
            .collect()
    }
}

/// Where the arguments stand in the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    pub n: usize,
    pub m: usize,
    pub k: usize,
    pub p: usize,
}

impl Places {
    pub(crate) fn q(&self) -> Range<usize> {
        0..self.n
    }
    pub(crate) fn v(&self) -> Range<usize> {
        self.n..2 * self.n
    }
    pub(crate) fn p_star(&self) -> Range<usize> {
        2 * self.n..3 * self.n
    }
    pub(crate) fn p_star_dot(&self) -> Range<usize> {
        3 * self.n..4 * self.n
    }
    pub(crate) fn sigma(&self) -> Range<usize> {
        4 * self.n..4 * self.n + self.m
    }
    pub(crate) fn u(&self) -> Range<usize> {
        self.sigma().end..self.sigma().end + self.k
    }
    pub(crate) fn t(&self) -> usize {
        self.u().end
    }
    pub(crate) fn b(&self) -> Range<usize> {
        self.t() + 1..self.t() + 1 + self.p
    }
    /// Behind all arguments.
    pub(crate) fn one(&self) -> usize {
        self.b().end
    }
}
