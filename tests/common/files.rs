//! Scenes that are written to a file and read again.
#![allow(dead_code)]

use hamiltonian_adjoint::{Inputs, Scene, System};

/// A scene from a file, compared with the scene that was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Copied {
    /// Formulas that branch on a value cannot be written.
    LeftOut,
    /// Equal results, to the last bit and with the signs of zeros.
    Same,
    /// Both scenes fail with the same kind of error.
    Failed,
}

/// Compares a scene with the one from its file: names of outputs, motion, J, outputs and all derivatives. Fails unless they are the same to the last
/// bit, with the signs of zeros, or unless both scenes fail alike.
///
/// `cargo test --all-features -- --nocapture | grep -c "is the same from its file"` counts the scenes.
#[cfg(feature = "files")]
pub fn compared(name: &str, scene: &Scene, inputs: &dyn Fn(&Scene, &System) -> Inputs) -> Copied {
    use hamiltonian_adjoint::{Error, SceneFile, Settings, Solver};
    use std::mem::discriminant;

    let json = scene.to_json().unwrap_or_else(|error| panic!("{name}: {error}"));
    let read = SceneFile::from_json(&json).unwrap_or_else(|error| panic!("{name}: {error}\n{json}"));
    if !read.left_out.is_empty() {
        let system = scene.clone().compile().unwrap_or_else(|error| panic!("{name}: {error}"));
        let without: Vec<&str> = system.without_programs().map(|(name, _)| name).collect();
        assert!(read.left_out.iter().all(|name| without.contains(&&name[..])), "{name}: {:?} is left out", read.left_out);
        return Copied::LeftOut;
    }
    // Some formulas are written in another way when they have been read, and from then on in the same.
    let second = read.scene.to_json().unwrap_or_else(|error| panic!("{name}: {error}"));
    let third = SceneFile::from_json(&second).and_then(|file| file.scene.to_json());
    assert!(third.is_ok_and(|third| third == second), "{name}: {second}");
    let results = |scene: &Scene| {
        let system = scene.clone().compile()?;
        let names: Vec<String> = (0..system.outputs()).map(|k| system.output_name(k).into()).collect();
        let mut solver = Solver::new(&system, Settings::default());
        let motion = solver.simulate(&inputs(scene, &system))?.clone();
        Ok::<_, Error>((names, motion, solver.gradient()?.clone(), solver.outputs()?, solver.jacobian()?.to_vec()))
    };
    match [scene, &read.scene].map(results) {
        // The formula and the arguments that are said to be the cause may be others, because a file contains formulas as they were simplified.
        [Err(was), Err(is)] => {
            assert_eq!(discriminant(&was), discriminant(&is), "{name}: {was}\n{is}\n{json}");
            println!("{name} fails alike from its file");
            Copied::Failed
        }
        // Numbers with the same digits have the same bits.
        [was, is] if format!("{was:?}") == format!("{is:?}") => {
            println!("{name} is the same from its file");
            Copied::Same
        }
        [was, is] => panic!("{name}: {was:?}\n{is:?}\n{json}"),
    }
}

/// Without files there is nothing to compare.
#[cfg(not(feature = "files"))]
pub fn compared(_name: &str, _scene: &Scene, _inputs: &dyn Fn(&Scene, &System) -> Inputs) -> Copied {
    Copied::LeftOut
}
