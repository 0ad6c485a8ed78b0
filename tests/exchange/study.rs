//! A study: outcomes kept in a file, a run that is lost in the middle, files that are none.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use super::common::assert_says;
use hamiltonian_adjoint::optimize::{Iterate, Options, Outcome, Problem, lbfgs, silent};
use hamiltonian_adjoint::{Error, Finished, Study};

/// (x² − 1)² + y²/2, which has no value left of −3.
struct Valleys(f64, f64);
impl Problem for Valleys {
    fn variables(&self) -> usize {
        2
    }
    fn evaluate(&mut self, x: &[f64], _: &mut [f64]) -> Result<f64, Error> {
        (self.0, self.1) = (x[0], x[1]);
        match x[0] < -3.0 {
            true => Err(Error::EmptyScene),
            false => Ok((x[0] * x[0] - 1.0).powi(2) + x[1] * x[1] / 2.0),
        }
    }
    fn gradient(&mut self, f: f64, _: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        gradient.copy_from_slice(&[f * 4.0 * self.0 * (self.0 * self.0 - 1.0), f * self.1]);
        Ok(())
    }
}

fn starts() -> Vec<Vec<f64>> {
    (0..20).map(|k| vec![3.0 * (f64::from(k) * 1.3).sin() - 0.3, f64::from(k) / 7.0]).collect()
}

fn method(problem: &mut Valleys, start: &[f64]) -> Result<Outcome, Error> {
    lbfgs(problem, start, &Options::default(), &mut silent)
}

/// A folder of its own that goes with the test.
struct Folder(PathBuf);
impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("study-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        Folder(folder)
    }
}
impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).ok();
    }
}

fn all(path: &Path) -> Vec<Finished> {
    let mut study = Study::open(path, "valleys", &starts()).expect("a study");
    study.run(|| Ok(Valleys(0.0, 0.0)), method).expect("written");
    study.finished().cloned().collect()
}

#[test]
fn a_study_that_was_lost_goes_on_where_it_was() {
    let folder = Folder::new("lost");
    let path = folder.0.join("whole.jsonl");
    let expected = all(&path);
    assert_eq!(expected.iter().map(|of| of.start).collect::<Vec<_>>(), (0..20).collect::<Vec<_>>());
    let failed: Vec<_> = expected.iter().filter(|of| of.value.is_none()).collect();
    assert!(!failed.is_empty() && failed.iter().all(|of| of.x.is_empty() && !of.converged && !of.reason.is_empty()));
    assert!(expected.iter().filter(|of| of.converged).all(|of| of.value.expect("a value") < 1e-12));
    let text = fs::read_to_string(&path).expect("the file");
    // Nothing more is computed, and nothing written.
    let calls = AtomicUsize::new(0);
    let counted = |problem: &mut Valleys, start: &[f64]| {
        calls.fetch_add(1, Relaxed);
        method(problem, start)
    };
    let mut study = Study::open(&path, "valleys", &starts()).expect("a study");
    study.run(|| Ok(Valleys(0.0, 0.0)), counted).expect("written");
    assert_eq!((calls.load(Relaxed), fs::read_to_string(&path).expect("the file") == text), (0, true));
    // Only one may write it.
    assert_says(
        &Study::open(&path, "valleys", &starts()).expect_err("it is open"),
        &["this or another process", "whole.jsonl"],
    );
    drop(study);
    // Lost after any byte: what is whole is kept, the rest is computed, and the answer is the same.
    for (k, length) in (0..text.len()).step_by(97).enumerate() {
        let path = folder.0.join(format!("torn {k}.jsonl"));
        fs::write(&path, &text[..length]).expect("written");
        let kept = text[..length].matches('\n').count().saturating_sub(1);
        assert_eq!(Study::open(&path, "valleys", &starts()).expect("a study").missing().count(), 20 - kept, "{length}");
        assert_eq!(all(&path), expected, "{length}");
        assert!(fs::read_to_string(&path).expect("the file").ends_with('\n'));
    }
}

