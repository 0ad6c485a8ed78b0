//! A step that has no solution is halved, and its parts again: the motion goes on, on a grid that is written down.

use crate::refinement::Refinement;
use crate::simulate::Forward;
use crate::{Settings, Warning};

/// Parts of a step below this share of it, as a power of ½, are lost in its rounding.
const MOST_HALVINGS: usize = 52;

impl Forward {
    /// How the grid taken follows from the given one.
    pub(crate) fn refinement(&self) -> Refinement {
        Refinement::new(&self.inputs.grid.steps, &self.trajectory.inserted)
    }

    /// Whether the step that ends at a node may be shorter by half.
    pub(crate) fn may_halve(&self, node: usize, settings: &Settings) -> bool {
        let share = self.refinement().share(node);
        // Below this the end of the step would be its beginning.
        let (t, dt) = (self.trajectory.times[node - self.first - 1], self.inputs.grid.steps[node - 1]);
        share * 2f64.powi(settings.max_halvings.min(MOST_HALVINGS) as i32) > 1.5 && t + 0.25 * dt != t
    }

    /// Inserts a node in the middle of the step that ends at `node`, with the mean of the controls at its ends.
    pub(crate) fn halve(&mut self, node: usize) {
        let (grid, trajectory) = (&mut self.inputs.grid, &mut self.trajectory);
        // A window over a longer motion keeps its length.
        let is_whole = self.first == 0 && trajectory.times.len() == grid.nodes();
        let half = 0.5 * grid.steps[node - 1];
        grid.steps[node - 1] = half;
        grid.steps.insert(node, half);
        let controls = std::mem::take(&mut self.inputs.controls);
        let mean = 0.5 * (controls.column(node - 1) + controls.column(node));
        self.inputs.controls = controls.insert_column(node, 0.0);
        self.inputs.controls.set_column(node, &mean);
        trajectory.inserted.iter_mut().filter(|inserted| **inserted >= node).for_each(|inserted| *inserted += 1);
        let place = trajectory.inserted.partition_point(|&inserted| inserted < node);
        trajectory.inserted.insert(place, node);
        if is_whole {
            trajectory.add_column();
            let blocks = std::mem::take(&mut self.blocks);
            let columns = blocks.ncols();
            self.blocks = blocks.insert_column(columns, 0.0);
        }
    }

    pub(crate) fn warn_of_halved_steps(&mut self) {
        let inserted = self.trajectory.inserted.len();
        let Some(&first) = self.trajectory.inserted.first() else { return };
        let refinement = self.refinement();
        let parts = (1..=self.inputs.grid.steps.len()).filter(|&node| refinement.share(node) < 1.0);
        let lengths = parts.map(|node| self.inputs.grid.steps[node - 1].abs());
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        let time = self.inputs.grid.times()[first - 1];
        self.report.warn(Warning::HalvedSteps { step: refinement.given_step(first), time, inserted, shortest });
    }
}
