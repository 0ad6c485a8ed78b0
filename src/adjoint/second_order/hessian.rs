//! Hessians along several directions, without backward sweeps: with the sources S of direction j at each stage, and the changes of the motion along i,
//!
//! ```text
//!   d_iᵀ H d_j = Σ (S_q·q̇_i + S_v·v̇_i + S_p*·ṗ_i + S_g·ġ_i + S_σ·σ̇_i)  +  what the formulas with the controls change by themselves
//! ```
//!
//! A backward sweep along j, whose equations are the transpose of those of the changes along i, would find the same sums.

use super::{First, SecondOrderSweep, check, recorded};
use crate::adjoint::{AdjointSweep, Gradient};
use crate::motion::Motion;
use crate::node::{Linearisation, SolvedMotion};
use crate::number::all_finite;
use crate::system::{CostRows, NodeView};
use crate::{Error, Inputs, Settings, System};

/// Changes of a motion along the directions of a Hessian.
#[derive(Default)]
pub(super) struct Changes {
    /// The number of all directions.
    directions: usize,
    /// The number of directions up to the current one.
    known: usize,
    /// The changes along all directions, next to each other, of each entry of (q, v, p*, ṗ*, σ) at each stage.
    entries: Vec<f64>,
    /// The products of the current sources with the known changes.
    products: Vec<f64>,
}

impl Changes {
    fn begin(&mut self, directions: usize, entries: usize) {
        (self.directions, self.known) = (directions, 0);
        self.entries.clear();
        self.entries.resize(entries * directions, 0.0);
    }

    /// Begins the next direction.
    fn next(&mut self) {
        self.known += 1;
        self.products.clear();
        self.products.resize(self.known, 0.0);
    }

    /// Stores the changes of a stage along the current direction.
    fn store(&mut self, stage: usize, NodeView { q, v, p_star, p_star_dot, sigma, .. }: &NodeView<f64>) {
        let states = [*q, v, p_star, p_star_dot, sigma];
        let mut at = self.known - 1 + stage * rows(states) * self.directions;
        for list in states {
            for x in list {
                self.entries[at] = *x;
                at += self.directions;
            }
        }
    }

    /// Adds the products of sources with the changes of a stage.
    fn multiply(&mut self, stage: usize, CostRows { q, v, p_star, p_star_dot, sigma, .. }: &CostRows) {
        let sources = [&q[..], v, p_star, p_star_dot, sigma];
        let mut at = stage * rows(sources) * self.directions;
        for list in sources {
            for source in list {
                if *source != 0.0 {
                    let along_known = &self.entries[at..at + self.known];
                    self.products.iter_mut().zip(along_known).for_each(|(sum, x)| *sum += source * x);
                }
                at += self.directions;
            }
        }
    }
}

fn rows(lists: [&[f64]; 5]) -> usize {
    lists.iter().map(|list| list.len()).sum()
}

impl SecondOrderSweep {
    /// Begins a Hessian along a number of directions.
    pub(crate) fn begin_hessian(
        &mut self,
        system: &System,
        (mut solved, first): (SolvedMotion, &mut AdjointSweep),
        settings: &Settings,
        directions: usize,
    ) -> Result<(), Error> {
        let first = recorded(first, system, &mut solved, settings)?;
        let SolvedMotion { motion, linearisation, .. } = solved;
        self.begin(system, motion, linearisation)?;
        self.begin_sources(system, motion, &first)?;
        self.changes.begin(directions, motion.blocks.ncols() * (4 * system.n() + system.m()));
        Ok(())
    }

    /// The next row of the Hessian, along a direction of controls, or of the start if momenta are given, which changes nothing before a node.
    pub(crate) fn hessian_along(
        &mut self,
        system: &System,
        (mut solved, first): (SolvedMotion, &mut AdjointSweep),
        settings: &Settings,
        (direction, node): (&Inputs, usize),
    ) -> Result<(&Gradient, &[f64]), Error> {
        check(solved.motion, direction)?;
        let first = recorded(first, system, &mut solved, settings)?;
        let SolvedMotion { motion, linearisation, .. } = solved;
        // A control in a step has an effect on costs with control rates at the node before it. Halved steps have other nodes.
        let is_given = motion.trajectory.inserted.is_empty();
        let from = if is_given { node.saturating_sub(usize::from(system.has_control_rates())) } else { 0 };
        self.follow(system, motion, direction);
        self.forward(system, motion, linearisation, from)?;
        self.changes.next();
        self.sweep.gradient.controls.fill(0.0);
        self.sweep.gradient.start.q_mut().fill(0.0);
        self.sweep.gradient.start.rate_mut().fill(0.0);
        for node in from..motion.nodes() {
            self.add_products(system, motion, (linearisation, &first), node)?;
        }
        if all_finite(&self.changes.products) && all_finite(self.sweep.gradient.controls.as_slice()) {
            return Ok((&self.sweep.gradient, &self.changes.products));
        }
        let overflow = || Error::Overflow { what: "a second derivative".into(), value: f64::NAN };
        Err(self.suspect.take().unwrap_or_else(overflow))
    }

    /// Multiplies the sources of a node, and of the stages of the step before it, with the known changes.
    fn add_products(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&Linearisation, &First),
        node: usize,
    ) -> Result<(), Error> {
        let last = motion.trajectory.last_stage();
        for s in if node == 0 { last..=last } else { 1..=last } {
            if s == last {
                self.sources_of_node(system, motion, (linearisation, first), node)?;
                let sweep = &mut self.sweep;
                sweep.refinement.add_controls(node, 1.0, &sweep.u, &mut sweep.gradient.controls);
            } else {
                self.sources_of_stage(system, motion, (linearisation, first), (node, s))?;
                self.sweep.add_inner_inputs(node, motion.trajectory.scheme.c(s));
            }
            let stage = motion.block_column(node, s);
            self.changes.store(stage, &self.change.at_stage(node, s));
            if !first.record.has_nothing(stage) {
                self.changes.multiply(stage, &self.sweep.cost);
            }
        }
        Ok(())
    }
}
