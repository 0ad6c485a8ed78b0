//! Robots in scene files.

use hamiltonian_adjoint::{Grid, Inputs, Scene, SceneFile, Settings, Solver};
use urdf::{Options, Robot};

use crate::state::Failure;
use crate::text;

#[test]
fn robots_come_back_from_scene_files_to_the_last_bit() -> Result<(), Failure> {
    for robot in ["arm", "linkage", "loose"] {
        let options = Options { accept_impossible_inertias: true, ..Options::default() };
        let mut scene = Scene::new();
        scene.spatial().gravity([0.0, 0.0, -9.81]);
        let added = Robot::from_text(text(robot))?.add_to(&mut scene, &options)?;
        let joint = added.joints.first().ok_or("no joint")?;
        scene.end_state(joint.coordinates[0]);
        let copy = SceneFile::from_json(&scene.to_json()?)?.complete()?;
        let [was, is] = [scene, copy].map(|scene| -> Result<_, Failure> {
            let system = scene.compile()?;
            let inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.01));
            let mut solver = Solver::new(&system, Settings::default());
            let motion = solver.simulate(&inputs)?.clone();
            Ok((motion, solver.jacobian()?.to_vec()))
        });
        assert!(was? == is?, "{robot}");
    }
    Ok(())
}
