//! Where a formula bends: lines through a point are searched, over eleven decades, for places where its derivatives change.
//!
//! A term like tanh(v/ε) or a stop at a distance matters in a small part of space that random points miss. On a line x(s) through a
//! point, along one argument or along all of a kind, it betrays itself twice: the block changes from one decade of s to the next, or the
//! function's values change by more than its slopes account for. Between two places the values are interpolated by the cubic through
//! values and slopes (Hermite); where the middle is not met, the interval is halved. A jump is so narrowed down, whatever its width.

use std::ops::Range;

use super::formula::Differentiable;
use super::oracle::Jacobian;
use super::plan::Setting;
use super::random::Random;

/// Lines are looked along from 1e-8 to 1e3 times the size of their arguments.
const DECADES: Range<i32> = -8..4;
/// Whether anything changes along a line is looked at here: as far out as random points are.
const WITHIN: [f64; 5] = [0.7, -0.9, 1e-6, 1.5, -1.4];
/// Values are compared between places that are so far out.
const COMPARED: Range<f64> = 1e-3..2.0;
/// At so many points.
const BASES: usize = 2;
/// Halvings on one side of a line.
const MOST_HALVINGS: usize = 80;
/// What searching one line costs, about, in evaluations of the function; a point costs some 30 for each column.
const LINE: usize = 160;
const POINT: usize = 30;
/// As many lines are searched as cost what the points do, but not fewer and not more than these.
const LINES: (usize, usize) = (8, 24);
/// What the cubic may miss, relative to the change of the value so far out.
const MISSED: f64 = 1e-3;
/// A block that differs from the straight line between its neighbours by more than this, relative to their size, has a bend.
const BENT: f64 = 0.1;
/// Bends on one side of a line that are compared.
const MOST_BENDS: usize = 4;

/// A place where a block shall be compared, too, and the point that it was found from.
pub(crate) struct Bend {
    pub x: Vec<f64>,
    pub base: usize,
}

/// x(s) = origin + s · direction.
struct Line {
    base: usize,
    origin: Vec<f64>,
    direction: Vec<f64>,
}

/// What is known at one place of a line.
struct Sample {
    s: f64,
    value: Vec<f64>,
    /// d(value)/ds.
    slope: Vec<f64>,
    /// The block times a fixed vector.
    block: Vec<f64>,
}

/// The places where the block ∂f/∂x over the arguments `by` bends, at most `most`, the sharpest of each line first.
pub(crate) fn bends(of: &Jacobian, setting: &Setting, most: usize) -> Vec<Bend> {
    let mut random = Random::new(setting.seed ^ 0xbe4d);
    let (f, mut along) = (of.function.as_ref(), vec![0.0; setting.magnitudes.len()]);
    of.by.clone().for_each(|j| along[j] = random.away_from_zero(setting.magnitudes[j]));
    let of_line = |line: Line| {
        let sample = |s: f64| line.sample(f, &along, setting, s);
        let samples = samples(&sample, &line.rounding(f, &mut random), setting.drawn.given, &mut random);
        strongest(&samples).into_iter().map(|s| Bend { x: line.at(s), base: line.base }).collect::<Vec<_>>()
    };
    let lines = lines(of, &along, setting).into_iter();
    let mut found: Vec<(usize, Bend)> = lines.map(of_line).flat_map(|bends| bends.into_iter().enumerate()).collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, bend)| bend).take(most).collect()
}

/// Along all arguments of a kind, and along each one, through the first points; those along which nothing changes are left out.
fn lines(of: &Jacobian, along: &[f64], setting: &Setting) -> Vec<Line> {
    let mut random = Random::new(setting.seed ^ 0x11e5);
    let drawn = &setting.drawn;
    let most = (drawn.points.len() * of.by.len() * POINT / LINE).clamp(LINES.0, LINES.1);
    let (most_bases, kinds) = if drawn.given { (usize::MAX, &[][..]) } else { (BASES, &setting.kinds[..]) };
    let bases: Vec<usize> = (0..drawn.points.len()).filter(|&p| drawn.parents[p].is_none()).take(most_bases).collect();
    let kinds = kinds.iter().filter(|kind| kind.len() > 1);
    let kinds = bases.iter().flat_map(|&base| kinds.clone().map(move |kind| (base, kind.clone())));
    let mut singles: Vec<_> = bases.iter().flat_map(|&base| setting.free.iter().map(move |&k| (base, vec![k]))).collect();
    (1..singles.len()).rev().for_each(|k| singles.swap(k, random.below(k + 1)));
    let lines = kinds.chain(singles).map(|(base, moved)| Line::new(base, &moved, setting));
    lines.filter(|line| line.matters(of.function.as_ref(), along, setting)).take(most).collect()
}

impl Line {
    /// s = 1 is the size of a single argument, and the point itself where several move.
    fn new(base: usize, moved: &[usize], setting: &Setting) -> Self {
        let point = &setting.drawn.points[base];
        let mut origin = point.clone();
        if !setting.drawn.given {
            moved.iter().for_each(|&k| origin[k] = 0.0);
            (setting.settle)(&mut origin);
        }
        let mut end = origin.clone();
        moved.iter().for_each(|&k| end[k] = if moved.len() == 1 { origin[k] + setting.magnitudes[k] } else { point[k] });
        (setting.settle)(&mut end);
        let direction = end.iter().zip(&origin).map(|(end, origin)| end - origin).collect();
        Line { base, origin, direction }
    }

