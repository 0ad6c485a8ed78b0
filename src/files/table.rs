//! [`Table`]: measured or wanted signals over time, from CSV.

use crate::{Error, Grid};

const SECONDS: [&str; 5] = ["s", "sec", "secs", "second", "seconds"];
/// Units of time that could be mistaken for s.
const NOT_SECONDS: [&str; 16] = [
    "ns",
    "us",
    "µs",
    "μs",
    "ms",
    "msec",
    "milliseconds",
    "min",
    "mins",
    "minutes",
    "h",
    "hr",
    "hours",
    "d",
    "days",
    "years",
];

/// A table of signals over time; cells may be empty.
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Scene, Table, planar::Body};
///
/// let table = Table::from_csv("t [s],force [N],x [m]\n0,1.5,0\n0.1,2.5,\n0.3,0.5,0.2\n")?;
/// let force = table.column("force")?;
/// assert!((table.value(force, 0.2) - 1.5).abs() < 1e-15);
/// // A gap is bridged.
/// assert!((table.value(table.column("x")?, 0.15) - 0.1).abs() < 1e-15);
///
/// let mut scene = Scene::new();
/// let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
/// let push = scene.control("push");
/// scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), push);
/// // A control that no element uses is a reference for costs.
/// let reference = scene.control("wanted x");
/// let system = scene.compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.01));
/// inputs.set_control(push, |t| table.value(force, t));
/// inputs.set_control(reference, |t| 0.5 * t);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The column names of the header with their units, except the time column.
    pub names: Vec<String>,
    /// The times of the rows, s, increasing.
    pub times: Vec<f64>,
    /// The values of each column; `None` for empty cells.
    pub columns: Vec<Vec<Option<f64>>>,
}

impl Table {
    /// Reads a table from CSV with a header. The first column is the time in s; its name may contain the unit s or no unit.
    ///
    /// # Errors
    /// No header, a time in another unit or column, no rows, cells that are not numbers, rows of different lengths, times that do not
    /// increase, or a column without values; each with its line.
    pub fn from_csv(text: &str) -> Result<Self, Error> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| problem(&error))?.clone();
        check_unit(header.get(0).unwrap_or_default())?;
        check_time(&header)?;
        let names: Vec<String> = header.iter().skip(1).map(str::to_string).collect();
        if names.is_empty() {
            return Err(wrong(1, "the header has no column besides the time; columns must be separated by commas"));
        }
        if let Some((k, name)) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
            return Err(wrong(1, &format!("column {} and an earlier column are both called `{name}`", k + 2)));
        }
        let mut table = Table { columns: vec![Vec::new(); names.len()], times: Vec::new(), names };
        for record in reader.records() {
            let record = record.map_err(|error| problem(&error))?;
            let line = record.position().map_or(0, csv::Position::line);
            table.add(&record, line)?;
        }
        if table.times.is_empty() {
            return Err(wrong(2, "there are no rows"));
        }
        let is_empty = |column: &Vec<Option<f64>>| column.iter().all(Option::is_none);
        match table.columns.iter().position(is_empty) {
            Some(k) => Err(wrong(1, &format!("column `{}` has no values", table.names[k]))),
            None => Ok(table),
        }
    }

    fn add(&mut self, record: &csv::StringRecord, line: u64) -> Result<(), Error> {
        let number = |cell: &str, k: usize| match cell.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => {
                // Shortened for the message.
                let cell: String = cell.chars().take(20).collect();
                Err(wrong(line, &format!("column {}: `{cell}` is not a finite number", k + 1)))
            }
        };
        let t = number(&record[0], 0)?;
        if self.times.last().is_some_and(|last| *last >= t) {
            return Err(wrong(line, &format!("the time {t} s is not later than that of the row before")));
        }
        self.times.push(t);
        for (k, column) in self.columns.iter_mut().enumerate() {
            let cell = &record[k + 1];
            column.push(if cell.is_empty() { None } else { Some(number(cell, k + 1)?) });
        }
        Ok(())
    }

    /// The index of a column by its name, with or without the unit.
    ///
    /// # Errors
    /// An unknown name, or one that is ambiguous without its unit; the error lists the existing names.
    pub fn column(&self, name: &str) -> Result<usize, Error> {
        let bare = |full: &str| full.split_once('[').map_or(full, |(name, _)| name).trim() == name;
        let exact = self.names.iter().position(|known| known == name);
        let mut alike = (0..self.names.len()).filter(|k| bare(&self.names[*k]));
        let what = match (exact, alike.next(), alike.next()) {
            (Some(k), ..) | (None, Some(k), None) => return Ok(k),
            (None, Some(_), Some(_)) => "more than one",
            (None, None, _) => "no",
        };
        let problem = format!("the header has {what} column `{name}`; its columns are {}", self.names.join(", "));
        Err(Error::File { kind: "a table", place: "the header".into(), problem })
    }

    /// The values of a column with the numbers of their nodes, without empty cells; a node may have several values.
    ///
    /// # Errors
    /// A value whose time differs from those of all nodes of the grid by more than a thousandth of a step.
    ///
    /// # Panics
    /// If the column does not exist.
    pub fn readings(&self, column: usize, grid: &Grid) -> Result<Vec<(usize, f64)>, Error> {
        let times = grid.times();
        // Without steps there is only the time of the start.
        let tolerance =
            1e-3 * grid.steps.iter().map(|dt| dt.abs()).filter(|dt| *dt > 0.0).min_by(f64::total_cmp).unwrap_or(0.0);
        let known = self.times.iter().zip(self.known_column(column)).filter_map(|(t, value)| value.map(|value| (*t, value)));
        // Steps may go back in time; of several nodes at the same time, the first one is used.
        let mut nodes: Vec<usize> = (0..times.len()).collect();
        nodes.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        let first_from = |t: f64| nodes.partition_point(|node| times[*node] < t);
        let at = |(t, value): (f64, f64)| {
            let distance = |node: &usize| (times[*node] - t).abs();
            let after = first_from(t);
            let before = after.checked_sub(1).map(|last| nodes[first_from(times[nodes[last]])]);
            let both = before.into_iter().chain(nodes.get(after).copied());
            let nearest = both.min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
            nearest
                .filter(|node| distance(node) <= tolerance)
                .map(|node| (grid.around[0].saturating_add(node), value))
                .ok_or_else(|| Error::File {
                    kind: "a table",
                    place: format!("column `{}`", self.names[column]),
                    problem: format!(
                        "it has a value at {t} s, where the grid has no node; use `Grid::through` to create a grid with nodes at given times"
                    ),
                })
        };
        known.map(at).collect()
    }

    fn known_column(&self, column: usize) -> &[Option<f64>] {
        let count = self.columns.len();
        assert!(
            column < count,
            "there is no column {column}: the table has {count} columns after the times; `Table::column` finds a column by its name"
        );
        &self.columns[column]
    }

    /// The value of a column at a time, s: linear between the rows with values, constant before the first and after the last.
    ///
    /// # Panics
    /// If the column does not exist.
    pub fn value(&self, column: usize, t: f64) -> f64 {
        let values = self.known_column(column);
        if t.is_nan() {
            return f64::NAN;
        }
        let known = |i: usize| values[i].map(|x| (self.times[i], x));
        let next = self.times.partition_point(|time| *time < t);
        let before = (0..next).rev().find_map(known);
        let after = (next..values.len()).find_map(known);
        match (before, after) {
            (Some((t0, x0)), Some((t1, x1))) => {
                // Exact at both ends; between them, also if x₁ − x₀ overflows or rounding would leave the interval.
                let share = (t - t0) / (t1 - t0);
                ((1.0 - share) * x0 + share * x1).clamp(x0.min(x1), x0.max(x1))
            }
            (Some((_, x)), None) | (None, Some((_, x))) => x,
            (None, None) => f64::NAN,
        }
    }
}

