//! Programs held to num-dual on the plain formula, which is the truth: in debug builds whenever a scene is compiled, and in tests.

use super::batch::Covector;
use super::block::{Block, BlockEntry};
use super::formula::{Component, Formula, Kernels};
use super::item::PlacedElement;
use super::jet::ElementKind;
use super::shape::Place;
use super::typed::{OnNumbers, Slot};
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
pub(super) struct Compared {
    pub program: f64,
    pub dual: f64,
}

/// Arguments of an element's own.
#[derive(Clone, Debug)]
pub(super) struct OwnPoint {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub sigma: Vec<f64>,
    pub u: Vec<f64>,
    pub t: f64,
    pub b: Vec<f64>,
}

impl OwnPoint {
    fn read(&self, slot: Slot) -> f64 {
        match slot {
            Slot::Q(i) => self.q[i],
            Slot::V(i) => self.v[i],
            Slot::Sigma(j) => self.sigma[j],
            Slot::U(k) => self.u[k],
            Slot::T => self.t,
            Slot::B(p) => self.b[p],
        }
    }
}

/// Any rates of controls, time and constants will do.
const RATE_OF_CONTROL: f64 = 0.37;
const RATE_OF_TIME: f64 = 1.3;

/// The factor of a component in c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt of an element's own numbers.
fn weight(of: Component, with: &Covector) -> f64 {
    match of {
        Component::Momentum(i) => with.c[i],
        Component::Force(i) => with.d[i],
        Component::Equation(j) => with.e[j],
    }
}

/// 𝓛_v and 𝓛_q + Q of an element of which constants are kept: from their values at zero, linearly.
fn as_kept(formula: &Formula, kernels: &Kernels, parameters: &[f64], at: &OwnPoint) -> Vec<f64> {
    let (n, none) = (formula.shape.n, |_| 0.0);
    let mut sums = kernels.at_zero.evaluate(parameters, none);
    let controls = sums.split_off(2 * n);
    for (row, slopes) in controls.chunks_exact(at.u.len().max(1)).enumerate() {
        sums[n + row] += slopes.iter().zip(&at.u).map(|(slope, u)| slope * u).sum::<f64>();
    }
    for (entry, value) in formula.fixed.iter().zip(kernels.fixed.evaluate(parameters, none)) {
        let (row, col) = (entry.row, entry.col);
        let [here, there] = match entry.block {
            Block::Vv => [(row, at.v[col]), (col, at.v[row])],
            Block::Vq => [(row, at.q[col]), (n + col, at.v[row])],
            Block::Qq => [(n + row, at.q[col]), (n + col, at.q[row])],
            Block::ForceV => [(n + row, at.v[col]); 2],
            _ => [(n + row, at.q[col]); 2],
        };
        sums[here.0] += value * here.1;
        if entry.mirrored || entry.block == Block::Vq {
            sums[there.0] += value * there.1;
        }
    }
    sums
}

