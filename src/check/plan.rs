//! Blocks and the setting of a comparison, which the checks of elements, functions and steps create.

use nalgebra::DMatrix;
use std::ops::Range;

use super::compare::check;
use super::draw::Drawn;
use super::reference::Jacobian;
use super::report::Report;
#[cfg(feature = "files")]
use super::{Arguments, worksheet};
use crate::Error;

/// A matrix that depends on the point.
pub(crate) type MatrixAt<'a> = Box<dyn Fn(&[f64]) -> DMatrix<f64> + 'a>;

/// A block of derivatives: the function and its variables, and the user's version.
pub(crate) struct Block<'a> {
    pub name: String,
    pub truth: Jacobian<'a>,
    /// The derivative from which this block's function is formed, if any; the references must agree on it too.
    pub foundation: Option<Jacobian<'a>>,
    pub rows: Vec<String>,
    pub columns: Vec<String>,
    pub hand: MatrixAt<'a>,
    /// Named terms that may be missing in the user's block.
    pub terms: Vec<(String, MatrixAt<'a>)>,
    /// Named matrices that the user may have given instead of this block.
    pub others: Vec<(String, MatrixAt<'a>)>,
    /// Named changes of a point: the user may have computed the true value at the changed point ("node i − 1").
    pub elsewhere: Vec<(String, Change<'a>)>,
}

/// A change of a point.
pub(crate) type Change<'a> = Box<dyn Fn(&mut [f64]) + 'a>;
type Admissible<'a> = Box<dyn Fn(&[f64]) -> bool + 'a>;

/// Points and tolerance of a comparison.
pub(crate) struct Setting<'a> {
    pub drawn: Drawn,
    /// Arguments that may be moved to reach a branch or a narrow feature of the formula, and the bounds of each argument.
    pub free: Vec<usize>,
    pub bounds: Vec<[f64; 2]>,
    /// Adjusts the other arguments of a point so that they are consistent with those that were moved.
    pub settle: Change<'a>,
    pub admissible: Admissible<'a>,
    pub seed: u64,
    /// The typical size of each argument.
    pub magnitudes: Vec<f64>,
    /// The name of each argument.
    pub arguments: Vec<String>,
    /// Arguments of one kind (q, v, σ, …), which may be mistaken for one another; empty if they cannot be changed freely.
    pub groups: Vec<(String, Range<usize>)>,
    /// Named constants that are tried as erroneous factors of the user's block.
    pub factors: Vec<(String, f64)>,
    /// Tolerance of an entry, relative to the size of its row and column.
    pub tolerance: f64,
}

/// A check that is ready to be run.
pub(crate) struct Plan<'a> {
    blocks: Vec<Block<'a>>,
    setting: Setting<'a>,
}

impl<'a> Block<'a> {
    /// Creates a block without names and without candidates for a diagnosis.
    pub(crate) fn new(name: impl Into<String>, truth: Jacobian<'a>, hand: MatrixAt<'a>) -> Self {
        Block {
            name: name.into(),
            truth,
            foundation: None,
            rows: Vec::new(),
            columns: Vec::new(),
            hand,
            terms: Vec::new(),
            others: Vec::new(),
            elsewhere: Vec::new(),
        }
    }
}

impl<'a> Setting<'a> {
    /// Creates a setting for these points and arguments; none of the arguments may be moved yet.
    pub(crate) fn new(drawn: Drawn, seed: u64, tolerance: f64, arguments: Vec<String>, magnitudes: Vec<f64>) -> Self {
        let size = |x: f64| if x == 0.0 { 1.0 } else { x.abs() };
        Setting {
            drawn,
            free: Vec::new(),
            bounds: vec![[f64::NEG_INFINITY, f64::INFINITY]; arguments.len()],
            settle: Box::new(|_| ()),
            admissible: Box::new(|_| true),
            seed,
            magnitudes: magnitudes.into_iter().map(size).collect(),
            arguments,
            groups: Vec::new(),
            factors: Vec::new(),
            tolerance,
        }
    }
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
