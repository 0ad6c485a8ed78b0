//! Formulas of users in scene files: what was written in Rust comes back to the last bit.

use hamiltonian_adjoint::check;
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Constraint, Cost, CostPoint, Force, ForcePoint, Grid, Inputs, KineticEnergy, ListCost, ListPoint, Mechanics,
    PotentialEnergy, Scalar, Scene, SceneFile, Settings, Sum, System,
};
use nalgebra::{DMatrix, SVector};

use crate::common::{assert_says, files};

/// Asserts that a scene is the same after it was written and read, along a short motion, and returns the file.
fn assert_comes_back(scene: Scene) -> String {
    let inputs = |_: &Scene, system: &System| {
        let controls = DMatrix::from_fn(system.k(), 13, |k, i| 0.3 + 0.1 * k as f64 - 0.05 * i as f64);
        Inputs { controls, ..Inputs::at_rest(system, Grid::uniform(12, 0.01)) }
    };
    assert_eq!(files::compared("a scene of formulas", &scene, &inputs), files::Copied::Same);
    let file = scene.to_json().expect("a file");
    let read = SceneFile::from_json(&file).and_then(SceneFile::complete).expect("everything");
    assert_eq!(read.to_json().expect("a file"), file, "it is written as it was read");
    file
}

/// Two hinges in relative angles; b = [m₁, m₂, l₁, l₂].
struct Motion;

impl KineticEnergy<2, 4> for Motion {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 2>, v: &SVector<S, 2>, b: &SVector<S, 4>) -> S {
        let [m1, m2, l1, l2] = [b[0], b[1], b[2], b[3]];
        let (first, second) = (l1 * l1 * v[0] * v[0], l2 * l2 * v[1] * v[1]);
        (m1 + m2) * first * 0.5 + m2 * second * 0.5 + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos()
    }
}

struct Height;

impl PotentialEnergy<2, 4> for Height {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 4>, t: S) -> S {
        -((b[0] + b[1]) * b[2] * q[0].cos() + b[1] * b[3] * q[1].cos()) * 9.81 + (t * 3.0).sin() * q[0] * 0.1
    }
}

/// A number of the type is a number of the formula, which no other formula of this type shares.
struct Brake(f64);

impl Force<2, 1, 1> for Brake {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 1>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let half = S::from(self.0);
        SVector::from([at.u[0] - b[0] * at.v[0] * at.t.exp(), -b[0] * (at.v[1] * 10.0).tanh() * half])
    }
}

/// The functions that files know.
struct Functions;

impl Cost<2, 0, 1, 2> for Functions {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 1>, b: &SVector<S, 2>) -> S {
        let x = at.q[0] * 0.1 + b[0];
        let sums = x.sqrt() + x.exp() + x.exp_m1() + x.ln() + x.ln_1p() + x.sin() + x.cos() + x.tan();
        let more = (x * 0.1).asin() + (x * 0.1).acos() + x.atan() + x.sinh() + x.cosh() + x.tanh() + x.abs();
        let powers = x.powi(5) + x.powf(2.5) + x.powf(2.0) + x.recip() + x.powi(-3) - x / (at.v[1] + 7.0);
        let two = at.q[0].atan2(x) + at.v[0].max(at.q[1]) + at.v[0].min(x) + at.u[0] * at.u_dot[0] - (-x).max(S::from(-0.0));
        sums * b[1] + more - powers + two
    }
}

pub fn pendulum() -> Scene {
    let mut scene = Scene::new();
    let q = scene.coordinates("arm", ["φ", "ψ"]);
    scene.place(q[0], 0.3);
    let (m, l) = (scene.design("m", 0.7), scene.design("length of it", 0.5));
    let torque = scene.control("torque");
    let b = [1.0.into(), m.into(), 0.4.into(), l * 1.0];
    scene.kinetic_energy("motion", Motion, q, b);
    scene.potential_energy("height", Height, q, b);
    scene.force("brake", Brake(0.3), q, [torque], [0.05.into()]);
    scene.force("another brake", Brake(0.7), [q[1], q[0]], [torque], [(m * l).sqrt()]);
    scene.cost("functions", Functions, Sum::Integral, q, [], [torque], [2.0.into(), m.into()]);
    let miss = scene.output("miss");
    scene.term(miss, "miss", Miss, Sum::Terminal, [q[1]], [], [], [0.3.into()]);
    scene.term(miss, "miss on the way", Miss, Sum::Node(3), [q[0]], [], [], [l.into()]);
    scene
}

/// Without `if_less`, the root of a negative number or a branch on a value.
struct Branches;

impl Force<2, 0, 1> for Branches {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 1>) -> SVector<S, 2> {
        let [x, y] = [at.q[0] - b[0], at.v[1]];
        let side = x.if_less(S::zero(), x * x * y, x.sqrt() * x);
        SVector::from([side, y.if_less(at.t + 5.0, side + x.if_less(y, S::one(), y), y * 3.0)])
    }
}

