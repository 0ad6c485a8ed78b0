//! [`Evidence`]: a block with the points at which it is judged.

use nalgebra::DMatrix;

use crate::check::block::Block;
use crate::check::place::Place;
use crate::check::setting::Setting;

/// The row and the column of an entry.
pub(super) type At = (usize, usize);

/// A block with the points at which it is judged.
pub(crate) struct Evidence<'a> {
    pub block: &'a Block<'a>,
    pub setting: &'a Setting<'a>,
    pub at: Vec<&'a Place>,
}

impl Evidence<'_> {
    /// Keeps the first points, and the worst of the others.
    pub(crate) fn with_worst(mut self, first: usize, most: usize) -> Self {
        let worst = |p: usize| self.entries().map(|entry| self.excess(p, entry)).fold(0.0, f64::max);
        let excesses: Vec<f64> = (0..self.at.len()).map(worst).collect();
        let mut others: Vec<_> = self.at.drain(first..).zip(excesses.into_iter().skip(first)).collect();
        others.sort_by(|a, b| b.1.total_cmp(&a.1));
        self.at.extend(others.into_iter().take(most).map(|(at, _)| at));
        self
    }

    /// |hand − true| relative to its tolerance; an entry is wrong if this exceeds 1.
    pub(crate) fn excess(&self, p: usize, entry: At) -> f64 {
        match self.difference(p, entry).abs() {
            0.0 => 0.0,
            error if error.is_nan() => f64::INFINITY,
            error => error / self.at[p].tolerance[entry],
        }
    }

    pub(super) fn difference(&self, p: usize, entry: At) -> f64 {
        self.at[p].hand[entry] - self.at[p].truth[entry]
    }

    pub(crate) fn rows(&self) -> usize {
        self.block.rows.len()
    }

    pub(crate) fn columns(&self) -> usize {
        self.block.columns.len()
    }

    /// All entries, row by row.
    pub(super) fn entries(&self) -> impl Iterator<Item = At> {
        let columns = self.columns();
        (0..self.rows()).flat_map(move |i| (0..columns).map(move |j| (i, j)))
    }

    /// The true block at changed points.
    pub(super) fn truth_at(&self, change: &dyn Fn(&mut [f64])) -> Vec<DMatrix<f64>> {
        let truth = |at: &&Place| {
            let mut x = at.x.clone();
            change(&mut x);
            self.block.truth.dual(&x)
        };
        self.at.iter().map(truth).collect()
    }

    /// True if there are groups of arguments, and few enough arguments to try all of them one by one.
    pub(super) fn is_small(&self) -> bool {
        !self.setting.groups.is_empty() && self.setting.arguments.len() <= 48
    }
}
