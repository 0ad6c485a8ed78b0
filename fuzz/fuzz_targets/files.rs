//! Reads any text as inputs, as a table, as a scene and as a worksheet: nothing may panic, and data that were read can be written.
#![no_main]

use hamiltonian_adjoint::check::Answers;
use hamiltonian_adjoint::{Inputs, SceneFile, Table, scenes::CartPendulum};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let system = CartPendulum::with_links(1).scene().compile().expect("a scene");
    if let Ok(inputs) = Inputs::from_json(&system, text) {
        inputs.to_json(&system).expect("what was read");
    }
    if let Ok(file) = SceneFile::from_json(text) {
        let _ = file.scene.to_json();
        let _ = file.scene.compile();
    }
    let _ = Answers::from_json(text);
    if let Ok(table) = Table::from_csv(text) {
        assert!((0..table.columns.len()).all(|k| table.value(k, 0.5).is_finite()));
    }
});
