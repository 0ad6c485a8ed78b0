//! Kinks between nodes: the gradient at frozen grid phase and its warning, beside an independent integration that finds every kink.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Cost, CostPoint, Force, ForcePoint, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, Warning};
use nalgebra::SVector;

/// A force on a mass of 1 kg whose coordinate is x.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// Falls on a floor at 0 that pushes with k depth^exponent.
    Floor { exponent: f64 },
    /// A pendulum of 1 m against a spring at the angle 0.
    Wall,
    /// A drive between two end stops at ±0.1.
    Stops,
    /// A spring with dry friction of 2 N; k is 1/(velocity of the friction).
    Friction,
    /// A spring with play of ±0.05.
    Play,
}

const LAWS: [Law; 6] =
    [Law::Floor { exponent: 1.5 }, Law::Floor { exponent: 1.0 }, Law::Wall, Law::Stops, Law::Friction, Law::Play];

impl Law {
    fn force<S: Scalar>(self, x: S, v: S, t: S, k: S) -> S {
        let zero = S::zero();
        let outside = |gap: f64| (x - gap).max(zero) + (x + gap).min(zero);
        match self {
            Law::Floor { exponent } => k * (-x).max(zero).powf(exponent) - 9.81,
            Law::Wall => -x.sin() * 9.81 - k * x.max(zero),
            Law::Stops => (t * 7.0).sin() * 20.0 - k * outside(0.1),
            Law::Friction => -x * 20.0 - (v * k).tanh() * 2.0,
            Law::Play => -k * outside(0.05) - v * 0.3,
        }
    }

    /// The functions whose zeros are kinks.
    fn gaps(self, x: f64, v: f64) -> [f64; 2] {
        match self {
            Law::Floor { .. } | Law::Wall => [x, 1.0],
            Law::Stops => [x - 0.1, x + 0.1],
            Law::Play => [x - 0.05, x + 0.05],
            Law::Friction => [v, 1.0],
        }
    }

    /// x₀, v₀ and k.
    fn draw(self, random: &mut Random) -> [f64; 3] {
        let between = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.uniform(0.0, 1.0));
        let u = |random: &mut Random, low, high| random.uniform(low, high);
        match self {
            Law::Floor { exponent } => {
                let k = if exponent > 1.0 { between(random, 1e3, 1e6) } else { between(random, 1e3, 1e5) };
                [u(random, 0.3, 1.0), u(random, -1.0, 1.0), k]
            }
            Law::Wall => [u(random, -0.9, -0.3), u(random, -0.5, 0.5), between(random, 1e2, 1e5)],
            Law::Stops => [u(random, -0.08, 0.08), u(random, -0.5, 0.5), between(random, 1e3, 1e5)],
            Law::Friction => [u(random, 0.4, 1.0), u(random, -1.0, 1.0), between(random, 1e1, 2e3)],
            Law::Play => [u(random, -0.04, 0.04), u(random, 0.3, 1.5), between(random, 1e2, 1e4)],
        }
    }
}

impl Force<1, 0, 1> for Law {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([Law::force(*self, at.q[0], at.v[0], at.t, b[0])])
    }
}

struct Place;

impl Cost<1> for Place {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0]
    }
}

struct Mass;

impl hamiltonian_adjoint::KineticEnergy<1, 0> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
        v[0] * v[0] * 0.5
    }
}

const DURATION: f64 = 1.2;

/// x(T) by the classical Runge–Kutta method with steps that end at the kinks.
fn integrate(law: Law, [x, v, k]: [f64; 3], steps: usize) -> f64 {
    let rate = |[x, v]: [f64; 2], t: f64| [v, law.force(x, v, t, k)];
    let step = |[x, v]: [f64; 2], t: f64, h: f64| {
        let moved = |r: [f64; 2], h: f64| [x + h * r[0], v + h * r[1]];
        let first = rate([x, v], t);
        let second = rate(moved(first, 0.5 * h), t + 0.5 * h);
        let third = rate(moved(second, 0.5 * h), t + 0.5 * h);
        let fourth = rate(moved(third, h), t + h);
        let mean = |i: usize| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0;
        [x + h * mean(0), v + h * mean(1)]
    };
    let crossed = |from: [f64; 2], to: [f64; 2]| {
        let [from, to] = [from, to].map(|[x, v]| law.gaps(x, v));
        (0..2).any(|i| from[i] * to[i] < 0.0)
    };
    let (mut y, mut t, full) = ([x, v], 0.0, DURATION / steps as f64);
    while t < DURATION - 1e-12 {
        let h = full.min(DURATION - t);
        let mut end = step(y, t, h);
        let mut taken = h;
        if law != Law::Friction && crossed(y, end) {
            // The last point before the kink, up to rounding; one tiny step passes it.
            let (mut before, mut behind) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (before + behind);
                *(if crossed(y, step(y, t, middle)) { &mut behind } else { &mut before }) = middle;
            }
            (taken, end) = (behind, step(y, t, behind));
        }
        (y, t) = (end, t + taken);
    }
    y[0]
}

/// The derivatives of x(T) by x₀, v₀ and k.
fn derivatives(law: Law, at: [f64; 3]) -> [f64; 3] {
    let steps = if law == Law::Friction { 200_000 } else { 10_000 };
    std::array::from_fn(|i| {
        let change = if i == 2 { 1e-4 * at[i] } else { 1e-5 };
        let moved = |sign: f64| {
            let mut moved = at;
            moved[i] += sign * change;
            integrate(law, moved, steps)
        };
        (moved(1.0) - moved(-1.0)) / (2.0 * change)
    })
}

