//! Forces on the coordinates of joints.

use hamiltonian_adjoint::{Force, ForcePoint, Scalar};
use nalgebra::SVector;

/// Q = −b v.
pub(crate) struct Viscous;

impl Force<1, 0, 1> for Viscous {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([-(b[0] * at.v[0])])
    }
}

/// Q = u.
pub(crate) struct Drive;

impl Force<1, 1> for Drive {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0]])
    }
}
