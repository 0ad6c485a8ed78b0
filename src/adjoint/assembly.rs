//! Adjoint equations of the assembly of a start (`assembly/`): from dJ/dq₀ and dJ/dv₀ to the guess and the parameters.
//!
//! ```text
//!   velocities:   Aᵀ (c, e) + E k = (v̄, 0)       dJ/dv̂ = 𝓛_vv(q₀, v̂, 0) c + E k
//!                 q̄ −= (𝓛_vq(q₀, v₀, μ) − 𝓛_vq(q₀, v̂, 0))ᵀ c + (dΦ/dt)_qᵀ e
//!   coordinates:  Aᵀ (c, e) + E k = (q̄, 0)       dJ/dq̂ = 𝓛_vv(q₀, w, ν) c + E k
//! ```

use nalgebra::DVector;

use super::sweep::AdjointSweep;
use crate::assembly::{Assembler, Tangent};
use crate::motion::{Assembly, Motion, Which, open};
use crate::node::Linearisation;
use crate::system::{Covector, InputRows, NodeView, Pair, StateRows};
use crate::{Error, Start, System};

/// A motion whose start was assembled, and zeros of the size of (v, σ).
#[derive(Clone, Copy)]
pub(super) struct AssembledStart<'a> {
    pub(super) motion: &'a Motion,
    pub(super) assembly: &'a Assembly,
    pub(super) zeros: &'a Pair,
}

/// One of the two systems of equations of an assembly.
pub(super) struct Side<'a> {
    pub(super) tangent: Tangent,
    /// (q₀, w, ν) or (q₀, v₀, μ), and (q₀, 0, 0) or (q₀, v̂, 0).
    pub(super) moved: NodeView<'a, f64>,
    pub(super) unmoved: NodeView<'a, f64>,
    pub(super) zeros: &'a Pair,
}

/// Results from (c, e): dJ/dv̂ or dJ/dq̂ without E k, and the contribution to q̄.
pub(super) struct Back {
    pub(super) guess: DVector<f64>,
    pub(super) q: DVector<f64>,
}

impl<'a> Side<'a> {
    pub(super) fn new(
        assembler: &mut Assembler,
        which: Which,
        AssembledStart { motion, assembly, zeros }: AssembledStart<'a>,
    ) -> Result<Self, Error> {
        let at = (motion.inputs.start.q().as_slice(), zeros);
        let here = motion.at(0);
        let tangent = assembler.tangent(assembly, which, at, here.into())?;
        let [moved, unmoved] = assembly.points(which, at, here.into());
        Ok(Side { tangent, moved, unmoved, zeros })
    }

    /// Covectors for the adjoint rows at the moved and the unmoved point.
    pub(super) fn covectors<'x>(&'x self, x: &'x Pair) -> [Covector<'x>; 2] {
        let none = &self.zeros.sigma;
        let e = if self.tangent.which == Which::Velocities { &x.sigma } else { none };
        [Covector { c: &x.v, d: &self.zeros.v, e }, Covector { c: &x.v, d: &self.zeros.v, e: none }]
    }

    /// Computes the results from (c, e).
    pub(super) fn back(&self, system: &System, linearisation: &Linearisation, x: &Pair) -> Back {
        let rows = || StateRows::new(system.n(), system.m());
        let (mut moved, mut unmoved) = (rows(), rows());
        let [of_moved, of_unmoved] = self.covectors(x);
        linearisation.evaluation.pull_back(system, &self.tangent.moved, &of_moved, &mut moved);
        linearisation.evaluation.pull_back(system, &self.tangent.unmoved, &of_unmoved, &mut unmoved);
        match self.tangent.which {
            Which::Velocities => {
                let q = unmoved.q.iter().zip(&moved.q).map(|(unmoved, moved)| unmoved - moved).collect::<Vec<f64>>();
                Back { guess: unmoved.v.into(), q: q.into() }
            }
            Which::Coordinates => Back { guess: moved.v.into(), q: DVector::zeros(system.n()) },
        }
    }
}

impl AdjointSweep {
    /// Replaces the derivatives with respect to q₀ and v₀ by those with respect to the guess.
    pub(super) fn through_assembly(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
    ) -> Result<(), Error> {
        let Some(assembly) = &motion.assembly else { return Ok(()) };
        let zeros = Pair::new(system.n(), system.m());
        let (mut q_bar, v_bar) = (self.gradient.start.q().clone(), self.gradient.start.rate().clone());
        let of = AssembledStart { motion, assembly, zeros: &zeros };
        let Back { guess: v, q } = self.through(system, linearisation, Which::Velocities, of, &v_bar)?;
        q_bar += q;
        let Back { guess: q, .. } = self.through(system, linearisation, Which::Coordinates, of, &q_bar)?;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(0));
        self.gradient.start = Start::Assembled { q, v, held: assembly.held.clone() };
        Ok(())
    }

    /// Solves the adjoint equations of one of the systems.
    fn through(
        &mut self,
        system: &System,
        linearisation: &mut Linearisation,
        which: Which,
        of: AssembledStart,
        bar: &DVector<f64>,
    ) -> Result<Back, Error> {
        let side = self.side(system, linearisation, which, of)?;
        let right = Pair { v: bar.as_slice().to_vec(), sigma: vec![0.0; system.m()] };
        let (x, of_held) = side.tangent.solve_transposed(system, linearisation, &right)?;
        self.add_parameters_of(system, linearisation, &side, &x);
        let Back { guess, q } = side.back(system, linearisation, &x);
        Ok(Back { guess: guess + of_held, q })
    }

    pub(super) fn side<'a>(
        &mut self,
        system: &System,
        linearisation: &mut Linearisation,
        which: Which,
        of: AssembledStart<'a>,
    ) -> Result<Side<'a>, Error> {
        let open = open(linearisation.evaluation.compliance()).collect();
        Side::new(&mut Assembler { system, linearisation, report: &mut self.report, tolerance: 0.0, open }, which, of)
    }

    /// Adds the contributions of (c, e) to derivatives with respect to parameters.
    pub(super) fn add_parameters_of(&mut self, system: &System, linearisation: &mut Linearisation, side: &Side, x: &Pair) {
        let minus = x.negative();
        let ([of_moved, _], [_, of_unmoved]) = (side.covectors(&minus), side.covectors(x));
        for (at, with) in [(&side.moved, &of_moved), (&side.unmoved, &of_unmoved)] {
            self.with_parameters(system, |rows| linearisation.evaluation.pull_back_inputs(system, at, with, rows));
        }
        if side.tangent.which == Which::Coordinates {
            self.with_parameters(system, |rows| {
                system.placed().for_each(|item| item.pull_back_phi(&side.unmoved, &minus.sigma, rows));
            });
        }
    }

    /// Adds derivatives with respect to parameters only: controls and time of a start do not depend on the guess.
    fn with_parameters(&mut self, system: &System, add: impl FnOnce(&mut InputRows)) {
        let (mut u, mut time) = (vec![0.0; system.k()], 0.0);
        let (design, evaluations) = (self.design.as_mut_slice(), &mut self.report.input_evaluations);
        add(&mut InputRows { u: &mut u, design, time: &mut time, evaluations });
    }
}
