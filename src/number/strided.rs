//! [`Strided`]: numbers at equal distances in a list, as those of elements are that were made in a loop.
//!
//! Two numbers say where they stand, and loops over them need not look whether each place is there: half the work of a list of places.

use super::plus_product;

/// The first of several numbers, and how far each stands from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Strided {
    pub(crate) first: usize,
    pub(crate) stride: usize,
}

impl Strided {
    /// What stands at these places, if they are at least four at equal distances of one to three.
    pub(crate) fn new(places: &[u32]) -> Option<Self> {
        let [first, second, _, _, ..] = *places else { return None };
        let stride = second.checked_sub(first).filter(|stride| (1..=3).contains(stride))?;
        let even = places.windows(2).all(|pair| pair[1].checked_sub(pair[0]) == Some(stride));
        even.then_some(Strided { first: first as usize, stride: stride as usize })
    }

    /// Adds x y to them, where y are the numbers of another list with the same stride.
    #[inline]
    pub(crate) fn add_products(self, x: &[f64], (y, of): (Strided, &[f64]), to: &mut [f64]) {
        debug_assert_eq!(self.stride, y.stride);
        let (of, to) = (&of[y.first..], &mut to[self.first..]);
        match self.stride {
            1 => add_products::<1>(x, of, to),
            2 => add_products::<2>(x, of, to),
            _ => add_products::<3>(x, of, to),
        }
    }
}

#[inline(always)]
fn add_products<const D: usize>(x: &[f64], y: &[f64], to: &mut [f64]) {
    // After the last number there may be less than the distance to another.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn number(k: usize) -> f64 {
        (0.7 * k as f64).sin()
    }

    fn at(first: usize, stride: usize) -> Strided {
        let places: Vec<u32> = (0..4).map(|k| (first + k * stride) as u32).collect();
        Strided::new(&places).expect("equal distances")
    }

    #[test]
    fn strided_loops_agree_with_plain_ones() {
        for stride in 1..=3 {
            for count in 1..=21 {
                // No longer than the last of them needs.
                let y: Vec<f64> = (0..6 + (count - 1) * stride).map(number).collect();
                let x: Vec<f64> = (0..count).map(|k| number(k + 50)).collect();
                let (mut sums, mut expected) = (y[3..].to_vec(), y[3..].to_vec());
                at(2, stride).add_products(&x, (at(5, stride), &y), &mut sums);
                (0..count).for_each(|k| {
                    let to = &mut expected[2 + k * stride];
                    *to = plus_product(*to, x[k], y[5 + k * stride]);
                });
                assert_eq!(sums, expected, "{count} at {stride}");
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
