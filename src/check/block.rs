//! [`Block`]: a block of derivatives with the user's version, as the checks of elements, functions and steps create it.

use nalgebra::DMatrix;

use super::reference::Jacobian;

/// A matrix that depends on the point.
pub(crate) type MatrixAt<'a> = Box<dyn Fn(&[f64]) -> DMatrix<f64> + 'a>;

/// A change of a point.
pub(crate) type Change<'a> = Box<dyn Fn(&mut [f64]) + 'a>;

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
