//! [`Examiner`]: finds formulas that lose derivatives along a motion. Formulas that read values are examined at some nodes, also far from the start.

use nalgebra::DMatrix;

use super::computed::Motion;
use super::report::Report;
use crate::System;
use crate::model::element::Sum;
use crate::motion::column;
use crate::system::{NodeView, Order};

/// Number of examined nodes that are evenly spaced, and largest number of examined nodes whose states were badly predicted, as in a contact. The last
/// node and those of costs at single nodes are examined in addition.
const EXAMINED: usize = 8;

/// Examines formulas for lost derivatives of an order.
#[derive(Clone, Copy)]
pub(crate) struct Examiner {
    order: Order,
    /// Number of badly predicted nodes so far.
    surprises: usize,
}

impl Examiner {
    pub(crate) fn new(order: Order) -> Self {
        Examiner { order, surprises: 0 }
    }

    /// Warns of formulas that lose derivatives at a node, if the node is to be examined.
    #[inline]
    pub(crate) fn visit(&mut self, system: &System, motion: &Motion, node: usize, report: &mut Report) {
        if system.reads_values() && !motion.is_growing && self.is_worth_it(system, motion, node) {
            self.examine(system, motion, node, report);
        }
    }

    fn is_worth_it(&mut self, system: &System, motion: &Motion, node: usize) -> bool {
        let (nodes, is_surprise) = (motion.nodes(), motion.is_surprising(node));
        self.surprises += usize::from(is_surprise);
        let is_early = is_surprise && self.surprises <= EXAMINED;
        let is_even = node * EXAMINED % nodes < EXAMINED;
        is_even || node + 1 == nodes || is_early || system.reads_values_at(motion.node_of_whole(node))
    }

    fn examine(&self, system: &System, motion: &Motion, node: usize, report: &mut Report) {
        // The last step that has a length.
        let back = (0..node - motion.first).take_while(|back| motion.length(node - back) == 0.0).count();
        let (k, step) = (node - back - motion.first, (node - back).max(1));
        // Approximate accelerations and reactions are sufficient.
        let rates = |x: &DMatrix<f64>| -> Vec<f64> {
            let changes = column(x, k).iter().zip(column(x, k.saturating_sub(1))).map(|(now, before)| now - before);
            changes.map(|change| change / motion.length(step)).collect()
        };
        let (v_dot, lambda) = (rates(&motion.trajectory.v), rates(&motion.trajectory.sigma));
        let mut u_dot = vec![0.0; system.k()];
        motion.inputs.control_rates(step, &mut u_dot);
        let at = NodeView { v_dot: &v_dot, lambda: &lambda, u_dot: &u_dot, ..motion.at(node) };
        let counts = |sum: Sum| match sum {
            Sum::Terminal => node + 1 == motion.nodes(),
            Sum::Node(own) => own == motion.node_of_whole(node),
            _ => true,
        };
        let found = system.find_lost_derivatives(&at, counts, self.order, &report.warnings);
        found.into_iter().for_each(|warning| report.warn(warning));
    }
}
