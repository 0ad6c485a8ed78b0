//! The step of the quadratic model within a trust region: first towards the constraints, then along them by projected conjugate gradients.
//!
//! With the variables in units of their scales, p = D⁻¹ d, and Â = A D, Ĥ = D (H + Σ) D, ĝ = D g:
//!
//! ```text
//!   normal        n = the dogleg of ½‖Â n + C‖² within ¾ of the radius Δ
//!   tangential    min ½ tᵀĤ t + (ĝ + Ĥ n)ᵀ t      Â t = 0,   ‖n + t‖ ≤ Δ       (Steihaug; Gould, Hribar and Nocedal 2001)
//! ```

mod region;

use nalgebra::DVector;

use super::barrier::{Barrier, TO_BOUND};
use crate::Error;
pub(super) use region::{CORRECTIONS, ROUNDING, Region, TAKEN_BACK};

/// The fraction of the radius that the normal step may take.
const OF_NORMAL: f64 = 0.75;
/// The fraction of the distance to bounds that the normal step may take: the step along the constraints cannot continue at a bound.
const NORMAL_TO_BOUND: f64 = 0.8 * TO_BOUND;
/// Largest tolerance of conjugate gradients; it decreases with the reduced gradient relative to its largest value, for superlinear convergence.
const TOLERANCE: f64 = 0.1;
/// A projected gradient below this fraction of the gradient is rounding error.
const ROUNDED: f64 = 1e-12;
/// Constraints contradict each other if the least change leaves more than this fraction of the violation.
const CONTRADICTS: f64 = 1e-6;

/// Linearised constraints Â p + C = 0 in scaled variables.
pub(super) trait Linearised {
    /// Number of independent constraints.
    fn rank(&self) -> usize;

    /// The Frobenius norm of Â.
    fn size(&self) -> f64;

    /// Â p.
    fn times(&self, p: &DVector<f64>) -> DVector<f64>;

    /// Âᵀ c.
    fn times_transposed(&self, c: &DVector<f64>) -> DVector<f64>;

    /// The smallest change n with C + Â n = 0, or with the smallest ‖C + Â n‖ if constraints contradict each other.
    fn least_change(&self, c: &DVector<f64>) -> DVector<f64>;

    /// r without its component along the rows of Â.
    fn project(&self, r: &DVector<f64>) -> DVector<f64>;
}

/// A change that should satisfy the constraints or, if it does not because they contradict each other, the change that minimises ‖C + Â n‖, by conjugate
/// gradients from there.
pub(super) fn least_residual(of: &dyn Linearised, c: &DVector<f64>, mut change: DVector<f64>) -> DVector<f64> {
    let mut left = c + of.times(&change);
    if left.norm() <= CONTRADICTS * c.norm() {
        return change;
    }
    let mut slope = of.times_transposed(&left);
    let (mut d, end) = (-&slope, ROUNDED * of.size() * left.norm());
    for _ in 0..=c.len() {
        let (of_d, square) = (of.times(&d), slope.norm_squared());
        if square.sqrt() <= end || of_d.amax() == 0.0 {
            break;
        }
        let alpha = square / of_d.norm_squared();
        change += &d * alpha;
        left += of_d * alpha;
        slope = of.times_transposed(&left);
        d = d * (slope.norm_squared() / square) - &slope;
    }
    change
}

/// Ĥ times a direction.
pub(super) type Product<'a> = &'a mut dyn FnMut(&DVector<f64>) -> Result<DVector<f64>, Error>;

/// A step in scaled variables.
pub(super) struct Step {
    pub(super) p: DVector<f64>,
    /// Predicted decrease of f + barrier.
    pub(super) model: f64,
    /// Predicted decrease of ‖C + A d‖.
    pub(super) closer: f64,
    /// Length of the step in scaled variables.
    pub(super) length: f64,
}

/// Intermediate results of a step: n with Ĥ n, the size of the gradient ĝ + Ĥ n along the constraints, and the conjugate directions d with Ĥ d.
pub(super) struct Known {
    normal: [DVector<f64>; 2],
    pub(super) reduced: f64,
    directions: Vec<[DVector<f64>; 2]>,
}

/// The quadratic model at the point y with the scales D.
pub(super) struct Model<'a> {
    /// The unit of ĝ and Ĥ in the model, a power of two: their squares may overflow or underflow.
    pub(super) unit: f64,
    /// ĝ in this unit, which products have, too.
    pub(super) gradient: &'a DVector<f64>,
    pub(super) c: &'a DVector<f64>,
    pub(super) constraints: &'a dyn Linearised,
    pub(super) barrier: &'a Barrier,
    pub(super) y: &'a DVector<f64>,
    pub(super) scales: &'a DVector<f64>,
    /// The largest reduced gradient so far.
    pub(super) steepest: f64,
}

