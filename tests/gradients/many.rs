//! Many motions at once are the same as one after the other.

use hamiltonian_adjoint::{Error, Grid, Inputs, Settings, gradient, gradients, scenes::CartPendulum};

#[test]
fn many_gradients_are_those_of_single_motions_and_failures_stay_in_their_place() {
    let system = CartPendulum::with_links(2).scene().compile().expect("scene");
    let at_rest = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
    let mut all: Vec<Inputs> = (0..40).map(|_| at_rest.clone()).collect();
    all.iter_mut().enumerate().for_each(|(k, inputs)| inputs.controls.fill(k as f64 - 20.0));
    all[7].controls[(0, 3)] = f64::NAN;
    let found = gradients(&system, &all, Settings::default());
    assert_eq!(found.len(), all.len());
    for (k, (inputs, found)) in all.iter().zip(found).enumerate() {
        if k == 7 {
            assert!(matches!(found, Err(Error::NotFinite { .. })));
        } else {
            assert_eq!(found, gradient(&system, inputs, Settings::default()), "motion {k}");
        }
    }
}