#[test]
fn both_sides_of_a_branch_come_back_and_have_exact_derivatives() {
    for (start, at) in [(0.1, 0.3), (0.5, 0.3)] {
        let mut scene = Scene::new();
        let q = scene.coordinates("arm", ["φ", "ψ"]);
        scene.place(q[0], start);
        scene.kinetic_energy("motion", Motion, q, [1.0, 0.7, 0.4, 0.5].map(Into::into));
        scene.force("branches", Branches, q, [], [at.into()]);
        scene.cost("miss", Miss, Sum::Integral, [q[1]], [], [], [at.into()]);
        let file = assert_comes_back(scene.clone());
        assert!(file.contains("less(") && file.contains("where("), "{file}");
        let system = scene.compile().expect("a system");
        assert!(system.without_programs().next().is_none(), "it has a program");
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.01));
        inputs.start.rate_mut().copy_from_slice(&[0.3, -0.2]);
        check::gradient(&system, &inputs, Settings::default()).run().expect("a report").assert_passed();
    }
}

#[test]
fn branches_are_read() {
    let part = r#"{"kind": "particle", "name": "free", "mass": 1, "place": [0, 0]}, {"kind": "force", "name": "side", "q": ["free.x"],
        "formula": "if(q[0] < 3, 1, 2) + 10 * if(q[0] <= 1, 1, 2) + 100 * if(1 > q[0], 1, 2) + 1000 * if(q[0] >= 1, 1, 2)"}"#;
    let scene = SceneFile::from_json(&with_part(part)).expect("a scene").complete().expect("everything");
    let system = scene.compile().expect("a system");
    let force = |x: f64| {
        let state = Mechanics::new(&system, &[1.0, 2.0, x, 0.0], &[0.0; 4]).expect("a state");
        state.accelerations().expect("accelerations").0[2]
    };
    assert_eq!([1.0, 0.5, 4.0].map(force), [1211.0, 2111.0, 1222.0]);
}

/// q − b.
struct Miss;

impl Cost<1, 0, 0, 1> for Miss {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] - b[0]
    }
}

/// σ and λ of a hinge, and accelerations.
struct Reaction;

impl ListCost for Reaction {
    fn cost<S: Scalar>(&self, at: &ListPoint<S>) -> S {
        at.lambda.iter().chain(at.sigma).chain(at.v_dot).chain(at.p_star).chain(at.p_star_dot).map(|x| *x * *x).sum()
    }
}

/// Both coordinates on a circle, as two equations.
struct Circle;

impl Constraint<2, 1, 1> for Circle {
    fn phi<S: Scalar>(&self, q: &SVector<S, 2>, b: &SVector<S, 1>, t: S) -> SVector<S, 1> {
        let radius = b[0] * (t * 0.1).cos();
        SVector::from([(q[0] * q[0] + q[1] * q[1] - radius * radius) * 0.5])
    }
}

#[test]
fn formulas_come_back_to_the_last_bit() {
    let file = assert_comes_back(pendulum());
    for part in ["\"like\": \"brake\"", "\"sum\": \"integral\"", "\"node\": 3", "\"output\": \"miss\"", "pow(", "atan2("] {
        assert!(file.contains(part), "{part} is not in {file}");
    }
}

#[test]
fn the_paper_s_example_with_its_cost_is_a_file() {
    for links in [1, 3, 12] {
        assert_comes_back(CartPendulum::with_links(links).scene());
    }
}

#[test]
fn constraints_and_costs_of_multipliers_come_back() {
    let mut scene = Scene::new();
    let radius = scene.design("radius", 1.0);
    scene.gravity(0.0, -9.81);
    let [ball, other] = [("ball", [1.0, 0.0]), ("other", [2.0, 0.0])].map(|(name, place)| scene.particle(name, 0.5, place));
    let on = scene.constraint("on a circle", Circle, ball.coordinates, [radius.into()]);
    let rod = scene.body("rod", 1.0, 0.1, [0.0, 3.0, 0.0]);
    let hinge = scene.revolute("hinge", Body::GROUND.at(0.0, 3.0), rod.at(0.0, 0.0));
    scene.distance("rope", ball.point(), other.point(), 1.0);
    let q = [ball.coordinates, other.coordinates].concat();
    scene.list_cost("reactions", Reaction, Sum::Trapezoidal, &q, &[on[0], hinge[1]], &[], &[]);
    let file = assert_comes_back(scene);
    assert!(file.contains("\"hinge.1\""), "{file}");
}

