//! Points that show the features of a formula, found by Newton's method on its graph from the points of the check and from earlier results.

use std::ops::Range;

use super::features::{Form, Need, VISIBLE, Variant};
use super::formula::Differentiable;
use super::reference::Jacobian;
use super::setting::Setting;
use crate::number::Random;
use crate::program::Node;

/// Maximum number of distinguished branches of a formula that compares values; a table lookup has one for each cell.
const MOST_FORMS: usize = 8;
/// Numbers of start points of a search: points of the check, and points found last, which may lie where no other feature hides it.
const STARTS: [usize; 2] = [4, 6];
/// Shifts of the first start, in sizes of the arguments, for features that have no slope at the start itself.
const BESIDE_STARTS: [f64; 2] = [1e-5, 1e-1];
/// Maximum numbers of Newton steps and of halvings of one step.
const MOST_STEPS: usize = 100;
const MOST_HALVINGS: i32 = 40;
/// Maximum length of a step relative to the distance of the point from 0, and maximum distance, both in sizes of the arguments.
const LONGEST: f64 = 1e4;
const FARTHEST: f64 = 1e9;
/// Powers of √10 for points beyond a switch: from one size of the arguments down, then up in case another switch hides all these.
const BEYOND: [i32; 20] = [0, -1, -2, -3, -4, -5, -6, -8, -10, -12, -14, -16, -18, 1, 2, 3, 4, 5, 6, 7];
/// Power of √10 for points just beside a switch, which show a wrong threshold: a thousandth of a size away, or of a larger argument.
const JUST_BESIDE: [i32; 1] = [-6];
/// A point shows a variant well if the gradients differ by this fraction; otherwise the search continues for a better one.
const CLEAR: f64 = 1e-3;
/// Multiples of its size to which a value that a formula compares is varied.
const LOOKED: [f64; 6] = [1e4, 1e3, 1e2, 10.0, 1.0, 1e-3];
const MOST_LOOKS: usize = 12;

/// A point where a block is compared, the index of the point of the check from which it was found, and its branch.
pub(crate) struct Known {
    pub x: Vec<f64>,
    pub base: usize,
    form: Option<usize>,
}

/// The features of a formula, and points that show them.
pub(crate) struct Features<'a> {
    of: &'a dyn Differentiable,
    by: Range<usize>,
    setting: &'a Setting<'a>,
    /// Known branches; more than one only if the formula compares values.
    forms: Vec<Form>,
    is_fixed: Vec<bool>,
    /// The points of the check and the additional points that were found.
    pub points: Vec<Known>,
    /// Variants (form and index) that no admissible point can show; `excludes` is true if inadmissible points show one of them.
    settled: Vec<(usize, usize)>,
    pub excludes: bool,
}

impl<'a> Features<'a> {
    /// Finds the features of a block's function, with at most `most` points besides those of the setting, or more if a branch needs them.
    pub(crate) fn find(of: &'a Jacobian, setting: &'a Setting, most: usize) -> Self {
        let points = &setting.drawn.points;
        let is_same = |k: usize| points.iter().all(|x| x[k] == points[0][k]);
        let is_fixed = (0..setting.magnitudes.len()).map(|k| is_same(k) && !setting.free.contains(&k)).collect();
        let (of, by, forms, settled) = (of.function.as_ref(), of.by.clone(), Vec::new(), Vec::new());
        let mut all = Features { of, by, setting, forms, is_fixed, points: Vec::new(), settled, excludes: false };
        for (base, x) in points.iter().enumerate() {
            let form = all.form_of(x);
            all.points.push(Known { x: x.clone(), base, form });
        }
        let most = points.len() + most;
        let mut f = 0;
        while f < all.forms.len() {
            all.look(f, most);
            all.show_all(f, most);
            f += 1;
        }
        // One feature may have hidden another one.
        (0..all.forms.len()).for_each(|f| all.show_all(f, most));
        all
    }

