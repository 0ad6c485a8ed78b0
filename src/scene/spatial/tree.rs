//! [`Tree`]: the kinetic and potential energy of bodies that joints connect to a tree, in the coordinates of the joints.
//!
//! Every node is a frame that moves relative to its parent, first by a fixed rotation R and origin p, then by the motion of a joint. With the rotation
//! rate w and the velocity u of the origin, both in the axes of the node, and the joint's own rates ω and ν,
//!
//! ```text
//!   w = Jᵀ Rᵀ w_p + ω,     u = Jᵀ (Rᵀ (u_p + w_p × p) + Rᵀ w_p × s) + ν
//!   T = Σ ½ m u·u + u·(w × m c) + ½ w·J w
//!   V = −Σ g·(m c + Σ_children m p) − Σ m g·s − m g·p of the whole tree and its first frame
//! ```
//!
//! where s is the offset of a slide, g is gravity in the axes of the node, m c and J are about the origin of the node, and the masses in V are those of
//! all bodies that the joint carries.

use std::sync::Arc;

use super::formula::{Fixed, Follows, Number, Vector, cross, dot, plus, scaled, values, zero};
use crate::model::space::Motion;
use crate::{ListKineticEnergy, ListPotentialEnergy, Scalar};

/// A frame of a tree.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The number of the parent, which is less than its own; `None` for the ground.
    pub(super) parent: Option<usize>,
    pub(super) fixed: Fixed,
    pub(super) motion: Motion<Follows>,
    pub(super) body: Inertial,
    /// m c, plus the masses carried by the children times the origins of their frames.
    pub(super) weighted: [Number; 3],
    /// The mass of all bodies carried by the joint.
    pub(super) carried: Number,
}

/// m, m c and J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the origin of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertial {
    pub(super) mass: Number,
    pub(super) first: [Number; 3],
    pub(super) second: [Number; 6],
}

/// The nodes of a tree, parents first.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub(super) nodes: Arc<Vec<Node>>,
    /// The acceleration of gravity.
    pub(super) gravity: [Number; 3],
}

/// T of a tree.
pub(super) struct Kinetic(pub(super) Tree);

/// V of a tree.
pub(super) struct Weight(pub(super) Tree);

/// The rotation rate and the velocity of the origin of a frame, in its axes.
#[derive(Clone, Copy)]
pub(super) struct Rates<S> {
    pub(super) turning: Vector<S>,
    pub(super) origin: Vector<S>,
}

impl<S: Scalar> Rates<S> {
    /// The rates of a frame at rest.
    pub(super) fn none() -> Self {
        Rates { turning: zero(), origin: zero() }
    }

    /// The rates of a frame that moves relative to this one.
    pub(super) fn of_inner(&self, fixed: &Fixed, motion: &Motion<Follows>, [q, v, b]: [&[S]; 3]) -> Self {
        let moved = motion.at(q, b);
        let turning = fixed.inward(self.turning, b);
        let origin = fixed.inward(plus(self.origin, cross(self.turning, fixed.origin(b))), b);
        let origin = plus(origin, cross(turning, moved.origin()));
        let (turns, slides) = motion.rates(q, v, b);
        Rates { turning: plus(moved.inward(turning), turns), origin: plus(moved.inward(origin), slides) }
    }
}

impl Inertial {
    /// ½ m u·u + u·(w × m c) + ½ w·J w.
    fn energy<S: Scalar>(&self, rates: &Rates<S>, b: &[S]) -> S {
        let Rates { turning: w, origin: u } = *rates;
        let [xx, yy, zz, xy, xz, yz] = values(self.second, b);
        let spin = [xx * w[0] + xy * w[1] + xz * w[2], xy * w[0] + yy * w[1] + yz * w[2], xz * w[0] + yz * w[1] + zz * w[2]];
        let both = dot(u, cross(w, values(self.first, b)));
        (self.mass.value(b) * dot(u, u) + dot(w, spin)) * 0.5 + both
    }

    fn is_none(&self) -> bool {
        let all = self.first.iter().chain(&self.second).chain([&self.mass]);
        all.into_iter().all(|number| number.is_zero())
    }
}

impl ListKineticEnergy for Kinetic {
    fn kinetic_energy<S: Scalar>(&self, q: &[S], v: &[S], b: &[S]) -> S {
        let mut rates: Vec<Rates<S>> = Vec::with_capacity(self.0.nodes.len());
        let mut energy = S::from(0.0);
        for Node { parent, fixed, motion, body, .. } in self.0.nodes.iter() {
            let outer = parent.map_or(Rates::none(), |parent| rates[parent]);
            let own = outer.of_inner(fixed, motion, [q, v, b]);
            if !body.is_none() {
                energy += body.energy(&own, b);
            }
            rates.push(own);
        }
        energy
    }
}

impl ListPotentialEnergy for Weight {
    fn potential_energy<S: Scalar>(&self, q: &[S], b: &[S], _t: S) -> S {
        let mut gravity: Vec<Vector<S>> = Vec::with_capacity(self.0.nodes.len());
        let mut energy = S::from(0.0);
        for Node { parent, fixed, motion, weighted, carried, .. } in self.0.nodes.iter() {
            let outer = parent.map_or_else(|| values(self.0.gravity, b), |parent| gravity[parent]);
            if parent.is_none() {
                energy -= dot(outer, scaled(fixed.origin(b), carried.value(b)));
            }
            let (before, moved) = (fixed.inward(outer, b), motion.at(q, b));
            energy -= dot(before, scaled(moved.origin(), carried.value(b)));
            let own = moved.inward(before);
            energy -= dot(own, values(*weighted, b));
            gravity.push(own);
        }
        energy
    }
}
