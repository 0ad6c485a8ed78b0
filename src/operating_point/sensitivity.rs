//! [`Sensitivity`]: derivatives of an equilibrium, by the implicit function theorem.
//!
//! ```text
//!   q' = q_p + P y,      q_p: change of dependent coordinates, Φ_q q_p = −Φ_b b'
//!   k y = Pᵀ f',         f': change of r − Φ_qᵀ λ along (q_p, u', b')
//!   holding' = −(x)',    λ' from K(0) (0, λ') = (f' along (q', u', b') + holding', 0)
//! ```

use nalgebra::{DMatrix, DVector};

use super::statics::{Balance, Statics};
use crate::Error;
use crate::assembly::Retraction;
use crate::system::{NodeView, Pair};

/// Derivatives of an equilibrium; a column for each control or design variable, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Of the coordinates (n rows).
    pub q: DMatrix<f64>,
    /// Of the reactions λ (m rows). For dependent constraints they are not unique, but that of Φ_qᵀλ is.
    pub lambda: DMatrix<f64>,
    /// Of the forces that hold the held coordinates (n rows).
    pub holding: DMatrix<f64>,
}

/// A change of controls, parameters, and dependent coordinates.
struct Change {
    u: Vec<f64>,
    design: Vec<f64>,
    q: DVector<f64>,
}

impl Statics {
    /// Forces that hold the held coordinates while the forces of a configuration act, N or N m.
    pub(super) fn holding(&self, at: &Balance) -> Vec<f64> {
        self.of_held(at, &at.forces)
    }

    /// −x in Gᵀ [x; λ] = r, for the held coordinates.
    fn of_held(&self, at: &Balance, forces: &DVector<f64>) -> Vec<f64> {
        let mut holding = vec![0.0; forces.len()];
        for (c, &i) in at.independent.iter().enumerate().filter(|(_, i)| self.held.contains(i)) {
            holding[i] = -at.motions.column(c).dot(forces);
        }
        holding
    }

    /// λ at an equilibrium, with dependent constraints as for [`Mechanics::accelerations`](crate::Mechanics::accelerations).
    pub(super) fn reactions(&mut self, at: &Balance, holding: &[f64]) -> Result<Vec<f64>, Error> {
        let none = vec![0.0; self.system.m()];
        let view = at.state.view(&none);
        self.accelerations.evaluate_under(&self.system, &view, (0, &at.state.compliances()), holding)?;
        Ok(self.accelerations.with(view).lambda.to_vec())
    }

    /// Derivatives with respect to controls and design variables, after [`reactions`](Self::reactions).
    pub(super) fn sensitivities(&mut self, at: &Balance, lambda: &[f64]) -> Result<[Sensitivity; 2], Error> {
        let system = self.system.clone();
        let (k, parameters) = (system.k(), system.parameters().len());
        let unit = |len: usize, i: usize| (0..len).map(|j| if i == j { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let still = DVector::zeros(system.n());
        let controls = (0..k).map(|i| Change { u: unit(k, i), design: vec![0.0; parameters], q: still.clone() });
        let dependent = self.dependent_changes(at)?;
        let none = vec![0.0; system.m()];
        let view = at.state.view(&none);
        let designs = (0..system.designs()).map(|b| {
            let design = system.parameters().along(&view.design[..system.designs()], &unit(system.designs(), b));
            Change { u: vec![0.0; k], design: design.to_vec(), q: dependent.column(b).into_owned() }
        });
        Ok([self.sensitivity(at, lambda, controls.collect())?, self.sensitivity(at, lambda, designs.collect())?])
    }

    /// q_p for all design variables.
    fn dependent_changes(&self, at: &Balance) -> Result<DMatrix<f64>, Error> {
        let (system, inputs) = (&self.system, at.state.inputs());
        let mut retraction = Retraction::new(system, &at.independent, &inputs)?;
        let z: Vec<f64> = at.independent.iter().flat_map(|&i| [at.state.q()[i], 0.0]).collect();
        retraction.place(&z, at.state.q(), &inputs)?;
        let designs: Vec<(usize, f64)> = (0..system.designs()).map(|b| (b, 1.0)).collect();
        let columns = retraction.columns(&designs)?;
        Ok(columns.q.columns(2 * at.independent.len(), designs.len()).into_owned())
    }

    fn sensitivity(&mut self, at: &Balance, lambda: &[f64], changes: Vec<Change>) -> Result<Sensitivity, Error> {
        let (n, m, none) = (self.system.n(), self.system.m(), vec![0.0; self.system.m()]);
        let view = at.state.view(&none);
        let factors = at.stiffness.clone().lu();
        let (at_rest, x) = (vec![0.0; n], Pair { v: vec![0.0; n], sigma: lambda.to_vec() });
        let [mut q, mut of_lambda, mut holding] = [n, m, n].map(|rows| DMatrix::zeros(rows, changes.len()));
        for (column, Change { u, design, q: of_q }) in changes.into_iter().enumerate() {
            let along = |q: &DVector<f64>, find: &mut dyn FnMut(&NodeView<f64>) -> Vec<f64>| {
                DVector::from_vec(find(&NodeView::of_equations([q.as_slice(), &at_rest, &none], (&u, 0.0, &design))))
            };
            let mut forces = |along: &NodeView<f64>| self.accelerations.changes(&self.system, (&view, along), &x).v.clone();
            let right = at.free.tr_mul(&along(&of_q, &mut forces));
            let of_free = if right.is_empty() { right } else { factors.solve(&right).unwrap_or(right * f64::NAN) };
            let all = of_q + &at.free * of_free;
            let forces = along(&all, &mut forces);
            let held = self.of_held(at, &forces);
            let mut reactions =
                |along: &NodeView<f64>| self.accelerations.along_under(&self.system, (&view, along), &held).sigma.clone();
            of_lambda.set_column(column, &along(&all, &mut reactions));
            q.set_column(column, &all);
            holding.set_column(column, &DVector::from_vec(held));
        }
        let not_finite = || Error::Overflow { what: "a derivative of the equilibrium".into(), value: f64::NAN };
        let is_finite = q.iter().chain(&of_lambda).chain(&holding).all(|x| x.is_finite());
        if is_finite { Ok(Sensitivity { q, lambda: of_lambda, holding }) } else { Err(not_finite()) }
    }
}
