//! What the trace of an element decided: what is constant, which coordinates have derivatives, and which of them are seeded for that.
//!
//! A formula that depends on q_i only as q_j − q_i, as two bodies' positions mostly do, has ∂/∂q_i = −∂/∂q_j: only one of the two is
//! seeded, and the derivatives with respect to the other are copied with the opposite sign. What a formula does not depend on is not seeded
//! either.

use nalgebra::SVector;

use super::jet::{ElementKind, FirstDerivatives, Seeds};
use crate::number::trace::Structure;

/// The sizes of dual numbers that are made; beyond this, all coordinates are seeded.
pub const MOST_SEEDS: usize = 4;

/// How an element is evaluated.
#[derive(Clone, Copy, PartialEq)]
pub struct Plan<const N: usize> {
    pub constant: bool,
    /// A constraint that is a sum of q_i, sin q_i, cos q_i.
    pub sinusoidal: bool,
    /// Whether anything is known of the formula; if not, it is taken to depend on everything.
    pub is_traced: bool,
    pub timed: bool,
    pub bound: bool,
    /// Local numbers of the active coordinates, which have entries in the blocks; the first `count` are valid.
    pub active: [usize; N],
    pub count: usize,
    /// Local numbers of the coordinates that are seeded; the first `seeded` are valid.
    seeds: [usize; N],
    pub seeded: usize,
    by_q: bool,
    by_v: bool,
    /// Of each active coordinate, the seed that its derivatives come from, and their sign: 0 where there are none.
    sources: [(usize, f64); N],
    /// Coordinates that enter only in the difference to another, which is seeded; the first `mirrored` are valid.
    mirrors: [Mirror; N],
    mirrored: usize,
    /// Where its slots begin in the batch's list.
    pub slots: usize,
}

/// q_i enters only as q_j − q_i.
#[derive(Clone, Copy, Default, PartialEq)]
struct Mirror {
    i: usize,
    j: usize,
}

impl<const N: usize> Default for Plan<N> {
    fn default() -> Self {
        let all = std::array::from_fn(|i| i);
        Plan {
            constant: false,
            sinusoidal: false,
            is_traced: false,
            timed: true,
            bound: true,
            active: all,
            count: N,
            seeds: all,
            seeded: N,
            by_q: true,
            by_v: true,
            sources: std::array::from_fn(|i| (i, 1.0)),
            mirrors: [Mirror::default(); N],
            mirrored: 0,
            slots: 0,
        }
    }
}

impl<const N: usize> Plan<N> {
    /// From what is known of the formula; `time` is the number of its input t, `bound` tells whether design variables are among its constants.
    pub fn new(
        form: ElementKind,
        structure: &Structure,
        (time, bound): (usize, bool),
        difference: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let mut plan = Plan { bound, is_traced: *structure != Structure::UNKNOWN, ..Plan::default() };
        if !plan.is_traced {
            return plan;
        }
        plan.timed = structure.depends_on(time);
        let highest = if matches!(form, ElementKind::Kinetic | ElementKind::Potential) { 2 } else { 1 };
        plan.constant = structure.degree <= highest && !plan.timed;
        plan.sinusoidal = form == ElementKind::Holonomic && structure.sinusoidal && !plan.timed && !plan.constant;
        if plan.sinusoidal {
            plan.activate((0..N).filter(|&i| structure.is_bent_in(i)));
        } else if !plan.constant && form != ElementKind::Kinetic {
            plan.seed(form, structure, difference);
        }
        plan
    }

    /// Whether another trace led to the same.
    pub fn agrees(&self, other: &Self) -> bool {
        *self == Plan { slots: self.slots, ..*other }
    }

    /// The columns of Φ_q that are constant.
    pub fn linear_columns(&self) -> impl Iterator<Item = usize> + Clone {
        let (active, count) = (self.active, if self.constant { 0 } else { self.count });
        (0..N).filter(move |i| !active[..count].contains(i))
    }

    fn activate(&mut self, coordinates: impl Iterator<Item = usize>) {
        self.count = 0;
        for i in coordinates {
            self.active[self.count] = i;
            self.count += 1;
        }
    }

