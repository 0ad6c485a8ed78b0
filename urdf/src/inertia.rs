//! Inertias of links: their checks, and their entries in the axes of the links.

use hamiltonian_adjoint::spatial::Inertia;
use nalgebra::Matrix3;

use crate::error::{Doubt, Error, Fault};
use crate::robot::{Inertial, Link};

impl Inertial {
    fn matrix(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.tensor;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// True if the inertia has no effect.
    pub(crate) fn is_none(&self) -> bool {
        self.mass == 0.0 && self.tensor == [0.0; 6]
    }

    /// In the axes of the link: R J Rᵀ about the centre of mass.
    pub(crate) fn in_link(&self) -> Inertia {
        let rotation = self.origin.rotation();
        let j = rotation * self.matrix() * rotation.transpose();
        let entries = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].map(|[row, col]| j[(row, col)]);
        Inertia::new(self.mass, entries).centred_at(self.origin.xyz)
    }
}

/// Returns why no distribution of mass has the inertia of a link, if this is so.
///
/// # Errors
/// A negative mass, or numbers that are not finite.
pub(crate) fn doubt(link: &Link) -> Result<Option<Doubt>, Error> {
    let Some(inertial) = &link.inertial else { return Ok(None) };
    let value = |what, value, must_be| {
        let fault = Fault::Value { of: format!("link '{}'", link.name), what, value, must_be };
        Err(Error::new(link.at, fault))
    };
    if !(inertial.mass >= 0.0 && inertial.mass.is_finite()) {
        return value("mass", inertial.mass, "finite, and positive or zero");
    }
    if let Some(entry) = inertial.tensor.into_iter().find(|entry| !entry.is_finite()) {
        return value("largest moment of inertia", entry.abs(), "finite");
    }
    if inertial.tensor == [0.0; 6] {
        return Ok(None);
    }
    Ok(match Inertia::impossible_moments(inertial.tensor) {
        Some(moments) => Some(Doubt::Moments { moments }),
        None if inertial.mass == 0.0 => Some(Doubt::NoMass),
        None => None,
    })
}