    /// Variants that must be shown but are not shown by any of these points, in words.
    pub(crate) fn unseen(&self, points: &[&[f64]]) -> Vec<String> {
        let judged: Vec<&Known> = self.points.iter().filter(|known| points.contains(&known.x.as_slice())).collect();
        let mut unseen = Vec::new();
        for (f, form) in self.forms.iter().enumerate().filter(|_| self.forms.len() < MOST_FORMS) {
            let is_seen = |v: usize| self.settled.contains(&(f, v)) || judged.iter().any(|at| self.shows((f, v), at) > 0.0);
            let seen: Vec<bool> = (0..form.variants.len()).map(is_seen).collect();
            let missed = form.variants.iter().enumerate().filter(|(v, variant)| match variant.need {
                Need::Variant => !seen[*v],
                Need::OfNode => (0..seen.len()).all(|v| form.variants[v].node != variant.node || !seen[v]),
                Need::Nothing => false,
            });
            unseen.extend(missed.map(|(_, variant)| form.name(variant, &self.setting.arguments)));
        }
        unseen.sort();
        unseen.dedup();
        unseen
    }

    /// True if the formula compares values with the same outcome at all points, or cannot be recorded.
    pub(crate) fn is_blind(&self) -> bool {
        self.forms.is_empty() || self.forms.len() == 1 && !self.forms[0].looks.is_empty()
    }

    /// Measure of how well a point shows a variant of a form.
    fn shows(&self, (f, v): (usize, usize), at: &Known) -> f64 {
        let form = &self.forms[f];
        if at.form == Some(f) { form.shows(&form.variants[v], &at.x, &self.setting.magnitudes) } else { 0.0 }
    }

    /// The branch that the formula takes at a point; `None` if it cannot be recorded there or has too many branches.
    fn form_of(&mut self, x: &[f64]) -> Option<usize> {
        if let [form] = &self.forms[..]
            && form.graph.looked_at().is_empty()
        {
            return Some(0);
        }
        let recorded = self.of.recorded(x, &self.is_fixed)?;
        let known = self.forms.iter().position(|form| form.is_of(&recorded));
        if known.is_none() && self.forms.len() < MOST_FORMS {
            self.forms.push(Form::new(recorded, &self.by, &self.setting.free));
            return Some(self.forms.len() - 1);
        }
        known
    }

    /// Adds a new point if the formula is defined and admissible there.
    fn add(&mut self, x: Vec<f64>, base: usize) {
        let is_new = self.points.iter().all(|known| known.x != x);
        if is_new && self.is_defined(&x) && (self.setting.admissible)(&x) {
            let form = self.form_of(&x);
            self.points.push(Known { x, base, form });
        }
    }

    fn is_defined(&self, x: &[f64]) -> bool {
        let is_near = |(x, size): (&f64, &f64)| x.abs() <= FARTHEST * size;
        let (value, slope) = self.of.by_dual(x, x);
        x.iter().zip(&self.setting.magnitudes).all(is_near) && value.iter().chain(&slope).all(|y| y.is_finite())
    }

    /// Adds points just beside every switch, and points for variants of a form that no point shows yet.
    fn show_all(&mut self, f: usize, most: usize) {
        for v in 0..self.forms[f].variants.len() {
            let Variant { need, .. } = self.forms[f].variants[v];
            if self.points.len() < most && self.forms[f].variants[v].is_side() {
                self.show((f, v), &JUST_BESIDE, 1);
            }
            let is_seen = self.points.iter().any(|at| self.shows((f, v), at) > VISIBLE);
            if !is_seen && !self.settled.contains(&(f, v)) && (need != Need::Nothing || self.points.len() < most) {
                let is_settled = self.show((f, v), &BEYOND, usize::MAX);
                self.settled.extend(is_settled.then_some((f, v)));
            }
        }
    }