    /// Chooses what is seeded: what the formula depends on (or is other than linear in, for a constraint), one of each difference.
    fn seed(&mut self, form: ElementKind, structure: &Structure, difference: impl Fn(usize, usize) -> bool) {
        let is_used = |&i: &usize| match form {
            ElementKind::Kinetic => true,
            ElementKind::Potential => structure.depends_on(i),
            ElementKind::Applied => structure.depends_on(i) || structure.depends_on(N + i),
            ElementKind::Holonomic => structure.is_bent_in(i),
        };
        let used: Vec<usize> = (0..N).filter(is_used).collect();
        self.by_q = (0..N).any(|i| structure.depends_on(i));
        self.by_v = (N..2 * N).any(|i| structure.depends_on(i));
        let mirrors = mirrors(&used, difference);
        let seeds: Vec<usize> = used.iter().copied().filter(|&k| mirrors.iter().all(|mirror| mirror.i != k)).collect();
        if seeds.len() > MOST_SEEDS {
            return;
        }
        // Of a force every component may depend on what is seeded.
        if form != ElementKind::Applied {
            self.activate(used.into_iter());
        }
        self.seeded = seeds.len();
        self.seeds[..seeds.len()].copy_from_slice(&seeds);
        self.mirrored = mirrors.len();
        self.mirrors[..mirrors.len()].copy_from_slice(&mirrors);
        for (source, &i) in self.sources.iter_mut().zip(&self.active[..self.count]) {
            let place = |k: usize| seeds.iter().position(|&seed| seed == k);
            let mirrored = || mirrors.iter().find(|mirror| mirror.i == i).and_then(|mirror| place(mirror.j));
            *source = match (place(i), mirrored()) {
                (Some(seed), _) => (seed, 1.0),
                (None, Some(seed)) => (seed, -1.0),
                (None, None) => (0, 0.0),
            };
        }
    }

    /// What is seeded, if it is `A` coordinates.
    pub fn seeds<const A: usize>(&self) -> Seeds<A> {
        Seeds { of: std::array::from_fn(|k| self.seeds[k]), by_q: self.by_q, by_v: self.by_v }
    }

    fn mirrors(&self) -> &[Mirror] {
        &self.mirrors[..self.mirrored]
    }

    /// Moves the velocities of coordinates that are not seeded to those that stand for them: v_j − v_i of q_j − q_i.
    pub fn gather_velocities(&self, v: &mut SVector<f64, N>) {
        self.mirrors().iter().for_each(|mirror| v[mirror.j] -= v[mirror.i]);
    }

    /// The length of the blocks with seeded coordinates only; of a force, all rows.
    pub fn seeded_len(&self, form: ElementKind, m: usize) -> usize {
        if form == ElementKind::Applied { 2 * N * self.seeded } else { form.length(self.seeded, m) }
    }

    /// Spreads derivatives with respect to the seeds, which lie at the beginning of the blocks, to all active coordinates.
    pub fn spread<const M: usize>(&self, form: ElementKind, first: &mut FirstDerivatives<f64, N, M>, blocks: &mut [f64]) {
        if self.seeded == self.count {
            return;
        }
        let (a, s) = (self.count, self.seeded);
        // From the end, so that nothing is overwritten that is still to be read.
        if form == ElementKind::Holonomic {
            self.widen(&mut blocks[form.squares() * s * s..], form.squares() * (a * a - s * s), 2 * M);
        }
        for square in (0..form.squares()).rev() {
            if form == ElementKind::Applied {
                self.widen(&mut blocks[square * a * s..], square * a * (a - s), a);
            } else {
                self.widen_square(&mut blocks[square * s * s..], square * (a * a - s * s));
            }
        }
        // All of a force is in its value.
        if form != ElementKind::Applied {
            for &Mirror { i, j } in self.mirrors() {
                first.l_v[i] = -first.l_v[j];
                first.force[i] = -first.force[j];
            }
        }
    }

    /// Rows of so many seeds at the beginning become rows of active coordinates, from `to` on.
    fn widen(&self, blocks: &mut [f64], to: usize, rows: usize) {
        let (a, s) = (self.count, self.seeded);
        for row in (0..rows).rev() {
            let mut seeds = [0.0; N];
            seeds[..s].copy_from_slice(&blocks[row * s..][..s]);
            let target = blocks[to + row * a..][..a].iter_mut();
            target.zip(&self.sources).for_each(|(entry, &(seed, sign))| *entry = sign * seeds[seed]);
        }
    }

    /// The same for rows and columns of a square.
    fn widen_square(&self, blocks: &mut [f64], to: usize) {
        let (a, s) = (self.count, self.seeded);
        let mut seeds = [[0.0; N]; N];
        for (row, values) in seeds.iter_mut().zip(blocks.chunks_exact(s.max(1))).take(s) {
            row[..s].copy_from_slice(values);
        }
        for (row, &(seed, sign)) in blocks[to..][..a * a].chunks_exact_mut(a.max(1)).zip(&self.sources) {
            let source = &seeds[seed];
            row.iter_mut().zip(&self.sources).for_each(|(entry, &(column, other))| *entry = sign * other * source[column]);
        }
    }
}

