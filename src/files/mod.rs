//! Inputs, gradients and motions as text that other programs can read and write: JSON and CSV, with the names of the scene.
//!
//! Files may come from untrusted sources: sizes are bounded by the length of the text, and errors contain the place of the problem.

mod fields;
mod formula;
mod formulas;
mod gradient;
mod inputs;
mod kinds;
mod lists;
mod names;
mod parts;
mod report;
mod scene;
mod schema;
mod study;
mod sums;
mod table;
mod text_function;
mod trajectory;
mod writer;

pub use kinds::{PartEntry, PartKind};
pub use scene::SceneFile;
pub use study::{Finished, Study};
pub use table::Table;
pub use text_function::TextFunction;

use serde::de::DeserializeOwned;

use crate::Error;

/// Returns an error for a file of another format or version.
fn check_format<V: ToString>(kind: &'static str, (format, version): (&str, V), expected: (&str, u32)) -> Result<(), Error> {
    let version = version.to_string();
    if (format, &version) == (expected.0, &expected.1.to_string()) {
        return Ok(());
    }
    let problem = format!("this is `{format}`, version {version}; expected `{}`, version {}", expected.0, expected.1);
    Err(Error::File { kind, place: "`format`".into(), problem })
}

/// Content of a JSON file of the given kind.
fn read_json<T: DeserializeOwned>(kind: &'static str, json: &str) -> Result<T, Error> {
    // Some editors write a byte order mark at the beginning.
    let json = json.strip_prefix('\u{feff}').unwrap_or(json);
    serde_json::from_str(json).map_err(|error| {
        let problem = error.to_string();
        // The message contains the place at its end, too.
        let problem = problem.rsplit_once(" at line").map_or(problem.as_str(), |(problem, _)| problem).to_string();
        Error::File { kind, place: format!("line {}, column {}", error.line(), error.column()), problem }
    })
}