    /// Searches from at most `starts` start points for a point at which a variant differs from the formula, and adds it. Returns true if no
    /// admissible point can show the variant.
    fn show(&mut self, (f, v): (usize, usize), exponents: &[i32], starts: usize) -> bool {
        let Variant { of, window, .. } = self.forms[f].variants[v];
        let goals = self.forms[f].variants[v].goals.clone();
        let (mut best, mut ends) = ((0.0, None), Vec::new());
        let (mut excludes, mut is_undefined, mut reaches) = (false, false, false);
        let searches =
            self.starts(f).into_iter().take(starts).flat_map(|start| goals.iter().map(move |&goal| (start.clone(), goal)));
        'search: for ((mut x, base), goal) in searches {
            ends.extend(self.solve(f, of, goal, &mut x));
            let is_beyond = !(window[0]..=window[1]).contains(&goal);
            let ways = if is_beyond { self.beyond(f, of, &x, window[0] > 0.0, exponents) } else { vec![x] };
            for mut x in ways {
                (self.setting.settle)(&mut x);
                let form = self.form_of(&x);
                let at = Known { x, base, form };
                reaches |= self.forms[f].reaches(&self.forms[f].variants[v], &at.x);
                let share = self.shows((f, v), &at);
                if share > best.0 {
                    let [is_defined, is_admissible] = [self.is_defined(&at.x), (self.setting.admissible)(&at.x)];
                    (is_undefined, excludes) = (is_undefined || !is_defined, excludes || is_defined && !is_admissible);
                    best = if is_defined && is_admissible { (share, Some(at)) } else { best };
                }
                if best.0 > CLEAR {
                    break 'search;
                }
            }
        }
        if let Some(at) = best.1 {
            self.add(at.x, at.base);
            return false;
        }
        self.excludes |= excludes;
        excludes || is_undefined || !reaches && is_out_of_reach(&ends, &goals)
    }

    /// Start points of a search, with the indices of the points of the check from which they were found.
    fn starts(&self, f: usize) -> Vec<(Vec<f64>, usize)> {
        let (drawn, found) = self.points.split_at(self.setting.drawn.points.len());
        let of_form = |known: &&Known| known.form == Some(f);
        let usual = drawn.iter().filter(of_form).filter(|known| self.setting.drawn.parents[known.base].is_none());
        let all = usual.take(STARTS[0]).chain(found.iter().rev().filter(of_form).take(STARTS[1]));
        let mut starts: Vec<(Vec<f64>, usize)> = all.map(|known| (known.x.clone(), known.base)).collect();
        let mut random = Random::new(self.setting.seed ^ 0xfea7);
        for aside in BESIDE_STARTS {
            let Some((mut x, base)) = starts.first().cloned() else { break };
            for &k in &self.setting.free {
                let [low, high] = self.setting.bounds[k];
                x[k] = (x[k] + random.away_from_zero(aside * self.setting.magnitudes[k])).clamp(low, high);
            }
            starts.push((x, base));
        }
        starts
    }

    /// Moves a point towards a given value of a node by Newton's method, with the shortest steps in sizes of the free arguments.
    /// Returns the node's value at the start and at the end; `None` if it has no slope at the start.
    fn solve(&self, f: usize, of: Node, goal: f64, x: &mut Vec<f64>) -> Option<[f64; 2]> {
        let graph = &self.forms[f].graph;
        let order = graph.reachable([of]);
        let value = |x: &[f64]| graph.values(&order, None, x)[of.index()];
        let start = value(x);
        let mut end = start;
        for step in 0..MOST_STEPS {
            let missed = goal - end;
            if missed.abs() <= 1e-3 * goal.abs() || !missed.is_finite() {
                break;
            }
            let direction = self.direction(f, (of, &order), x, missed);
            let square: f64 = direction.iter().map(|(_, d)| d * d).sum();
            if !(square > 0.0 && square.is_finite()) {
                return (step > 0).then_some([start, end]);
            }
            let far = x.iter().zip(&self.setting.magnitudes).fold(1.0f64, |far, (x, size)| far.max((x / size).abs()));
            let longest = LONGEST * far / square.sqrt();
            let length = (missed / square).clamp(-longest, longest);
            let shorter = |k: i32| self.moved(x, &direction, length * 0.5f64.powi(k));
            let mut nearer = (0..MOST_HALVINGS).map(shorter).map(|x| (value(&x), x));
            let Some(next) = nearer.find(|(value, _)| (goal - value).abs() < missed.abs()) else { break };
            (end, *x) = next;
        }
        end.is_finite().then_some([start, end])
    }

    /// Slopes of a node by the free arguments, in sizes of these, without arguments at a bound beyond which they would be moved.
    fn direction(&self, f: usize, (of, order): (Node, &[Node]), x: &[f64], missed: f64) -> Vec<(usize, f64)> {
        let (form, sizes) = (&self.forms[f], &self.setting.magnitudes);
        let slopes = form.graph.slopes(order, None, &form.graph.values(order, None, x), of);
        let free = form.inputs.iter().filter(|(k, _)| self.setting.free.contains(k));
        let all = free.map(|&(k, input)| (k, slopes[input.index()] * sizes[k]));
        all.filter(|&(k, d)| self.setting.bounds[k][usize::from(d * missed > 0.0)] != x[k]).collect()
    }

    /// Moves a point along a direction, in sizes of the arguments and within their bounds.
    fn moved(&self, x: &[f64], direction: &[(usize, f64)], length: f64) -> Vec<f64> {
        let mut x = x.to_vec();
        for &(k, d) in direction {
            let [low, high] = self.setting.bounds[k];
            x[k] = (x[k] + length * d * self.setting.magnitudes[k]).clamp(low, high);
        }
        x
    }

    /// Points beyond a switch, on its positive or negative side, at distances given by `exponents`.
    fn beyond(&self, f: usize, of: Node, x: &[f64], is_above: bool, exponents: &[i32]) -> Vec<Vec<f64>> {
        let sign = if is_above { 1.0 } else { -1.0 };
        let direction = self.direction(f, (of, &self.forms[f].graph.reachable([of])), x, sign);
        let norm = direction.iter().map(|(_, d)| d * d).sum::<f64>().sqrt();
        let ratio = |&(k, d): &(usize, f64)| (d / norm * x[k] / self.setting.magnitudes[k]).abs();
        let unit = direction.iter().map(ratio).fold(1.0, f64::max) * sign / norm;
        let at = |&e: &i32| self.moved(x, &direction, unit * 10f64.powf(0.5 * f64::from(e)));
        if norm > 0.0 && norm.is_finite() { exponents.iter().map(at).collect() } else { Vec::new() }
    }

    /// Searches for other branches: varies the values that the formula compares over decades, and adds points on both sides of a change.
    fn look(&mut self, f: usize, most: usize) {
        for of in self.forms[f].looks.clone().into_iter().take(MOST_LOOKS) {
            let order = self.forms[f].graph.reachable([of]);
            for (start, base) in self.starts(f).into_iter().take(2) {
                let size = self.forms[f].graph.values(&order, None, &start)[of.index()].abs();
                let goals = LOOKED.iter().map(|goal| goal * if size > 0.0 { size } else { 1.0 });
                let mut last = (self.form_of(&start), start.clone());
                for goal in goals.clone().map(|goal| -goal).chain(goals.rev()) {
                    let mut x = start.clone();
                    if self.solve(f, of, goal, &mut x).is_some() {
                        (self.setting.settle)(&mut x);
                        let next = (self.form_of(&x), x);
                        if next.0 != last.0 && self.points.len() < most {
                            self.add_both_sides(&last.1, &next.1, base);
                        }
                        last = next;
                    }
                }
            }
        }
    }

    /// Adds points on both sides of the change of branch between two points, and further inside the second branch.
    fn add_both_sides(&mut self, first: &[f64], last: &[f64], base: usize) {
        let between =
            |a: &[f64], b: &[f64], share: f64| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect() };
        let (form, mut a, mut b) = (self.form_of(first), first.to_vec(), last.to_vec());
        for _ in 0..60 {
            let middle = between(&a, &b, 0.5);
            let side = if self.form_of(&middle) == form { &mut a } else { &mut b };
            *side = middle;
        }
        self.add(between(&a, first, 1e-6), base);
        [1e-6, 1e-4, 1e-2, 0.1, 0.5].into_iter().for_each(|share| self.add(between(&b, last, share), base));
    }
}

/// True if all searches ended at the same extremum of the node, or one reached the goal up to rounding: then no point lies beyond.
fn is_out_of_reach(ends: &[[f64; 2]], goals: &[f64]) -> bool {
    let is_met = |[start, end]: &[f64; 2]| goals.iter().any(|goal| (end - goal).abs() <= 1e-9 * (start - goal).abs());
    let moved = ends.iter().filter(|[start, end]| (start - end).abs() > 1e-3 * start.abs()).count();
    let is_one = |[start, end]: &[f64; 2]| (end - ends[0][1]).abs() <= 1e-6 * start.abs().max(end.abs());
    ends.iter().any(is_met) || moved > 1 && ends.iter().all(is_one)
}
