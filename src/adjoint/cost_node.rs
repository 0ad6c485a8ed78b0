//! [`CostNode`]: evaluates the costs of one node or stage.

use crate::accelerations::AccelerationsOfCosts;
use crate::motion::Compliances;
use crate::system::{CostPrograms, CostRows, Depends, NodeView, Weights};
use crate::{Error, System};

/// Quantities at a node that costs may need in addition to y and u.
pub(super) struct CostNode {
    pub(super) programs: CostPrograms,
    pub(super) accelerations: AccelerationsOfCosts,
    /// Empty if no cost needs it.
    pub(super) u_dot: Vec<f64>,
    /// Derivatives at another λ, computed if constraints depend on each other.
    aside: Option<Box<CostRows>>,
}

impl CostNode {
    pub(super) fn new(system: &System) -> Self {
        let u_dot = vec![0.0; if system.has_control_rates() { system.k() } else { 0 }];
        CostNode { programs: CostPrograms::default(), accelerations: AccelerationsOfCosts::default(), u_dot, aside: None }
    }

    /// Begins another motion.
    pub(super) fn begin(&mut self) {
        self.accelerations.own.iter_mut().for_each(|accelerations| accelerations.begin());
    }

    pub(super) fn view<'a>(&'a self, at: &NodeView<'a, f64>) -> NodeView<'a, f64> {
        let at = NodeView { u_dot: &self.u_dot, ..*at };
        self.accelerations.own.as_ref().map_or(at, |accelerations| accelerations.with(at))
    }

    /// Evaluates the costs of a node or stage, including their dependence on v̇ and λ.
    pub(super) fn evaluate(
        &mut self,
        system: &System,
        (at, place): (&NodeView<f64>, (usize, &Compliances)),
        weights: &Weights<f64>,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        self.accelerations.missing = None;
        let uses = system.use_of_accelerations(weights, &rows.factors);
        if uses > Depends::Never {
            self.accelerations.find(system, uses, |accelerations| accelerations.evaluate(system, at, place))?;
        }
        let CostNode { programs, accelerations, u_dot, .. } = self;
        let here = NodeView { u_dot, ..*at };
        let here = accelerations.own.as_ref().map_or(here, |accelerations| accelerations.with(here));
        system.costs().add(programs, (&here, None), weights, rows);
        if uses > Depends::Never && self.accelerations.missing.is_none() {
            self.check_aside(system, at, weights, rows)?;
        }
        match &mut self.accelerations.own {
            Some(accelerations) => accelerations.pull_back(system, at, rows),
            None => Ok(()),
        }
    }

    /// Returns an error for costs on undetermined reactions, even if their derivatives happen to be zero.
    fn check_aside(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        weights: &Weights<f64>,
        rows: &mut CostRows,
    ) -> Result<(), Error> {
        let CostNode { programs, accelerations, u_dot, aside } = self;
        let Some(accelerations) = accelerations.own.as_mut().filter(|own| own.is_compliant()) else { return Ok(()) };
        let sizes = (system.n(), system.m(), system.k());
        let aside = aside.get_or_insert_with(|| Box::new(CostRows::new(sizes, system.parameters().len(), system.outputs())));
        aside.factors.copy_from(&rows.factors);
        let at = NodeView { u_dot, ..*at };
        accelerations.check_aside(system, &at, aside, |there, aside| {
            system.costs().add(programs, (there, None), weights, aside);
        })
    }
}
