//! [`Strided`]: numbers at equal distances in a list, as of elements created in a loop; and their differences, [`StridedDifference`].
//!
//! Two numbers describe the positions, and loops need not check that each position exists: half the work of a list of positions.

use super::plus_product;

/// Position of the first of several numbers, and the distance between successive ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Strided {
    pub(crate) first: usize,
    pub(crate) stride: usize,
}

impl Strided {
    /// The numbers at these places, if they are at least four at equal distances of one to three.
    pub(crate) fn new(places: &[u32]) -> Option<Self> {
        let [first, second, _, _, ..] = *places else { return None };
        let stride = second.checked_sub(first).filter(|stride| (1..=3).contains(stride))?;
        let even = places.windows(2).all(|pair| pair[1].checked_sub(pair[0]) == Some(stride));
        even.then_some(Strided { first: first as usize, stride: stride as usize })
    }
}

/// Strided numbers, or their differences from others with the same stride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StridedDifference {
    first: usize,
    /// Position of the first subtracted number, if differences are taken.
    reference: Option<usize>,
    pub(crate) stride: usize,
}

impl StridedDifference {
    /// The numbers at some places, minus those at others.
    pub(crate) fn new(places: &[u32], reference: Option<&[u32]>) -> Option<Self> {
        let Strided { first, stride } = Strided::new(places)?;
        let reference = match reference {
            Some(places) => Some(Strided::new(places).filter(|reference| reference.stride == stride)?.first),
            None => None,
        };
        Some(StridedDifference { first, reference, stride })
    }

    /// Adds x y to the numbers, where y are those of another list with the same stride. For a difference, the products are added to its first
    /// number and subtracted from the other.
    #[inline]
    pub(crate) fn add_products(self, x: &[f64], (y, of): (StridedDifference, &[f64]), to: &mut [f64]) {
        debug_assert_eq!(self.stride, y.stride);
        match self.stride {
            1 => self.add_products_at::<1>(x, (y, of), to),
            2 => self.add_products_at::<2>(x, (y, of), to),
            _ => self.add_products_at::<3>(x, (y, of), to),
        }
    }

    #[inline(always)]
    fn add_products_at<const D: usize>(self, x: &[f64], (y, of): (StridedDifference, &[f64]), to: &mut [f64]) {
        let [at, y_at] = [self, y].map(|difference| [difference.first, difference.reference.unwrap_or_default()]);
        match [self.reference, y.reference].map(|reference| reference.is_some()) {
            [false, false] => add_products::<D>(x, &of[y.first..], &mut to[self.first..]),
            [false, true] => add_differences::<D, false, true>(x, (y_at, of), (at, to)),
            [true, false] => add_differences::<D, true, false>(x, (y_at, of), (at, to)),
            [true, true] => add_differences::<D, true, true>(x, (y_at, of), (at, to)),
        }
    }
}

