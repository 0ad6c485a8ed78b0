//! Compares the accelerations of robots with those of Pinocchio, which `urdf/reference/accelerations.py` has written as JSON files:
//!
//! `cargo run --release -p urdf --example compare_robots -- FOLDER_OF_URDF_FILES FOLDER_OF_JSON_FILES`
//!
//! Every line contains the largest difference of a file, relative to the largest acceleration of the state; the difference between two algorithms of
//! Pinocchio; and the residual of Pinocchio's equations, if it knows the accelerations with few digits. Without the second folder the program only
//! reports which files can be read.

#[path = "../reference/state.rs"]
mod state;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use hamiltonian_adjoint::Scene;
use serde_json::Value;
use state::{Compared, Failure};
use urdf::{Base, Fault, Options, Robot, Why};

fn main() -> ExitCode {
    let folders: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let result = match &folders[..] {
        [robots] => read_all(robots),
        [robots, reference] => read_all(robots).and_then(|()| compare_all(robots, reference)),
        _ => {
            Err("usage: cargo run --release -p urdf --example compare_robots -- FOLDER_OF_URDF_FILES [FOLDER_OF_JSON_FILES]"
                .into())
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// All files below a folder with this extension, sorted.
fn files(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, Failure> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|of| of == extension) => found.push(path),
                false => {}
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The options that a robot needs: ignored mimic joints where leaders are missing, and impossible inertias.
fn needed(robot: &Robot, base: Base) -> Result<Options, urdf::Error> {
    let mut options = Options { base, ..Options::default() };
    loop {
        match robot.add_to(&mut Scene::new(), &options).map_err(|error| (error.fault.clone(), error)) {
            Ok(_) => return Ok(options),
            Err((Fault::Mimic { why: Why::Unknown, .. }, _)) if !options.ignore_mimic => options.ignore_mimic = true,
            Err((Fault::Inertia { .. }, _)) if !options.accept_impossible_inertias => {
                options.accept_impossible_inertias = true
            }
            Err((_, error)) => return Err(error),
        }
    }
}

fn read_all(folder: &Path) -> Result<(), Failure> {
    let files = files(folder, "urdf")?;
    let mut read = 0;
    for path in &files {
        let name = path.strip_prefix(folder)?.display();
        match Robot::read(path).and_then(|robot| needed(&robot, Base::Fixed).map(|options| (robot, options))) {
            Ok((robot, options)) => {
                read += 1;
                let added = robot.add_to(&mut Scene::new(), &options)?;
                let locked: Vec<&str> = added.locked.iter().map(|joint| joint.name.as_str()).collect();
                let notes = [
                    (!locked.is_empty()).then(|| format!("locked: {locked:?}")),
                    (!added.doubts.is_empty()).then(|| format!("{} doubtful inertias", added.doubts.len())),
                    options.ignore_mimic.then(|| "needs `ignore_mimic`".to_string()),
                    options.accept_impossible_inertias.then(|| "needs `accept_impossible_inertias`".to_string()),
                ];
                let notes = notes.into_iter().flatten().collect::<Vec<_>>().join("; ");
                println!("read    {name}: {} links, {} joints move {notes}", robot.links.len(), added.joints.len());
            }
            Err(error) => println!("refused {name}: {error}"),
        }
    }
    println!("{read} of {} files were read", files.len());
    Ok(())
}

fn compare_all(robots: &Path, reference: &Path) -> Result<(), Failure> {
    let (mut compared, mut worst, mut failed) = (0, (0.0, String::new()), Vec::new());
    for path in files(reference, "json")? {
        let reference: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        let is_floating = reference["floating"] == true;
        let file = reference["file"].as_str().unwrap_or_default();
        let name = format!("{file}, {} base", if is_floating { "floating" } else { "fixed" });
        let begin = Instant::now();
        match compare(&robots.join(file), is_floating, &reference) {
            Ok((states, difference, residual)) => {
                let (spread, seconds) = (reference["spread"].as_f64().unwrap_or(f64::NAN), begin.elapsed().as_secs_f64());
                let residual = residual.map_or(String::new(), |residual| format!(", residual {residual:.1e}"));
                println!("{difference:.1e} (Pinocchio {spread:.1e}{residual}) in {states} states, {seconds:.1} s: {name}");
                compared += usize::from(states > 0);
                if difference > worst.0 {
                    worst = (difference, name);
                }
            }
            Err(error) => failed.push(format!("failed: {name}: {error}")),
        }
    }
    failed.iter().for_each(|failed| println!("{failed}"));
    println!("{compared} compared, {} failed; the largest difference is {:.1e}, of {}", failed.len(), worst.0, worst.1);
    Ok(())
}

/// The number of states, the largest difference relative to the largest acceleration of the state, and the largest residual.
fn compare(path: &Path, is_floating: bool, reference: &Value) -> Result<(usize, f64, Option<f64>), Failure> {
    let robot = Robot::read(path)?;
    let options = needed(&robot, if is_floating { Base::Floating } else { Base::Fixed })?;
    let Some(compared) = Compared::new(&robot, &options, reference)? else { return Ok((0, 0.0, None)) };
    let states = reference["states"].as_array().ok_or("no states")?;
    let (mut worst, mut residual) = (0.0f64, None::<f64>);
    for state in states {
        let (difference, own) = compared.difference(state)?;
        worst = worst.max(difference);
        residual = own.into_iter().chain(residual).reduce(f64::max);
    }
    Ok((states.len(), worst, residual))
}
