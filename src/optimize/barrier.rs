//! [`Barrier`]: bounds as a barrier −μ Σ [ln(y − l) + ln(u − y)] on the variables y = (x, s), with slacks s for inequality constraints.

use super::counted::Counted;
use super::problem::Interval;

/// A start is moved inside its bounds by this fraction: for variables, of the size of the bound or the distance between the bounds, whichever is
/// smaller; for slacks, of this distance or, with one bound, of the larger of its size and `far` units.
pub(super) const INSIDE: f64 = 1e-2;
/// Largest fraction of the distance to a bound that a step may take.
pub(super) const TO_BOUND: f64 = 0.995;
/// Largest distance to which a start near a bound is moved, relative to the distance between the bounds.
const NEAREST_MIDDLE: f64 = 0.4;
/// A variable is close to a bound if its distance is below this fraction of the size of the bound or of the distance between the bounds.
const BESIDE: f64 = 5e-3;
/// Largest factor between the multiplier of a bound and μ/distance.
const NEAR: f64 = 1e10;
/// Largest number of Newton iterations for a minimum between two bounds, and their tolerance relative to the distance from the bounds.
const NEWTON: usize = 60;
const CLOSE: f64 = 1e-8;

/// The bounds of y, their multipliers z, and μ.
#[derive(Clone)]
pub(super) struct Barrier {
    pub(super) bounds: Vec<Interval>,
    /// Multipliers of the lower and the upper bounds.
    z: Vec<[f64; 2]>,
    pub(super) mu: f64,
    /// A length scale of the variables.
    pub(super) unit: f64,
    /// Distance of a far bound, in units of a length: 1 for variables; for slacks, the change of their constraints by a step of this length.
    pub(super) far: Vec<f64>,
}

impl Barrier {
    /// The barrier of a problem and of those of its constraints that have slacks.
    pub(super) fn new(problem: &Counted, inequalities: &[usize]) -> Self {
        let of_constraints = inequalities.iter().map(|&j| problem.intervals[j]);
        let bounds: Vec<Interval> = problem.bounds.iter().copied().chain(of_constraints).collect();
        Barrier::of(bounds)
    }

    /// The barrier of these bounds.
    pub(super) fn of(bounds: Vec<Interval>) -> Self {
        Barrier { z: vec![[0.0; 2]; bounds.len()], far: vec![1.0; bounds.len()], bounds, unit: 1.0, mu: 0.0 }
    }

    /// Moves variables inside their bounds by a fraction `share`.
    pub(super) fn move_variables(&self, x: &mut [f64], share: f64) {
        x.iter_mut()
            .zip(&self.bounds)
            .for_each(|(x, of)| move_inside(x, of, |bound| share * self.size(bound).min(of.most - of.least)));
    }

    /// The size of a bound, or `unit` if it is 0.
    fn size(&self, bound: f64) -> f64 {
        if bound == 0.0 { self.unit } else { bound.abs() }
    }

    /// Moves slacks, the entries of y after n variables, inside their bounds.
    pub(super) fn move_slacks(&self, n: usize, y: &mut [f64]) {
        for ((y, of), far) in y.iter_mut().zip(&self.bounds).zip(&self.far).skip(n) {
            let distance = of.most - of.least;
            move_inside(y, of, |bound| {
                INSIDE * if distance.is_finite() { distance } else { bound.abs().max(far * self.unit) }
            });
        }
    }

    /// True if any bound needs a barrier.
    pub(super) fn is_there(&self) -> bool {
        self.bounds.iter().any(|of| !of.is_equality() && *of != Interval::FREE)
    }

    /// Sets μ, and the corresponding multipliers.
    pub(super) fn set(&mut self, mu: f64, y: &[f64]) {
        self.mu = mu;
        for ((z, of), y) in self.z.iter_mut().zip(&self.bounds).zip(y) {
            *z = distances(of, *y).map(|distance| mu / distance);
        }
    }

