//! Formulas that are not defined everywhere are asked only where the scene stands, or where a motion is.

use super::*;
use hamiltonian_adjoint::{Grid, Solver, simulate};

/// Φ = x − √(l² − y²): a slider on a rod.
struct Rod;
impl Constraint<2, 1, 1> for Rod {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, _t: S) -> SVector<S, 1> {
        SVector::from([q[0] - (b[0] * b[0] - q[1] * q[1]).sqrt()])
    }
}

/// A slider at x = 0.16 on a rod of 0.2 m, with the rod's length as a design variable.
fn slider(opaque: bool, place: bool) -> Result<Gradient, Error> {
    let mut s = Scene::new();
    let ([x], [y]) = (s.coordinates("a", ["x"]), s.coordinates("b", ["y"]));
    s.kinetic_energy("mx", Mass, [x], [1.0.into()]);
    s.kinetic_energy("my", Mass, [y], [1.0.into()]);
    let length = s.design("length", if place { 0.2 } else { 0.01 });
    if opaque {
        s.constraint("rod", Opaque(Rod), [x, y], [length.into()]);
    } else {
        s.constraint("rod", Rod, [x, y], [length.into()]);
    }
    s.cost("squares", Squares, Sum::Terminal, [x, y], [], [], []);
    if place {
        s.place(x, 0.16);
        s.place(y, 0.12);
    }
    run(s, |inputs| {
        inputs.design[0] = 0.2;
        inputs.start.q_mut().copy_from_slice(&[0.16, 0.12]);
        inputs.start.rate_mut().copy_from_slice(&[-0.03, 0.04]);
        inputs.grid = Grid::uniform(12, 0.01);
    })
}

#[test]
fn a_rod_much_shorter_than_a_metre_is_no_singular_configuration() {
    let opaque = slider(true, true).expect("a motion");
    for place in [false, true] {
        let traced = slider(false, place).expect("a motion");
        assert!(distance(&traced, &opaque) < 1e-12);
    }
}

/// A formula that panics outside its domain, whatever its argument.
struct Narrow {
    from: f64,
    to: f64,
    of: fn(&[f64; 3]) -> f64,
}

impl Narrow {
    fn check<S: Scalar>(&self, q: S, v: S, t: S) {
        let x = (self.of)(&[q.re(), v.re(), t.re()]);
        assert!(self.from <= x && x <= self.to, "{x} is outside the domain");
    }
}

impl Force<1> for Narrow {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        self.check(at.q[0], at.v[0], at.t);
        SVector::from([-at.q[0].sin()])
    }
}

impl Constraint<1, 1> for Narrow {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _b: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        self.check(q[0], S::zero(), t);
        SVector::from([q[0] - t * 0.1])
    }
}

impl Cost<1> for Narrow {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        self.check(at.q[0], at.v[0], at.t);
        at.q[0] * at.q[0]
    }
}

#[test]
fn a_formula_that_panics_outside_its_domain_is_not_asked_there() {
    // q near 0.5, as the scene is placed; v and t as the inputs have them, which no scene knows.
    let domains: [fn() -> Narrow; 3] = [
        || Narrow { from: 0.2, to: 0.9, of: |x| x[0] },
        || Narrow { from: 0.005, to: 0.4, of: |x| x[1] },
        || Narrow { from: 4.9, to: 5.7, of: |x| x[2] },
    ];
    for (which, domain) in domains.into_iter().enumerate() {
        let mut s = Scene::new();
        let [x] = s.coordinates("a", ["x"]);
        s.place(x, 0.5);
        s.kinetic_energy("m", Mass, [x], [1.0.into()]);
        if which == 1 {
            s.force("narrow", domain(), [x], [], []);
        } else {
            s.constraint("narrow", domain(), [x], []);
        }
        s.cost("cost", domain(), Sum::Terminal, [x], [], [], []);
        let system = s.compile().expect("a scene");
        let mut inputs = Inputs::at_rest(&system, Grid { start: 5.0, ..Grid::uniform(12, 0.05) });
        inputs.start.rate_mut()[0] = if which == 1 { 0.35 } else { 0.1 };
        simulate(&system, &inputs, Settings::default()).expect("a motion");
        gradient(&system, &inputs, Settings::default()).expect("a gradient");
    }
}

