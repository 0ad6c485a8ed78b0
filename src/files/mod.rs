//! Inputs, gradients and motions as text that others can read and write: JSON and CSV, with the names of the scene.
//!
//! What is read may come from anybody: sizes are bounded by that of the text, and what does not fit is named with its place.

mod fields;
mod gradient;
mod inputs;
mod names;
mod ready_costs;
mod report;
mod scene;
mod study;
mod table;
mod trajectory;

pub use scene::SceneFile;
pub use study::{Finished, Study};
pub use table::Table;

use serde::de::DeserializeOwned;

use crate::Error;

/// Refuses a file of another format or version.
fn check_format<V: ToString>(kind: &'static str, (format, version): (&str, V), expected: (&str, u32)) -> Result<(), Error> {
    let version = version.to_string();
    if (format, &version) == (expected.0, &expected.1.to_string()) {
        return Ok(());
    }
    let problem = format!("this is `{format}`, version {version}; expected `{}`, version {}", expected.0, expected.1);
    Err(Error::File { kind, place: "`format`".into(), problem })
}

/// What a JSON file of some kind says.
fn read_json<T: DeserializeOwned>(kind: &'static str, json: &str) -> Result<T, Error> {
    // Some editors put a byte order mark before it.
    let json = json.strip_prefix('\u{feff}').unwrap_or(json);
    serde_json::from_str(json).map_err(|error| {
        let problem = error.to_string();
        // The place stands at its end, too.
        let problem = problem.rsplit_once(" at line").map_or(problem.as_str(), |(problem, _)| problem).to_string();
        Error::File { kind, place: format!("line {}, column {}", error.line(), error.column()), problem }
    })
}