    /// Sets μ, moves y to the distances from bounds where complementarity holds with this μ and a gradient of the Lagrangian, and sets the corresponding
    /// multipliers. Away from bounds everything is moved; towards them, slacks (the entries of y from `slacks` on) and variables close to them are,
    /// so that they follow a bound that has changed.
    pub(super) fn begin_near(&mut self, mu: f64, gradient: &[f64], (slacks, y): (usize, &mut [f64])) {
        let pushes = mu.sqrt();
        for (i, ((y, of), g)) in y.iter_mut().zip(&self.bounds).zip(gradient).enumerate() {
            if of.is_equality() {
                continue;
            }
            let width = of.most - of.least;
            // Near a bound that does not push, distance and multiplier are alike.
            let wanted = |force: f64| (mu / force.max(pushes)).min(NEAREST_MIDDLE * width);
            let follows = |bound: f64, force: f64| {
                force > pushes && (i >= slacks || (*y - bound).abs() < BESIDE * self.size(bound).min(width))
            };
            *y = if follows(of.least, *g) {
                of.least + wanted(*g)
            } else if follows(of.most, -g) {
                of.most - wanted(-g)
            } else {
                y.max(of.least + wanted(*g)).min(of.most - wanted(-g))
            };
        }
        self.set(mu, y);
    }

    /// −μ times the sum of the logarithms of all distances.
    pub(super) fn value(&self, y: &[f64]) -> f64 {
        let logarithm = |(of, y): (&Interval, &f64)| {
            distances(of, *y).into_iter().filter(|distance| distance.is_finite()).map(f64::ln).sum::<f64>()
        };
        if self.mu == 0.0 { 0.0 } else { -self.mu * self.bounds.iter().zip(y).map(logarithm).sum::<f64>() }
    }

    /// Adds the gradient of the barrier.
    pub(super) fn add_gradient(&self, y: &[f64], gradient: &mut [f64]) {
        for ((g, of), y) in gradient.iter_mut().zip(&self.bounds).zip(y) {
            let [below, above] = distances(of, *y);
            *g += self.mu / above - self.mu / below;
        }
    }

    /// Adds the multipliers of the bounds, −z of the lower one and z of the upper one.
    pub(super) fn add_multipliers(&self, gradient: &mut [f64]) {
        gradient.iter_mut().zip(&self.z).for_each(|(g, z)| *g += z[1] - z[0]);
    }

    /// The largest error of z · distance = μ.
    pub(super) fn complementarity(&self, y: &[f64], mu: f64) -> f64 {
        let of = |((of, y), z): ((&Interval, &f64), &[f64; 2])| {
            let error = |(distance, z): (f64, f64)| if distance.is_finite() { (distance * z - mu).abs() } else { 0.0 };
            distances(of, *y).into_iter().zip(*z).map(error).fold(0.0, f64::max)
        };
        self.bounds.iter().zip(y).zip(&self.z).map(of).fold(0.0, f64::max)
    }

    /// The sum of all multipliers.
    pub(super) fn sum_of_multipliers(&self) -> f64 {
        self.z.iter().flatten().sum()
    }

    /// The curvature of the barrier computed with its multipliers, z/(y − l) + z/(u − y).
    pub(super) fn curvature(&self, y: &[f64]) -> Vec<f64> {
        let of = |((of, y), z): ((&Interval, &f64), &[f64; 2])| {
            let [below, above] = distances(of, *y);
            z[0] / below + z[1] / above
        };
        self.bounds.iter().zip(y).zip(&self.z).map(of).collect()
    }

    /// The scale of each entry of y: its distance from the nearest bound, at most `far` times `length`; 0 for fixed entries.
    pub(super) fn scales(&self, y: &[f64], length: f64) -> Vec<f64> {
        let of = |((of, y), far): ((&Interval, &f64), &f64)| {
            let [below, above] = distances(of, *y);
            if of.is_equality() { 0.0 } else { below.min(above).min(far * length) }
        };
        self.bounds.iter().zip(y).zip(&self.far).map(of).collect()
    }

