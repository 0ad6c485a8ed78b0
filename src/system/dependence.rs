//! What an element's formula depends on, found by evaluating it on numbers that record what is done with them.
//!
//! A [`Trace`] tells which derivatives are constant and which are zero whatever the values are: never by looking at values, since a
//! coefficient that is zero for one set of design variables need not be for the next. A [`Fingerprint`] tells whether the formula is still
//! the one that was traced.

use nalgebra::SVector;

use super::blame::Argument;
use super::item::PlacedElement;
use super::jet::{ElementKind, Jet, Local, time_input};
use super::plan::Plan;
use super::view::NodeView;
use crate::number::Fingerprint;
use crate::number::trace::{Structure, Trace};

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// Its arguments as inputs of a trace, numbered q, v, u, t; their values are for formulas that look at them.
    fn traced(&self, at: &NodeView<f64>) -> Local<Trace, N, M, K> {
        let real: Local<f64, N, M, K> = self.local(at);
        Local {
            q: SVector::from_fn(|i, _| Trace::input(real.q[i], i)),
            v: SVector::from_fn(|i, _| Trace::input(real.v[i], N + i)),
            sigma: real.sigma.map(Trace::from),
            u: SVector::from_fn(|k, _| Trace::input(real.u[k], 2 * N + k)),
            t: Trace::input(real.t, time_input(N, K)),
        }
    }

    /// Its constants, as far as they are known.
    fn traced_constants(&self, design: &[f64]) -> SVector<Trace, P> {
        SVector::from_fn(|p, _| match self.b[p].constant() {
            Some(value) => Trace::from(value),
            None => Trace::unknown_constant(self.b[p].value(design)),
        })
    }

    fn structure(&self, local: &Local<Trace, N, M, K>, b: &SVector<Trace, P>) -> Structure {
        if time_input(N, K) < Structure::MOST_INPUTS {
            Structure::of(|| {
                let mut values = Vec::new();
                self.jet.values(local, b, &mut |value| values.push(value));
                values
            })
        } else {
            Structure::UNKNOWN
        }
    }

    /// How its derivatives are to be evaluated.
    pub fn traced_plan(&self, at: &NodeView<f64>) -> Plan<N> {
        let (local, b) = (self.traced(at), self.traced_constants(at.design));
        let structure = self.structure(&local, &b);
        let bound = self.b.iter().any(|b| b.constant().is_none());
        Plan::new(J::KIND, &structure, (time_input(N, K), bound), |i, j| self.depends_on_difference(&local, &b, (i, j)))
    }

    /// All arguments that the formula depends on, as far as its trace tells.
    pub fn arguments(&self, at: &NodeView<f64>) -> Vec<Argument> {
        let structure = self.structure(&self.traced(at), &self.traced_constants(at.design));
        let used = |i: usize| structure.depends_on(i);
        let q = (0..N).filter(|&i| used(i)).map(|i| Argument::Coordinate(self.q[i]));
        let v = (0..N).filter(|&i| used(N + i)).map(|i| Argument::Velocity(self.q[i]));
        let u = (0..K).filter(|&k| used(2 * N + k)).map(|k| Argument::Control(self.u[k]));
        let design = self.b.iter().filter_map(|b| b.design()).map(|(p, _)| Argument::Design(p));
        let time = self.plan.timed.then_some(Argument::Time);
        q.chain(v).chain(u).chain(design).chain(time).collect()
    }

    /// Whether q_i and q_j, and v_i and v_j, enter only in their differences.
    fn depends_on_difference(&self, at: &Local<Trace, N, M, K>, b: &SVector<Trace, P>, (i, j): (usize, usize)) -> bool {
        let (mut with_q, mut with_v) = (*at, *at);
        for k in [i, j] {
            with_q.q[k] = with_q.q[k].shifted();
            with_v.v[k] = with_v.v[k].shifted();
        }
        [with_q, with_v].iter().all(|at| self.structure(at, b).unmoved)
    }

    /// Appends the entries of K that constant derivatives can have: of all it has, or of the columns in which a constraint is linear.
    pub fn constant_entries(&self, at: &NodeView<f64>, n: usize, entries: &mut Vec<(usize, usize)>) {
        let (local, b) = (self.traced(at), self.traced_constants(at.design));
        let has = |inputs: u128, i: usize| (inputs >> i | inputs >> (N + i)) & 1 == 1;
        match J::KIND {
            ElementKind::Kinetic | ElementKind::Potential if self.plan.constant => {
                for (i, partners) in (0..2 * N).map(|i| (i % N, self.partners(&local, &b, i))) {
                    entries.extend((0..N).filter(|&j| has(partners, j)).map(|j| (self.q[i], self.q[j])));
                }
            }
            ElementKind::Applied if self.plan.constant => {
                let mut rows = self.q.iter();
                let mut put = |component: Trace| {
                    let row = rows.next().into_iter();
                    entries.extend(row.flat_map(|&row| {
                        let columns = (0..N).filter(move |&j| has(component.inputs(), j));
                        columns.map(move |j| (row, self.q[j]))
                    }));
                };
                self.jet.values(&local, &b, &mut put);
            }
            ElementKind::Holonomic if self.plan.is_traced => {
                let linear = self.plan.linear_columns();
                let mut rows = self.sigma.iter();
                let mut put = |phi: Trace| {
                    let row = rows.next().into_iter();
                    entries.extend(row.flat_map(|&row| {
                        let columns = linear.clone().filter(move |&j| phi.inputs() >> j & 1 == 1);
                        columns.map(move |j| (n + row, self.q[j]))
                    }));
                };
                self.jet.values(&local, &b, &mut put);
            }
            _ => {}
        }
    }

    /// The inputs that a second derivative of an energy with respect to input `i` can mix it with.
    fn partners(&self, at: &Local<Trace, N, M, K>, b: &SVector<Trace, P>, i: usize) -> u128 {
        let mut at = *at;
        let x = if i < N { &mut at.q[i] } else { &mut at.v[i - N] };
        *x = x.marked();
        let mut partners = 0;
        self.jet.values(&at, b, &mut |energy| partners |= energy.partners());
        partners
    }

    /// Joins what identifies the formula, if anything was concluded from its trace.
    pub fn fingerprint(&self, sum: &mut Fingerprint) {
        if !self.plan.is_traced {
            return;
        }
        let input = |i: usize| Fingerprint::input(i);
        let at = Local {
            q: SVector::from_fn(|i, _| input(i)),
            v: SVector::from_fn(|i, _| input(N + i)),
            sigma: SVector::from_fn(|_, _| Fingerprint::from(1.0)),
            u: SVector::from_fn(|k, _| input(2 * N + k)),
            t: input(time_input(N, K)),
        };
        let b = SVector::from_fn(|p, _| input(time_input(N, K) + 1 + p));
        self.jet.values(&at, &b, &mut |value| sum.join(value));
    }
}
