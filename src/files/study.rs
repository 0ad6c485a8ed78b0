//! [`Study`]: results of many starts, each stored in a file as soon as it is known.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::optimize::{Outcome, Problem, Reason};
use crate::solver::each;

const FORMAT: &str = "hamiltonian-adjoint study";
const VERSION: u32 = 1;

/// The result of one start of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finished {
    /// Number of the start.
    pub start: usize,
    /// The best point; empty if the start ended with an error or has no value.
    pub x: Vec<f64>,
    /// The value at this point; `None` if it is not finite.
    pub value: Option<f64>,
    /// The largest violation of a constraint; `None` if it is not finite.
    pub violation: Option<f64>,
    /// True if the method converged.
    pub converged: bool,
    /// The reason why the method stopped, or the error.
    pub reason: String,
    /// Numbers of evaluations, gradients and Hessian products.
    pub counts: [usize; 3],
}

impl Finished {
    /// Converts the outcome of the optimisation from start number `start` to a stored result; if x is not finite, the result is an error.
    pub fn new(start: usize, outcome: &Result<Outcome, Error>) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let failed = |reason: String| Finished {
            start,
            x: Vec::new(),
            value: None,
            violation: None,
            converged: false,
            reason,
            counts: [0; 3],
        };
        match outcome {
            Ok(Outcome { reason: Reason::NoStart, first_failure: Some(error), .. }) | Err(error) => {
                failed(error.to_string())
            }
            Ok(of) if of.x.iter().any(|x| !x.is_finite()) => failed("the best point has a number that is not finite".into()),
            Ok(of) => Finished {
                start,
                x: of.x.clone(),
                value: finite(of.value),
                violation: finite(of.violation),
                converged: of.reason.is_converged(),
                reason: format!("{:?}", of.reason),
                counts: [of.evaluations, of.gradients, of.products],
            },
        }
    }

    /// The result as a line of JSON without line break.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("numbers, lists and strings")
    }

    /// Reads a result from a line of JSON.
    ///
    /// # Errors
    /// A malformed line.
    pub fn from_json(line: &str) -> Result<Self, Error> {
        super::read_json("the result of a start", line)
    }
}

#[derive(PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    format: String,
    version: u32,
    name: String,
    starts: usize,
    /// Checksum of the bits of all starts.
    sum: String,
}

/// A study runs one optimisation method from many starting points and stores each outcome as a line of a file. An interrupted study
/// continues where it stopped.
///
/// An incomplete last line is discarded and computed again. Outcomes do not depend on the number of threads or interruptions.
///
/// ```
/// use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Variables, lbfgs, silent};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, Study, scenes::CartPendulum};
///
/// let scene = CartPendulum::with_links(1).scene();
/// let force = scene.control_named("force on the cart").expect("its only control");
/// let system = scene.compile()?;
/// let inputs = Inputs::at_rest(&system, Grid::uniform(40, 0.02));
/// let variables = Variables::new(&system, &inputs, vec![Free::control(force)])?;
/// let starts: Vec<Vec<f64>> = [-10.0, 5.0, 20.0].map(|force| vec![force; 41]).into();
///
/// # let folder = std::env::temp_dir().join(format!("study-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).expect("a folder");
/// let path = folder.join("swing-up.jsonl");
/// let mut study = Study::open(&path, "swing-up", &starts)?;
/// let problem = || MotionProblem::new(&system, Settings::default(), inputs.clone(), variables.clone());
/// study.run(problem, |problem, start| lbfgs(problem, start, &Options::default(), &mut silent))?;
/// assert_eq!(study.finished().count(), 3);
/// # drop(study);
/// # assert_eq!(Study::open(&path, "swing-up", &starts)?.missing().count(), 0);
/// # std::fs::remove_dir_all(&folder).expect("removed");
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Debug)]
pub struct Study {
    place: String,
    file: File,
    starts: Vec<Vec<f64>>,
    finished: BTreeMap<usize, Finished>,
}

impl Study {
    /// Opens the study in a file, or creates it.
    ///
    /// # Errors
    /// A file that cannot be read or written, that is already open as a study, that is not a study, or that belongs to another name or
    /// other starts.
    pub fn open(path: &Path, name: &str, starts: &[Vec<f64>]) -> Result<Self, Error> {
        let place = path.display().to_string();
        let failed = |error: std::io::Error| wrong(&place, error.to_string());
        let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        file.try_lock().map_err(|_| {
            wrong(&place, "the study is already open in this or another process, or the file cannot be locked".into())
        })?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let head = Head {
            format: FORMAT.into(),
            version: VERSION,
            name: name.into(),
            starts: starts.len(),
            sum: format!("{:016x}", sum(starts)),
        };
        let first = serde_json::to_string(&head).expect("numbers and strings") + "\n";
        // An interrupted run may leave an incomplete last line, which may end in the middle of a character.
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        if whole == 0 && !first.as_bytes().starts_with(&bytes) {
            return Err(wrong(&place, "line 1 is not the first line of a study".into()));
        }
        let mut finished = BTreeMap::new();
        if whole > 0 {
            let text = std::str::from_utf8(&bytes[..whole]).map_err(|error| wrong(&place, error.to_string()))?;
            let mut lines = text.lines();
            check(&place, lines.next().unwrap_or_default(), &head)?;
            for (number, line) in (2..).zip(lines) {
                let of = Finished::from_json(line)
                    .map_err(|error| wrong(&format!("{place}, line {number}"), error.to_string()))?;
                if of.start >= starts.len() {
                    return Err(wrong(&format!("{place}, line {number}"), format!("there is no start {}", of.start)));
                }
                finished.entry(of.start).or_insert(of);
            }
        }
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        if whole == 0 {
            file.write_all(first.as_bytes()).map_err(failed)?;
        }
        Ok(Study { place, file, starts: starts.to_vec(), finished })
    }