/// Returns an error if the first column is not named like a time but another one is.
fn check_time(header: &csv::StringRecord) -> Result<(), Error> {
    let bare = |name: &str| name.split(['[', '(', '/']).next().unwrap_or_default().trim().to_lowercase();
    let is_time = |name: &str| ["t", "time"].contains(&bare(name).as_str());
    let (Some(first), Some(k)) = (header.get(0), header.iter().position(is_time)) else { return Ok(()) };
    if k == 0 || bare(first).contains("time") {
        return Ok(());
    }
    let problem = format!(
        "column {} is called `{}`, but the first column, called `{first}`, is used as the time; move the time to the first column",
        k + 1,
        &header[k]
    );
    Err(wrong(1, &problem))
}

/// Returns an error if the name of the time column contains another unit than s: `t [ms]`, `t (ms)`, `t / ms`.
fn check_unit(name: &str) -> Result<(), Error> {
    let closed = |open: char, close: char| name.strip_suffix(close).and_then(|name| name.rsplit_once(open));
    let bracketed = closed('[', ']').map(|(_, unit)| unit.trim());
    // Other suffixes may belong to the name.
    let other = closed('(', ')').or_else(|| name.rsplit_once('/')).map(|(_, unit)| unit.trim());
    let wrong_unit = bracketed
        .filter(|unit| !unit.is_empty() && !SECONDS.contains(unit))
        .or(other.filter(|unit| bracketed.is_none() && NOT_SECONDS.contains(unit)));
    match wrong_unit {
        Some(unit) => Err(wrong(1, &format!("column 1, `{name}`: the times are in `{unit}`; expected `s`, as in `t [s]`"))),
        None => Ok(()),
    }
}

fn problem(error: &csv::Error) -> Error {
    let line = error.position().map_or(1, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            wrong(line, &format!("{len} cells, but the header has {expected_len}"))
        }
        _ => wrong(line, &error.to_string()),
    }
}

fn wrong(line: u64, problem: &str) -> Error {
    Error::File { kind: "a table", place: format!("line {line}"), problem: problem.to_string() }
}
