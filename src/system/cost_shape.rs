//! The arguments of a cost, numbered consecutively, and the quantities of a node that they refer to.

use crate::model::element::ListPoint;

/// The list of quantities at a node (q, v, …) to which an argument belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    Q,
    V,
    PStar,
    PStarDot,
    VDot,
    Sigma,
    Lambda,
    U,
    UDot,
    Time,
}

/// The arguments of a cost: for each, its list and its index in the scene's numbering.
#[derive(Clone)]
pub struct CostShape {
    n: usize,
    m: usize,
    k: usize,
    pub places: Vec<(Of, usize)>,
}

impl CostShape {
    pub fn new(q: &[usize], sigma: &[usize], u: &[usize]) -> Self {
        let of = |of: Of, list: &[usize]| list.iter().map(|&i| (of, i)).collect::<Vec<_>>();
        let states = [Of::Q, Of::V, Of::PStar, Of::PStarDot, Of::VDot].map(|kind| of(kind, q)).concat();
        let others = [of(Of::Sigma, sigma), of(Of::Lambda, sigma), of(Of::U, u), of(Of::UDot, u), vec![(Of::Time, 0)]];
        CostShape { n: q.len(), m: sigma.len(), k: u.len(), places: [states, others.concat()].concat() }
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether the cost has arguments other than controls and time.
    pub fn has_state(&self) -> bool {
        self.n + self.m > 0
    }

    /// Splits a list of all arguments into the fields of a point.
    pub fn point<'a, S: Copy>(&self, x: &'a [S], b: &'a [S]) -> ListPoint<'a, S> {
        let CostShape { n, m, k, .. } = *self;
        let mut rest = x;
        let mut next = |len: usize| {
            let (own, after) = rest.split_at(len);
            rest = after;
            own
        };
        ListPoint {
            q: next(n),
            v: next(n),
            p_star: next(n),
            p_star_dot: next(n),
            v_dot: next(n),
            sigma: next(m),
            lambda: next(m),
            u: next(k),
            u_dot: next(k),
            t: next(1)[0],
            b,
        }
    }
}