    /// The largest derivative times the distance from the bound towards which it pushes, in units of `length` and at most `far`: the error of
    /// complementarity.
    pub(super) fn stationarity(&self, y: &[f64], gradient: &[f64], length: f64) -> f64 {
        let of = |(((of, y), g), far): (((&Interval, &f64), &f64), &f64)| {
            let [below, above] = distances(of, *y);
            let room = if *g > 0.0 { below } else { above };
            if of.is_equality() { 0.0 } else { g.abs() * (room / length).min(*far) }
        };
        self.bounds.iter().zip(y).zip(gradient).zip(&self.far).map(of).fold(0.0, f64::max)
    }

    /// The largest factor ≤ 1 with which a step, taken after `before` from y, covers at most a fraction `share` of the distance to any bound.
    pub(super) fn most(&self, share: f64, y: &[f64], before: &[f64], step: &[f64]) -> f64 {
        let mut most = 1.0f64;
        for (i, of) in self.bounds.iter().enumerate().filter(|(i, _)| step[*i] != 0.0) {
            let [below, above] = distances(of, y[i]);
            let room = if step[i] < 0.0 { share * below + before[i] } else { share * above - before[i] };
            most = most.min((room / step[i].abs()).max(0.0));
        }
        most
    }

    /// The fraction of a step of y_i up to its bound, but at least over the width of the interval or the size of the bound (`size` if the bound is
    /// 0), whichever is smaller.
    pub(super) fn share(&self, i: usize, y: f64, step: f64, size: f64) -> f64 {
        let of = &self.bounds[i];
        let ([below, above], is_down) = (distances(of, y), step < 0.0);
        let (room, bound) = if is_down { (below, of.least) } else { (above, of.most) };
        let beside = if bound == 0.0 { size } else { bound.abs() };
        let room = room.abs().max(beside.min(of.most - of.least));
        if room > 0.0 && room < step.abs() { room / step.abs() } else { 1.0 }
    }

    /// Restores the previous value of entries that rounding would move onto a bound.
    pub(super) fn keep_inside(&self, before: &[f64], y: &mut [f64]) {
        for ((y, before), of) in y.iter_mut().zip(before).zip(&self.bounds) {
            let is_outside = distances(of, *y).into_iter().any(|distance| distance <= 0.0);
            if is_outside {
                *y = *before;
            }
        }
    }

    /// The y_i that minimises −w [ln(y_i − l) + ln(u − y_i)] + ½ (y_i − x)²; `None` if rounding leaves no room for it.
    pub(super) fn settled(&self, i: usize, x: f64, weight: f64) -> Option<f64> {
        let of = &self.bounds[i];
        // The root of d (d − e) = w, without cancellation.
        let from_bound = |e: f64| {
            let root = (e * e + 4.0 * weight).sqrt();
            if e > 0.0 { 0.5 * (e + root) } else { 2.0 * weight / (root - e) }
        };
        let y = match [of.least, of.most].map(f64::is_finite) {
            [true, false] => of.least + from_bound(x - of.least),
            [false, true] => of.most - from_bound(of.most - x),
            _ => between(of, x, weight),
        };
        let is_inside = distances(of, y).into_iter().all(|distance| distance > 0.0);
        is_inside.then_some(y)
    }

    /// Updates the multipliers after a step from y, of which a part led to `next`: by Newton's method for z · distance = μ along the whole step,
    /// over at most a fraction `share` of the way to zero.
    pub(super) fn step_multipliers(&mut self, share: f64, y: &[f64], step: &[f64], next: &[f64]) {
        let mu = self.mu;
        let change = |z: &[f64; 2], i: usize| {
            let before = distances(&self.bounds[i], y[i]);
            [(0, -1.0), (1, 1.0)].map(|(side, sign)| (mu + sign * z[side] * step[i]) / before[side] - z[side])
        };
        let changes: Vec<[f64; 2]> = self.z.iter().enumerate().map(|(i, z)| change(z, i)).collect();
        let mut most = 1.0f64;
        for (z, by) in self.z.iter().flatten().zip(changes.iter().flatten()).filter(|(z, by)| **z > 0.0 && **by < 0.0) {
            most = most.min(share * z / -by);
        }
        for (i, z) in self.z.iter_mut().enumerate() {
            let now = distances(&self.bounds[i], next[i]);
            for side in 0..2 {
                let exact = mu / now[side];
                let moved = z[side] + most * changes[i][side];
                z[side] = if now[side].is_finite() { moved.clamp(exact / NEAR, exact * NEAR) } else { 0.0 };
            }
        }
    }

