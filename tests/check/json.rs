//! Reports for machines: `cargo test --features serde --test check json`.

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, Settings, check, planar::Revolute};

#[test]
fn reports_become_json() {
    let report = check::constraint(&Revolute, [0.5, 0.0, -0.5, 0.0]).phi_q(|_| [[0.0; 6]; 2]).run();
    let json = serde_json::to_value(&report).expect("no maps, no NaN keys");
    assert_eq!(json["blocks"][0]["verdict"], "Wrong");
    assert_eq!(json["blocks"][0]["diagnoses"][0]["mistake"], "Zero");

    let system = CartPendulum::with_links(1).scene().compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    inputs.controls.fill(1.0);
    let report = check::gradient(&system, &inputs, Settings::default()).run().expect("motion");
    let json = serde_json::to_value(&report).expect("no maps, no NaN keys");
    assert_eq!(json["directions"][0]["verdict"], "Right");
}
