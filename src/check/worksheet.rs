//! Worksheets: the points of a check and the true blocks there as JSON, and [`Answers`], the values that another program has added.

use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::DMatrix;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::arguments::Arguments;
use super::block::Block;
use super::compare::{SEED, places};
use super::setting::Setting;
use crate::Error;
use crate::number::Random;

const FORMAT: &str = "hamiltonian-adjoint worksheet";
const VERSION: u32 = 1;
/// Relative difference up to which points are the same, because a program may round the numbers that it writes.
const SAME: f64 = 1e-9;

/// Derivatives that another program wrote into a worksheet.
///
/// [`ElementCheck::worksheet`](super::ElementCheck::worksheet), [`FunctionCheck::worksheet`](super::FunctionCheck::worksheet) and
/// [`StepCheck::worksheet`](super::StepCheck::worksheet) write
///
/// ```json
/// {"format": "hamiltonian-adjoint worksheet", "version": 1, "of": "constraint `Distance`", "blocks": [
///   {"name": "Φ_q", "rows": ["…"], "columns": ["…"], "points": [
///     {"at": {"q": [0.1, 0.2], "t": 0.5, "b": [0.7]}, "reference": [[1.0, 0.0]]}]}]}
/// ```
///
/// with all arguments of the element in `at`. The program reads the file, adds its own matrix to each point as `"value"`, and writes it
/// back. The same check with the same points and seed then compares the matrices.
///
/// ```
/// use hamiltonian_adjoint::check::{self, Answers};
/// use hamiltonian_adjoint::planar::Distance;
///
/// let b = [0.1, 0.2, 0.3, 0.4, 0.7];
/// let sheet = check::constraint(&Distance, b).phi_q(|_| [[0.0; 6]]).worksheet()?;
/// let theirs = sheet.replace("reference", "value"); // in practice, your program does this
/// let answers = Answers::from_json(&theirs)?;
/// let report = check::constraint(&Distance, b).phi_q(|at| answers.ask("Φ_q", at)).run();
/// answers.finish()?;
/// report.assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct Answers {
    /// Answers by the name of their block.
    blocks: HashMap<String, Vec<Answer>>,
    /// The first request without an answer.
    problem: OnceLock<String>,
}

/// The numbers of a point, the matrix there, and whether it was requested.
struct Answer {
    at: Vec<f64>,
    value: DMatrix<f64>,
    asked: AtomicBool,
}

#[derive(Deserialize)]
struct Sheet {
    format: String,
    version: u32,
    blocks: List<SheetBlock>,
}

#[derive(Deserialize)]
struct SheetBlock {
    name: String,
    points: List<SheetPoint>,
}

/// A list, or its only entry: Matlab writes a list of one entry as the entry itself.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a list, or the entry itself if there is only one")]
enum List<T> {
    Many(Vec<T>),
    One(T),
}

impl<T> List<T> {
    fn all(self) -> Vec<T> {
        match self {
            List::Many(list) => list,
            List::One(entry) => vec![entry],
        }
    }
}

#[derive(Deserialize)]
struct SheetPoint {
    at: Map<String, Value>,
    value: Option<Value>,
}