    /// Updates the multipliers after a step d from y to `next`.
    pub(super) fn step(&mut self, y: &[f64], next: &[f64]) {
        for (i, of) in self.bounds.iter().enumerate() {
            let (before, now, d) = (distances(of, y[i]), distances(of, next[i]), next[i] - y[i]);
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let z = self.mu / before[side] + sign * self.z[i][side] * d / before[side];
                let exact = self.mu / now[side];
                self.z[i][side] = if now[side].is_finite() { z.clamp(exact / NEAR, exact * NEAR) } else { 0.0 };
            }
        }
    }
}

/// Moves y away from its bounds by `by`; a fixed y is not moved.
pub(super) fn move_inside(y: &mut f64, of: &Interval, by: impl Fn(f64) -> f64) {
    if !of.is_equality() {
        *y = y.max(of.least + by(of.least)).min(of.most - by(of.most));
    }
}

/// y − l and u − y; infinite for a fixed y.
fn distances(of: &Interval, y: f64) -> [f64; 2] {
    if of.is_equality() { [f64::INFINITY; 2] } else { [y - of.least, of.most - y] }
}

/// The root of y − x − w/(y − l) + w/(u − y), by Newton's method, with bisection if an iterate leaves the bracket.
fn between(of: &Interval, x: f64, weight: f64) -> f64 {
    let (mut low, mut high) = (of.least, of.most);
    let mut y = 0.5 * (low + high);
    for _ in 0..NEWTON {
        let [below, above] = distances(of, y);
        let slope = y - x - weight / below + weight / above;
        *if slope > 0.0 { &mut high } else { &mut low } = y;
        let next = y - slope / (1.0 + weight / (below * below) + weight / (above * above));
        let next = if next >= low && next <= high { next } else { 0.5 * (low + high) };
        let is_found = (next - y).abs() <= CLOSE * below.min(above);
        y = next;
        if is_found {
            break;
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_settled_slack_is_where_its_terms_are_least() {
        let bounds = [Interval::at_least(-1.0), Interval::at_most(2.0), Interval::new(-1.0, 2.0)];
        let barrier = Barrier { z: vec![[0.0; 2]; 3], bounds: bounds.to_vec(), mu: 1.0, unit: 1.0, far: vec![1.0; 3] };
        for (i, of) in bounds.iter().enumerate() {
            for x in [-30.0, -1.0, -1.0 + 1e-9, 0.3, 0.5, 2.0, 2.1, 1e6] {
                for weight in [1e-18, 1e-7, 0.1, 30.0] {
                    let Some(y) = barrier.settled(i, x, weight) else {
                        // A weight lost to rounding next to a bound.
                        assert!(weight < 1e-12 && !(of.least < x && x < of.most), "{of:?} {x} {weight}");
                        continue;
                    };
                    let [below, above] = distances(of, y);
                    let terms = [y - x, -weight / below, weight / above];
                    // If the terms are steep, the rounding error of y counts.
                    let steep = 1.0 + weight / (below * below) + weight / (above * above);
                    let rounding = 1e-15 * terms.iter().map(|x| x.abs()).sum::<f64>() + 4e-16 * steep * y.abs();
                    assert!(terms.iter().sum::<f64>().abs() <= 4.0 * rounding, "{of:?} {x} {weight}: {y} {terms:?}");
                }
            }
        }
    }
}
