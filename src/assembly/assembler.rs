//! [`Assembler`]: the assembly of a start from a guess.

use super::bordered::Bordered;
use super::equations::{Equations, Unknowns, sum};
use super::tangent::Tangent;
use crate::motion::{Assembly, Compliances, Held, Report, Which, closed, indices, open, with_open};

use nalgebra::DVector;

use crate::node::Linearisation;
use crate::number::{Real, larger, largest};
use crate::redundancy::{SUSPICIOUS, Scaled};
use crate::system::{Given, KnownPart, NodeView, Pair};
use crate::{Error, Start, System, redundancy};

pub(super) const MOST_CORRECTIONS_OF_START: usize = 50;
/// If K(0) has a compliance, multipliers need more than one correction, even if coordinates do not move.
pub(super) const LEAST_CORRECTIONS_OF_START: usize = 3;
/// A correction below this fraction of the largest number is rounding; if corrections have stopped shrinking, below [`Tangent::stalled`].
pub(super) const ROUNDING: f64 = 1e-15;
/// Corrections below this are rounding for any size, because their terms begin to underflow.
pub(super) const UNDERFLOW: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// System, factors and tolerance for the assembly of a start.
pub(crate) struct Assembler<'a> {
    pub(crate) system: &'a System,
    pub(crate) linearisation: &'a mut Linearisation,
    pub(crate) report: &'a mut Report,
    /// Tolerance of Φ, m or rad.
    pub(crate) tolerance: f64,
    /// The equations that are open, and do not count.
    pub(crate) open: Vec<usize>,
}

