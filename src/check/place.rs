//! A point where a block is compared, with the true value and the scales of its errors.

use nalgebra::DMatrix;
use std::ops::Range;

use super::reference::{Jacobian, differenced};
use super::scale::sizes;
use super::setting::Setting;
use crate::number::Random;

/// Allowed error of an entry in multiples of the noise of the true value.
pub(crate) const NOISE: f64 = 64.0;
/// Allowed error as a fraction of the largest change in the row, per size of the argument: a slope of 1e-36 may be given as 0.
const LOST: f64 = 1e-20;
/// Values within this factor count as similar in size, because sums of like terms may cancel at one place.
const ALIKE: f64 = 16.0;

/// A point and the true block there.
pub(crate) struct Place {
    /// Index of the place, counted from 0; the points come first, then the places at which the formula has a branch or a narrow feature.
    pub number: usize,
    pub x: Vec<f64>,
    /// The place from which this one was derived, by reducing some arguments or by a search.
    parent: Option<usize>,
    /// The user's values; empty until they are computed.
    pub hand: DMatrix<f64>,
    /// The true values, by dual numbers.
    pub truth: DMatrix<f64>,
    pub complex_step: DMatrix<f64>,
    /// Derivatives by finite differences; NaN in columns that were not differenced.
    pub differences: DMatrix<f64>,
    /// Estimated error of the finite differences.
    pub differences_error: DMatrix<f64>,
    /// Changes of the entries when the arguments change by rounding.
    pub noise: DMatrix<f64>,
    /// Values of the function itself, for the scales of the rows.
    function: Vec<f64>,
    /// r_i c_j of the entries at this place, or at another one if larger there and if its rounding errors may occur at this place.
    pub scale: DMatrix<f64>,
    /// Allowed errors of the entries: a fraction of r_i c_j plus rounding.
    pub tolerance: DMatrix<f64>,
}

impl Place {
    /// Computes the derivatives by dual numbers and complex step; everything else is filled in later.
    pub(crate) fn new(of: &Jacobian, x: Vec<f64>, parent: Option<usize>, random: &mut Random) -> Self {
        let truth = of.dual(&x);
        let (rows, columns) = truth.shape();
        let none = || DMatrix::zeros(0, 0);
        Place {
            complex_step: of.complex_step(&x),
            differences: DMatrix::from_element(rows, columns, f64::NAN),
            differences_error: DMatrix::from_element(rows, columns, f64::INFINITY),
            noise: of.noise(&x, &truth, random),
            function: of.function.real(&x),
            number: 0,
            hand: none(),
            scale: none(),
            tolerance: none(),
            x,
            parent,
            truth,
        }
    }

    /// All points of a setting, with differences.
    pub(crate) fn of_points(of: &Jacobian, setting: &Setting, random: &mut Random) -> Vec<Self> {
        let mut place = |(x, &parent): (&Vec<f64>, &Option<usize>)| {
            let mut place = Place::new(of, x.clone(), parent, random);
            place.difference(of, &setting.magnitudes, random);
            place
        };
        setting.drawn.points.iter().zip(&setting.drawn.parents).map(&mut place).collect()
    }

    /// Adds the differences; `magnitudes` are the typical sizes of the arguments.
    pub(crate) fn difference(&mut self, of: &Jacobian, magnitudes: &[f64], random: &mut Random) {
        for j in differenced(self.truth.ncols(), random) {
            let (estimate, error) = of.differences(&self.x, j, magnitudes, 0);
            self.differences.column_mut(j).copy_from_slice(&estimate);
            self.differences_error.column_mut(j).copy_from_slice(&error);
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.truth.iter().chain(&self.complex_step).chain(&self.function).all(|x| x.is_finite())
    }

    /// True if the user's values are true within the tolerance (or have a wrong shape, which is reported elsewhere).
    pub(crate) fn holds(&self) -> bool {
        let within = |(i, within): (usize, &f64)| (self.hand[i] - self.truth[i]).abs() <= *within;
        self.hand.shape() != self.truth.shape() || self.tolerance.iter().enumerate().all(within)
    }
}

/// Sets numbers, scales and tolerances; the first places are the points of the setting.
///
/// A hand-derived formula may round more than the reference does: far from 0, 1 − tanh² has the rounding error of 1, its value at 0. The
/// scale of an entry is therefore the largest of its values at places where the *function* is about as large as here or as usual, and
/// at the parent: the terms there may be rounded here. So the scale of exp(20 x) at x = −1 is not its value at x = 1.
pub(crate) fn set_scales(places: &mut [Place], by: &Range<usize>, setting: &Setting) {
    let points = setting.drawn.points.len();
    let finite = |x: f64| if x.is_finite() { x.abs() } else { 0.0 };
    let values: Vec<DMatrix<f64>> = places.iter().map(|place| place.truth.map(finite)).collect();
    let functions: Vec<Vec<f64>> = places.iter().map(|place| place.function.iter().map(|&y| finite(y)).collect()).collect();
    let usual = |i: usize| {
        let mut sizes: Vec<f64> = functions[..points].iter().map(|f| f[i]).collect();
        sizes.sort_by(f64::total_cmp);
        sizes[(points - 1) / 2]
    };
    let usual: Vec<f64> = (0..functions[0].len()).map(usual).collect();
    let magnitude = |j: usize| setting.magnitudes[by.start + j];
    // Largest change of a row's function by one column, and the maximum over all points.
    let change =
        |value: &DMatrix<f64>, i: usize| (0..value.ncols()).fold(0.0f64, |m, j| m.max(value[(i, j)] * magnitude(j)));
    let most: Vec<f64> =
        (0..usual.len()).map(|i| values[..points].iter().fold(0.0f64, |m, v| m.max(change(v, i)))).collect();
    for (p, place) in places.iter_mut().enumerate() {
        let (value, function) = (&values[p], &functions[p]);
        // An empty column gets the size that would change the row's function as much as the others do. The function's own value counts at
        // most as much as the largest change, if there is one, because it may contain an offset.
        let limit = |i: usize| if most[i] > 0.0 { most[i] } else { f64::INFINITY };
        let row = |i: usize| change(value, i).max(function[i].min(limit(i)));
        let size = sizes(value, |i, j| row(i) / magnitude(j));
        place.scale = size.clone();
        for i in 0..value.nrows() {
            let near = |o: &usize| functions[*o][i] <= ALIKE * function[i].max(usual[i]) || place.parent == Some(*o);
            for o in (0..values.len()).filter(near) {
                (0..value.ncols()).for_each(|j| place.scale[(i, j)] = place.scale[(i, j)].max(values[o][(i, j)]));
            }
        }
        let rounding = place.scale.zip_map(&place.noise, |scale, noise| NOISE * noise.max(f64::EPSILON * scale));
        let lost = |i: usize, j: usize| LOST * change(value, i) / magnitude(j);
        place.tolerance = size.zip_map(&rounding, |size, rounding| setting.tolerance * size + rounding);
        place.tolerance = place.tolerance.map_with_location(|i, j, within| within + lost(i, j));
        place.number = p;
    }
}
