//! The surroundings of a state: its linearised motion ([`LinearModel`]), the equilibrium near it ([`Equilibrium`]), and the controls for given accelerations.

mod descent;
mod equilibrium;
mod inverse_dynamics;
mod linear_model;
mod newton;
mod relative_degree;
mod sensitivity;
mod statics;

pub use equilibrium::Equilibrium;
pub use linear_model::LinearModel;
pub use sensitivity::Sensitivity;

use crate::redundancy::pivots;
use crate::{Control, Coordinate, Error, Mechanics, System};

/// The indices of chosen coordinates.
///
/// # Errors
/// A coordinate of another scene.
fn indices(caller: &str, coordinates: &[Coordinate], system: &System) -> Result<Vec<usize>, Error> {
    if coordinates.iter().any(|q| q.index() >= system.n() || !system.owns(q.0)) {
        return Err(Error::Foreign { element: caller.into(), kind: "coordinate" });
    }
    Ok(coordinates.iter().map(Coordinate::index).collect())
}

/// The indices of controls.
///
/// # Errors
/// A control of another scene.
fn control_indices(caller: &str, controls: &[Control], system: &System) -> Result<Vec<usize>, Error> {
    if controls.iter().any(|u| u.index() >= system.k() || !system.owns(u.0)) {
        return Err(Error::Foreign { element: caller.into(), kind: "control" });
    }
    Ok(controls.iter().map(Control::index).collect())
}

/// Independent coordinates of a state, in ascending order, among them the chosen ones.
///
/// # Errors
/// A chosen coordinate that the constraints and the others before it determine.
fn independent(state: &Mechanics, chosen: &[usize]) -> Result<Vec<usize>, Error> {
    let (system, open) = (state.system(), state.open());
    let closed: Vec<usize> = (0..system.m()).filter(|&j| open.iter().all(|open| open.index() != j)).collect();
    let phi_q = state.phi_q().select_rows(&closed);
    let dependent = |chosen: &[usize]| {
        let rest: Vec<usize> = (0..system.n()).filter(|i| !chosen.contains(i)).collect();
        pivots(phi_q.select_columns(&rest)).into_iter().map(|[_, column]| rest[column]).collect::<Vec<usize>>()
    };
    let rank = dependent(&[]).len();
    let found = dependent(chosen);
    if found.len() < rank {
        let first = (0..chosen.len()).find(|&i| dependent(&chosen[..=i]).len() < rank).unwrap_or(0);
        return Err(Error::NotIndependent { coordinate: system.coordinate_name(chosen[first]).to_string() });
    }
    Ok((0..system.n()).filter(|i| !found.contains(i)).collect())
}