impl Assembler<'_> {
    /// The start for a guess. If the assembly fails and an element is not finite at the guess, the error names the element.
    pub(crate) fn assemble(&mut self, q: &[f64], v: &[f64], held: &Held, given: Given) -> Result<(Start, Assembly), Error> {
        let multipliers = vec![0.0; self.system.m()];
        let system = self.system;
        let blame = |error| system.find_not_finite(&given.at(q, v, &multipliers), 0).unwrap_or(error);
        self.assemble_from(q, v, held, given).map_err(blame)
    }

    fn assemble_from(&mut self, q: &[f64], v: &[f64], held: &Held, given: Given) -> Result<(Start, Assembly), Error> {
        let zeros = Pair::new(self.system.n(), self.system.m());
        let mut moved = zeros.clone();
        self.move_coordinates(q, &indices(&held.coordinates), &mut moved, given)?;
        let q0 = sum(q, &moved.v);
        let points = [given.at(&q0, v, &zeros.sigma); 2];
        let tangent = Tangent::new(self, Which::Velocities, [&points[0], &points[1]], &indices(&held.velocities), &[])?;
        let mut velocity = Unknowns::new(v, &zeros.sigma);
        let from = self.l_v(&points[1]);
        self.correct(&tangent, Equations::Velocities(&q0, v, q), &mut velocity, given, |this, at, left| {
            this.residual((Which::Velocities, &from), &given.at(&q0, &at.x, &at.multipliers), left);
        })?;
        self.see_that_it_is_free(&tangent, (&q0, &velocity.x), given)?;
        let start = Start::Velocity { q: DVector::from_vec(q0), v: DVector::from_column_slice(&velocity.x) };
        let velocity = Pair { v: velocity.x, sigma: velocity.multipliers };
        Ok((start, Assembly { q: q.to_vec(), v: v.to_vec(), held: held.clone(), moved, velocity }))
    }

    /// Returns an error if velocities violate a constraint: then a held coordinate only seems to be free, but dependent constraints determine it.
    fn see_that_it_is_free(&mut self, tangent: &Tangent, (q0, v): (&[f64], &[f64]), given: Given) -> Result<(), Error> {
        let has_dependent = closed(self.linearisation.evaluation.compliance()).next().is_some();
        let Some(held) = tangent.least_free().filter(|_| has_dependent) else {
            return Ok(());
        };
        let mut left = Pair::new(self.system.n(), self.system.m());
        let none = left.sigma.clone();
        let at = given.at(q0, v, &none);
        self.linearisation.l_v_and_phi_dot(self.system, &at, &mut left, self.report);
        self.system.take_rounding(&at, v, &mut left.sigma);
        self.open.iter().for_each(|&j| left.sigma[j] = 0.0);
        if largest(&left.sigma) > self.tolerance {
            return Err(Error::Held { coordinate: self.system.coordinate_name(held).to_string() });
        }
        Ok(())
    }

    /// The start on another number type, near an assembled one, by the plain formulas.
    pub(crate) fn lift<R: Real>(
        &mut self,
        (q, v): (&[R], &[R]),
        (assembly, real): (&Assembly, Given),
        given: Given<R>,
    ) -> Result<Start<R>, Error> {
        let (near, zeros) = (sum(&assembly.q, &assembly.moved.v), Pair::new(self.system.n(), self.system.m()));
        let system = self.system;
        let mut moved = Unknowns::new(&assembly.moved.v, &assembly.moved.sigma);
        let tangent = self.tangent(assembly, Which::Coordinates, (&near, &zeros), real)?;
        let equations = Equations::Coordinates(q);
        self.correct(&tangent, equations, &mut moved, given, |_, at, left| equations.residual(system, at, given, left))?;
        let q0 = sum(q, &moved.x);
        let mut velocity = Unknowns::new(&assembly.velocity.v, &assembly.velocity.sigma);
        // Held velocities are those of the guess, including derivatives.
        assembly.held(Which::Velocities).iter().for_each(|&i| velocity.x[i] = v[i]);
        let tangent = self.tangent(assembly, Which::Velocities, (&near, &zeros), real)?;
        let equations = Equations::Velocities(&q0, v, q);
        self.correct(&tangent, equations, &mut velocity, given, |_, at, left| equations.residual(system, at, given, left))?;
        Ok(Start::Velocity { q: DVector::from_vec(q0), v: DVector::from_vec(velocity.x) })
    }

    /// The tangent at an assembled start.
    pub(crate) fn tangent(
        &mut self,
        assembly: &Assembly,
        which: Which,
        at: (&[f64], &Pair),
        given: Given,
    ) -> Result<Tangent, Error> {
        let [moved, unmoved] = assembly.points(which, at, given);
        Tangent::new(self, which, [&moved, &unmoved], &assembly.held(which), &[])
    }

    /// 𝓛_v, evaluated by the programs.
    pub(super) fn l_v(&mut self, at: &NodeView<f64>) -> Vec<f64> {
        let mut l_v = vec![0.0; self.system.n()];
        self.linearisation.l_v(self.system, at, &mut l_v, self.report);
        l_v
    }

    /// Writes the residual of one of the systems, without E κ, by the programs. `from` is 𝓛_v at the unmoved point.
    pub(super) fn residual(&mut self, (which, from): (Which, &[f64]), at: &NodeView<f64>, left: &mut Unknowns<f64>) {
        let mut pair = Pair::new(at.v.len(), at.sigma.len());
        self.linearisation.l_v_and_phi_dot(self.system, at, &mut pair, self.report);
        left.x.iter_mut().zip(pair.v.iter().zip(from)).for_each(|(left, (l_v, from))| *left = l_v - from);
        match which {
            Which::Coordinates => {
                left.multipliers.fill(0.0);
                self.system.phi(at, &mut left.multipliers);
            }
            Which::Velocities => left.multipliers.copy_from_slice(&pair.sigma),
        }
    }

    /// Factors K(0) at a point with additional inertia. Without given compliances, dependent constraints get default ones.
    pub(super) fn factor(
        &mut self,
        at: &NodeView<f64>,
        held: &[usize],
        (compliances, inertia): (&Compliances, Vec<(usize, f64)>),
    ) -> Result<Bordered, Error> {
        let zeros = vec![0.0; self.system.m()];
        let at = Given::from(*at).at(at.q, at.v, &zeros);
        self.linearisation.evaluation.set_inertia(&inertia);
        let compliances = with_open(compliances, &self.open);
        let factored = factor_state(self.system, self.linearisation, (&at, (0, &compliances)), self.report);
        self.linearisation.evaluation.set_inertia(&[]);
        factored?;
        let mut masses = redundancy::apparent_masses(self.linearisation, self.system, &at);
        inertia.into_iter().for_each(|(i, more)| masses[i] += more);
        Bordered::new(self.system, self.linearisation, held, &masses)
    }

    /// Corrects every part with the same tangent until the corrections are rounding.
    fn correct<R: Real>(
        &mut self,
        tangent: &Tangent,
        equations: Equations<R>,
        unknowns: &mut Unknowns<R>,
        given: Given<R>,
        mut residual: impl FnMut(&mut Self, &Unknowns<R>, &mut Unknowns<R>),
    ) -> Result<(), Error> {
        let (n, m) = (self.system.n(), self.system.m());
        let mut left = Unknowns { x: vec![R::zero(); n], multipliers: vec![R::zero(); m] };
        let (mut delta, mut last) = (Pair::new(n, m), vec![f64::INFINITY; R::PARTS]);
        for corrections in 1..=MOST_CORRECTIONS_OF_START {
            residual(self, unknowns, &mut left);
            self.open.iter().for_each(|&j| left.multipliers[j] = R::zero());
            let mut is_done = true;
            for (k, last) in last.iter_mut().enumerate() {
                left.part(k, &mut delta);
                tangent.correct_in_range(self.system, self.linearisation, &mut delta);
                unknowns.subtract(k, &delta);
                let given = equations.size(k, given);
                let size = unknowns.x.iter().fold(given, |size, x| larger(size, x.part(k).abs()));
                let correction = largest(&delta.v);
                let is_stalled = correction >= 0.5 * *last && correction <= tangent.stalled() * size;
                // The real part was solved before; for a start at rest its corrections are only rounding, which never settles.
                let is_known = k == 0 && R::PARTS > 1;
                is_done &= is_known || correction <= larger(ROUNDING * size, UNDERFLOW) || is_stalled;
                *last = correction;
            }
            if corrections >= LEAST_CORRECTIONS_OF_START && is_done {
                return Ok(());
            }
        }
        Err(Error::AssemblyStalled { correction: largest(&last) })
    }
}

