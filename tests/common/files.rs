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
    /// Results that differ by rounding.
    Rounded,
    /// Both scenes fail with the same kind of error.
    Failed,
}

/// Largest difference between the numbers of two outcomes that are not the same to the last bit, relative to the largest number in the same list.
const ROUNDING: f64 = 1e-9;

/// Compares a scene with the one from its file: names of outputs, motion, J, outputs and all derivatives. Fails if they differ by more than rounding.
///
/// Results are the same to the last bit, with the signs of zeros, if the unknowns are eliminated in the same order. The order depends on values of the
/// formulas as they were written by the user, and a file contains them as they were simplified; so a few results differ by rounding.
/// `cargo test --all-features -- --nocapture | grep -c "is the same from its file"` counts the scenes that are the same to the last bit, and
/// `"differs by rounding from its file"` the others.
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
        [Ok(was), Ok(is)] => {
            assert_eq!(was.0, is.0, "{name}");
            let [was, is] = [was, is].map(|(_, motion, gradient, outputs, jacobian)| {
                let mut lists = vec![motion.q.iter().copied().collect::<Vec<_>>(), outputs.iter().copied().collect()];
                for gradient in std::iter::once(&gradient).chain(&jacobian) {
                    lists.extend([gradient.controls.as_slice().to_vec(), gradient.design.as_slice().to_vec()]);
                }
                lists
            });
            for (was, is) in was.iter().zip(&is) {
                let size = was.iter().fold(0.0f64, |size, x| size.max(x.abs()));
                let is_near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= ROUNDING * size;
                assert!(was.len() == is.len() && was.iter().zip(is).all(is_near), "{name}: {was:?}\n{is:?}\n{json}");
            }
            println!("{name} differs by rounding from its file");
            Copied::Rounded
        }
        [was, is] => panic!("{name}: {was:?}\n{is:?}\n{json}"),
    }
}

/// Without files there is nothing to compare.
#[cfg(not(feature = "files"))]
pub fn compared(_name: &str, _scene: &Scene, _inputs: &dyn Fn(&Scene, &System) -> Inputs) -> Copied {
    Copied::LeftOut
}
