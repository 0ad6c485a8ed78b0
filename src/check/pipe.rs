//! [`Pipe`]: derivatives from a program in any language, one line of JSON in, one line out.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use nalgebra::{DMatrix, SVector};
use serde_json::{Map, Value, json};

use super::point::Point;
use crate::Error;

/// A program that is about to end is waited for so often, and so long each time.
const MOST_WAITS: usize = 200;
const WAIT: Duration = Duration::from_millis(10);
/// A line of more bytes than this is no answer.
const MOST_BYTES: usize = 10_000_000;

/// A program that is asked for matrices: C, Python, Matlab, anything that reads and writes lines.
///
/// It gets lines like `{"ask":"phi_q","q":[0.1,0.2],"v":[…],"sigma":[…],"u":[…],"t":0.5,"b":[0.7]}`, or `{"ask":"jacobian","x":[…]}` for a function, and answers each
/// with a line, the rows of the matrix `[[1,0],[0,1]]`, and flushes its output. `{"error":"…"}` is an answer, too.
///
/// ```no_run
/// use hamiltonian_adjoint::check::{self, Pipe};
/// use hamiltonian_adjoint::planar::Distance;
/// use std::process::Command;
///
/// let pipe = Pipe::new(Command::new("python3").arg("tests/languages/distance.py"))?;
/// let report = check::constraint(&Distance, [0.1, 0.2, 0.3, 0.4, 0.7]).phi_q(|at| pipe.ask("phi_q", at)).run();
/// pipe.finish()?;
/// report.assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct Pipe(Mutex<Talk>);

struct Talk {
    program: Child,
    questions: Option<ChildStdin>,
    answers: Receiver<Result<String, String>>,
    patience: Duration,
    asked: usize,
    /// The first thing that went wrong; nothing is asked any more.
    problem: Option<String>,
}

impl Pipe {
    /// Starts the program; an answer may take ten seconds.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub fn new(command: &mut Command) -> Result<Self, Error> {
        let started = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let mut program = started.map_err(|error| wrong(format!("{command:?} does not start: {error}")))?;
        let (tell, answers) = channel();
        let output = program.stdout.take().ok_or_else(|| wrong("it has no output".into()))?;
        thread::spawn(move || {
            for line in BufReader::new(output).lines() {
                if tell.send(line.map_err(|error| error.to_string())).is_err() {
                    return;
                }
            }
        });
        let questions = program.stdin.take();
        let patience = Duration::from_secs(10);
        Ok(Pipe(Mutex::new(Talk { program, questions, answers, patience, asked: 0, problem: None })))
    }

    /// The matrix called `name` at a point of an element; NaN from the first problem on, which [`finish`](Self::finish) tells.
    pub fn ask<const N: usize, const M: usize, const K: usize, const P: usize>(
        &self,
        name: &str,
        at: &Point<N, M, K, P>,
    ) -> DMatrix<f64> {
        fn list<const L: usize>(x: &SVector<f64, L>) -> Value {
            json!(x.as_slice())
        }
        let parts = [
            ("q", list(&at.q)),
            ("v", list(&at.v)),
            ("p_star", list(&at.p_star)),
            ("p_star_dot", list(&at.p_star_dot)),
            ("v_dot", list(&at.v_dot)),
            ("sigma", list(&at.sigma)),
            ("lambda", list(&at.lambda)),
            ("u", list(&at.u)),
            ("u_dot", list(&at.u_dot)),
            ("t", json!(at.t)),
            ("b", list(&at.b)),
        ];
        let parts = parts.into_iter().map(|(name, value)| (name.to_string(), value));
        self.exchange(name, parts.collect())
    }

    /// The matrix called `name` for the arguments of a [`function`](super::function).
    pub fn ask_function(&self, name: &str, x: &[f64]) -> DMatrix<f64> {
        self.exchange(name, Map::from_iter([("x".to_string(), json!(x))]))
    }

    fn exchange(&self, name: &str, mut question: Map<String, Value>) -> DMatrix<f64> {
        question.insert("ask".into(), json!(name));
        let mut talk = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let answer = if talk.problem.is_some() { Err(String::new()) } else { talk.exchange(&Value::Object(question)) };
        answer.unwrap_or_else(|problem| {
            let asked = talk.asked;
            talk.problem.get_or_insert_with(|| format!("question {asked}, `{name}`: {problem}"));
            DMatrix::from_element(1, 1, f64::NAN)
        })
    }

    /// Ends the program.
    ///
    /// # Errors
    /// The first answer that failed: a program that ended or took too long, a line that is no matrix, an error that it told.
    pub fn finish(self) -> Result<(), Error> {
        let problem = self.0.lock().unwrap_or_else(PoisonError::into_inner).problem.take();
        problem.map_or(Ok(()), |problem| Err(wrong(problem)))
    }
}

impl Talk {
    fn exchange(&mut self, question: &Value) -> Result<DMatrix<f64>, String> {
        self.asked += 1;
        let input = self.questions.as_mut().ok_or("it has no input")?;
        let sent = writeln!(input, "{question}").and_then(|()| input.flush());
        sent.map_err(|error| format!("it does not listen any more: {error}"))?;
        let line = self.answers.recv_timeout(self.patience).map_err(|error| match error {
            RecvTimeoutError::Timeout => {
                format!("no answer within {} s; does it flush its output?", self.patience.as_secs())
            }
            RecvTimeoutError::Disconnected => match self.status() {
                Some(status) => format!("it ended with {status}"),
                None => "it closed its output".into(),
            },
        })??;
        matrix(&line)
    }

    /// How it ended, if it does soon.
    fn status(&mut self) -> Option<ExitStatus> {
        for _ in 0..MOST_WAITS {
            if let Ok(Some(status)) = self.program.try_wait() {
                return Some(status);
            }
            thread::sleep(WAIT);
        }
        None
    }
}

impl Drop for Talk {
    fn drop(&mut self) {
        // At the end of its input a program ends by itself, or is ended.
        self.questions = None;
        if self.status().is_none() {
            self.program.kill().ok();
            self.program.wait().ok();
        }
    }
}

/// A matrix by its rows; a list of numbers is one row, and a number a matrix of one.
fn matrix(line: &str) -> Result<DMatrix<f64>, String> {
    let shown: String = line.chars().take(60).collect();
    if line.len() > MOST_BYTES {
        return Err(format!("{} bytes are no answer", line.len()));
    }
    let value: Value = serde_json::from_str(line).map_err(|error| format!("`{shown}` is no JSON: {error}"))?;
    if let Some(text) = value.get("error") {
        return Err(format!("it says {text}"));
    }
    let number = |x: &Value| x.as_f64().ok_or_else(|| format!("`{shown}` is no matrix of numbers"));
    let rows: Vec<Vec<f64>> = match &value {
        Value::Array(rows) if rows.iter().any(Value::is_array) => {
            let row = |row: &Value| row.as_array().into_iter().flatten().map(number).collect();
            rows.iter().map(row).collect::<Result<_, String>>()?
        }
        Value::Array(row) => vec![row.iter().map(number).collect::<Result<_, String>>()?],
        x => vec![vec![number(x)?]],
    };
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 || rows.iter().any(|row| row.len() != columns) {
        return Err(format!("the rows of `{shown}` have different lengths, or none"));
    }
    Ok(DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}

fn wrong(problem: String) -> Error {
    Error::File { kind: "a program", place: "asked for derivatives".into(), problem }
}