#[test]
fn a_study_that_was_lost_inside_a_character_goes_on() {
    let folder = Folder::new("character");
    let path = folder.0.join("study.jsonl");
    let open = || Study::open(&path, "vallées", &starts());
    let of = Finished { reason: "½ of a µm".into(), ..Finished::new(3, &Err(Error::EmptyScene)) };
    open().and_then(|mut study| study.add(of)).expect("written");
    let bytes = fs::read(&path).expect("the file");
    let inside: Vec<usize> = (0..bytes.len()).filter(|at| std::str::from_utf8(&bytes[..*at]).is_err()).collect();
    assert_eq!(inside.len(), 3, "those of é, ½ and µ");
    for at in inside {
        fs::write(&path, &bytes[..at]).expect("written");
        assert_eq!(open().expect("a study").missing().count(), 20, "cut at {at}");
    }
}

#[test]
fn what_is_not_finite_is_no_line_of_a_study() {
    let folder = Folder::new("finite");
    let path = folder.0.join("study.jsonl");
    let mut study = Study::open(&path, "valleys", &starts()).expect("a study");
    let lost =
        |problem: &mut Valleys, start: &[f64]| method(problem, start).map(|of| Outcome { x: vec![f64::NAN, of.x[1]], ..of });
    study.run(|| Ok(Valleys(0.0, 0.0)), lost).expect("written");
    let of = study.finished().find(|of| of.reason.contains("not finite")).expect("what was lost").clone();
    assert!(of.x.is_empty() && of.value.is_none() && !of.converged);
    drop(study);
    assert_eq!(Study::open(&path, "valleys", &starts()).expect("a study").missing().count(), 0);
    let mut study = Study::open(&folder.0.join("other.jsonl"), "valleys", &starts()).expect("a study");
    assert_says(&study.add(Finished { x: vec![1.0, f64::NAN], ..of }).expect_err("no number"), &["other.jsonl", "NaN"]);
}

#[test]
fn files_that_are_no_such_study_are_left_alone() {
    let folder = Folder::new("wrong");
    let path = folder.0.join("study.jsonl");
    all(&path);
    let good = fs::read_to_string(&path).expect("the file");
    let refuse = |text: &str, words: &[&str]| {
        fs::write(&path, text).expect("written");
        assert_says(&Study::open(&path, "valleys", &starts()).expect_err(text), words);
        assert_eq!(fs::read_to_string(&path).expect("the file"), text, "it was changed");
    };
    refuse("my notes, without an end of line", &["line 1", "study.jsonl"]);
    refuse("my notes\nmore\n", &["a study", "line 1"]);
    refuse(&good.replacen("valleys", "hills", 1), &["`hills`", "`valleys`"]);
    refuse(&good.replacen("\"version\":1", "\"version\":2", 1), &["version 2"]);
    refuse(&good.replacen("\"starts\":20", "\"starts\":21", 1), &["21", "other starts"]);
    let sum = good.split("\"sum\":\"").nth(1).expect("a sum")[..16].to_string();
    refuse(&good.replacen(&sum, "0123456789abcdef", 1), &["other starts"]);
    let second = good.lines().nth(1).expect("a line").to_string();
    refuse(&good.replacen(&second, "{\"start\":0}", 1), &["line 2"]);
    refuse(&good.replacen(&second, &second.replacen("\"start\":", "\"start\":7", 1), 1), &["line 2", "no start 7"]);
    assert_says(&Study::open(&folder.0, "valleys", &starts()).expect_err("a folder"), &["a study"]);
}

#[test]
fn starts_that_were_stopped_when_asked_to_stay_missing() {
    let folder = Folder::new("asked");
    let path = folder.0.join("asked.jsonl");
    let all = starts();
    let mut study = Study::open(&path, "valleys", &all).expect("a study");
    let begun = AtomicUsize::new(0);
    let until_third = |problem: &mut Valleys, start: &[f64]| {
        let stop = begun.fetch_add(1, Relaxed) >= 2;
        let mut watch = |_: &Iterate, _: &[f64]| if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        lbfgs(problem, start, &Options::default(), &mut watch)
    };
    study.run(|| Ok(Valleys(0.0, 0.0)), until_third).expect("kept");
    let finished = study.finished().count();
    assert!(finished >= 2 && finished < all.len() && study.finished().all(|of| of.reason != "Interrupted"), "{finished}");
    study.run(|| Ok(Valleys(0.0, 0.0)), method).expect("kept");
    assert_eq!(study.missing().count(), 0);
    let mut whole = Study::open(&folder.0.join("whole.jsonl"), "valleys", &all).expect("a study");
    whole.run(|| Ok(Valleys(0.0, 0.0)), method).expect("kept");
    assert!(study.finished().eq(whole.finished()));
}
