//! Sets of entries of a block, and how people call them.

use super::Evidence;

/// Some entries of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mask {
    pub(super) entries: Vec<(usize, usize)>,
}

impl Mask {
    pub(super) fn all(evidence: &Evidence) -> Self {
        let columns = evidence.columns();
        Mask { entries: (0..evidence.rows()).flat_map(|i| (0..columns).map(move |j| (i, j))).collect() }
    }

    /// The entries that are wrong at some point.
    pub(super) fn wrong(evidence: &Evidence) -> Self {
        let is_wrong = |&(i, j): &(usize, usize)| (0..evidence.points.len()).any(|p| evidence.excess(p, i, j) > 1.0);
        Mask { entries: Mask::all(evidence).entries.into_iter().filter(is_wrong).collect() }
    }

    fn split(&self, key: impl Fn(&(usize, usize)) -> usize) -> Vec<Mask> {
        let mut keys: Vec<usize> = self.entries.iter().map(&key).collect();
        keys.sort_unstable();
        keys.dedup();
        let one = |k| Mask { entries: self.entries.iter().copied().filter(|e| key(e) == k).collect() };
        keys.into_iter().map(one).collect()
    }

    pub(super) fn by_rows(&self) -> Vec<Mask> {
        self.split(|e| e.0)
    }

    pub(super) fn by_columns(&self) -> Vec<Mask> {
        self.split(|e| e.1)
    }

    pub(super) fn singles(&self) -> Vec<Mask> {
        self.entries.iter().map(|&e| Mask { entries: vec![e] }).collect()
    }

    /// "in the whole block", "in row …", "in the entry …": for the end of a sentence.
    pub(super) fn place(&self, evidence: &Evidence) -> String {
        let (rows, columns) = (&evidence.block.rows, &evidence.block.columns);
        if self.entries.len() == evidence.rows() * evidence.columns() {
            return "in the whole block".into();
        }
        if let [(i, j)] = self.entries[..] {
            return format!("in d({})/d({})", rows[i], columns[j]);
        }
        let (by_rows, by_columns) = (self.by_rows(), self.by_columns());
        if let [row] = &by_rows[..] {
            return format!("in the row of {}", rows[row.entries[0].0]);
        }
        if let [column] = &by_columns[..] {
            return format!("in the column of {}", columns[column.entries[0].1]);
        }
        if self.entries.iter().all(|(i, j)| i == j) {
            return "on the diagonal".into();
        }
        if self.entries.iter().all(|(i, j)| i > j) {
            return "below the diagonal".into();
        }
        if self.entries.iter().all(|(i, j)| i < j) {
            return "above the diagonal".into();
        }
        format!("in {} of the {} entries", self.entries.len(), evidence.rows() * evidence.columns())
    }
}