    /// Stores the result of a start.
    ///
    /// # Errors
    /// A file that cannot be written, a start that does not exist, or numbers that are not finite.
    pub fn add(&mut self, of: Finished) -> Result<(), Error> {
        if of.start >= self.starts.len() {
            return Err(wrong(&self.place, format!("there is no start {}", of.start)));
        }
        if let Some(x) = of.x.iter().chain(&of.value).chain(&of.violation).find(|x| !x.is_finite()) {
            return Err(wrong(&self.place, format!("start {} ended with {x}, which is not finite", of.start)));
        }
        if self.finished.contains_key(&of.start) {
            return Ok(());
        }
        // A single write for the line and its end.
        let line = of.to_json() + "\n";
        self.file.write_all(line.as_bytes()).map_err(|error| wrong(&self.place, error.to_string()))?;
        self.finished.insert(of.start, of);
        Ok(())
    }

    /// The results of the finished starts, in the order of the starts.
    pub fn finished(&self) -> impl Iterator<Item = &Finished> {
        self.finished.values()
    }

    /// The numbers of the unfinished starts.
    pub fn missing(&self) -> impl Iterator<Item = usize> {
        (0..self.starts.len()).filter(|start| !self.finished.contains_key(start))
    }

    /// All starts.
    pub fn starts(&self) -> &[Vec<f64>] {
        &self.starts
    }

    /// The finished start with the lowest value among those whose violation is at most `violation`; the first of equal ones.
    pub fn lowest(&self, violation: f64) -> Option<&Finished> {
        let good = self.finished().filter(|of| of.violation.is_some_and(|found| found <= violation));
        let value = |of: &Finished| of.value.unwrap_or(f64::INFINITY);
        good.min_by(|one, other| value(one).total_cmp(&value(other)))
    }

    /// Computes the unfinished starts; with the feature `rayon` on all cores, with one problem per thread.
    ///
    /// Starts that a progress callback interrupted ([`Reason::Interrupted`], [`Error::Interrupted`]) and starts that had not yet begun remain
    /// missing.
    ///
    /// # Errors
    /// A file that cannot be written. Errors of problems and methods are stored as results.
    pub fn run<P: Problem>(
        &mut self,
        problem: impl Fn() -> Result<P, Error> + Sync,
        method: impl Fn(&mut P, &[f64]) -> Result<Outcome, Error> + Sync,
    ) -> Result<(), Error> {
        let (starts, missing) = (self.starts.clone(), self.missing().collect::<Vec<_>>());
        let (study, was_asked) = (Mutex::new(self), AtomicBool::new(false));
        let one = |worker: &mut Option<P>, start: &usize| {
            if was_asked.load(Ordering::Relaxed) {
                return Ok(());
            }
            let own = worker.take().map_or_else(&problem, Ok);
            let outcome = own.and_then(|mut own| {
                let outcome = method(&mut own, &starts[*start]);
                *worker = Some(own);
                outcome
            });
            if matches!(&outcome, Ok(Outcome { reason: Reason::Interrupted, .. }) | Err(Error::Interrupted { .. })) {
                was_asked.store(true, Ordering::Relaxed);
                return Ok(());
            }
            let of = Finished::new(*start, &outcome);
            study.lock().unwrap_or_else(std::sync::PoisonError::into_inner).add(of)
        };
        each(&missing, || None, one).into_iter().collect()
    }
}

fn check(place: &str, line: &str, expected: &Head) -> Result<(), Error> {
    let found: Head = super::read_json("a study", line).map_err(|error| wrong(place, error.to_string()))?;
    let problem = match found {
        _ if found.format != expected.format || found.version != expected.version => {
            format!("it is `{}` of version {}, not `{FORMAT}` of version {VERSION}", found.format, found.version)
        }
        _ if found.name != expected.name => format!("it is the study `{}`, not `{}`", found.name, expected.name),
        _ if found != *expected => format!("it has {} other starts; use another file", found.starts),
        _ => return Ok(()),
    };
    Err(wrong(place, problem))
}

fn wrong(place: &str, problem: String) -> Error {
    Error::File { kind: "a study", place: place.to_string(), problem }
}

/// FNV-1a hash of the sizes and bits.
fn sum(starts: &[Vec<f64>]) -> u64 {
    let words = starts.iter().flat_map(|start| std::iter::once(start.len() as u64).chain(start.iter().map(|x| x.to_bits())));
    let bytes = words.flat_map(u64::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