#[inline(always)]
fn add_products<const D: usize>(x: &[f64], y: &[f64], to: &mut [f64]) {
    // After the last number there may be fewer entries than the stride.
    let Some((last, x)) = x.split_last() else { return };
    let end = x.len() * D;
    to[end] = plus_product(to[end], *last, y[end]);
    let (y, to) = (y[..end].as_chunks::<D>().0, to[..end].as_chunks_mut::<D>().0);
    let ((x, x_rest), (y, y_rest), (to, to_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>(), to.as_chunks_mut::<4>());
    for ((x, y), to) in x.iter().zip(y).zip(to) {
        for k in 0..4 {
            to[k][0] = plus_product(to[k][0], x[k], y[k][0]);
        }
    }
    x_rest.iter().zip(y_rest).zip(to_rest).for_each(|((x, y), to)| to[0] = plus_product(to[0], *x, y[0]));
}

/// Adds products to differences, of differences, or both.
#[inline(always)]
fn add_differences<const D: usize, const TO: bool, const OF: bool>(
    x: &[f64],
    (y, of): ([usize; 2], &[f64]),
    (at, to): ([usize; 2], &mut [f64]),
) {
    let (fours, rest) = x.as_chunks::<4>();
    for (k, x) in fours.iter().enumerate() {
        let behind = |first: usize| first + 4 * D * k;
        add_some::<D, 4, TO, OF>(x, (y.map(behind), of), (at.map(behind), to));
    }
    for (k, x) in rest.iter().enumerate() {
        let behind = |first: usize| first + (4 * fours.len() + k) * D;
        add_some::<D, 1, TO, OF>(&[*x], (y.map(behind), of), (at.map(behind), to));
    }
}

// If the last place exists, so do all: only one is checked.
#[inline(always)]
fn add_some<const D: usize, const L: usize, const TO: bool, const OF: bool>(
    x: &[f64; L],
    ([y, y_reference], of): ([usize; 2], &[f64]),
    ([at, reference], to): ([usize; 2], &mut [f64]),
) {
    let len = (L - 1) * D + 1;
    let y = &of[y..][..len];
    let mut products: [f64; L] = std::array::from_fn(|k| y[k * D]);
    if OF {
        let y = &of[y_reference..][..len];
        products = std::array::from_fn(|k| products[k] - y[k * D]);
    }
    products = std::array::from_fn(|k| products[k] * x[k]);
    let sums = &mut to[at..][..len];
    (0..L).for_each(|k| sums[k * D] += products[k]);
    if TO {
        let sums = &mut to[reference..][..len];
        (0..L).for_each(|k| sums[k * D] -= products[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(k: usize) -> f64 {
        (0.7 * k as f64).sin()
    }

    fn places(first: usize, stride: usize) -> Vec<u32> {
        (0..4).map(|k| (first + k * stride) as u32).collect()
    }

    /// Products for and with numbers and differences, for lists no longer than the last of them needs.
    #[test]
    fn strided_loops_agree_with_plain_ones() {
        let references = [None, Some(0), Some(9)];
        for (stride, count) in (1..=3).flat_map(|stride| (1..=21).map(move |count| (stride, count))) {
            for (reference, y_reference) in references.into_iter().flat_map(|a| references.map(|b| (a, b))) {
                let at = |first: usize, reference: Option<usize>| {
                    let reference = reference.map(|first| places(first, stride));
                    StridedDifference::new(&places(first, stride), reference.as_deref()).expect("equal distances")
                };
                let len =
                    |first: usize, reference: Option<usize>| first.max(reference.unwrap_or(0)) + (count - 1) * stride + 1;
                let y: Vec<f64> = (0..len(5, y_reference)).map(number).collect();
                let x: Vec<f64> = (0..count).map(|k| number(k + 50)).collect();
                let mut sums: Vec<f64> = (0..len(2, reference)).map(|k| number(k + 90)).collect();
                let mut expected = sums.clone();
                at(2, reference).add_products(&x, (at(5, y_reference), &y), &mut sums);
                for k in 0..count {
                    let product = x[k] * (y[5 + k * stride] - y_reference.map_or(0.0, |first| y[first + k * stride]));
                    expected[2 + k * stride] += product;
                    reference.into_iter().for_each(|first| expected[first + k * stride] -= product);
                }
                let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-14;
                assert!(sums.iter().zip(&expected).all(is_close), "{count} at {stride}: {sums:?} for {expected:?}");
            }
        }
    }

    #[test]
    fn places_at_unequal_distances_need_a_list() {
        assert_eq!(Strided::new(&[2, 5, 8, 11]), Some(Strided { first: 2, stride: 3 }));
        let lists: [&[u32]; 6] = [&[1, 2, 3], &[4, 4, 4, 4], &[9, 8, 7, 6], &[0, 1, 2, 4], &[0, 4, 8, 12], &[3, 5, 7, 5]];
        assert!(lists.iter().all(|places| Strided::new(places).is_none()));
    }
}