impl Answers {
    /// Reads a worksheet that was filled in.
    ///
    /// # Errors
    /// Malformed worksheet (with line and column), or a point whose value is missing or not a matrix.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let sheet: Sheet = serde_json::from_str(text)
            .map_err(|error| wrong(format!("line {}, column {}", error.line(), error.column()), error.to_string()))?;
        if (sheet.format.as_str(), sheet.version) != (FORMAT, VERSION) {
            let problem = format!(
                "it has the format `{}`, version {}; expected `{FORMAT}`, version {VERSION}",
                sheet.format, sheet.version
            );
            return Err(wrong("format".into(), problem));
        }
        let mut blocks = HashMap::new();
        for SheetBlock { name, points } in sheet.blocks.all() {
            let read = |(k, SheetPoint { at, value }): (usize, SheetPoint)| {
                let value = value.ok_or_else(|| "has no \"value\"".to_string()).and_then(|value| matrix(&value));
                value
                    .map(|value| Answer { at: numbers(&at), value, asked: AtomicBool::new(false) })
                    .map_err(|problem| wrong(format!("block `{name}`, point {k}"), problem))
            };
            let values: Vec<_> = points.all().into_iter().enumerate().map(read).collect::<Result<_, _>>()?;
            blocks.insert(name, values);
        }
        Ok(Answers { blocks, problem: OnceLock::new() })
    }

    /// The matrix of a block at the arguments of a check; NaN if there is none, which [`finish`](Self::finish) reports.
    pub fn ask(&self, block: &str, at: &(impl Arguments + ?Sized)) -> DMatrix<f64> {
        let at = at.by_name();
        let asked = numbers(&at);
        let answers = self.blocks.get(block).map_or(&[][..], Vec::as_slice);
        let distances = answers.iter().map(|answer| (distance(&answer.at, &asked), answer));
        let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(distance, _)| *distance <= SAME);
        let all_were_asked = || !answers.is_empty() && answers.iter().all(|answer| answer.asked.load(Ordering::Relaxed));
        match nearest {
            Some((_, answer)) => {
                answer.asked.store(true, Ordering::Relaxed);
                answer.value.clone()
            }
            // After all points, the diagnosis of a mistake tries points of its own.
            None if all_were_asked() => none(),
            None => {
                self.problem.get_or_init(|| match self.blocks.contains_key(block) {
                    true => {
                        let shown: String = Value::Object(at).to_string().chars().take(80).collect();
                        format!("{shown}… is not a point of `{block}`; was the check changed?")
                    }
                    false => format!("there is no block `{block}`"),
                });
                none()
            }
        }
    }

    /// Checks that every requested matrix was found.
    ///
    /// # Errors
    /// The first request without a matrix.
    pub fn finish(self) -> Result<(), Error> {
        self.problem.into_inner().map_or(Ok(()), |problem| Err(wrong("requested derivatives".into(), problem)))
    }
}

/// The worksheet of these blocks: their points and the true values there; `at` names the arguments of a point.
pub(super) fn of<A: Arguments>(title: &str, blocks: &[Block], setting: &Setting, at: impl Fn(&[f64]) -> A) -> String {
    let of_block = |block: &Block| {
        // The same places as `check` finds.
        let (places, _) = places(block, setting, &mut Random::new(setting.seed ^ SEED));
        let points = places.iter().map(|place| {
            let reference: Vec<Vec<f64>> = place.truth.row_iter().map(|row| row.iter().copied().collect()).collect();
            json!({ "at": at(&place.x).by_name(), "reference": reference })
        });
        json!({ "name": block.name, "rows": block.rows, "columns": block.columns, "points": points.collect::<Vec<_>>() })
    };
    let blocks: Vec<Value> = blocks.iter().map(of_block).collect();
    format!("{:#}\n", json!({ "format": FORMAT, "version": VERSION, "of": title, "blocks": blocks }))
}

/// Placeholder for a missing answer.
pub(super) fn none() -> DMatrix<f64> {
    DMatrix::from_element(1, 1, f64::NAN)
}

/// The numbers of a point in the order of their names; a list of one entry may have become a number, and an empty one may be missing.
fn numbers(at: &Map<String, Value>) -> Vec<f64> {
    let mut parts: Vec<(&String, &Value)> = at.iter().collect();
    parts.sort_by_key(|(name, _)| *name);
    let of = |value: &Value| match value {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect(),
        x => vec![x.as_f64().unwrap_or(f64::NAN)],
    };
    parts.into_iter().flat_map(|(_, value)| of(value)).collect()
}

/// The largest relative difference; infinite for points of different length, or if a value is not a number.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    let of = |(x, y): (&f64, &f64)| if x == y { 0.0 } else { (x - y).abs() / x.abs().max(y.abs()) };
    let largest = |most: f64, next: f64| if next.is_nan() { f64::INFINITY } else { most.max(next) };
    if x.len() == y.len() { x.iter().zip(y).map(of).fold(0.0, largest) } else { f64::INFINITY }
}

/// A matrix by its rows; a list of numbers is one row (transposed later if a column is expected), and a number a 1 × 1 matrix.
pub(super) fn matrix(value: &Value) -> Result<DMatrix<f64>, String> {
    let number = |x: &Value| x.as_f64().ok_or_else(|| "is not a matrix of numbers".to_string());
    let rows: Vec<Vec<f64>> = match value {
        Value::Array(rows) if rows.iter().any(Value::is_array) => {
            let row = |row: &Value| row.as_array().into_iter().flatten().map(number).collect();
            rows.iter().map(row).collect::<Result<_, String>>()?
        }
        Value::Array(row) => vec![row.iter().map(number).collect::<Result<_, String>>()?],
        x => vec![vec![number(x)?]],
    };
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 || rows.iter().any(|row| row.len() != columns) {
        return Err("has rows of different lengths, or none".into());
    }
    Ok(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}

fn wrong(place: String, problem: String) -> Error {
    Error::File { kind: "a worksheet", place, problem }
}
