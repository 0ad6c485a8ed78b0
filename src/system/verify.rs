//! Programs held to num-dual on the plain formula, which is the truth: in debug builds whenever a scene is compiled, and in tests.

use nalgebra::SVector;

use super::batch::Covector;
use super::block::BlockEntry;
use super::formula::{Component, Formula, InputOf};
use super::item::PlacedElement;
use super::jet::{FirstDerivatives, Jet, Local};
use super::shape::Place;
use super::view::NodeView;
use crate::number::{Hyper, Slope, hyper, hyper_parts, slope};

/// Random numbers of a linear congruential generator, between −1 and 1; the same ones every time.
pub(super) struct Draw(pub u64);

impl Draw {
    pub(super) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// What two ways of computing gave, and how large the numbers around it are.
pub(super) struct Pair {
    pub program: f64,
    pub dual: f64,
}

impl<J: Jet<N, M, K, P>, const N: usize, const M: usize, const K: usize, const P: usize> PlacedElement<J, N, M, K, P> {
    /// All that a formula's programs compute, beside the same by dual numbers, at a point of the element's own.
    pub(super) fn compare(
        &self,
        formula: &Formula,
        numbers: &[f64],
        at: &Local<f64, N, M, K>,
        (design, with): (&[f64], &Covector),
    ) -> Vec<Pair> {
        let (Some(kernels), shape, b) = (&formula.kernels, formula.shape, self.b::<f64>(design)) else { return Vec::new() };
        let parameters: Vec<f64> = b.iter().chain(numbers).copied().collect();
        let input = |which: usize| match shape.place(which) {
            Place::Q(i) => at.q[i],
            Place::V(i) => at.v[i],
            Place::U(k) => at.u[k],
            Place::T => at.t,
            Place::Sigma(j) => at.sigma[j],
            Place::C(i) => with.c[i],
            Place::D(i) => with.d[i],
            Place::E(j) => with.e[j],
            // Any rates will do.
            Place::QRate(i) => with.d[i],
            Place::VRate(i) => with.c[i],
            Place::SigmaRate(j) => with.e[j],
            Place::URate(_) => 0.37,
            Place::TRate | Place::ConstantRate(_) => 1.3,
        };
        let mut first = FirstDerivatives::zero();
        let mut dual = vec![0.0; J::KIND.length(N, M)];
        self.jet.blocks(at, &b, &mut first, &mut dual);

        let all = BlockEntry::all(J::KIND, N, M);
        let mut program = vec![0.0; dual.len()];
        let mut own = FirstDerivatives::<f64, N, M>::zero();
        let varying = formula.varying.iter().zip(kernels.second.evaluate(&parameters, input));
        for (entry, value) in formula.fixed.iter().zip(kernels.fixed.evaluate(&parameters, input)).chain(varying) {
            for (k, place) in all.iter().enumerate().filter(|(_, place)| place.block == entry.block) {
                let here = (place.row, place.col) == (entry.row, entry.col);
                let there = entry.mirrored && (place.col, place.row) == (entry.row, entry.col);
                program[k] += if here || there { value } else { 0.0 };
            }
        }
        // What a constraint's linear columns contribute stands elsewhere.
        for (entry, value) in formula.fixed.iter().zip(kernels.fixed.evaluate(&parameters, input)) {
            if entry.block.has_equations() {
                own.l_v[entry.col] += value * at.sigma[entry.row];
                own.phi_dot[entry.row] += value * at.v[entry.col];
            }
        }
        for (of, value) in kernels.components.iter().zip(kernels.first.evaluate(&parameters, input)) {
            match *of {
                Component::Momentum(i) => own.l_v[i] += value,
                Component::Force(i) => own.force[i] += value,
                Component::Equation(j) => own.phi_dot[j] += value,
            }
        }
        let list = |first: &FirstDerivatives<f64, N, M>| -> Vec<f64> {
            first.l_v.iter().chain(&first.force).chain(&first.phi_dot).copied().collect()
        };
        program.extend(list(&own));
        dual.extend(list(&first));
        for (of, value) in kernels.inputs_of.iter().zip(kernels.inputs.evaluate(&parameters, input)) {
            program.push(value);
            dual.push(self.by_input(at, &b, *of, with));
        }
        program.extend(kernels.along.evaluate(&parameters, input));
        dual.extend(self.along_rates(at, &b, with));
        program.into_iter().zip(dual).map(|(program, dual)| Pair { program, dual }).collect()
    }

    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate, for the rates above.
    fn along_rates(&self, at: &Local<f64, N, M, K>, b: &SVector<f64, P>, with: &Covector) -> [f64; 2] {
        let moving = |x: f64, rate: f64| hyper(x, rate, 0.0, 0.0);
        let point = Local {
            q: SVector::from_fn(|i, _| moving(at.q[i], with.d[i])),
            v: SVector::from_fn(|i, _| moving(at.v[i], with.c[i])),
            sigma: SVector::from_fn(|j, _| moving(at.sigma[j], with.e[j])),
            u: at.u.map(|u| moving(u, 0.37)),
            t: moving(at.t, 1.3),
        };
        let first = self.jet.first(&point, &b.map(|b| hyper(b, 0.0, 0.0, 0.0)));
        let dot = |x: &[Hyper], y: &[f64]| x.iter().zip(y).map(|(x, y)| *x * *y).sum::<Hyper>();
        let sum =
            dot(first.l_v.as_slice(), with.c) + dot(first.force.as_slice(), with.d) + dot(first.phi_dot.as_slice(), with.e);
        let [value, rate, ..] = hyper_parts(&sum);
        [value, rate]
    }

