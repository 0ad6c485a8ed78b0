//! [`Dependent`]: what the rest of the library asks about dependent constraints while a motion is computed.

use super::circuits::Circuits;
use super::compliances::{Relaxed, refuse_gaps};
use crate::linear::Breakdown;
use crate::motion::{Motion, Report, column};
use crate::node::{Lengths, Linearisation, Point};
use crate::system::{Given, KnownPart};
use crate::{Error, Settings, System, Warning};

/// What is known of the dependent constraints of a motion.
pub(crate) struct Dependence {
    /// The dependent constraints of the last start that has any.
    pub(super) relaxed: Option<Relaxed>,
    pub(super) circuits: Circuits,
    pub(crate) losses: Losses,
}

/// What left-out equations have cost so far.
#[derive(Clone, Copy)]
pub(crate) struct Losses {
    /// Largest loss of kinetic energy by compliances, if it is worth a warning; largest kinetic energy at checked nodes.
    pub(super) most_braked: f64,
    pub(super) most_kinetic: f64,
    /// Loss of energy since left-out equations were chosen, if it is worth another choice.
    pub(super) brake: f64,
    /// True if left-out equations must be chosen anew, or positions projected, as soon as possible.
    pub(super) is_urgent: bool,
}

impl Losses {
    const NONE: Losses = Losses { most_braked: Warning::BRAKED, most_kinetic: 0.0, brake: 0.0, is_urgent: false };
}

impl Dependence {
    pub(crate) fn new() -> Self {
        Dependence { relaxed: None, circuits: Circuits::default(), losses: Losses::NONE }
    }

    /// Resets the losses of energy, for another motion.
    pub(crate) fn forget_brakes(&mut self) {
        self.losses = Losses::NONE;
    }

    /// Forgets which constraints depend on each other, for another start.
    pub(crate) fn forget_circuits(&mut self) {
        self.circuits.forget();
    }
}

/// The dependent constraints of a motion, at its last node.
pub(crate) struct Dependent<'a> {
    pub(crate) system: &'a System,
    pub(crate) motion: &'a mut Motion,
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    pub(crate) lengths: &'a mut Lengths,
    /// Workspace.
    pub(crate) point: &'a mut Point,
    /// The known part of the last node problem.
    pub(crate) from: KnownPart<'a>,
    pub(crate) state: &'a mut Dependence,
}

impl Dependent<'_> {
    /// Factors K(0) at the given start, before any solve.
    pub(crate) fn factor_start(&mut self) -> Result<(), Breakdown> {
        let Dependent { system, motion, linearisation, report, from, .. } = self;
        let given =
            Given { u: motion.inputs.controls_at(0), t: motion.trajectory.times[0], design: motion.design.as_slice() };
        let (v, sigma) = (column(&motion.trajectory.v, 0), column(&motion.trajectory.sigma, 0));
        linearisation.factor_at(system, &KnownPart { h: 0.0, ..*from }, given, (v, sigma), report)
    }

    /// Returns an error if dependent constraints cannot be satisfied together at a node, so that their compliances have gaps.
    #[cold]
    pub(crate) fn compare_gaps(&self, node: usize, settings: &Settings) -> Result<(), Error> {
        let (at, linearisation) = (self.motion.at(node), &self.linearisation);
        let sigma = |j: usize| at.sigma[j] - self.from.sigma[j];
        let within = (settings.velocity_tolerance, linearisation.size_of(at.v));
        refuse_gaps(self.system, &at, (linearisation.evaluation.compliance(), sigma), within)
    }
}
