//! Arguments of an element: all that any element can have, by name and in one list.

use nalgebra::SVector;
use std::ops::Range;

use crate::Scalar;
use crate::number::Random;

/// The arguments of an element with N coordinates, M equations, K controls and P constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<const N: usize, const M: usize = 0, const K: usize = 0, const P: usize = 0, S = f64> {
    /// Coordinates.
    pub q: SVector<S, N>,
    /// Velocities.
    pub v: SVector<S, N>,
    /// Augmented momenta (costs only).
    pub p_star: SVector<S, N>,
    /// Rates ṗ* of the augmented momenta (costs only).
    pub p_star_dot: SVector<S, N>,
    /// Accelerations (costs only).
    pub v_dot: SVector<S, N>,
    /// Multipliers.
    pub sigma: SVector<S, M>,
    /// Reactions λ = dσ/dt (costs only).
    pub lambda: SVector<S, M>,
    /// Controls.
    pub u: SVector<S, K>,
    /// Rates of the controls (costs only).
    pub u_dot: SVector<S, K>,
    /// Time.
    pub t: S,
    /// The element's constants.
    pub b: SVector<S, P>,
}

impl<const N: usize, const M: usize, const K: usize, const P: usize, S: Scalar> Point<N, M, K, P, S> {
    /// The point whose arguments are in a list, one after another.
    pub(crate) fn from_list(x: &[S]) -> Self {
        let at = Places { n: N, m: M, k: K, p: P };
        fn part<S: Scalar, const L: usize>(x: &[S], range: Range<usize>) -> SVector<S, L> {
            SVector::from_fn(|i, _| x[range.start + i])
        }
        Point {
            q: part(x, at.of(Part::Q)),
            v: part(x, at.of(Part::V)),
            p_star: part(x, at.of(Part::PStar)),
            p_star_dot: part(x, at.of(Part::PStarDot)),
            v_dot: part(x, at.of(Part::VDot)),
            sigma: part(x, at.of(Part::Sigma)),
            lambda: part(x, at.of(Part::Lambda)),
            u: part(x, at.of(Part::U)),
            u_dot: part(x, at.of(Part::UDot)),
            t: x[at.of(Part::T).start],
            b: part(x, at.of(Part::B)),
        }
    }
}

impl<const N: usize, const M: usize, const K: usize, const P: usize> Point<N, M, K, P> {
    pub(crate) const PLACES: Places = Places { n: N, m: M, k: K, p: P };

    /// The point with zero arguments and these constants.
    pub fn zero(b: [f64; P]) -> Self {
        Self::same(0.0, b)
    }

    /// A point whose arguments are all x, except the constants.
    pub(crate) fn same(x: f64, b: [f64; P]) -> Self {
        Point { b: b.into(), ..Self::from_list(&vec![x; Self::PLACES.of(Part::One).end]) }
    }

    /// The point with other coordinates.
    #[must_use]
    pub fn with_q(mut self, q: [f64; N]) -> Self {
        self.q = q.into();
        self
    }

    /// The point with other velocities.
    #[must_use]
    pub fn with_v(mut self, v: [f64; N]) -> Self {
        self.v = v.into();
        self
    }

    /// A random point of these magnitudes, none of whose arguments is near zero; the constants are kept.
    pub(crate) fn random(magnitudes: &Self, random: &mut Random) -> Self {
        let (t, mut x) = (Self::PLACES.of(Part::T).start, magnitudes.list());
        x[..t].iter_mut().for_each(|x| *x = random.away_from_zero(1.5 * *x));
        x[t] *= random.uniform(0.1, 2.0);
        Self::from_list(&x)
    }

    /// All arguments in one list, followed by the factor 1 by which compared values are multiplied.
    pub(crate) fn list(&self) -> Vec<f64> {
        let states = [self.q, self.v, self.p_star, self.p_star_dot, self.v_dot].map(|x| x.data.0[0]).concat();
        let Point { sigma, lambda, u, u_dot, t, b, .. } = self;
        let rest = [sigma.as_slice(), lambda.as_slice(), u.as_slice(), u_dot.as_slice(), &[*t], b.as_slice(), &[1.0]];
        [states, rest.concat()].concat()
    }
}

/// One kind of argument, in the order of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Q,
    V,
    PStar,
    PStarDot,
    VDot,
    Sigma,
    Lambda,
    U,
    UDot,
    T,
    B,
    /// The factor 1 by which values are multiplied.
    One,
}

impl Part {
    /// Kinds of arguments with their names in files and in texts, starting with those most often mistaken for one another.
    pub(crate) const GROUPS: [(Part, &'static str, &'static str); 11] = [
        (Part::B, "b", "b"),
        (Part::V, "v", "v"),
        (Part::Sigma, "sigma", "σ"),
        (Part::U, "u", "u"),
        (Part::T, "t", "t"),
        (Part::PStar, "p_star", "p*"),
        (Part::PStarDot, "p_star_dot", "ṗ*"),
        (Part::VDot, "v_dot", "v̇"),
        (Part::Lambda, "lambda", "λ"),
        (Part::UDot, "u_dot", "u̇"),
        (Part::Q, "q", "q"),
    ];
}

/// Positions of the arguments in the list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    pub n: usize,
    pub m: usize,
    pub k: usize,
    pub p: usize,
}

impl Places {
    pub(crate) fn of(&self, part: Part) -> Range<usize> {
        let Places { n, m, k, p } = *self;
        let lengths = [n, n, n, n, n, m, m, k, k, 1, p, 1];
        let start = lengths[..part as usize].iter().sum();
        start..start + lengths[part as usize]
    }
}
