//! Comparison of programs with num-dual on the plain formula, which is the reference: in debug builds whenever a scene is compiled, and in tests.

use crate::system::formula::{
    BlockEntry, Covector, Element, ElementKind, Layout, NodeValues, NodeView, PlacedElement, Sums,
};
use crate::system::tangent::Constants;

/// Pseudorandom numbers between −1 and 1 from a linear congruential generator with a fixed seed.
pub(in crate::system) struct Draw(pub u64);

impl Draw {
    pub(in crate::system) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(in crate::system) fn numbers(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.number()).collect()
    }
}

/// The results of the two ways of computing a number.
pub(in crate::system) struct Compared {
    pub program: f64,
    pub dual: f64,
}

/// An arbitrary rate of the controls and of time.
const RATE_OF_CONTROL: f64 = 0.37;
const RATE_OF_TIME: f64 = 1.3;

/// Rates of the controls and of the state: those of q, v and σ are d, c and e.
fn rates(controls: usize, with: &Covector) -> NodeValues<f64> {
    let u = vec![RATE_OF_CONTROL; controls];
    NodeValues::of_equations(&NodeView::of_equations([with.d, with.c, with.e], (&u, RATE_OF_TIME, &[])), |x| x)
}

impl PlacedElement {
    /// All results of an element's programs, paired with those of dual numbers, at a point of its scene.
    pub(in crate::system) fn compare(&self, element: &Element, at: &NodeValues<f64>, with: &Covector) -> Vec<Compared> {
        let (formula, shape) = (&element.formula, element.formula.shape);
        let Some(kernels) = &formula.kernels else { return Vec::new() };
        let (real, rates, parameters) = (at.view(), rates(at.u.len(), with), element.parameters(&at.design));
        let layout = Layout { n: at.q.len(), m: at.sigma.len(), k: at.u.len(), p: at.design.len() };
        let mut point = vec![0.0; layout.len()];
        layout.load(&real, &mut point);
        layout.load_direction(&rates.view(), &mut point);
        layout.load_covector(with, &mut point);
        let input = |which: usize| point[layout.source(&element.to, shape.place(which))];
        let sums = || Sums::new(layout.n, layout.m);
        let (mut first, mut own) = (sums(), sums());
        let mut dual = vec![0.0; formula.kind.length(shape.n, shape.m)];
        self.evaluate(&real, &mut first, &mut dual);

        let all = BlockEntry::all(formula.kind, shape.n, shape.m);
        let mut program = vec![0.0; dual.len()];
        let (components, _) = kernels.at_state(&parameters, input);
        let fixed = kernels.fixed.evaluate(&parameters, input);
        for (entry, value) in element.second_derivatives(&parameters, input).into_iter().flatten() {
            for (k, place) in all.iter().enumerate().filter(|(_, place)| place.block == entry.block) {
                let here = (place.row, place.col) == (entry.row, entry.col);
                let there = entry.mirrored && (place.col, place.row) == (entry.row, entry.col);
                program[k] += if here || there { value } else { 0.0 };
            }
        }
        let negatives = kernels.negatives.iter().zip(components.iter().map(|value| -value));
        for (of, value) in kernels.components.iter().zip(components.iter().copied()).chain(negatives) {
            *self.place(*of, &mut own) += value;
        }
        // The contributions of a constraint's linear columns are added separately.
        let [l_v, _, phi_dot] = own.parts_mut();
        for (entry, value) in formula.fixed.iter().zip(&fixed).filter(|(entry, _)| entry.block.has_equations()) {
            let [row, col] = element.row_and_col(entry);
            l_v[col] += value * at.sigma[row];
            phi_dot[row] += value * at.v[col];
        }
        program.extend(own.all);
        dual.extend(&first.all);
        if formula.constant && formula.kind != ElementKind::Holonomic {
            let (mut constants, mut kept) = (Constants::new(layout.n), sums());
            element.add_constants(&parameters, &mut constants);
            let [l_v, force, _] = kept.parts_mut();
            constants.l_v(&real, l_v);
            constants.force(&real, force);
            program.extend(kept.all);
            dual.extend(&first.all);
        }
        program.extend(kernels.inputs.kernel.evaluate(&parameters, input));
        dual.extend(kernels.inputs.of.iter().map(|slot| self.directional(&real, with, *slot)));
        program.extend(kernels.along.evaluate(&parameters, input));
        dual.extend(self.along(&real, &rates.view(), with));
        program.into_iter().zip(dual).map(|(program, dual)| Compared { program, dual }).collect()
    }

    /// Whether programs and dual numbers agree to rounding at points near `at`; true if numbers of extreme magnitude prevent a comparison.
    pub(in crate::system) fn agrees(&self, element: &Element, at: &NodeView<f64>) -> bool {
        let (mut draw, mut point) = (Draw(1), NodeValues::of_equations(at, |x| x));
        // Avoids the kink of |x|, where either slope is correct.
        point.design.iter_mut().filter(|b| **b == 0.0).for_each(|b| *b = 0.3 * draw.number());
        let is_moderate = |x: &f64| *x == 0.0 || (1e-3..1e3).contains(&x.abs());
        let is_near = element.to.q.iter().all(|&i| at.q[i].abs() <= 10.0);
        if !is_near || !element.parameters(&point.design).iter().all(is_moderate) {
            return true;
        }
        let (n, m, k) = (at.q.len(), at.sigma.len(), at.u.len());
        (0..3).all(|_| {
            let mut near = |x: &[f64]| x.iter().map(|x| x + 0.3 * draw.number()).collect::<Vec<f64>>();
            (point.q, point.v, point.t) = (near(at.q), near(at.v), near(&[at.t])[0]);
            (point.sigma, point.u) = (draw.numbers(m), draw.numbers(k));
            let (c, d, e) = (draw.numbers(n), draw.numbers(n), draw.numbers(m));
            agree(&self.compare(element, &point, &Covector { c: &c, d: &d, e: &e }), 1e-6)
        })
    }
}

const LARGE: f64 = 1e6;
/// Smaller numbers may be rounding errors of larger terms that cancelled.
const SMALL: f64 = 1e-3;

/// Whether both ways agree relative to the largest number; true if that number is too large for a comparison.
fn agree(pairs: &[Compared], tolerance: f64) -> bool {
    let largest = pairs.iter().fold(0.0, |size: f64, pair| size.max(pair.dual.abs()).max(pair.program.abs()));
    let is_close = |pair: &Compared| (pair.program - pair.dual).abs() <= tolerance * largest.max(SMALL);
    largest > LARGE || pairs.iter().any(|pair| pair.dual.is_nan() || pair.program.is_nan()) || pairs.iter().all(is_close)
}