    fn at(&self, s: f64) -> Vec<f64> {
        self.origin.iter().zip(&self.direction).map(|(x, d)| x + s * d).collect()
    }

    fn sample(&self, f: &dyn Differentiable, along: &[f64], setting: &Setting, s: f64) -> Option<Sample> {
        let x = self.at(s);
        if !(setting.admissible)(&x) {
            return None;
        }
        let (value, slope) = f.by_dual(&x, &self.direction);
        let block = f.by_dual(&x, along).1;
        let finite = value.iter().chain(&slope).chain(&block).all(|y| y.is_finite());
        finite.then_some(Sample { s, value, slope, block })
    }

    /// What rounding the arguments does to the values, generously.
    fn rounding(&self, f: &dyn Differentiable, random: &mut Random) -> Vec<f64> {
        let x = self.at(0.7);
        let nearby: Vec<f64> = x.iter().map(|x| x * (1.0 + f64::EPSILON * random.uniform(-2.5, 2.5).round())).collect();
        let off = |(a, b): (&f64, &f64)| 1e-13 * a.abs() + 64.0 * (a - b).abs();
        f.real(&x).iter().zip(&f.real(&nearby)).map(off).map(|x| if x.is_finite() { x } else { 0.0 }).collect()
    }

    /// Whether the function or the block depends on s at all.
    fn matters(&self, f: &dyn Differentiable, along: &[f64], setting: &Setting) -> bool {
        let samples: Vec<_> = WITHIN.map(|s| self.sample(f, along, setting, s)).into_iter().flatten().collect();
        samples.len() < 2 || samples.windows(2).any(|pair| pair[0].value != pair[1].value || pair[0].block != pair[1].block)
    }
}

/// Both sides of a line: first in decades, then wherever the values are not what the slopes say; by increasing distance from 0.
fn samples(sample: &dyn Fn(f64) -> Option<Sample>, rounding: &[f64], given: bool, random: &mut Random) -> [Vec<Sample>; 2] {
    let decades = if given { DECADES.start..1 } else { DECADES };
    [1.0, -1.0].map(|side| {
        let mut places = decades.clone().map(|e| side * 10f64.powi(e) * random.uniform(0.6, 1.0));
        let mut samples: Vec<Sample> = places.by_ref().filter_map(sample).collect();
        let far = |pair: &[Sample]| pair[1].s.abs() > COMPARED.start && pair[0].s.abs() < COMPARED.end;
        let mut open: Vec<(f64, f64)> =
            samples.windows(2).filter(|pair| far(pair)).map(|pair| (pair[0].s, pair[1].s)).collect();
        let mut budget = MOST_HALVINGS;
        // The innermost first: what happens there is small beside what happens far out.
        open.reverse();
        while let (Some((a, b)), true) = (open.pop(), budget > 0) {
            budget -= 1;
            let m = 0.5 * (a + b);
            if m == a || m == b || (b - a).abs() < 1e-9 * b.abs() {
                continue;
            }
            let Some(middle) = sample(m) else { continue };
            let at = samples.partition_point(|x| x.s.abs() < m.abs());
            if missed(&samples[..=at], &middle, rounding) {
                open.extend([(m, b), (a, m)]);
            }
            samples.insert(at, middle);
        }
        samples
    })
}

/// Whether the value in the middle is not the cubic's, relative to all change of the value up to there.
fn missed(samples: &[Sample], middle: &Sample, rounding: &[f64]) -> bool {
    let [.., a, b] = samples else { return false };
    (0..middle.value.len()).any(|i| {
        let expected = 0.5 * (a.value[i] + b.value[i]) + (b.s - a.s) / 8.0 * (a.slope[i] - b.slope[i]);
        let change = samples.iter().fold(0.0f64, |m, x| m.max((x.value[i] - samples[0].value[i]).abs()));
        let rounding = rounding[i] + 1e-13 * (a.value[i].abs() + b.value[i].abs() + middle.value[i].abs());
        (middle.value[i] - expected).abs() > MISSED * change + rounding
    })
}

/// Where the block differs from the straight line between its neighbours, the largest changes first, on both sides by turns.
fn strongest(sides: &[Vec<Sample>; 2]) -> Vec<f64> {
    let of_side = |samples: &Vec<Sample>| {
        let mut largest = vec![0.0f64; samples.first().map_or(0, |sample| sample.block.len())];
        let mut found: Vec<(f64, f64)> = Vec::new();
        for [a, x, b] in samples.array_windows() {
            [a, x, b].iter().for_each(|at| largest.iter_mut().zip(&at.block).for_each(|(m, z)| *m = m.max(z.abs())));
            let share = (x.s - a.s) / (b.s - a.s);
            let bend = |i: usize| {
                let (a, x, b) = (a.block[i], x.block[i], b.block[i]);
                let change = (x - (a + share * (b - a))).abs();
                let local = a.abs().max(x.abs()).max(b.abs()).max(1e-6 * largest[i]);
                if change > BENT * local { change / largest[i].max(f64::MIN_POSITIVE) } else { 0.0 }
            };
            let strength = (0..largest.len()).map(bend).fold(0.0, f64::max);
            if strength > 0.0 {
                found.push((strength, x.s));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(MOST_BENDS);
        found
    };
    let mut all: Vec<(f64, f64)> = sides.iter().flat_map(of_side).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, s)| s).collect()
}
