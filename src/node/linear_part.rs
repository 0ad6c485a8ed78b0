//! The linear part of a step, whose matrix is a polynomial of the half step: L(h) = L₀ + h L₁ + h² L₂ − diag(0, μ).

use crate::System;
use crate::linear::{Breakdown, Factorization, Matrix};
use crate::motion::Compliances;
use crate::system::Constants;

/// L, and the half steps for which the matrix stores it.
#[derive(Default)]
pub(super) struct LinearPart {
    /// Positions of entries, ascending, and their values in L₀, L₁ and L₂.
    entries: Vec<(usize, [f64; 3])>,
    /// Equations with a compliance, and their μ.
    compliance: Vec<(usize, f64)>,
    /// Coordinates, and their additional inertia.
    inertia: Vec<(usize, f64)>,
    /// The last half steps; `oldest` is the next to be replaced.
    steps: Vec<f64>,
    oldest: usize,
}

/// Number of stored half steps: a composition of steps has few different ones.
const KEPT_STEPS: usize = 5;

impl LinearPart {
    /// Sets constant derivatives.
    pub(super) fn set(&mut self, system: &System, constants: &Constants) {
        self.entries.clear();
        for (row, col, power, value) in constants.tangent() {
            let place = system.symbolic().place(row, col);
            debug_assert!(place.is_some(), "({row}, {col}) is not in the pattern");
            let mut powers = [0.0; 3];
            powers[power] = value;
            self.entries.extend(place.map(|place| (place, powers)));
        }
        self.entries.sort_unstable_by_key(|(place, _)| *place);
        self.entries.dedup_by(|(later, more), (place, powers)| {
            let is_same = later == place;
            if is_same {
                powers.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
            }
            is_same
        });
        self.forget();
    }

    /// Sets the compliances of constraint equations.
    pub(super) fn set_compliance(&mut self, compliance: &Compliances) {
        if self.compliance != compliance {
            self.compliance.clear();
            self.compliance.extend_from_slice(compliance);
            self.forget();
        }
    }

    /// Sets the additional inertia of coordinates.
    pub(super) fn set_inertia(&mut self, inertia: &[(usize, f64)]) {
        if self.inertia != inertia {
            self.inertia = inertia.to_vec();
            self.forget();
        }
    }

    /// Equations with a compliance, and their μ.
    pub(super) fn compliance(&self) -> &Compliances {
        &self.compliance
    }

    fn forget(&mut self) {
        self.steps.clear();
        self.oldest = 0;
    }

    /// Selects or computes L(h) in the matrix.
    pub(super) fn select<F: Factorization>(
        &mut self,
        system: &System,
        h: f64,
        matrix: &mut Matrix<F>,
    ) -> Result<(), Breakdown> {
        if let Some(which) = self.steps.iter().position(|&known| known == h) {
            matrix.select(which);
            return Ok(());
        }
        self.make(system, h, matrix)
    }

    /// Computes L for a half step that is not stored.
    #[cold]
    fn make<F: Factorization>(&mut self, system: &System, h: f64, matrix: &mut Matrix<F>) -> Result<(), Breakdown> {
        let which = self.oldest;
        self.oldest = (self.oldest + 1) % KEPT_STEPS;
        if which >= self.steps.len() {
            self.steps.push(h);
        }
        // If the following fails, this half step is not stored.
        self.steps[which] = f64::NAN;
        let entries = self.entries.iter().map(|&(place, [l_0, l_1, l_2])| (place, l_0 + h * (l_1 + h * l_2)));
        let compliances = self.compliance.iter().map(|&(j, mu)| (system.n() + j, -mu));
        let diagonal = compliances.chain(self.inertia.iter().copied());
        let diagonal = diagonal.filter_map(|(unknown, x)| system.symbolic().place(unknown, unknown).map(|place| (place, x)));
        matrix.set_constant(system.symbolic(), which, entries.chain(diagonal))?;
        self.steps[which] = h;
        Ok(())
    }
}
