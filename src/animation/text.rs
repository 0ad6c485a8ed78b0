//! Text for files: escaped names, short numbers, and files that are written completely or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use crate::Error;

/// Maximum number of decimals, and largest size, of numbers written without an exponent.
const MOST_DIGITS: i32 = 12;
const LARGE: f64 = 1e15;

/// Text escaped for HTML and SVG, including their attributes.
pub(super) fn escaped(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => all.push_str("&amp;"),
            '<' => all.push_str("&lt;"),
            '>' => all.push_str("&gt;"),
            '"' => all.push_str("&quot;"),
            '\'' => all.push_str("&#39;"),
            // XML does not allow control characters.
            c if c.is_control() => all.push(' '),
            c => all.push(c),
        }
    }
    all
}

/// A JSON string that is safe inside a `<script>`.
pub(super) fn quoted(text: &str) -> String {
    let mut all = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => all.extend(['\\', c]),
            c if c.is_control() || "<>&\u{2028}\u{2029}".contains(c) => all.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => all.push(c),
        }
    }
    all.push('"');
    all
}

/// Number of decimals that distinguish a thousandth of a size, and a few more; negative if digits before the point are superfluous.
fn places(size: f64) -> i32 {
    if size > 0.0 && size.is_finite() { 4 - size.log10().floor() as i32 } else { 4 }
}

/// Number of decimals for sizes that are written without exponents.
pub(super) fn digits(size: f64) -> usize {
    places(size).clamp(0, MOST_DIGITS) as usize
}

/// A number with this many decimals, without trailing zeros.
pub(super) fn number(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".into() } else { short.to_string() }
}

/// A number to this many decimals, with an exponent if it is very small or very large.
fn short(x: f64, places: i32) -> String {
    let fixed = |places: i32| number(x, places.max(0) as usize);
    if x == 0.0 || (places <= MOST_DIGITS && x.abs() < LARGE) {
        return fixed(places);
    }
    let significant = x.abs().log10().floor() as i32 + places;
    if significant < 0 {
        return "0".into();
    }
    let text = format!("{x:.*e}", significant.min(16) as usize);
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    if exponent == "0" { mantissa.into() } else { format!("{mantissa}e{exponent}") }
}

/// A list of numbers as JSON, with the digits that show how they change; numbers that are not finite become null.
pub(super) fn list(values: &[f64]) -> String {
    let finite = || values.iter().copied().filter(|x| x.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let size = low.abs().max(high.abs());
    // Smaller changes are rounding; the difference of large numbers may overflow.
    let places = places(if high > low { (high - low).max(1e-9 * size).min(f64::MAX) } else { size });
    let item = |x: &f64| if x.is_finite() { short(*x, places) } else { "null".into() };
    format!("[{}]", values.iter().map(item).collect::<Vec<_>>().join(","))
}

/// Writes a temporary file in the same folder and renames it.
pub(super) fn write_whole(path: &Path, text: &str) -> Result<(), Error> {
    let failed = |error: io::Error| Error::File {
        kind: "an animation",
        place: path.display().to_string(),
        problem: format!("cannot be written: {error}"),
    };
    let name = path.file_name().ok_or_else(|| failed(io::Error::other("the path has no file name")))?;
    let mut name = name.to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    let moved = written.and_then(|()| fs::rename(&part, path));
    if moved.is_err() {
        // An incomplete file is removed.
        fs::remove_file(&part).ok();
    }
    moved.map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_leave_their_places() {
        let name = "</script><b a='\"'>\u{0}&\\";
        assert_eq!(escaped(name), "&lt;/script&gt;&lt;b a=&#39;&quot;&#39;&gt; &amp;\\");
        let json = quoted(name);
        assert!(!json.contains('<') && !json.contains('\u{0}'));
        assert_eq!(serde_json::from_str::<String>(&json).expect("a string"), name);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(-0.00001, 3), "0");
        assert_eq!(number(120.0, 2), "120");
        assert_eq!(list(&[1.25, f64::NAN, -3.0]), "[1.25,null,-3]");
        assert_eq!((digits(1.0), digits(250.0), digits(0.0)), (4, 2, 4));
        assert_eq!((list(&[]), list(&[0.0, 0.0]), list(&[1e-6])), ("[]".into(), "[0,0]".into(), "[0.000001]".into()));
    }

    #[test]
    fn numbers_far_from_zero_keep_the_digits_in_which_they_differ() {
        assert_eq!(list(&[10000.0, 10000.01, 10000.02]), "[10000,10000.01,10000.02]");
        assert_eq!(list(&[-1e9, -1e9 + 0.25]), "[-1000000000,-999999999.75]");
        assert_eq!(list(&[1.0, 1.0 + f64::EPSILON]), "[1,1]", "no digits of rounding");
    }

    #[test]
    fn very_small_and_very_large_numbers_keep_their_digits() {
        assert_eq!(list(&[0.0, -1e-14, 2.5e-14, 1e-30]), "[0,-1e-14,2.5e-14,0]");
        assert_eq!(list(&[1e150, 1.25e150, -0.0]), "[1e150,1.25e150,0]");
        assert_eq!(list(&[5e-324, 1.5e-310]), "[0,1.5e-310]");
        assert_eq!(list(&[-1.7e308, 1.7e308]), "[-1.7e308,1.7e308]");
        assert_eq!(list(&[1.0 + 1e-10, 1.0]), "[1.0000000001,1]");
    }

    #[test]
    fn a_file_is_written_whole_or_not_at_all() {
        let folder = std::env::temp_dir().join(format!("whole-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("page.html");
        write_whole(&path, "first").expect("a file");
        write_whole(&path, "second").expect("a file");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "second");
        let missing = folder.join("missing").join("page.html");
        let error = write_whole(&missing, "x").expect_err("no folder");
        assert!(error.to_string().contains(&missing.display().to_string()), "{error}");
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1, "nothing is left behind");
        fs::remove_dir_all(&folder).expect("removed");
    }
}
