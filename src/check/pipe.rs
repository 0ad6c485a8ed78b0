//! [`Pipe`]: derivatives from a program in any language, one line of JSON in, one line out.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use nalgebra::DMatrix;
use serde_json::{Value, json};

use super::arguments::Arguments;
use super::worksheet;
use crate::Error;

/// Number and length of the waits for a program that is about to end.
const MOST_WAITS: usize = 200;
const WAIT: Duration = Duration::from_millis(10);
/// Allowed bytes of an answer for each pair of numbers in the request (a square matrix has one entry for each pair), …
const OF_ENTRY: usize = 64;
/// … and allowed bytes in any case: a matrix may have more rows than its function has arguments.
const LEAST_BYTES: usize = 10_000_000;

/// A program in any language that computes matrices on request, by reading and writing lines.
///
/// The program receives lines like `{"ask":"phi_q","q":[0.1,0.2],"v":[…],"sigma":[…],"u":[…],"t":0.5,"b":[0.7]}` or, for a function,
/// `{"ask":"jacobian","x":[…]}`. It answers each with one line that contains the rows of the matrix, `[[1,0],[0,1]]`, or
/// `{"error":"…"}`, and flushes its output.
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
#[derive(Debug)]
pub struct Pipe(Mutex<Talk>);

#[derive(Debug)]
struct Talk {
    program: Child,
    questions: Option<ChildStdin>,
    answers: Receiver<Result<String, String>>,
    /// Maximum number of bytes of the answer.
    most: Arc<AtomicUsize>,
    patience: Duration,
    asked: usize,
    /// The first problem; no request is sent after it.
    problem: Option<String>,
}

impl Pipe {
    /// Starts the program. It must answer within ten seconds.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn new(command: &mut Command) -> Result<Self, Error> {
        let started = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let mut program = started.map_err(|error| wrong(format!("{command:?} does not start: {error}")))?;
        let most = Arc::new(AtomicUsize::new(LEAST_BYTES));
        // Lines that were not requested stay in the program.
        let (tell, answers) = sync_channel(1);
        let mut output = BufReader::new(program.stdout.take().ok_or_else(|| wrong("it has no output".into()))?);
        let bound = Arc::clone(&most);
        thread::spawn(move || {
            while let Some(line) = read_line(&mut output, &bound).transpose() {
                let is_last = line.is_err();
                if tell.send(line).is_err() || is_last {
                    return;
                }
            }
        });
        let questions = program.stdin.take();
        let patience = Duration::from_secs(10);
        Ok(Pipe(Mutex::new(Talk { program, questions, answers, most, patience, asked: 0, problem: None })))
    }

    /// The matrix called `name` at the arguments of a check; NaN after the first problem, which [`finish`](Self::finish) returns.
    pub fn ask(&self, name: &str, at: &(impl Arguments + ?Sized)) -> DMatrix<f64> {
        let mut question = at.by_name();
        question.insert("ask".into(), json!(name));
        let mut talk = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let answer = if talk.problem.is_some() { Err(String::new()) } else { talk.exchange(&Value::Object(question)) };
        answer.unwrap_or_else(|problem| {
            let asked = talk.asked;
            talk.problem.get_or_insert_with(|| format!("question {asked}, `{name}`: {problem}"));
            worksheet::none()
        })
    }

    /// Ends the program and returns the first problem.
    ///
    /// # Errors
    /// The first failed answer: the program ended or took too long, a line was not a matrix, the program reported an error, or it wrote
    /// more lines than there were requests.
    pub fn finish(self) -> Result<(), Error> {
        let mut talk = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        talk.questions = None;
        let wait = if talk.problem.is_none() && talk.status().is_some() { MOST_WAITS as u32 * WAIT } else { WAIT };
        let surplus = talk.answers.recv_timeout(wait).ok().and_then(Result::ok).map(|line| unasked(&line));
        let problem = talk.problem.take().or(surplus.map(|text| format!("after {} questions: {text}", talk.asked)));
        problem.map_or(Ok(()), |problem| Err(wrong(problem)))
    }
}

impl Talk {
    fn exchange(&mut self, question: &Value) -> Result<DMatrix<f64>, String> {
        if let Ok(Ok(line)) = self.answers.try_recv() {
            return Err(unasked(&line));
        }
        self.asked += 1;
        self.most.store(most_bytes(question), Ordering::Relaxed);
        let input = self.questions.as_mut().ok_or("it has no input")?;
        let sent = writeln!(input, "{question}").and_then(|()| input.flush());
        sent.map_err(|error| format!("it no longer reads its input: {error}"))?;
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

    /// Exit status of the program, if it ends soon.
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
        // A program should end at the end of its input; otherwise it is killed.
        self.questions = None;
        if self.status().is_none() {
            self.program.kill().ok();
            self.program.wait().ok();
        }
    }
}

/// Problem text for a line without a request: the answers after it, and possibly some before, belong to other requests.
fn unasked(line: &str) -> String {
    format!("it wrote one line too many, `{}`; it must answer each question with one line", shown(line))
}

fn shown(line: &str) -> String {
    line.chars().take(60).collect()
}

/// Maximum number of bytes of the answer to a request.
fn most_bytes(question: &Value) -> usize {
    let lists = question.as_object().into_iter().flat_map(|lists| lists.values());
    let numbers: usize = lists.map(|list| list.as_array().map_or(1, Vec::len)).sum();
    LEAST_BYTES.max(OF_ENTRY.saturating_mul(numbers).saturating_mul(numbers))
}

/// The next line; `None` at the end of the output.
fn read_line(output: &mut impl BufRead, most: &AtomicUsize) -> Result<Option<String>, String> {
    let mut line = Vec::new();
    let mut read = |line: &mut Vec<u8>, most: usize| {
        output.by_ref().take(most as u64).read_until(b'\n', line).map_err(|error| error.to_string())
    };
    // The limit for this request is set by the time its answer begins.
    if read(&mut line, 1)? == 0 {
        return Ok(None);
    }
    let most = most.load(Ordering::Relaxed);
    if line != b"\n" {
        read(&mut line, most)?;
    }
    line.pop_if(|last| *last == b'\n');
    if line.len() > most {
        return Err(format!("its line has more than {most} bytes, more than any requested matrix needs"));
    }
    String::from_utf8(line).map(Some).map_err(|error| error.to_string())
}

/// Parses a line as a matrix.
fn matrix(line: &str) -> Result<DMatrix<f64>, String> {
    let value: Value = serde_json::from_str(line).map_err(|error| format!("`{}` is not JSON: {error}", shown(line)))?;
    match value.get("error") {
        Some(text) => Err(format!("it reports {text}")),
        None => worksheet::matrix(&value).map_err(|problem| format!("`{}` {problem}", shown(line))),
    }
}

fn wrong(problem: String) -> Error {
    Error::File { kind: "a program", place: "requested derivatives".into(), problem }
}