/// Pairs of coordinates that enter only in their difference, each coordinate in one pair at most.
fn mirrors(used: &[usize], difference: impl Fn(usize, usize) -> bool) -> Vec<Mirror> {
    let mut mirrors: Vec<Mirror> = Vec::new();
    for (k, &i) in used.iter().enumerate() {
        let is_free = |k: usize| mirrors.iter().all(|mirror| mirror.i != k && mirror.j != k);
        let partner = used[k + 1..].iter().copied().find(|&j| is_free(i) && is_free(j) && difference(i, j));
        mirrors.extend(partner.map(|j| Mirror { i, j }));
    }
    mirrors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Param;
    use crate::scene::planar::{Actuator, Damper, Distance, LinearSpring, Prismatic};
    use crate::system::item::PlacedElement;
    use crate::system::jet::Jet;
    use crate::system::{Applied, Holonomic, NodeView, Potential, Sums};
    use crate::{Constraint, Force, ForcePoint, Scalar};

    /// Everything that `evaluate` gives, with few seeds and with all.
    fn assert_same<J, const N: usize, const M: usize, const K: usize, const P: usize>(jet: J, b: [Param; P], seeds: &[usize])
    where
        J: Jet<N, M, K, P>,
    {
        let (q, sigma, u) = (std::array::from_fn(|i| i), std::array::from_fn(|j| j), std::array::from_fn(|k| k));
        let mut item = PlacedElement { name: String::new(), jet, q, sigma, u, b, plan: Plan::default() };
        let number = |k: usize| (12.9898 * (k + 1) as f64).sin();
        let numbers = |from: usize, len: usize| (from..from + len).map(number).collect::<Vec<_>>();
        let (q, v, sigma, u) = (numbers(0, N), numbers(20, N), numbers(40, M), numbers(50, K));
        let at = NodeView::of_equations([&q, &v, &sigma], (&u, 0.3, &[0.37]));
        let evaluate = |item: &PlacedElement<J, N, M, K, P>| {
            let (mut sums, mut blocks) = (Sums::new(N, M), vec![f64::NAN; item.block_len()]);
            item.evaluate(&at, &mut sums, &mut blocks);
            (sums, blocks)
        };
        let (all_sums, all) = evaluate(&item);
        item.plan = item.traced_plan(&at);
        let plan = item.plan;
        assert_eq!(&plan.seeds[..plan.seeded], seeds);
        let (sums, blocks) = evaluate(&item);
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-14 * (1.0 + a.abs()), "{a} and {b}: {all:?}, {blocks:?}");
        let active = &plan.active[..plan.count];
        for &i in active {
            close(all_sums.l_v[i], sums.l_v[i]);
            close(all_sums.force[i], sums.force[i]);
        }
        let (squares, rest) = all.split_at(J::KIND.squares() * N * N);
        let expected_squares = squares
            .chunks_exact(N * N)
            .flat_map(|square| active.iter().flat_map(move |&i| active.iter().map(move |&j| square[i * N + j])));
        let expected_rest = rest.chunks_exact(N).flat_map(|row| active.iter().map(|&j| row[j]));
        let expected: Vec<f64> = expected_squares.chain(expected_rest).collect();
        assert_eq!(expected.len(), blocks.len());
        expected.iter().zip(&blocks).for_each(|(a, b)| close(*a, *b));
    }

    fn params<const P: usize>() -> [Param; P] {
        std::array::from_fn(|p| (0.4 + 0.1 * p as f64).into())
    }

    /// Depends on one coordinate, and acts on another.
    struct Crossed;
    impl Force<3, 0> for Crossed {
        fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 0>, _b: &SVector<S, 0>) -> SVector<S, 3> {
            SVector::from([at.q[2].sin() + at.v[2] * at.v[2], S::zero(), S::zero()])
        }
    }

    /// Depends on a velocity alone.
    struct Dragged;
    impl Force<2, 1> for Dragged {
        fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, _b: &SVector<S, 0>) -> SVector<S, 2> {
            SVector::from([-at.v[1] * at.v[1] * at.u[0], at.t])
        }
    }

    /// More equations than coordinates, and one coordinate that is linear.
    struct Many;
    impl Constraint<4, 5> for Many {
        fn phi<S: Scalar>(&self, q: &SVector<S, 4>, _b: &SVector<S, 0>, t: S) -> SVector<S, 5> {
            let d = q[2] - q[0];
            SVector::from([d * d, d.sin() * q[3], d.exp() * t, q[1] + d * q[3], q[3].cos() + q[1] * 2.0])
        }
    }

    #[test]
    fn derivatives_from_few_seeds_are_those_from_all() {
        assert_same(Holonomic(Distance), params::<5>(), &[2, 3, 4, 5]);
        assert_same(Holonomic(Prismatic), params::<6>(), &[2, 3, 4, 5]);
        assert_same(Potential(LinearSpring), params::<6>(), &[2, 3, 4, 5]);
        let at_centres = [0.0, 0.0, 0.0, 0.0, 0.8, 0.3].map(Param::from);
        assert_same(Potential(LinearSpring), at_centres, &[3, 4]);
        assert_same(Applied(Damper), params::<5>(), &[2, 3, 4, 5]);
        assert_same(Applied(Actuator), params::<5>(), &[2, 3, 4, 5]);
        assert_same(Applied(Crossed), [], &[2]);
        assert_same(Applied(Dragged), [], &[1]);
        assert_same(Holonomic(Many), [], &[2, 3]);
    }
}
