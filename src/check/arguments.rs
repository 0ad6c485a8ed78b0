//! [`Arguments`]: the arguments of a block, by names that programs in other languages understand.

use serde_json::{Map, Value, json};

use super::point::{Part, Point};
use super::step::{State, StepPoint};

/// The arguments at which a check compares derivatives: a [`Point`] of an element, a [`StepPoint`], or the list x of a function.
pub trait Arguments {
    /// The arguments by name, for JSON.
    fn by_name(&self) -> Map<String, Value>;
}

impl<const N: usize, const M: usize, const K: usize, const P: usize> Arguments for Point<N, M, K, P> {
    fn by_name(&self) -> Map<String, Value> {
        let (x, places) = (self.list(), Self::PLACES);
        let lists = Part::GROUPS.map(|(part, name, _)| (name.to_string(), json!(x[places.of(part)])));
        // Time is a number.
        lists.into_iter().chain([("t".to_string(), json!(self.t))]).collect()
    }
}

impl Arguments for StepPoint<'_> {
    /// y_i as `q`, `v`, …, y_{i−1} as `q_previous`, `v_previous`, …; u_i, b, t_i, Δt and i.
    fn by_name(&self) -> Map<String, Value> {
        let lists = [("u", json!(self.u.as_slice())), ("b", json!(self.b.as_slice()))];
        let numbers = [("t", json!(self.t)), ("dt", json!(self.dt)), ("node", json!(self.node as f64))];
        let mut all: Map<_, _> = lists.into_iter().chain(numbers).map(|(name, value)| (name.to_string(), value)).collect();
        for (State { v, p_star_dot, q, p_star, sigma }, which) in [(&self.y, ""), (&self.previous, "_previous")] {
            for (name, x) in [("q", q), ("v", v), ("p_star", p_star), ("p_star_dot", p_star_dot), ("sigma", sigma)] {
                all.insert(format!("{name}{which}"), json!(x.as_slice()));
            }
        }
        all
    }
}

impl Arguments for [f64] {
    fn by_name(&self) -> Map<String, Value> {
        Map::from_iter([("x".to_string(), json!(self))])
    }
}

impl Arguments for Vec<f64> {
    fn by_name(&self) -> Map<String, Value> {
        self.as_slice().by_name()
    }
}