/// Φ = x − √(l² − y²) for a start beside its domain is blamed, and not the configuration.
#[test]
fn a_start_outside_the_domain_of_a_formula_is_blamed_on_it_with_its_argument() {
    let mut s = Scene::new();
    let ([x], [y]) = (s.coordinates("a", ["x"]), s.coordinates("b", ["y"]));
    s.kinetic_energy("mx", Mass, [x], [1.0.into()]);
    s.kinetic_energy("my", Mass, [y], [1.0.into()]);
    s.constraint("rod", Rod, [x, y], [0.2.into()]);
    let error = run(s, |inputs| inputs.start.q_mut().copy_from_slice(&[0.0, 0.3])).expect_err("√ of a negative number");
    let Error::Model { element, arguments, node: 0, .. } = &error else { panic!("{error}") };
    assert_eq!(element, "`rod`");
    assert!(arguments.contains("`b.y` = 0.3"), "{arguments}");
}

/// (b tᵏ)ⁿ, whose derivatives of higher order by b are 0 · ∞ at t = 0 if factors are taken one by one.
struct Ramp {
    k: i32,
    n: f64,
}

impl Ramp {
    fn at<S: Scalar>(&self, b: &SVector<S, 1>, t: S) -> S {
        (b[0] * t.powi(self.k)).powf(self.n)
    }
}

impl Constraint<1, 1, 1> for Ramp {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, t: S) -> SVector<S, 1> {
        SVector::from([q[0] - self.at(b, t)])
    }
}

impl PotentialEnergy<1, 1> for Ramp {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 1>, b: &SVector<S, 1>, t: S) -> S {
        self.at(b, t) * q[0].cos()
    }
}

impl Force<1, 0, 1> for Ramp {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([self.at(b, at.t) * at.q[0].cos()])
    }
}

/// The gradient of a mass that a ramp moves from t = 0, and the product of the Hessian with a change of the ramp.
fn moved(ramp: Ramp, which: usize, with_programs: bool) -> Result<[Gradient; 2], Error> {
    let mut s = Scene::new();
    let [x] = s.coordinates("a", ["x"]);
    s.kinetic_energy("mass", Mass, [x], [1.0.into()]);
    let rate = s.design("rate", 0.7);
    match which {
        0 => {
            s.constraint("ramp", ramp, [x], [rate.into()]);
        }
        1 => s.potential_energy("ramp", ramp, [x], [rate.into()]),
        _ => s.force("ramp", ramp, [x], [], [rate.into()]),
    }
    s.cost("squares", Squares, Sum::Trapezoidal, [x], [], [], []);
    let system = if with_programs { s.compile() } else { s.compile_without_programs() }?;
    let inputs = Inputs::at_rest(&system, Grid::uniform(12, 0.05));
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs)?;
    let mut direction = inputs.no_change();
    direction.design[0] = 1.0;
    let product = solver.hessian_product(&direction)?.clone();
    Ok([gradient(&system, &inputs, Settings::default())?, product])
}

#[test]
fn ramps_that_begin_at_zero_have_the_derivatives_that_num_dual_makes() {
    for (n, k) in [1.5, 2.5, 3.5].into_iter().flat_map(|n| [(n, 1), (n, 2)]) {
        for which in 0..3 {
            let [program, dual] = [true, false].map(|with| moved(Ramp { k, n }, which, with).expect("derivatives"));
            for (program, dual) in program.iter().zip(&dual) {
                let far = distance(program, dual);
                assert!(far < 1e-13, "(b t^{k})^{n} as {which}: {far:e}");
            }
        }
    }
}
