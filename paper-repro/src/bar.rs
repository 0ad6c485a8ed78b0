//! Progress bars, shown only on a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar with the given number of steps.
pub fn bar(what: &str, steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template(&format!("{what} {{wide_bar}} {{pos}}/{{len}}  {{msg}}"));
    ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
