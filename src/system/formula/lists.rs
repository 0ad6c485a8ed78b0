//! [`Lists`]: formulas of lists, whose lengths are known only at run time.

use super::applied::ForceFormula;
use super::energy::{KineticFormula, PotentialFormula};
use super::holonomic::ConstraintFormula;
use super::on_numbers::{List, Read, with_lists, with_memory};
use super::shape::{Shape, Slot};
use crate::Scalar;
use crate::model::element::{ListConstraint, ListForce, ListForcePoint, ListKineticEnergy, ListPotentialEnergy};

/// A formula of lists.
pub struct Lists<E>(pub E);

impl<E: ListKineticEnergy> KineticFormula for Lists<E> {
    fn kinetic_energy<S: Scalar>(&self, shape: Shape, read: Read<S>) -> S {
        let mut energy = S::zero();
        with_lists(read, [(Slot::Q, shape.n), (Slot::V, shape.n), (Slot::B, shape.p)], &mut |[q, v, b]| {
            energy = self.0.kinetic_energy(q, v, b);
        });
        energy
    }
}

impl<E: ListPotentialEnergy> PotentialFormula for Lists<E> {
    fn potential_energy<S: Scalar>(&self, shape: Shape, read: Read<S>) -> S {
        let mut energy = S::zero();
        with_lists(read, [(Slot::Q, shape.n), (Slot::B, shape.p)], &mut |[q, b]| {
            energy = self.0.potential_energy(q, b, read(Slot::T));
        });
        energy
    }
}

impl<E: ListForce> ForceFormula for Lists<E> {
    fn force<S: Scalar>(&self, shape: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        let Shape { n, k, p, .. } = shape;
        let lists: [List; 4] = [(Slot::Q, n), (Slot::V, n), (Slot::U, k), (Slot::B, p)];
        with_lists(read, lists, &mut |[q, v, u, b]| {
            with_memory(n, &mut |force: &mut [S]| {
                self.0.force(&ListForcePoint { q, v, u, t: read(Slot::T) }, b, force);
                force.iter().for_each(|component| put(*component));
            });
        });
    }
}

impl<E: ListConstraint> ConstraintFormula for Lists<E> {
    fn phi<S: Scalar>(&self, shape: Shape, read: Read<S>, put: &mut dyn FnMut(S)) {
        with_lists(read, [(Slot::Q, shape.n), (Slot::B, shape.p)], &mut |[q, b]| {
            with_memory(shape.m, &mut |phi: &mut [S]| {
                self.0.phi(q, b, read(Slot::T), phi);
                phi.iter().for_each(|phi| put(*phi));
            });
        });
    }
}
