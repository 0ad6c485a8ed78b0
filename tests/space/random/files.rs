//! Random scenes that are written to a file and read again: equal motions and derivatives, to the last bit.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Grid, Scene, SceneFile, Settings, Solver};

use super::build::build;
use super::plan::{Scope, plan};
use super::{TREES, inputs, number, seeds};

#[test]
fn scenes_come_back_from_files_to_the_last_bit() {
    let loops = Scope { loops: true, ..TREES };
    let mut moved = 0;
    for seed in seeds(70_000, number("RANDOM_SCENES").unwrap_or(12)) {
        let mut random = Random::new(seed);
        let mut plan = plan(&mut random, if seed % 3 == 0 { loops } else { TREES });
        plan.cuts.extend((seed % 2 == 0 && plan.links.len() > 3).then_some(1));
        let built = build(&plan, &mut random);
        let Ok(json) = built.scene.to_json() else { continue };
        let copy = SceneFile::from_json(&json).and_then(SceneFile::complete).expect("the whole scene");
        assert_eq!(copy.to_json().expect("a file"), json, "seed {seed}");
        let run = |scene: &Scene| {
            let system = scene.clone().compile().ok()?;
            let mut inputs = inputs(&system, &built, Grid::uniform(4, 0.01));
            if !plan.cuts.is_empty() {
                inputs.start = hamiltonian_adjoint::Start::assembled(&system);
            }
            let mut solver = Solver::new(&system, Settings::default());
            let motion = solver.simulate(&inputs).ok()?.clone();
            Some((motion, solver.jacobian().ok()?.to_vec()))
        };
        let (was, is) = (run(&built.scene), run(&copy));
        assert!(was == is, "seed {seed}");
        moved += usize::from(was.is_some());
    }
    assert!(moved > 6, "{moved} motions");
}