/// Plain and frozen derivatives of the discrete motion, whether it warns, and the fewest steps between two kinks.
struct Discrete {
    plain: [f64; 3],
    frozen: [f64; 3],
    warns: bool,
    fewest: usize,
}

fn discrete(law: Law, [x, v, k]: [f64; 3], steps: usize) -> Discrete {
    let mut scene = Scene::new();
    let q = scene.coordinates("mass", ["x"]);
    scene.place(q[0], x);
    scene.kinetic_energy("T", Mass, q, []);
    let stiffness = scene.design("k", k);
    scene.force("law", law, q, [], [stiffness.into()]);
    scene.cost("x", Place, Sum::Terminal, q, [], [], []);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, DURATION / steps as f64));
    inputs.start.rate_mut()[0] = v;
    let mut solver = Solver::new(&system, Settings::default());
    let motion = solver.simulate(&inputs).expect("a motion");
    let gaps: Vec<[f64; 2]> = (0..=steps).map(|i| law.gaps(motion.q[(0, i)], motion.v[(0, i)])).collect();
    let is_kink = |i: &usize| (0..2).any(|k| gaps[i - 1][k] * gaps[*i][k] < 0.0);
    let kinks: Vec<usize> = (1..=steps).filter(is_kink).collect();
    let fewest = kinks.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(usize::MAX);
    let gradient = solver.gradient().expect("a gradient");
    let list = |of: &hamiltonian_adjoint::Gradient| [of.start.q()[0], of.start.rate()[0], of.design[0]];
    let plain = list(gradient);
    let frozen = gradient.frozen.as_deref().map_or(plain, list);
    let warns = gradient.warnings.iter().any(|warning| matches!(warning, Warning::GridPhase { .. }));
    Discrete { plain, frozen, warns, fewest }
}

/// The largest error, relative to the derivative or to a hundredth of the largest effect.
fn error(found: [f64; 3], truth: [f64; 3], at: [f64; 3]) -> f64 {
    let sizes = [1.0, 1.0, at[2]];
    let most = (0..3).map(|i| truth[i].abs() * sizes[i]).fold(0.0, f64::max);
    let relative = |i: usize| (found[i] - truth[i]).abs() * sizes[i] / (truth[i].abs() * sizes[i]).max(0.01 * most);
    (0..3).map(relative).fold(0.0, f64::max)
}

/// The median, 0 for none.
fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of.get(of.len() / 2).copied().unwrap_or(0.0)
}

#[test]
fn who_is_far_from_the_motion_is_warned_and_the_frozen_gradient_is_near() {
    let mut random = Random::new(5);
    // The steps between two kinks, and the errors of the gradients, of all motions.
    let mut all: Vec<(usize, f64, f64)> = Vec::new();
    let (mut unwarned, mut false_alarms, mut sticking) = (Vec::new(), Vec::new(), 0);
    for case in 0..300 {
        let law = LAWS[case % LAWS.len()];
        let at = law.draw(&mut random);
        let steps = (60.0 * 32f64.powf(random.uniform(0.0, 1.0))) as usize;
        let (truth, found) = (derivatives(law, at), discrete(law, at, steps));
        let [plain, frozen] = [found.plain, found.frozen].map(|found| error(found, truth, at));
        let line = format!("{law:?} {at:.3?}, {steps} steps: plain {plain:.3}, frozen {frozen:.3}");
        all.push((found.fewest, plain, frozen));
        if plain > 0.1 && !found.warns {
            // Where friction catches a mass without a reversal, its velocity has no zero.
            sticking += usize::from(law == Law::Friction);
            unwarned.extend((law != Law::Friction).then(|| line.clone()));
        }
        if plain < 0.02 && found.warns {
            false_alarms.push(line);
        }
    }
    println!("steps in a contact, motions, median error plain and frozen, frozen within 5 %");
    for (from, to) in [(0, 4), (4, 8), (8, 16), (16, 32), (32, 64), (64, usize::MAX), (usize::MAX, usize::MAX)] {
        let of: Vec<_> = all.iter().filter(|of| of.0 >= from && (of.0 < to || from == to)).collect();
        let within = of.iter().filter(|of| of.2 < 0.05).count();
        let [plain, frozen] = [median(of.iter().map(|of| of.1).collect()), median(of.iter().map(|of| of.2).collect())];
        println!("{from:20} {:4} {plain:10.3} {frozen:10.3} {within:4}", of.len());
    }
    let off: Vec<_> = all.iter().filter(|of| of.1 > 0.1).collect();
    let nearer = off.iter().filter(|of| of.2 < of.1).count();
    println!("plain off by more than 10 %: {}, frozen nearer: {nearer}; unwarned, friction: {sticking}", off.len());
    println!("false alarms {false_alarms:#?}\nunwarned {unwarned:#?}");
    assert!(unwarned.is_empty() && false_alarms.is_empty() && sticking <= 5);
    assert!(10 * nearer > 9 * off.len());
    let resolved: Vec<_> = all.iter().filter(|of| (32..usize::MAX).contains(&of.0)).collect();
    let [plain, frozen] =
        [|of: &&(usize, f64, f64)| of.1, |of: &&(usize, f64, f64)| of.2].map(|of| median(resolved.iter().map(of).collect()));
    assert!(frozen < 0.02 && plain > 0.1, "{frozen} {plain}");
}
