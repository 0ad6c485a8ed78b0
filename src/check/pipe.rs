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

/// A program that is about to end is waited for so often, and so long each time.
const MOST_WAITS: usize = 200;
const WAIT: Duration = Duration::from_millis(10);
/// An answer may have so many bytes for each pair of two numbers of the question, which a square matrix has an entry for, …
const OF_ENTRY: usize = 64;
/// … and always so many: a matrix may have more rows than its function has arguments.
const LEAST_BYTES: usize = 10_000_000;

/// A program in any language that computes matrices on request, by reading and writing lines.
///
/// It receives lines like `{"ask":"phi_q","q":[0.1,0.2],"v":[…],"sigma":[…],"u":[…],"t":0.5,"b":[0.7]}`, or `{"ask":"jacobian","x":[…]}`
/// for a function, answers each with one line that contains the rows of the matrix, `[[1,0],[0,1]]`, or `{"error":"…"}`, and flushes its
/// output.
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
    /// The most bytes that the answer may have.
    most: Arc<AtomicUsize>,
    patience: Duration,
    asked: usize,
    /// The first thing that went wrong; nothing is asked any more.
    problem: Option<String>,
}

impl Pipe {
    /// Starts the program. It must answer within ten seconds.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub fn new(command: &mut Command) -> Result<Self, Error> {
        let started = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let mut program = started.map_err(|error| wrong(format!("{command:?} does not start: {error}")))?;
        let most = Arc::new(AtomicUsize::new(LEAST_BYTES));
        // What was not asked for waits in the program.
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

/// A line that no question was asked for: all answers from there on, or some before, would be those of other questions.
fn unasked(line: &str) -> String {
    format!("it wrote a line more than it was asked for, `{}`; it must answer each question with one line", shown(line))
}

fn shown(line: &str) -> String {
    line.chars().take(60).collect()
}

/// The most bytes that the answer to a question may have.
fn most_bytes(question: &Value) -> usize {
    let lists = question.as_object().into_iter().flat_map(|lists| lists.values());
    let numbers: usize = lists.map(|list| list.as_array().map_or(1, Vec::len)).sum();
    LEAST_BYTES.max(OF_ENTRY.saturating_mul(numbers).saturating_mul(numbers))
}

/// The next line; none at the end of the output.
fn read_line(output: &mut impl BufRead, most: &AtomicUsize) -> Result<Option<String>, String> {
    let mut line = Vec::new();
    let mut read = |line: &mut Vec<u8>, most: usize| {
        output.by_ref().take(most as u64).read_until(b'\n', line).map_err(|error| error.to_string())
    };
    // What was asked for is known once the answer begins.
    if read(&mut line, 1)? == 0 {
        return Ok(None);
    }
    let most = most.load(Ordering::Relaxed);
    if line != b"\n" {
        read(&mut line, most)?;
    }
    line.pop_if(|last| *last == b'\n');
    if line.len() > most {
        return Err(format!("its line has more than {most} bytes, which no matrix that was asked for has"));
    }
    String::from_utf8(line).map(Some).map_err(|error| error.to_string())
}

/// A matrix in a line.
fn matrix(line: &str) -> Result<DMatrix<f64>, String> {
    let value: Value = serde_json::from_str(line).map_err(|error| format!("`{}` is no JSON: {error}", shown(line)))?;
    match value.get("error") {
        Some(text) => Err(format!("it says {text}")),
        None => worksheet::matrix(&value).map_err(|problem| format!("`{}` {problem}", shown(line))),
    }
}

fn wrong(problem: String) -> Error {
    Error::File { kind: "a program", place: "asked for derivatives".into(), problem }
}
