//! Through the assembly of a start: (q₀, v₀) = A(q̂, v̂; b) along a direction, and the change of (∂A)ᵀ (q̄, v̄), by hyper-dual numbers.

use super::{SecondOrderSweep, dual};
use crate::adjoint::AdjointSweep;
use crate::forward::{Assembler, Assembly, Motion};
use crate::node::Newton;
use crate::number::{Hyper, Real, dot};
use crate::system::{Covector, Given, StateRows};
use crate::{Error, Inputs, Start, System};

impl SecondOrderSweep {
    /// The direction of the start that was assembled, in the place of that of its guess.
    pub(super) fn along_assembly(
        &mut self,
        system: &System,
        motion: &Motion,
        newton: &mut Newton,
        direction: &Inputs,
    ) -> Result<(), Error> {
        let Some(assembly) = &motion.assembly else { return Ok(()) };
        let guess = [
            dual(&assembly.q, direction.start.q().as_slice()),
            dual(&assembly.v, direction.start.rate().as_slice()),
            dual(&motion.design, &self.change.design),
        ];
        let start = self.assemble(system, motion, (newton, assembly), &guess)?;
        self.change.inputs.start = Start::Velocity { q: start.q().map(|q| q.eps), v: start.rate().map(|v| v.eps) };
        Ok(())
    }

    /// The start that a guess with derivatives leads to.
    fn assemble<R: Real>(
        &mut self,
        system: &System,
        motion: &Motion,
        (newton, assembly): (&mut Newton, &Assembly),
        [q, v, design]: &[Vec<R>; 3],
    ) -> Result<Start<R>, Error> {
        let here = motion.at(0);
        let u: Vec<R> = here.u.iter().map(|u| R::from(*u)).collect();
        let given = Given { u: &u, t: R::from(here.t), design };
        let mut assembler = Assembler { system, newton: &mut *newton, report: &mut self.report, tolerance: 0.0 };
        let start = assembler.lift((q, v), (assembly, here.into()), given);
        newton.evaluation.set_compliance(&motion.trajectory.compliance);
        start
    }

    /// From the derivatives with respect to (q₀, v₀) to those with respect to the guess and the parameters.
    pub(super) fn back_through_assembly(
        &mut self,
        system: &System,
        motion: &Motion,
        (newton, first): (&mut Newton, &AdjointSweep),
        direction: &Inputs,
    ) -> Result<(), Error> {
        let (Some(assembly), Some(record)) = (&motion.assembly, &first.record) else { return Ok(()) };
        self.sweep.through_assembly(system, motion, newton)?;
        // dJ/dq₀ and dJ/dv₀ of the gradient itself.
        let [a, b] = record.of_step(motion.block_column(0, motion.trajectory.last_stage()));
        let of_p: Vec<f64> = b.iter().map(|b| -b).collect();
        let mut rows = StateRows::new(system.n(), system.m());
        let with = Covector { c: &of_p, d: &self.zeros.v, e: &self.zeros.sigma };
        newton.evaluation.pull_back(system, motion.node_blocks(0), &with, &mut rows);
        rows.q.iter_mut().zip(a).for_each(|(q, a)| *q -= a);
        let along = [
            (assembly.q.as_slice(), direction.start.q().as_slice()),
            (assembly.v.as_slice(), direction.start.rate().as_slice()),
            (motion.design.as_slice(), &self.change.design.clone()),
        ];
        for (list, (x, _)) in along.iter().enumerate() {
            for i in 0..x.len() {
                let guess = [0, 1, 2].map(|of| {
                    let number = |(k, (x, d)): (usize, (&f64, &f64))| {
                        let mut number = Hyper::from(*x);
                        number.add_to_part(2, *d);
                        number.add_to_part(1, if (of, k) == (list, i) { 1.0 } else { 0.0 });
                        number
                    };
                    along[of].0.iter().zip(along[of].1).enumerate().map(number).collect::<Vec<Hyper>>()
                });
                let start = self.assemble(system, motion, (newton, assembly), &guess)?;
                let mixed = |list: &[Hyper]| list.iter().map(|x| x.part(3)).collect::<Vec<f64>>();
                let own = dot(&rows.q, &mixed(start.q().as_slice())) + dot(&rows.v, &mixed(start.rate().as_slice()));
                match list {
                    0 => self.sweep.gradient.start.q_mut()[i] += own,
                    1 => self.sweep.gradient.start.rate_mut()[i] += own,
                    _ => self.sweep.design[i] += own,
                }
            }
        }
        Ok(())
    }
}
