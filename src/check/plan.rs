//! [`Plan`]: the blocks of a check and their setting.

use super::block::Block;
use super::compare::check;
use super::report::Report;
use super::setting::Setting;
#[cfg(feature = "files")]
use super::{Arguments, worksheet};
use crate::Error;

/// A check that is ready to be run.
pub(crate) struct Plan<'a> {
    blocks: Vec<Block<'a>>,
    setting: Setting<'a>,
}

impl<'a> Plan<'a> {
    /// Creates a plan of blocks whose rows have names; the columns are the setting's arguments.
    pub(crate) fn new(setting: Setting<'a>, blocks: impl Iterator<Item = Block<'a>>) -> Self {
        let named = |block: Block<'a>| Block { columns: setting.arguments[block.truth.by.clone()].to_vec(), ..block };
        Plan { blocks: blocks.map(named).collect(), setting }
    }

    /// Runs a plan; if it could not be created, the report contains the error.
    pub(crate) fn run(plan: Result<Self, Error>, title: String) -> Report {
        let (blocks, notes, refused) = match plan {
            Ok(Plan { blocks, setting }) => {
                (blocks.iter().map(|block| check(block, &setting)).collect(), setting.drawn.notes, None)
            }
            Err(error) => (Vec::new(), Vec::new(), Some(error)),
        };
        Report { title, blocks, notes, refused }
    }

    /// The points and the true blocks there as JSON; `at` names the arguments of a point.
    #[cfg(feature = "files")]
    pub(crate) fn worksheet<A: Arguments>(&self, title: &str, at: impl Fn(&[f64]) -> A) -> String {
        worksheet::of(title, &self.blocks, &self.setting, at)
    }
}
