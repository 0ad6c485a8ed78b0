//! [`Setting`]: points and tolerance of a comparison.

use std::ops::Range;

use super::block::Change;
use super::draw::Drawn;

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
