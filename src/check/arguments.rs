//! [`Arguments`]: what a block is evaluated at, by names that programs in other languages understand.

use serde_json::{Map, Value, json};

use super::point::Point;
use super::step::{State, StepPoint};

/// Where a check asks for derivatives: a [`Point`] of an element, a [`StepPoint`], or the list x of a function.
pub trait Arguments {
    /// The numbers by their names, as JSON.
    fn by_name(&self) -> Map<String, Value>;
}

impl<const N: usize, const M: usize, const K: usize, const P: usize> Arguments for Point<N, M, K, P> {
    fn by_name(&self) -> Map<String, Value> {
        let lists: [(&str, &[f64]); 10] = [
            ("q", self.q.as_slice()),
            ("v", self.v.as_slice()),
            ("p_star", self.p_star.as_slice()),
            ("p_star_dot", self.p_star_dot.as_slice()),
            ("v_dot", self.v_dot.as_slice()),
            ("sigma", self.sigma.as_slice()),
            ("lambda", self.lambda.as_slice()),
            ("u", self.u.as_slice()),
            ("u_dot", self.u_dot.as_slice()),
            ("b", self.b.as_slice()),
        ];
        with(lists, [("t", self.t)])
    }
}

impl Arguments for StepPoint<'_> {
    /// y_i as `q`, `v`, …, y_{i−1} as `q_previous`, `v_previous`, …; u_i, b, t_i, Δt and i.
    fn by_name(&self) -> Map<String, Value> {
        let State { v, p_star_dot, q, p_star, sigma } = &self.y;
        let before = &self.previous;
        let lists: [(&str, &[f64]); 12] = [
            ("q", q.as_slice()),
            ("v", v.as_slice()),
            ("p_star", p_star.as_slice()),
            ("p_star_dot", p_star_dot.as_slice()),
            ("sigma", sigma.as_slice()),
            ("q_previous", before.q.as_slice()),
            ("v_previous", before.v.as_slice()),
            ("p_star_previous", before.p_star.as_slice()),
            ("p_star_dot_previous", before.p_star_dot.as_slice()),
            ("sigma_previous", before.sigma.as_slice()),
            ("u", self.u.as_slice()),
            ("b", self.b.as_slice()),
        ];
        with(lists, [("t", self.t), ("dt", self.dt), ("node", self.node as f64)])
    }
}

impl Arguments for [f64] {
    fn by_name(&self) -> Map<String, Value> {
        with([("x", self)], [])
    }
}

impl Arguments for Vec<f64> {
    fn by_name(&self) -> Map<String, Value> {
        self.as_slice().by_name()
    }
}

fn with<const L: usize, const S: usize>(lists: [(&str, &[f64]); L], numbers: [(&str, f64); S]) -> Map<String, Value> {
    let lists = lists.into_iter().map(|(name, list)| (name.to_string(), json!(list)));
    lists.chain(numbers.into_iter().map(|(name, x)| (name.to_string(), json!(x)))).collect()
}
