//! What can be asked for by name.

use std::path::Path;

use clap::ValueEnum;

use crate::error::Error;
use crate::experiment::Experiment;
use crate::figures::{fig1, fig2, fig3, fig4, fig5, fig6};
use crate::table::Row;
use crate::timing;

/// A figure or a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Part {
    /// Layout of the mechanism
    Fig1,
    /// Snapshots of the swing-up
    Fig2,
    /// Cost and optimality over the iterations
    Fig3,
    /// Constraints on three levels
    Fig4,
    /// Force during the optimisation
    Fig5,
    /// Gradient by two methods
    Fig6,
    /// Adjoint against complex step
    Timing,
}

impl Part {
    /// Everything in section 4 of the paper.
    pub const PAPER: [Part; 7] = [Part::Fig1, Part::Fig2, Part::Fig3, Part::Fig4, Part::Fig5, Part::Fig6, Part::Timing];

    pub fn make(self, experiment: &Experiment, folder: &Path) -> Result<Vec<Row>, Error> {
        match self {
            Part::Fig1 => fig1::draw(experiment, &folder.join("fig1")),
            Part::Fig2 => fig2::draw(experiment, &folder.join("fig2")),
            Part::Fig3 => fig3::draw(experiment, &folder.join("fig3")),
            Part::Fig4 => fig4::draw(experiment, &folder.join("fig4")),
            Part::Fig5 => fig5::draw(experiment, &folder.join("fig5")),
            Part::Fig6 => fig6::draw(experiment, &folder.join("fig6")),
            Part::Timing => Ok(timing::claims(experiment.timing()?)),
        }
    }
}
