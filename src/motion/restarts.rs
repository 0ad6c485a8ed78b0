//! The restarts of a motion (`forward/restart.rs`) as data, complete for the adjoint sweep.

use crate::number::Real;

/// A projection that has not converged after this number of corrections fails; corrections that shrink by a third have reached rounding by then. The
/// corrections of its derivatives shrink alike.
pub(crate) const MOST_CORRECTIONS_OF_PROJECTION: usize = 90;

/// The nodes at which a motion was restarted, and the states before the restarts, stored one after another.
#[derive(Default)]
pub(crate) struct Restarts {
    pub(crate) nodes: Vec<usize>,
    /// For each restart, true if Φ = 0 was restored.
    pub(crate) projected: Vec<bool>,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) p_star_dot: Vec<f64>,
    pub(crate) sigma: Vec<f64>,
    pub(crate) nu: Vec<f64>,
    /// The nodes of σ₋.
    pub(crate) before: Vec<usize>,
    /// α and β in s = α σ⁻ + β σ₋, and s.
    pub(crate) weights: Vec<[f64; 2]>,
    pub(crate) begin: Vec<f64>,
    /// Second derivatives at the end of the step, at (q, v⁻, s) and at (q, w, ν).
    pub(crate) step_blocks: Vec<f64>,
    pub(crate) momentum_blocks: Vec<f64>,
    pub(crate) projection_blocks: Vec<f64>,
}

/// One restart.
#[derive(Clone, Copy)]
pub(crate) struct Restart<'a> {
    pub(crate) q: &'a [f64],
    pub(crate) v: &'a [f64],
    pub(crate) p_star_dot: &'a [f64],
    pub(crate) sigma: &'a [f64],
    /// The node of σ₋.
    pub(crate) before: usize,
    /// α and β in s = α σ⁻ + β σ₋, and s.
    pub(crate) weights: [f64; 2],
    pub(crate) begin: &'a [f64],
    pub(crate) step_blocks: &'a [f64],
    pub(crate) momentum_blocks: &'a [f64],
    /// ν and the second derivatives, if Φ = 0 was restored.
    pub(crate) projection: Option<(&'a [f64], &'a [f64])>,
}

impl Restarts {
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.projected.clear();
        self.before.clear();
        self.weights.clear();
        let lists = [&mut self.q, &mut self.v, &mut self.p_star_dot, &mut self.sigma, &mut self.begin, &mut self.nu];
        let blocks = [&mut self.step_blocks, &mut self.momentum_blocks, &mut self.projection_blocks];
        lists.into_iter().chain(blocks).for_each(Vec::clear);
    }

    /// True if both restart at the same nodes in the same way.
    pub(crate) fn are_alike(&self, other: &Restarts) -> bool {
        self.nodes == other.nodes && self.projected == other.projected && self.weights == other.weights
    }

    /// The restart at a node.
    pub(crate) fn at(&self, node: usize) -> Option<Restart<'_>> {
        let which = self.nodes.binary_search(&node).ok()?;
        let count = self.nodes.len();
        let part = |list: &'_ Vec<f64>| {
            let len = list.len() / count;
            which * len..(which + 1) * len
        };
        let of = |list| &(list as &Vec<f64>)[part(list)];
        Some(Restart {
            q: of(&self.q),
            v: of(&self.v),
            p_star_dot: of(&self.p_star_dot),
            sigma: of(&self.sigma),
            before: self.before[which],
            weights: self.weights[which],
            begin: of(&self.begin),
            step_blocks: of(&self.step_blocks),
            momentum_blocks: of(&self.momentum_blocks),
            projection: self.projected[which].then(|| (of(&self.nu), of(&self.projection_blocks))),
        })
    }
}

impl Restart<'_> {
    /// The initial σ, from σ₋ and σ⁻.
    pub(crate) fn begin<R: Real>(&self, before: R, now: R) -> R {
        now * self.weights[0] + before * self.weights[1]
    }
}