impl PlacedElement {
    /// All that a formula's programs compute, beside the same by dual numbers, at a point of the element's own.
    pub(super) fn compare(&self, formula: &Formula, numbers: &[f64], at: &OwnPoint, with: &Covector) -> Vec<Compared> {
        let (Some(kernels), shape) = (&formula.kernels, formula.shape) else { return Vec::new() };
        let (n, m) = (shape.n, shape.m);
        let parameters: Vec<f64> = at.b.iter().chain(numbers).copied().collect();
        let input = |which: usize| match shape.place(which) {
            Place::Q(i) => at.q[i],
            Place::V(i) => at.v[i],
            Place::U(k) => at.u[k],
            Place::T => at.t,
            Place::Sigma(j) => at.sigma[j],
            Place::C(i) => with.c[i],
            Place::D(i) => with.d[i],
            Place::E(j) => with.e[j],
            Place::QRate(i) => with.d[i],
            Place::VRate(i) => with.c[i],
            Place::SigmaRate(j) => with.e[j],
            Place::URate(_) => RATE_OF_CONTROL,
            Place::TRate | Place::ConstantRate(_) => RATE_OF_TIME,
        };
        let place = |of: Component| match of {
            Component::Momentum(i) => i,
            Component::Force(i) => n + i,
            Component::Equation(j) => 2 * n + j,
        };
        let mut first = vec![0.0; 2 * n + m];
        let mut dual = vec![0.0; formula.kind.length(n, m)];
        self.formula.blocks(&|slot| at.read(slot), &mut |of, x| first[place(of)] += x, &mut dual);

        let all = BlockEntry::all(formula.kind, n, m);
        let mut program = vec![0.0; dual.len()];
        let mut own = vec![0.0; first.len()];
        let (components, entries) = kernels.at_state(&parameters, input);
        let varying = formula.varying.iter().zip(entries);
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
                own[entry.col] += value * at.sigma[entry.row];
                own[2 * n + entry.row] += value * at.v[entry.col];
            }
        }
        for (of, value) in kernels.components.iter().zip(components) {
            own[place(*of)] += value;
        }
        program.extend(own);
        dual.extend(&first);
        if formula.constant && formula.kind != ElementKind::Holonomic {
            program.extend(as_kept(formula, kernels, &parameters, at));
            dual.extend(&first[..2 * n]);
        }
        for (of, value) in kernels.inputs_of.iter().zip(kernels.inputs.evaluate(&parameters, input)) {
            program.push(value);
            dual.push(self.by_input(at, *of, with));
        }
        program.extend(kernels.along.evaluate(&parameters, input));
        dual.extend(self.along_rates(at, with));
        program.into_iter().zip(dual).map(|(program, dual)| Compared { program, dual }).collect()
    }

    /// c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt and its rate, for the rates above.
    fn along_rates(&self, at: &OwnPoint, with: &Covector) -> [f64; 2] {
        let read = |slot: Slot| {
            let rate = match slot {
                Slot::Q(i) => with.d[i],
                Slot::V(i) => with.c[i],
                Slot::Sigma(j) => with.e[j],
                Slot::U(_) => RATE_OF_CONTROL,
                Slot::T => RATE_OF_TIME,
                Slot::B(_) => 0.0,
            };
            hyper(at.read(slot), rate, 0.0, 0.0)
        };
        let mut sums = [0.0; 2];
        OnNumbers::<Hyper>::first(&*self.formula, &read, &mut |of, x| {
            let [value, rate, ..] = hyper_parts(&x);
            sums[0] += weight(of, with) * value;
            sums[1] += weight(of, with) * rate;
        });
        sums
    }

    /// The derivative of c·𝓛_v + d·(𝓛_q + Q) + e·dΦ/dt with respect to one of the element's own inputs.
    fn by_input(&self, at: &OwnPoint, seed: Slot, with: &Covector) -> f64 {
        let read = |slot: Slot| {
            let x = Slope::from_re(at.read(slot));
            if slot == seed { x.derivative(0) } else { x }
        };
        let mut sum = 0.0;
        OnNumbers::<Slope>::first(&*self.formula, &read, &mut |of, x| sum += weight(of, with) * slope(&x));
        sum
    }

    /// Whether programs and dual numbers agree at points around one, as far as rounding lets them: among numbers of moderate size.
    pub(super) fn agrees(&self, formula: &Formula, numbers: &[f64], at: &NodeView<f64>) -> bool {
        let mut draw = Draw(1);
        let is_moderate = |x: &f64| *x == 0.0 || (1e-3..1e3).contains(&x.abs());
        let coordinates = self.q.iter().map(|&i| at.q[i].abs());
        // Where |x| has its kink either slope is right.
        let mut moved = |b: f64, is_bound: bool| if is_bound && b == 0.0 { 0.3 * draw.number() } else { b };
        let b: Vec<f64> = self.b.iter().map(|b| moved(b.value(at.design), b.bound().is_some())).collect();
        if !b.iter().chain(numbers).all(is_moderate) || coordinates.fold(0.0, f64::max) > 10.0 {
            return true;
        }
        (0..3).all(|_| {
            let mut near = |x: &[f64]| self.q.iter().map(|&i| x[i] + 0.3 * draw.number()).collect::<Vec<_>>();
            let (q, v) = (near(at.q), near(at.v));
            let mut numbers_of = |len: usize| (0..len).map(|_| draw.number()).collect::<Vec<_>>();
            let (sigma, u) = (numbers_of(self.sigma.len()), numbers_of(self.u.len()));
            let t = at.t + 0.3 * numbers_of(1)[0];
            let point = OwnPoint { q, v, sigma, u, t, b: b.clone() };
            let (c, d, e) = (numbers_of(self.q.len()), numbers_of(self.q.len()), numbers_of(self.sigma.len()));
            agree(&self.compare(formula, numbers, &point, &Covector { c: &c, d: &d, e: &e }), 1e-6)
        })
    }
}

const LARGE: f64 = 1e6;
/// Numbers below this are taken for rounding of larger ones that vanished from the result.
const SMALL: f64 = 1e-3;

/// Whether two ways agree to a fraction of the largest number; where that is not moderate, nothing can be said.
fn agree(pairs: &[Compared], tolerance: f64) -> bool {
    let largest = pairs.iter().fold(0.0, |size: f64, pair| size.max(pair.dual.abs()).max(pair.program.abs()));
    let is_close = |pair: &Compared| (pair.program - pair.dual).abs() <= tolerance * largest.max(SMALL);
    largest > LARGE || pairs.iter().any(|pair| pair.dual.is_nan() || pair.program.is_nan()) || pairs.iter().all(is_close)
}
