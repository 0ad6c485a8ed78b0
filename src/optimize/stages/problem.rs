//! [`Staged`]: an optimisation problem in stages.

use nalgebra::{DMatrix, DVector};

use super::super::problem::Interval;
use crate::Error;

/// Sizes, bounds and intervals of a problem in stages.
///
/// ```text
///   min Σ f_k(v_k)    s_{k+1} = F_k(v_k),   c_k(v_k) within intervals,   v_k = (s_k, w_k) within bounds,   k = 0 … K,   v_K = s_K
/// ```
#[derive(Clone)]
pub(super) struct Shape {
    /// Number of entries of every s.
    pub states: usize,
    /// Entries of s that are quantities of the whole motion: in s_0 the only variables, in all others copies of them.
    pub of_whole: Vec<usize>,
    /// Bounds of v_k.
    pub bounds: Vec<Vec<Interval>>,
    /// Intervals of c_k.
    pub rows: Vec<Vec<Interval>>,
    /// 1 for variables, 0 for entries of s_k that are copies of earlier variables.
    pub shifted: Vec<DVector<f64>>,
}

/// Values of the functions of all stages.
pub(super) struct Values {
    /// Σ f_k.
    pub cost: f64,
    /// F_0 … F_{K−1}.
    pub next: Vec<DVector<f64>>,
    /// c_0 … c_K.
    pub rows: Vec<DVector<f64>>,
}

/// First derivatives of the functions of one stage.
pub(super) struct Linear {
    /// ∇f_k.
    pub gradient: DVector<f64>,
    /// ∂F_k/∂v_k.
    pub dynamics: DMatrix<f64>,
    /// ∂c_k/∂v_k.
    pub rows: DMatrix<f64>,
}

/// Multipliers of all constraints.
#[derive(Clone)]
pub(super) struct Multipliers {
    /// Of s_{k+1} = F_k, for k = 0 … K − 1.
    pub costates: Vec<DVector<f64>>,
    /// Of c_0 … c_K.
    pub rows: Vec<DVector<f64>>,
}

impl Multipliers {
    pub(super) fn zeros(shape: &Shape) -> Self {
        let costates = shape.rows.iter().skip(1).map(|_| DVector::zeros(shape.states)).collect();
        Multipliers { costates, rows: shape.rows.iter().map(|of| DVector::zeros(of.len())).collect() }
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &f64> {
        self.costates.iter().chain(&self.rows).flat_map(|of| of.iter())
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.costates.iter_mut().chain(&mut self.rows).flat_map(|of| of.iter_mut())
    }

    /// The largest absolute value.
    pub(super) fn largest(&self) -> f64 {
        self.all().fold(0.0f64, |most, x| most.max(x.abs()))
    }

    /// Sets all entries, in the order of [`all`](Self::all).
    pub(super) fn set(&mut self, to: &[f64]) {
        self.all_mut().zip(to).for_each(|(x, to)| *x = *to);
    }

    /// Adds α times other multipliers.
    pub(super) fn add(&mut self, alpha: f64, other: &Multipliers) {
        self.all_mut().zip(other.all()).for_each(|(x, by)| *x += alpha * by);
    }

    pub(super) fn scale(&mut self, by: f64) {
        self.all_mut().for_each(|x| *x *= by);
    }
}

/// Residuals of all constraints: F_k − s_{k+1}, and of the rows c_k.
#[derive(Clone)]
pub(super) struct Residuals {
    pub defects: Vec<DVector<f64>>,
    pub rows: Vec<DVector<f64>>,
}

impl Residuals {
    /// Residuals with the values of multipliers.
    pub(super) fn of(Multipliers { costates, rows }: Multipliers) -> Self {
        Residuals { defects: costates, rows }
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &f64> {
        self.defects.iter().chain(&self.rows).flat_map(|of| of.iter())
    }

    /// The residuals as multipliers of their constraints.
    pub(super) fn into_multipliers(self) -> Multipliers {
        Multipliers { costates: self.defects, rows: self.rows }
    }

    /// All residuals in one vector.
    pub(super) fn flat(&self) -> DVector<f64> {
        DVector::from_vec(self.all().copied().collect())
    }

    /// Multiplies by α and adds other residuals.
    pub(super) fn scale_and_add(&mut self, alpha: f64, other: &Residuals) {
        let all = self.defects.iter_mut().chain(&mut self.rows).flat_map(|of| of.iter_mut());
        all.zip(other.all()).for_each(|(x, by)| *x = alpha * *x + by);
    }
}

/// Numbers of evaluations, of right-hand sides of backward sweeps, and of Hessian products, over all stages.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub evaluations: usize,
    pub gradients: usize,
    pub products: usize,
}

/// An optimisation problem in stages.
pub(super) trait Staged {
    fn shape(&self) -> &Shape;

    fn counts(&self) -> Counts;

    /// True if steps were halved in the last evaluation.
    fn is_halved(&self) -> bool;

    /// The variables of the whole problem at a point.
    fn x(&self, v: &[DVector<f64>]) -> Vec<f64>;

    /// # Errors
    /// A point without values.
    fn evaluate(&mut self, v: &[DVector<f64>]) -> Result<Values, Error>;

    /// First derivatives at the last evaluated point.
    ///
    /// # Errors
    /// A point without derivatives.
    fn linearise(&mut self) -> Result<Vec<Linear>, Error>;

    /// Hessians by v_k of `cost` f_k, and of F_k and c_k times their multipliers, at the last evaluated point.
    ///
    /// # Errors
    /// A point without second derivatives.
    fn hessians(&mut self, cost: f64, multipliers: &Multipliers) -> Result<Vec<DMatrix<f64>>, Error>;
}