/// A scene of a particle with this part.
fn with_part(part: &str) -> String {
    format!(
        r#"{{"format": "hamiltonian-adjoint scene", "version": 2, "parts": [
        {{"kind": "design variable", "name": "mass", "value": 0.5}}, {{"kind": "design variable", "name": "t", "value": 0.5}},
        {{"kind": "control", "name": "push"}}, {{"kind": "particle", "name": "ball", "mass": "mass", "place": [1, 2]}},
        {{"kind": "distance", "name": "rope", "a": {{"at": [0, 0]}}, "b": {{"body": "ball", "at": [0, 0]}}, "length": 2.23606797749979}},
        {part}], "left_out": []}}"#
    )
}

#[test]
fn arguments_have_the_names_of_the_scene() {
    let part = r#"{"kind": "force", "name": "drag", "q": ["ball.x"], "formula": "u[push] - 0.1 * mass * v[ball.x] ^ 3 * exp(-t) + `t` * b[t]"},
        {"kind": "cost", "name": "end", "sum": "terminal", "formula": "(q[ball.x] - 1.0)^2 + lambda[rope]^2 + u_dot[push]^2 + v_dot[0]^2"}"#;
    let scene = SceneFile::from_json(&with_part(part)).expect("a scene").complete().expect("everything");
    let file = assert_comes_back(scene.clone());
    assert!(file.contains("\"mass\""), "{file}");
    let system = scene.compile().expect("a system");
    assert!(system.without_programs().next().is_none());
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(5, 0.1));
    inputs.controls.fill(0.3);
    check::gradient(&system, &inputs, Settings::default()).run().expect("a report").assert_passed();
}

#[test]
fn mistakes_in_formulas_are_named_with_their_place() {
    let force = |rest: &str| format!(r#"{{"kind": "force", "name": "drag", "q": ["ball.x"], {rest}}}"#);
    let cases = [
        (force(r#""formula": "v[0] +""#), "`formula`, character 7: the formula ends too early"),
        (force(r#""formula": "v[1]""#), "character 1: no coordinate `1` is defined before this part"),
        (force(r#""formula": "w[0]""#), "`w` is not an argument of such a formula; its arguments are q, v, u, b, t"),
        (force(r#""formula": "lambda[rope]""#), "`lambda` is not an argument of such a formula"),
        (force(r#""formula": "2 ^ q[0]""#), "the exponent must be a number"),
        (force(r#""formula": "weight * 2""#), "no design variable `weight` is defined before this part"),
        (force(r#""formula": ["1.0", "2.0"]"#), "`formula` has 2 components; 1 are expected"),
        (force(r#""formula": "q[ball.y]""#), "`formula` has 1 components; 2 are expected"),
        (force(r#""formula": "$1", "parts": ["q[0"]"#), "part 1, character 3: `]` is missing"),
        (force(r#""formula": "$2", "parts": ["q[0]"]"#), "no part `$2` precedes it"),
        (force(r#""formula": "1.0", "arguments": ["z"]"#), "`arguments`: no design variable `z`"),
        (force(r#""formula": "1.0", "like": "rope""#), "no such element `rope`"),
        (force(r#""formula": "1.0", "u": ["pull"]"#), "no control `pull`"),
        (force(r#""formula": "1.0", "colour": 3"#), "the field `colour` does not exist here"),
        (r#"{"kind": "cost", "name": "J", "sum": "mean", "formula": "1.0"}"#.into(), "`mean` is not one of the sums plain"),
        (r#"{"kind": "cost", "name": "J", "sum": {"nod": 1}, "formula": "1.0"}"#.into(), "`node`, `event` or `after event`"),
        (r#"{"kind": "term", "name": "J", "output": "x", "sum": "plain", "formula": "1.0"}"#.into(), "no output `x`"),
        (r#"{"kind": "constraint", "name": "c", "formula": []}"#.into(), "0 components"),
    ];
    for (part, expected) in cases {
        match SceneFile::from_json(&with_part(&part)) {
            Err(error) => assert_says(&error, &["part 6", expected]),
            Ok(_) => panic!("{part} is read"),
        }
    }
}

#[test]
fn functions_as_text_are_checked() {
    let read = |parts: &[&str], results: &[&str]| hamiltonian_adjoint::TextFunction::read(parts, results, 2);
    let product = read(&["x[0] * x[1]"], &["$1", "sin($1)"]).expect("a function");
    let names = (["a", "b"], ["y", "z"]);
    let hand = |x: &[f64], factor: f64| {
        let cos = (x[0] * x[1]).cos() * factor;
        [[x[1], x[0]], [cos * x[1], cos * x[0]]]
    };
    check::function(&product, names.0, names.1).jacobian(|x| hand(x, 1.0)).run().assert_passed();
    assert!(!check::function(&product, names.0, names.1).jacobian(|x| hand(x, 0.5)).run().passed());
    for (result, expected) in [("x[2]", "x[0] to x[1]"), ("2 * y", "character 5"), ("x[0] +", "ends too early")] {
        assert_says(&read(&[], &[result]).err().expect("a mistake"), &["the function", expected]);
    }
}
