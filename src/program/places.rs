//! [`Places`]: the places in a list of the numbers of elements that are computed side by side.

use crate::number::Strided;

/// The places from which inputs are read, or to which results are added, number by number.
#[derive(Clone, Debug)]
pub(crate) enum Places {
    /// For each number, the place for the first lane; those of the other lanes follow at equal distances.
    Strided { firsts: Vec<usize>, stride: usize },
    /// For each number, the places lane by lane.
    Any(Vec<u32>),
}

impl Places {
    /// Converts a list of places, ordered by number and within a number by lane.
    pub(super) fn new(places: Vec<u32>, lanes: usize) -> Self {
        let numbers: Option<Vec<Strided>> = places.chunks_exact(lanes).map(Strided::new).collect();
        let numbers = numbers.unwrap_or_default();
        match numbers.first() {
            Some(first) if numbers.iter().all(|number| number.stride == first.stride) => {
                Places::Strided { firsts: numbers.iter().map(|number| number.first).collect(), stride: first.stride }
            }
            _ => Places::Any(places),
        }
    }

    /// Reads the numbers into the first registers.
    #[inline]
    pub(super) fn gather<const L: usize>(&self, from: &[f64], registers: &mut [[f64; L]]) {
        match self {
            Places::Strided { firsts, stride: 1 } => gather::<1, L>(firsts, from, registers),
            Places::Strided { firsts, stride: 2 } => gather::<2, L>(firsts, from, registers),
            Places::Strided { firsts, .. } => gather::<3, L>(firsts, from, registers),
            Places::Any(places) => {
                for (places, register) in places.as_chunks::<L>().0.iter().zip(registers) {
                    *register = places.map(|place| from[place as usize]);
                }
            }
        }
    }

    /// Adds numbers at their places.
    #[inline]
    pub(super) fn add<const L: usize>(&self, numbers: impl Iterator<Item = [f64; L]>, to: &mut [f64]) {
        match self {
            Places::Strided { firsts, stride: 1 } => add::<1, L>(firsts, numbers, to),
            Places::Strided { firsts, stride: 2 } => add::<2, L>(firsts, numbers, to),
            Places::Strided { firsts, .. } => add::<3, L>(firsts, numbers, to),
            Places::Any(places) => {
                for (places, x) in places.as_chunks::<L>().0.iter().zip(numbers) {
                    places.iter().zip(x).for_each(|(&place, x)| to[place as usize] += x);
                }
            }
        }
    }
}

// If the place of the last lane is within bounds, so are all others; no further bounds are checked.

#[inline(always)]
fn gather<const D: usize, const L: usize>(firsts: &[usize], from: &[f64], registers: &mut [[f64; L]]) {
    for (&first, register) in firsts.iter().zip(registers) {
        let from = &from[first..][..(L - 1) * D + 1];
        register.iter_mut().enumerate().for_each(|(lane, x)| *x = from[lane * D]);
    }
}

#[inline(always)]
fn add<const D: usize, const L: usize>(firsts: &[usize], numbers: impl Iterator<Item = [f64; L]>, to: &mut [f64]) {
    for (&first, x) in firsts.iter().zip(numbers) {
        let to = &mut to[first..][..(L - 1) * D + 1];
        x.iter().enumerate().for_each(|(lane, x)| to[lane * D] += x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two numbers of each of four elements, with and without equal distances.
    #[test]
    fn strided_places_and_lists_say_the_same() {
        let number = |k: usize| (0.7 * k as f64).sin();
        for distances in [[1; 3], [2; 3], [3; 3], [2, 3, 2], [0; 3], [5; 3]] {
            let mut list = Vec::new();
            for first in [4, 3] {
                list.extend([0, distances[0], distances[0] + distances[1], distances.iter().sum()].map(|at| first + at));
            }
            let places = Places::new(list.clone(), 4);
            let is_strided = matches!(places, Places::Strided { .. });
            assert_eq!(is_strided, (1..=3).contains(&distances[0]) && distances[1] == distances[0]);

            // The list is only as long as its largest place requires.
            let len = *list.iter().max().expect("eight") as usize + 1;
            let from: Vec<f64> = (0..len).map(number).collect();
            let mut registers = [[0.0; 4]; 2];
            places.gather(&from, &mut registers);
            let (mut sums, mut expected) = (from.clone(), from.clone());
            places.add(registers.iter().copied(), &mut sums);
            for (&place, &x) in list.iter().zip(registers.as_flattened()) {
                assert_eq!(x, from[place as usize], "{distances:?}");
                expected[place as usize] += x;
            }
            assert_eq!(sums, expected, "{distances:?}");
        }
    }
}
