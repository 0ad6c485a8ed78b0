//! Medians, largest values, differences, distinct items.

use std::borrow::Borrow;

/// The median (the upper one of two); 0 for an empty list.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// The largest |value|; NaN if any value is NaN, 0 for an empty list.
pub fn largest<X: Borrow<f64>>(values: impl IntoIterator<Item = X>) -> f64 {
    values.into_iter().map(|x| x.borrow().abs()).max_by(f64::total_cmp).unwrap_or(0.0)
}

/// The least and the greatest value; ∞ and −∞ for an empty list.
pub fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)))
}

/// ‖a − b‖∞/‖b‖∞, infinite if the lengths differ.
pub fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    largest(a.iter().zip(b).map(|(a, b)| a - b)) / largest(b)
}

/// The items without duplicates, in the order of their first occurrence.
pub fn distinct<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for item in items {
        if !kept.contains(&item) {
            kept.push(item);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_keep_the_order_in_which_they_come_first() {
        assert_eq!(distinct(["rest", "effort", "rest"]), ["rest", "effort"]);
    }

    #[test]
    fn differences_are_relative_to_the_largest_component() {
        assert_eq!(relative_difference(&[1.0, 4.5], &[1.0, 4.0]), 0.125);
        assert_eq!(relative_difference(&[1.0], &[1.0, 4.0]), f64::INFINITY);
        assert!(relative_difference(&[f64::NAN, 4.0], &[1.0, 4.0]).is_nan());
    }
}