impl Model<'_> {
    /// The step within a radius, with products of Ĥ in the unit of the model.
    pub(super) fn step(&self, radius: f64, product: Product<'_>) -> Result<(Step, Known), Error> {
        let n = self.normal(OF_NORMAL * radius);
        let of_n = if n.amax() > 0.0 { product(&n)? } else { DVector::zeros(n.len()) };
        let mut known = Known { normal: [n, of_n], reduced: 0.0, directions: Vec::new() };
        let t = self.tangential(&mut known, radius, product)?;
        Ok((self.sum(&known.normal, t), known))
    }

    /// A step within a smaller radius without further products: a shorter n, and the best t in the same directions, which are conjugate.
    pub(super) fn shorter(&self, radius: f64, known: &Known) -> Step {
        let share = (OF_NORMAL * radius / known.normal[0].norm()).min(1.0);
        let normal = known.normal.each_ref().map(|x| x * share);
        let gradient = self.gradient + &normal[1];
        let (mut t, mut of_t) = (DVector::zeros(gradient.len()), DVector::zeros(gradient.len()));
        for [d, of_d] in &known.directions {
            let (curvature, slope) = (d.dot(of_d), gradient.dot(d));
            let d = if slope > 0.0 { -d } else { d.clone() };
            let longest = to_sphere(&(&normal[0] + &t), &d, radius);
            let alpha = if curvature > 0.0 { (slope.abs() / curvature).min(longest) } else { longest };
            t += d * alpha;
            of_t += of_d * if slope > 0.0 { -alpha } else { alpha };
            if alpha >= longest {
                break;
            }
        }
        let most = self.most(TO_BOUND, &normal[0], &t);
        self.sum(&normal, [t * most, of_t * most])
    }

    fn sum(&self, [n, of_n]: &[DVector<f64>; 2], [t, of_t]: [DVector<f64>; 2]) -> Step {
        self.complete(n + t, &(of_n + of_t))
    }

    /// The step p, given Ĥ p.
    pub(super) fn complete(&self, p: DVector<f64>, of_p: &DVector<f64>) -> Step {
        let model = self.unit * (-self.gradient.dot(&p) - 0.5 * p.dot(of_p));
        let closer = self.c.norm() - (self.c + self.constraints.times(&p)).norm();
        Step { length: p.norm(), p, model, closer }
    }

    fn normal(&self, radius: f64) -> DVector<f64> {
        let a = self.constraints;
        if self.c.amax() == 0.0 {
            return DVector::zeros(self.y.len());
        }
        let mut newton = a.least_change(self.c);
        let slope = a.times_transposed(self.c);
        let ahead = a.times(&slope).norm_squared();
        let cauchy = if ahead > 0.0 { &slope * -(slope.norm_squared() / ahead) } else { slope };
        // Rounding may spoil the Newton step if rows are nearly equal.
        let left = |n: &DVector<f64>| (self.c + a.times(n)).norm();
        if left(&newton) > left(&cauchy) {
            newton.copy_from(&cauchy);
        }
        let (to_newton, to_cauchy) = (newton.norm(), cauchy.norm());
        let n = if to_newton <= radius {
            newton
        } else if to_cauchy >= radius {
            cauchy * (radius / to_cauchy)
        } else {
            let rest = newton - &cauchy;
            let share = to_sphere(&cauchy, &rest, radius);
            cauchy + rest * share
        };
        let most = self.most(NORMAL_TO_BOUND, &DVector::zeros(n.len()), &n);
        n * most
    }

    /// The largest factor ≤ 1 with which a step after `before` covers at most a fraction of the distance to the bounds.
    fn most(&self, share: f64, before: &DVector<f64>, step: &DVector<f64>) -> f64 {
        let (before, step) = (before.component_mul(self.scales), step.component_mul(self.scales));
        self.barrier.most(share, self.y.as_slice(), before.as_slice(), step.as_slice())
    }

    /// t and Ĥ t.
    fn tangential(
        &self,
        Known { normal: [n, of_n], reduced, directions }: &mut Known,
        radius: f64,
        product: Product<'_>,
    ) -> Result<[DVector<f64>; 2], Error> {
        let zeros = || DVector::zeros(n.len());
        let (mut t, mut of_t, mut r) = (zeros(), zeros(), self.gradient + &*of_n);
        let mut v = self.constraints.project(&r);
        let mut d = -&v;
        let mut rv = r.dot(&v);
        *reduced = self.unit * rv.max(0.0).sqrt();
        let exact = TOLERANCE.min(*reduced / self.steepest.max(*reduced));
        let end = (rv * exact * exact).max(ROUNDED * ROUNDED * r.norm_squared());
        // The last point at a sufficient distance from bounds, and the step from there.
        let mut inside: Option<[DVector<f64>; 4]> = None;
        for _ in 0..(n.len() + 1).saturating_sub(self.constraints.rank()) {
            if rv <= end || rv <= 0.0 {
                break;
            }
            let of_d = product(&d)?;
            let curvature = d.dot(&of_d);
            let at = &*n + &t;
            let longest = to_sphere(&at, &d, radius);
            let alpha = if curvature > 0.0 { (rv / curvature).min(longest) } else { longest };
            let is_last = alpha >= longest;
            let step = &d * alpha;
            match self.most(TO_BOUND, &at, &step) >= 1.0 {
                true => inside = None,
                false if inside.is_none() => inside = Some([t.clone(), of_t.clone(), step.clone(), &of_d * alpha]),
                false => {}
            }
            t += step;
            of_t += &of_d * alpha;
            r += &of_d * alpha;
            directions.push([d.clone(), of_d]);
            if is_last {
                break;
            }
            v = self.constraints.project(&r);
            // r may be replaced by its projection, which reduces the remaining rounding error.
            r.copy_from(&v);
            let next = r.dot(&v);
            d = &d * (next / rv) - &v;
            rv = next;
        }
        if let Some([t, of_t, step, of_step]) = inside {
            let share = self.most(TO_BOUND, &(&*n + &t), &step);
            return Ok([t + step * share, of_t + of_step * share]);
        }
        Ok([t, of_t])
    }
}

/// s ≥ 0 with ‖x + s d‖ = radius.
fn to_sphere(x: &DVector<f64>, d: &DVector<f64>, radius: f64) -> f64 {
    let (a, b, c) = (d.norm_squared(), x.dot(d), x.norm_squared() - radius * radius);
    let root = (b * b - a * c).max(0.0).sqrt();
    // The form without cancellation.
    if a == 0.0 || c >= 0.0 {
        0.0
    } else if b > 0.0 {
        -c / (b + root)
    } else {
        (root - b) / a
    }
}