    /// The derivative of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to one of the element's own inputs.
    fn by_input(&self, at: &Local<f64, N, M, K>, b: &SVector<f64, P>, of: InputOf, with: &Covector) -> f64 {
        let (mut local, mut b) = (at.lift(), b.map(Slope::from_re));
        match of {
            InputOf::Control(k) => local.u[k] = local.u[k].derivative(0),
            InputOf::Constant(p) => b[p] = b[p].derivative(0),
            InputOf::Time => local.t = local.t.derivative(0),
        }
        let first = self.jet.first(&local, &b);
        let dot = |x: &[Slope], y: &[f64]| x.iter().zip(y).map(|(x, y)| slope(x) * y).sum::<f64>();
        dot(first.l_v.as_slice(), with.c) + dot(first.force.as_slice(), with.d) + dot(first.phi_dot.as_slice(), with.e)
    }

    /// Whether programs and dual numbers agree at points around one, as far as rounding lets them: among numbers of moderate size.
    pub(super) fn agrees(&self, formula: &Formula, numbers: &[f64], at: &NodeView<f64>) -> bool {
        let mut draw = Draw(1);
        let is_moderate = |x: &f64| *x == 0.0 || (1e-3..1e3).contains(&x.abs());
        let coordinates = self.q.iter().map(|&i| at.q[i].abs());
        if !self.b(at.design).iter().chain(numbers).all(is_moderate) || coordinates.fold(0.0, f64::max) > 10.0 {
            return true;
        }
        (0..3).all(|_| {
            let mut local: Local<f64, N, M, K> = self.local(at);
            local.q.iter_mut().chain(local.v.iter_mut()).for_each(|x| *x += 0.3 * draw.number());
            local.sigma.iter_mut().chain(local.u.iter_mut()).for_each(|x| *x = draw.number());
            let mut numbers_of = |len: usize| (0..len).map(|_| draw.number()).collect::<Vec<_>>();
            let (c, d, e) = (numbers_of(N), numbers_of(N), numbers_of(M));
            let pairs = self.compare(formula, numbers, &local, (at.design, &Covector { c: &c, d: &d, e: &e }));
            agree(&pairs, 1e-6)
        })
    }
}

const LARGE: f64 = 1e6;
/// Numbers below this are taken for rounding of larger ones that vanished from the result.
const SMALL: f64 = 1e-3;

/// Whether two ways agree to a fraction of the largest number; where that is not moderate, nothing can be said.
fn agree(pairs: &[Pair], tolerance: f64) -> bool {
    let largest = pairs.iter().fold(0.0, |size: f64, pair| size.max(pair.dual.abs()).max(pair.program.abs()));
    let is_close = |pair: &Pair| (pair.program - pair.dual).abs() <= tolerance * largest.max(SMALL);
    largest > LARGE || pairs.iter().any(|pair| pair.dual.is_nan() || pair.program.is_nan()) || pairs.iter().all(is_close)
}
