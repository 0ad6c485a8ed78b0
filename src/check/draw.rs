//! Random points over decades of magnitude, and validation of a check's settings.

use crate::Error;
use crate::number::Random;

/// Number of random points by default, if no points are given.
const USUAL: usize = 12;
/// Maximum number of attempts to draw one point at which the formula is defined.
const MOST_DRAWS: usize = 200;
/// Every second point is the one before with about half of its arguments smaller, by up to this many decades.
const DECADES: f64 = 6.0;

/// Points where blocks are compared.
#[derive(Default)]
pub(crate) struct Drawn {
    pub points: Vec<Vec<f64>>,
    /// For each point, the index of the point from which it was made by reducing some arguments, if any.
    pub parents: Vec<Option<usize>>,
    /// Notes about the points for the report.
    pub notes: Vec<String>,
}

/// The given points and `count` random ones (by default 12 if no points are given). Fresh points alternate with copies whose arguments
/// are partly reduced. A fresh point flips all or half of the signs of the one before: otherwise products could keep their signs.
///
/// # Errors
/// Every drawn point was rejected.
pub(crate) fn draw(
    given: Vec<Vec<f64>>,
    (count, seed): (Option<usize>, u64),
    signed: &[usize],
    fresh: impl Fn(&mut Random) -> Vec<f64>,
    usable: impl Fn(&[f64]) -> bool,
) -> Result<Drawn, Error> {
    let (first, count) = (given.len(), count.unwrap_or(if given.is_empty() { USUAL } else { 0 }));
    let (mut drawn, mut left_out, random) = (Drawn::of(given), 0, &mut Random::new(seed));
    for k in 0..count {
        for attempt in 0..MOST_DRAWS {
            // Odd attempts draw an independent point, because flipped signs or small arguments may be outside the domain.
            let last = (attempt % 2 == 0).then(|| drawn.points.len().checked_sub(1 + (k + 1) % 2)).flatten();
            let (x, parent) = match last {
                Some(last) if k % 2 == 1 => (smaller(&drawn.points[last], signed, random), Some(last)),
                Some(last) => {
                    let turned = if k % 4 == 2 { signed.to_vec() } else { half(signed, random) };
                    (with_signs(fresh(random), &drawn.points[last], (signed, &turned)), None)
                }
                None => (fresh(random), None),
            };
            if usable(&x) {
                drawn.points.push(x);
                drawn.parents.push(parent);
                break;
            }
            left_out += 1;
        }
    }
    let found = drawn.points.len() - first;
    if left_out > 0 && drawn.points.is_empty() {
        return Err(Error::NoPoint { drawn: left_out });
    }
    if left_out > 0 {
        let few = if found < count { format!("only {found} of {count} random points were found; ") } else { String::new() };
        let why = "not admissible, or the formula is not finite there";
        drawn.notes.push(format!("{few}{left_out} drawn points were left out: {why}"));
    }
    Ok(drawn)
}

fn smaller(point: &[f64], signed: &[usize], random: &mut Random) -> Vec<f64> {
    let mut x = point.to_vec();
    for &k in signed {
        let factor = 10f64.powf(random.uniform(-DECADES, 0.0));
        x[k] *= if random.below(2) == 0 { factor } else { 1.0 };
    }
    x
}

/// A random half of a list.
fn half(of: &[usize], random: &mut Random) -> Vec<usize> {
    let mut all = of.to_vec();
    (1..all.len()).rev().for_each(|k| all.swap(k, random.below(k + 1)));
    all.truncate(of.len() / 2);
    all
}

/// x with the signs of a point, some of which are flipped.
fn with_signs(mut x: Vec<f64>, point: &[f64], (signed, turned): (&[usize], &[usize])) -> Vec<f64> {
    signed.iter().for_each(|&k| x[k] = x[k].abs().copysign(point[k]));
    turned.iter().for_each(|&k| x[k] = -x[k]);
    x
}

impl Drawn {
    /// The given points, none of which was made from another.
    pub(crate) fn of(points: Vec<Vec<f64>>) -> Self {
        Drawn { parents: vec![None; points.len()], points, ..Drawn::default() }
    }
}

/// Returns an error for a tolerance that is not in [0, 1).
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), Error> {
    check_number("the tolerance of the check", tolerance, (0.0..1.0).contains(&tolerance), "at least 0 and less than 1")
}

/// Returns an error for a magnitude that is not finite.
pub(crate) fn check_magnitudes(names: &[String], magnitudes: &[f64]) -> Result<(), Error> {
    let one =
        |(name, &size): (&String, &f64)| check_number(&format!("the magnitude of {name}"), size, size.is_finite(), "finite");
    names.iter().zip(magnitudes).try_for_each(one)
}

pub(crate) fn check_number(what: &str, value: f64, fits: bool, must_be: &'static str) -> Result<(), Error> {
    if fits { Ok(()) } else { Err(Error::Parameter { what: what.into(), value, must_be }) }
}
