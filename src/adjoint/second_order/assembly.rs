//! Second derivatives of the assembly of a start: its equations along a direction, and the derivatives of their transpose (`adjoint/assembly.rs`).
//!
//! ```text
//!   A (ẇ, ν̇) = −D(𝓛_v(q₀, w, ν) − 𝓛_v(q₀, 0, 0), Φ)              D along q̂˙ and ḃ,          q̇₀ = q̂˙ + ẇ
//!   A (v̇₀ − v̂˙, μ̇) = −D(𝓛_v(q₀, v₀, μ) − 𝓛_v(q₀, v̂, 0), dΦ/dt)    D along q̇₀, v̂˙ and ḃ
//!   Aᵀ (ċ, ė) + E k̇ = (v̄˙, 0) − Ȧᵀ (c, e),                        and so on
//! ```

use super::changes::AssemblyChange;
use super::sources::direction;
use super::{First, SecondOrderSweep};
use crate::adjoint::assembly::{AssembledStart, Side};
use crate::motion::{Motion, Which};
use crate::node::{ALONG, Linearisation};
use crate::number::{Real, add};
use crate::system::{Covector, NodeView, Pair, StateRows};
use crate::{Error, Inputs, Start, System};
use nalgebra::DVector;

impl SecondOrderSweep {
    /// Replaces the direction of the guess by that of the assembled start.
    pub(super) fn along_assembly(
        &mut self,
        system: &System,
        motion: &Motion,
        linearisation: &mut Linearisation,
        direction: &Inputs,
    ) -> Result<(), Error> {
        let Some(assembly) = &motion.assembly else { return Ok(()) };
        let zeros = Pair::new(system.n(), system.m());
        let of = AssembledStart { motion, assembly, zeros: &zeros };
        let (mut q, mut v) = (direction.start.q().clone(), direction.start.rate().clone());
        let side = self.sweep.side(system, linearisation, Which::Coordinates, of)?;
        let mut right = self.change_of_residual(system, linearisation, &side, [q.as_slice(), &zeros.v]);
        let (no_v, no_sigma, design) = (&zeros.v, &zeros.sigma, &self.change.design);
        let along =
            NodeView::of_equations([q.as_slice(), no_v, no_sigma], (&self.no_controls, direction.grid.start, design));
        self.phi.set(&NodeView { q: motion.inputs.start.q().as_slice(), ..motion.at(0) }, &along);
        right.sigma.iter_mut().zip(self.phi.evaluate(system)).for_each(|(right, phi)| *right = -phi.part(ALONG));
        let moved = side.tangent.solve(system, linearisation, &right)?;
        q += DVector::from_column_slice(&moved.v);
        let side = self.sweep.side(system, linearisation, Which::Velocities, of)?;
        let right = self.change_of_residual(system, linearisation, &side, [q.as_slice(), v.as_slice()]);
        let mut velocity = side.tangent.solve(system, linearisation, &right)?;
        v += DVector::from_column_slice(&velocity.v);
        velocity.v.copy_from_slice(v.as_slice());
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(0));
        self.change.inputs.start = Start::Velocity { q, v };
        self.of_assembly = Some(AssemblyChange { moved, velocity });
        Ok(())
    }

    /// −D of the equations along q, v, the time of the start and the design variables; the rows of Φ contain −D of dΦ/dt.
    fn change_of_residual(
        &mut self,
        system: &System,
        linearisation: &Linearisation,
        side: &Side,
        [q, v]: [&[f64]; 2],
    ) -> Pair {
        let SecondOrderSweep { change, programs, zeros, no_controls, sums, .. } = self;
        let t = change.inputs.grid.start;
        let along = NodeView::of_equations([q, v, &zeros.sigma], (no_controls, t, &change.design));
        let mut right = Pair::new(q.len(), zeros.sigma.len());
        for (blocks, at, sign) in [(&side.tangent.moved, &side.moved, -1.0), (&side.tangent.unmoved, &side.unmoved, 1.0)] {
            programs.changes((system, &linearisation.evaluation), (at, blocks), &along, sums);
            right.v.iter_mut().zip(sums.l_v()).for_each(|(right, l_v)| *right += sign * l_v);
            if sign < 0.0 {
                right.sigma.iter_mut().zip(sums.phi_dot()).for_each(|(right, phi_dot)| *right = -phi_dot);
            }
        }
        right
    }

    /// From the derivatives with respect to (q₀, v₀) to those with respect to the guess and the parameters.
    pub(super) fn back_through_assembly(
        &mut self,
        system: &System,
        motion: &Motion,
        (linearisation, first): (&mut Linearisation, &First),
        direction: &Inputs,
    ) -> Result<(), Error> {
        let (Some(assembly), Some(along)) = (&motion.assembly, self.of_assembly.take()) else { return Ok(()) };
        let zeros = Pair::new(system.n(), system.m());
        let of = AssembledStart { motion, assembly, zeros: &zeros };
        let [q_bar, v_bar] = of_start(system, motion, (linearisation, first));
        let (q, v) = (self.sweep.gradient.start.q().clone(), self.sweep.gradient.start.rate().clone());
        let q_dot = self.change.inputs.start.q().clone();
        let guess = Pair { v: direction.start.rate().as_slice().to_vec(), ..zeros.clone() };
        let directions = (q_dot.as_slice(), [&along.velocity, &guess]);
        let of_velocities = self.through(system, linearisation, (Which::Velocities, of), directions, [&v_bar, &v])?;
        let [q_bar, q] = [q_bar + of_velocities.to_q[0].clone(), q + of_velocities.to_q[1].clone()];
        let directions = (q_dot.as_slice(), [&along.moved, &zeros]);
        let of_coordinates = self.through(system, linearisation, (Which::Coordinates, of), directions, [&q_bar, &q])?;
        let time = self.sweep.time;
        self.phi.set(&motion.at(0), &NodeView { q: q_dot.as_slice(), ..self.change.at(0) });
        let rows = (&mut self.sweep.design[..], &mut self.sweep.time);
        self.phi.add_change(system, (&of_coordinates.x.sigma, -1.0), rows);
        // The time of a start does not depend on the guess.
        self.sweep.time = time;
        linearisation.evaluation.set_compliance(motion.trajectory.compliance_from(0));
        let held = assembly.held.clone();
        self.sweep.gradient.start = Start::Assembled { q: of_coordinates.guess, v: of_velocities.guess, held };
        Ok(())
    }

    /// Solves the adjoint equations of one of the systems, with the derivatives with respect to its solution and with their changes.
    fn through(
        &mut self,
        system: &System,
        linearisation: &mut Linearisation,
        (which, of): (Which, AssembledStart),
        directions: (&[f64], [&Pair; 2]),
        [bar, dot]: [&DVector<f64>; 2],
    ) -> Result<Through, Error> {
        let side = self.sweep.side(system, linearisation, which, of)?;
        let right = |v: &DVector<f64>| Pair { v: v.as_slice().to_vec(), sigma: vec![0.0; system.m()] };
        let (x, _) = side.tangent.solve_transposed(system, linearisation, &right(bar))?;
        let change = self.change_of_rows(system, linearisation, (&side, &x), directions);
        let mut right = right(dot);
        subtract(&mut right.v, &change.of_matrix.v);
        subtract(&mut right.sigma, &change.of_matrix.sigma);
        let (x_dot, of_held) = side.tangent.solve_transposed(system, linearisation, &right)?;
        self.sweep.add_parameters_of(system, linearisation, &side, &x_dot);
        add(&mut self.sweep.design, &change.design);
        let back = side.back(system, linearisation, &x_dot);
        let to_q = [side.back(system, linearisation, &x).q, back.q + change.q];
        Ok(Through { guess: back.guess + of_held + change.guess, to_q, x })
    }

    /// Changes of Aᵀ (c, e) and of the rows of (c, e) along a direction of the two points.
    fn change_of_rows(
        &mut self,
        system: &System,
        linearisation: &Linearisation,
        (side, x): (&Side, &Pair),
        (q, [moved, unmoved]): (&[f64], [&Pair; 2]),
    ) -> Change {
        let [of_moved, of_unmoved] = side.covectors(x);
        let mut rows = |(at, blocks): (&NodeView<f64>, &[f64]), of: &Pair, with: &Covector| {
            let along = direction(&self.change, 0, [q, &of.v, &of.sigma]);
            let mut rows = self.first_rows.clone();
            self.programs.rows_along((system, &linearisation.evaluation), (at, blocks), &along, with, &mut rows);
            rows
        };
        let m = rows((&side.moved, &side.tangent.moved), moved, &of_moved);
        let u = rows((&side.unmoved, &side.tangent.unmoved), unmoved, &of_unmoved);
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let design = less(&u.design, &m.design);
        if side.tangent.which == Which::Velocities {
            let of_matrix = Pair { v: m.v, sigma: m.sigma };
            let q = less(&u.q, &m.q).into();
            return Change { of_matrix, guess: u.v.into(), q, design };
        }
        let of_e = Covector { c: &side.zeros.v, d: &side.zeros.v, e: &x.sigma };
        let l = rows((&side.unmoved, &side.tangent.unmoved), unmoved, &of_e);
        let of_matrix = (0..q.len()).map(|i| m.v[i] + m.q[i] - u.q[i] + l.v[i]).collect();
        let of_matrix = Pair { v: of_matrix, sigma: m.sigma };
        Change { of_matrix, guess: m.v.into(), q: DVector::zeros(q.len()), design }
    }
}