/// Factors K(0) at a state with σ = 0; without given compliances, dependent constraints get default ones. Returns the smallest pivot ratio.
pub(crate) fn factor_state(
    system: &System,
    linearisation: &mut Linearisation,
    (at, (node, compliance)): (&NodeView<f64>, (usize, &Compliances)),
    report: &mut Report,
) -> Result<f64, Error> {
    let from = KnownPart { h: 0.0, q: at.q, p_star: &[], sigma: at.sigma };
    let given = Given::from(*at);
    let mut own = Report { worst_pivot: 1.0, ..Report::default() };
    linearisation.evaluation.set_compliance(compliance);
    let mut factored = linearisation.factor_at(system, &from, given, (at.v, at.sigma), &mut own);
    if closed(compliance).next().is_none() && (factored.is_err() || own.worst_pivot < SUSPICIOUS || system.has_still_loops())
    {
        let open: Vec<usize> = open(compliance).collect();
        let all = with_open(&redundancy::compliances(linearisation, system, at), &open);
        let mut factor = |compliances: &Compliances| {
            own.worst_pivot = 1.0;
            linearisation.evaluation.set_compliance(compliances);
            factored = linearisation.factor_at(system, &from, given, (at.v, at.sigma), &mut own);
            factored.is_ok() && own.worst_pivot >= SUSPICIOUS
        };
        let compliances = redundancy::sufficient(all, (system, at), &mut factor);
        factor(&compliances);
    }
    report.factorisations += own.factorisations;
    factored.map(|()| own.worst_pivot).map_err(|breakdown| {
        let cause = system.find_not_finite(at, node).or_else(|| Scaled::at(system, at)?.explain(system, at));
        cause.unwrap_or_else(|| system.singular_step(&breakdown, node, at.t))
    })
}
