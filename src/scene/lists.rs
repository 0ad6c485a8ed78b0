//! Elements of lists, whose lengths are known only at run time.

use super::Scene;
use crate::model::{Control, Coordinate, Multiplier, Param};
use crate::system::{Applied, Holonomic, Kinetic, Lists, Potential, SEEDS};
use crate::{ListConstraint, ListForce, ListKineticEnergy, ListPotentialEnergy};

impl Scene {
    /// Adds generalized coordinates that belong together, in m or rad, as [`coordinates`](Self::coordinates), in any number.
    pub fn list_coordinates(&mut self, group: &str, names: &[&str]) -> Vec<Coordinate> {
        let first = self.coordinate_group(group, names);
        (first..first + names.len()).map(|i| Coordinate(self.parts.scene.handle(i))).collect()
    }

    /// Adds a kinetic energy T(q, v; b) of lists ([`ListKineticEnergy`]).
    pub fn list_kinetic_energy(&mut self, name: &str, element: impl ListKineticEnergy, q: &[Coordinate], b: &[Param]) {
        let formula = Kinetic::<_, SEEDS> { energy: Lists(element), n: q.len(), p: b.len() };
        self.insert(name, formula, (q, 0..0), &[], b);
    }

    /// Adds a potential energy V(q, t; b) of lists ([`ListPotentialEnergy`]).
    pub fn list_potential_energy(&mut self, name: &str, element: impl ListPotentialEnergy, q: &[Coordinate], b: &[Param]) {
        let formula = Potential::<_, SEEDS> { energy: Lists(element), n: q.len(), p: b.len() };
        self.insert(name, formula, (q, 0..0), &[], b);
    }

    /// Adds a generalized force Q(q, v, u, t; b) of lists ([`ListForce`]).
    pub fn list_force(&mut self, name: &str, element: impl ListForce, q: &[Coordinate], u: &[Control], b: &[Param]) {
        let formula = Applied::<_, SEEDS> { force: Lists(element), n: q.len(), k: u.len(), p: b.len() };
        self.insert(name, formula, (q, 0..0), u, b);
    }

    /// Adds a holonomic constraint Φ(q, t; b) = 0 of lists ([`ListConstraint`]) and returns its multipliers, one for each equation.
    pub fn list_constraint(
        &mut self,
        name: &str,
        element: impl ListConstraint,
        equations: usize,
        q: &[Coordinate],
        b: &[Param],
    ) -> Vec<Multiplier> {
        let formula = Holonomic::<_, SEEDS> { constraint: Lists(element), n: q.len(), m: equations, p: b.len() };
        let equations = self.equations(name, equations);
        self.insert(name, formula, (q, equations.clone()), &[], b);
        equations.map(|j| Multiplier(self.parts.scene.handle(j))).collect()
    }
}