/// The change of dJ/dv̂ or dJ/dq̂, the contribution to q̄ and its change, and (c, e).
struct Through {
    guess: DVector<f64>,
    to_q: [DVector<f64>; 2],
    x: Pair,
}

/// Changes along a direction for constant (c, e).
struct Change {
    of_matrix: Pair,
    guess: DVector<f64>,
    q: DVector<f64>,
    design: Vec<f64>,
}

/// dJ/dq₀ and dJ/dv₀ of the gradient.
fn of_start(system: &System, motion: &Motion, (linearisation, first): (&Linearisation, &First)) -> [DVector<f64>; 2] {
    let (mut rows, zeros) = (StateRows::new(system.n(), system.m()), Pair::new(system.n(), system.m()));
    let [a, b] = first.record.of_step(motion.block_column(0, motion.trajectory.last_stage()));
    let of_p: Vec<f64> = b.iter().map(|b| -b).collect();
    let with = Covector { c: &of_p, d: &zeros.v, e: &zeros.sigma };
    linearisation.evaluation.pull_back(system, motion.given_start().1, &with, &mut rows);
    subtract(&mut rows.q, a);
    [rows.q.into(), rows.v.into()]
}

fn subtract(from: &mut [f64], what: &[f64]) {
    from.iter_mut().zip(what).for_each(|(x, y)| *x -= y);
}
