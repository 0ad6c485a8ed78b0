//! Mistakes as a new user makes them, each with the words that its name must contain; nonsense, which must get no name.

use std::f64::consts::PI;

use hamiltonian_adjoint::check::{self, Mistake, Random, Report};
use hamiltonian_adjoint::paper_system::Equation::{F3, F4, F5};
use hamiltonian_adjoint::paper_system::PaperSystem;
use hamiltonian_adjoint::paper_system::Variable::{Q, V};
use hamiltonian_adjoint::{Grid, Inputs, Scalar, Scene, Settings, System, simulate};
use nalgebra::DMatrix;

use super::edit;
use super::elements::*;

/// What was done, in which block, words of which the name must contain one, and the report.
type Case = (&'static str, &'static str, &'static [&'static str], Report);

fn kinetic_energies() -> Vec<Case> {
    let arm = || check::kinetic_energy(&Arm, ARM).coordinates(["φ", "r"]).constants(["J", "m"]);
    let cart = || check::kinetic_energy(&CartPole, CART_POLE).coordinates(["x", "θ"]).constants(["M", "m", "l"]);
    let [_, m] = ARM;
    vec![
        ("J left out", "arm M", &["missing"], arm().mass(|at| [[m * at.q[1] * at.q[1], 0.0], [0.0, m]]).run()),
        (
            "factor 2 of r² forgotten",
            "arm (M v)_q",
            &["½"],
            arm().mass_v_q(|at| [[0.0, m * at.q[1] * at.v[0]], [0.0, 0.0]]).run(),
        ),
        (
            "r² not differentiated",
            "arm (M v)_q",
            &["factor ½ `r`"],
            arm().mass_v_q(|at| [[0.0, m * at.q[1] * at.q[1] * at.v[0]], [0.0, 0.0]]).run(),
        ),
        ("φ̇ for φ̇²", "arm T_q", &["1/v of `φ`"], arm().t_q(|at| [0.0, m * at.q[1] * at.v[0]]).run()),
        (
            "centrifugal term in the wrong row",
            "arm T_q",
            &["exchanged"],
            arm().t_q(|at| [m * at.q[1] * at.v[0] * at.v[0], 0.0]).run(),
        ),
        (
            "coupling forgotten",
            "cart M",
            &["zero where it should not be"],
            cart().mass(|at| edit(cart_pole_mass(&at.q), |m| (m[0][1], m[1][0]) = (0.0, 0.0))).run(),
        ),
        (
            "sine for cosine",
            "cart M",
            &["sine and cosine"],
            cart()
                .mass(|at| {
                    let coupling = CART_POLE[1] * CART_POLE[2] * at.q[1].sin();
                    edit(cart_pole_mass(&at.q), |m| (m[0][1], m[1][0]) = (coupling, coupling))
                })
                .run(),
        ),
        ("sign", "cart T_q", &["sign"], cart().t_q(|at| cart_pole_t_q(&at.q, &at.v).map(|x| -x)).run()),
        (
            "ẋ and θ̇ exchanged",
            "cart (M v)_q",
            &["exchanged", "the value", "used instead"],
            cart().mass_v_q(|at| edit(cart_pole_mass_v_q(&at.q, &at.v), |m| m.swap(0, 1))).run(),
        ),
        (
            "transposed",
            "cart (M v)_q",
            &["transposed"],
            cart()
                .mass_v_q(|at| {
                    let m = cart_pole_mass_v_q(&at.q, &at.v);
                    [[m[0][0], m[1][0]], [m[0][1], m[1][1]]]
                })
                .run(),
        ),
        (
            "symmetric part only",
            "cart (M v)_q",
            &["symmetric part"],
            cart()
                .mass_v_q(|at| {
                    let m = cart_pole_mass_v_q(&at.q, &at.v);
                    let half = 0.5 * (m[0][1] + m[1][0]);
                    [[m[0][0], half], [half, m[1][1]]]
                })
                .run(),
        ),
        (
            "m left out of M + m",
            "cart M",
            &["missing"],
            cart().mass(|at| edit(cart_pole_mass(&at.q), |m| m[0][0] = CART_POLE[0])).run(),
        ),
        (
            "l for l²",
            "cart M",
            &["1/`l`"],
            cart().mass(|at| edit(cart_pole_mass(&at.q), |m| m[1][1] = CART_POLE[1] * CART_POLE[2])).run(),
        ),
        (
            "half of the Coriolis term",
            "cart T_qq",
            &["½"],
            cart()
                .t_qq(|at| {
                    let [_, m, l] = CART_POLE;
                    [[0.0, 0.0], [0.0, -0.5 * m * l * at.q[1].cos() * at.v[0] * at.v[1]]]
                })
                .run(),
        ),
    ]
}

fn potential_energies() -> Vec<Case> {
    let track = || check::potential_energy(&Track, TRACK).coordinates(["x", "θ"]).constants(["k", "h", "l_0", "w", "c"]);
    let stops = || check::potential_energy(&Stops, STOPS).coordinates(["x"]).constants(["k", "l"]);
    let [k, h, free, w, c] = TRACK;
    let [stop, end] = STOPS;
    vec![
        (
            "derivative of the length forgotten",
            "track V_q",
            &["inner derivative"],
            track().v_q(|at| edit(track_q(&at.q), |g| g[0] = k * (track_length(at.q[0]) - free) + c * at.q[1].sin())).run(),
        ),
        (
            "geometric stiffness left out",
            "track V_qq",
            &["product rule", "only one term"],
            track().v_qq(|at| edit(track_qq(&at.q), |m| m[0][0] = k * (at.q[0] / track_length(at.q[0])).powi(2))).run(),
        ),
        (
            "half of the quotient rule",
            "track V_qq",
            &["missing"],
            track()
                .v_qq(|at| {
                    let s = track_length(at.q[0]);
                    edit(track_qq(&at.q), |m| m[0][0] = k * (at.q[0] / s).powi(2) + k * (s - free) / s)
                })
                .run(),
        ),
        (
            "l₀ of last week",
            "track V_q",
            &["`l_0`"],
            track()
                .v_q(|at| {
                    let s = track_length(at.q[0]);
                    edit(track_q(&at.q), |g| g[0] = k * (s - 0.3) * at.q[0] / s + c * at.q[1].sin())
                })
                .run(),
        ),
        (
            "l₀ of last week",
            "track V_qq",
            &["`l_0`"],
            track()
                .v_qq(|at| {
                    let s = track_length(at.q[0]);
                    let xx = k * (at.q[0] / s).powi(2) + k * (s - 0.3) * h * h / s.powi(3);
                    edit(track_qq(&at.q), |m| m[0][0] = xx)
                })
                .run(),
        ),
        (
            "h of last week",
            "track V_q",
            &["`h`"],
            track()
                .v_q(|at| {
                    let s = at.q[0].hypot(0.5);
                    edit(track_q(&at.q), |g| g[0] = k * (s - free) * at.q[0] / s + c * at.q[1].sin())
                })
                .run(),
        ),
        (
            "coupling left out",
            "track V_q",
            &["missing"],
            track().v_q(|at| edit(track_q(&at.q), |g| g[1] = w * at.q[1].sin())).run(),
        ),
        (
            "sign of one term",
            "track V_qq",
            &["sign"],
            track().v_qq(|at| edit(track_qq(&at.q), |m| m[1][1] += 2.0 * c * at.q[0] * at.q[1].sin())).run(),
        ),
        (
            "degrees in both terms",
            "track V_q",
            &["degrees"],
            track()
                .v_q(|at| {
                    let angle = at.q[1] * 180.0 / PI;
                    edit(track_q(&at.q), |g| g[1] = w * angle.sin() + c * at.q[0] * angle.cos())
                })
                .run(),
        ),
        (
            "degrees in one term",
            "track V_q",
            &["degrees"],
            track()
                .v_q(|at| {
                    let angle = at.q[1] * 180.0 / PI;
                    edit(track_q(&at.q), |g| g[1] = w * angle.sin() + c * at.q[0] * at.q[1].cos())
                })
                .run(),
        ),
        ("π/180 in a row", "track V_q", &["degrees"], track().v_q(|at| edit(track_q(&at.q), |g| g[1] *= PI / 180.0)).run()),
        (
            "π/180 in a term",
            "track V_q",
            &["degrees"],
            track()
                .v_q(|at| edit(track_q(&at.q), |g| g[1] = w * at.q[1].sin() + c * at.q[0] * at.q[1].cos() * PI / 180.0))
                .run(),
        ),
        (
            "sine for cosine in a term",
            "track V_q",
            &["sin(`θ`) is used instead of its derivative", "sine and cosine"],
            track().v_q(|at| edit(track_q(&at.q), |g| g[1] = w * at.q[1].sin() + c * at.q[0] * at.q[1].sin())).run(),
        ),
        (
            "sign of |x| forgotten",
            "stops V_q",
            &["inner derivative missing: that of |`x`|"],
            stops().v_q(|at| [stop * (at.q[0].abs() - end).max(0.0)]).run(),
        ),
        (
            "only the upper stop",
            "stops V_q",
            &["only where `x` <"],
            stops().v_q(|at| [stop * (at.q[0] - end).max(0.0)]).run(),
        ),
        ("stiff between the stops too", "stops V_qq", &["only where"], stops().v_qq(|_| [[stop]]).run()),
    ]
}

fn forces() -> Vec<Case> {
    let drag = || check::force(&Drag, DRAG).coordinates(["x", "θ"]).controls(["motor"]).constants(["c", "μ", "ε", "d"]);
    let [c, mu, width, d] = DRAG;
    let slope = move |v: f64| 1.0 - (v / width).tanh().powi(2);
    vec![
        (
            "v for |v|",
            "drag Q_v",
            &["only where v of `x` < 0"],
            drag()
                .q_v(move |at| edit(drag_v(&at.q, &at.v), |m| m[0][0] = -2.0 * c * at.v[0] - mu * slope(at.v[0]) / width))
                .run(),
        ),
        (
            "half of v |v|",
            "drag Q_v",
            &["product rule"],
            drag().q_v(|at| edit(drag_v(&at.q, &at.v), |m| m[0][0] += c * at.v[0].abs())).run(),
        ),
        (
            "1/ε forgotten in one term",
            "drag Q_v",
            &["inner derivative"],
            drag()
                .q_v(move |at| edit(drag_v(&at.q, &at.v), |m| m[0][0] = -2.0 * c * at.v[0].abs() - mu * slope(at.v[0])))
                .run(),
        ),
        (
            "1/ε twice in one term",
            "drag Q_v",
            &["inner derivative squared"],
            drag()
                .q_v(move |at| {
                    edit(drag_v(&at.q, &at.v), |m| {
                        m[0][0] = -2.0 * c * at.v[0].abs() - mu * slope(at.v[0]) / (width * width)
                    })
                })
                .run(),
        ),
        (
            "friction left out",
            "drag Q_v",
            &["missing"],
            drag().q_v(|at| edit(drag_v(&at.q, &at.v), |m| m[0][0] = -2.0 * c * at.v[0].abs())).run(),
        ),
        (
            "derivative of x in u x cos θ forgotten",
            "drag Q_q",
            &["product rule", "missing"],
            drag().q_q(|at| edit(drag_q(&at.q, &at.v, at.u[0]), |m| m[1][0] = -2.0 * d * at.q[0] * at.v[1])).run(),
        ),
        (
            "factor 2 missing in one term",
            "drag Q_q",
            &["½"],
            drag()
                .q_q(|at| {
                    edit(drag_q(&at.q, &at.v, at.u[0]), |m| m[1][0] = -d * at.q[0] * at.v[1] + at.u[0] * at.q[1].cos())
                })
                .run(),
        ),
        (
            "transposed",
            "drag Q_q",
            &["transposed"],
            drag()
                .q_q(|at| {
                    let m = drag_q(&at.q, &at.v, at.u[0]);
                    [[m[0][0], m[1][0]], [m[0][1], m[1][1]]]
                })
                .run(),
        ),
        ("Q_v for Q_q", "drag Q_q", &["Q_v"], drag().q_q(|at| drag_v(&at.q, &at.v)).run()),
        ("sine for cosine", "drag Q_u", &["sine and cosine"], drag().q_u(|at| [0.0, at.q[0] * at.q[1].sin()]).run()),
        (
            "|x| for x in one term",
            "drag Q_q",
            &["only where `x` < 0"],
            drag()
                .q_q(|at| {
                    edit(drag_q(&at.q, &at.v, at.u[0]), |m| {
                        m[1][0] = -2.0 * d * at.q[0].abs() * at.v[1] + at.u[0] * at.q[1].cos();
                    })
                })
                .run(),
        ),
        (
            "nonsense for negative speeds",
            "drag Q_v",
            &["only where v of `θ` < 0"],
            drag()
                .q_v(|at| {
                    edit(drag_v(&at.q, &at.v), |m| {
                        m[1][1] += if at.v[1] < 0.0 { (3.0 * at.q[0]).sin() + at.v[0] } else { 0.0 }
                    })
                })
                .run(),
        ),
    ]
}

fn constraints() -> Vec<Case> {
    let crank = || check::constraint(&Crank, CRANK).coordinates(["x", "φ"]).constants(["r", "l"]);
    let driven = || check::constraint(&Driven, DRIVEN).coordinates(["x", "φ"]).constants(["a", "ω"]);
    let (r, [a, omega]) = (CRANK[0], DRIVEN);
    vec![
        (
            "cos φ of sin² φ forgotten",
            "crank Φ_q",
            &["inner derivative"],
            crank()
                .phi_q(|at| {
                    let [s, _, root] = crank_parts(at.q[1]);
                    [[1.0, r * s + r * r * s / root]]
                })
                .run(),
        ),
        (
            "sign of the second term",
            "crank Φ_q",
            &["sign"],
            crank()
                .phi_q(|at| {
                    let [s, c, root] = crank_parts(at.q[1]);
                    [[1.0, r * s - r * r * s * c / root]]
                })
                .run(),
        ),
        ("second term left out", "crank Φ_q", &["missing"], crank().phi_q(|at| [[1.0, r * at.q[1].sin()]]).run()),
        (
            "only the first term differentiated",
            "crank (Φ_q v)_q",
            &["missing"],
            crank().phi_q_v_q(|at| [[0.0, r * at.q[1].cos() * at.v[1]]]).run(),
        ),
        (
            "half of the quotient rule",
            "crank (Φ_q v)_q",
            &["quotient rule", "product rule"],
            crank()
                .phi_q_v_q(|at| {
                    let [s, c, root] = crank_parts(at.q[1]);
                    [[0.0, at.v[1] * (r * c + r * r * (c * c - s * s) / root)]]
                })
                .run(),
        ),
        (
            "half of sin φ cos φ",
            "crank (Φ_q v)_q",
            &["product rule"],
            crank()
                .phi_q_v_q(|at| {
                    let ([s, _, root], right) = (crank_parts(at.q[1]), crank_q_v_q(&at.q, &at.v));
                    [[0.0, right[1] + at.v[1] * r * r * s * s / root]]
                })
                .run(),
        ),
        ("v for the angle", "crank Φ_q", &["is used instead of"], crank().phi_q(|at| [crank_q(&at.v)]).run()),
        ("ω forgotten", "driven Φ_t", &["`ω`"], driven().phi_t(|at| [-a * (omega * at.t).cos() * at.q[1]]).run()),
        ("Φ_tq left out", "driven (dΦ/dt)_q", &["missing", "zero"], driven().phi_dot_q(|_| [[0.0, 0.0]]).run()),
    ]
}

fn costs() -> Vec<Case> {
    let reach = || check::cost(&Reach, REACH).coordinates(["x", "θ"]).controls(["motor"]).constants(["w", "l", "k"]);
    let [w, l, k] = REACH;
    vec![
        (
            "inner derivative of the exponential forgotten",
            "reach h_q",
            &["inner derivative"],
            reach()
                .h_q(|at| {
                    let x = at.q[0];
                    edit(reach_q(&at.q, at.u[0]), |g| g[0] += (2.0 * k * x + 1.0) * (-k * x * x).exp())
                })
                .run(),
        ),
        (
            "l cos θ forgotten",
            "reach h_q",
            &["inner derivative"],
            reach().h_q(|at| edit(reach_q(&at.q, at.u[0]), |g| g[1] = w * (at.q[0] + l * at.q[1].sin()))).run(),
        ),
        (
            "obstacle left out",
            "reach h_q",
            &["missing"],
            reach()
                .h_q(|at| edit(reach_q(&at.q, at.u[0]), |g| g[0] += 2.0 * k * at.q[0] * (-k * at.q[0] * at.q[0]).exp()))
                .run(),
        ),
        ("x left out", "reach h_u", &["1/`x`"], reach().h_u(|at| [at.u[0]]).run()),
        ("factor 2 forgotten", "reach h_v", &["½"], reach().h_v(|at| [at.v[1] * at.v[1], at.v[0] * at.v[1]]).run()),
        (
            "u² not halved",
            "reach h_q",
            &["factor 2", "term counted twice"],
            reach().h_q(|at| edit(reach_q(&at.q, at.u[0]), |g| g[0] += 0.5 * at.u[0] * at.u[0])).run(),
        ),
    ]
}

fn guided() -> (System, Inputs) {
    let mut scene = Scene::new();
    let q = scene.coordinates("cart", ["x", "θ"]);
    let u = scene.control("motor");
    scene.kinetic_energy("T", CartPole, q, CART_POLE.map(Into::into));
    scene.force("Q", Drag, q, [u], DRAG.map(Into::into));
    scene.constraint("guide", Guide, q, [0.4.into()]);
    let system = scene.compile().expect("scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(30, 0.02));
    inputs.controls.fill(3.0);
    (system, inputs)
}

fn steps() -> Vec<Case> {
    let (system, inputs) = guided();
    let motion = simulate(&system, &inputs, Settings::default()).expect("motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("complete");
    let step = || check::step(&paper);
    let f4_q = |at: &check::StepPoint| {
        let t = at.terms();
        t.force_q + (t.force_v + t.phi_q_t_sigma_q) * at.gamma + t.phi_dot_q_t_sigma_q
    };
    let f3_q =
        |at: &check::StepPoint, factor: f64| at.terms().mass * factor + at.terms().mass_v_q + at.terms().phi_q_t_sigma_q;
    vec![
        (
            "Q_v + T_qv of node i − 1, S of node i",
            "∂f4_i/∂v_(i−1)",
            &["i − 1"],
            step().f_y_previous(F4, V, |at| -(at.terms().phi_q_t_sigma_q + at.previous_terms().force_v)).run(),
        ),
        (
            "S of node i − 1",
            "∂f4_i/∂v_(i−1)",
            &["i − 1"],
            step().f_y_previous(F4, V, |at| -(at.previous_terms().phi_q_t_sigma_q + at.terms().force_v)).run(),
        ),
        (
            "all of node i − 1",
            "∂f4_i/∂v_(i−1)",
            &["i − 1"],
            step().f_y_previous(F4, V, |at| -(at.previous_terms().phi_q_t_sigma_q + at.previous_terms().force_v)).run(),
        ),
        ("Δt for γ in one term", "∂f3_i/∂q_i", &["Δt"], step().f_y(F3, Q, |at| f3_q(at, at.dt)).run()),
        ("Δt/2 for γ in one term", "∂f3_i/∂q_i", &["1/γ"], step().f_y(F3, Q, |at| f3_q(at, 0.5 * at.dt)).run()),
        ("Δt for γ", "∂f5_i/∂q_(i−1)", &["Δt"], step().f_y_previous(F5, Q, |at| at.terms().phi_q * -at.dt).run()),
        (
            "T_q left out",
            "∂f4_i/∂q_i",
            &["T_q"],
            step().f_y(F4, Q, |at| f4_q(at) - at.terms().t_qq - at.terms().t_qv * at.gamma).run(),
        ),
        (
            "γ Q_v left out",
            "∂f4_i/∂q_i",
            &["Q_v"],
            step().f_y(F4, Q, |at| f4_q(at) - (at.terms().force_v - at.terms().t_qv) * at.gamma).run(),
        ),
        (
            "(M v)_q left out",
            "∂f3_i/∂q_i",
            &["(M v)_q"],
            step().f_y(F3, Q, |at| f3_q(at, at.gamma) - at.terms().mass_v_q).run(),
        ),
        (
            "sign of S",
            "∂f4_i/∂v_(i−1)",
            &["sign"],
            step().f_y_previous(F4, V, |at| at.terms().phi_q_t_sigma_q - at.terms().force_v).run(),
        ),
    ]
}

/// x y sin z + exp(x y), x²/(1 + y²) + |z| y, tanh(x − y) z + (x + 2 y)³.
struct Mixture;

impl check::Function for Mixture {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let [x, y, z] = [x[0], x[1], x[2]];
        let quotient = x * x / (y * y + 1.0);
        vec![x * y * z.sin() + (x * y).exp(), quotient + z.abs() * y, (x - y).tanh() * z + (x + y * 2.0).powi(3)]
    }
}

fn mixture(x: &[f64]) -> [[f64; 3]; 3] {
    let ([x, y, z], below) = ([x[0], x[1], x[2]], 1.0 + x[1] * x[1]);
    let (e, t, s) = ((x * y).exp(), (x - y).tanh(), x + 2.0 * y);
    let slope = z * (1.0 - t * t);
    [
        [y * z.sin() + y * e, x * z.sin() + x * e, x * y * z.cos()],
        [2.0 * x / below, -2.0 * x * x * y / (below * below) + z.abs(), y * z.signum()],
        [slope + 3.0 * s * s, -slope + 6.0 * s * s, t],
    ]
}

fn functions() -> Vec<Case> {
    let names = (["x", "y", "z"], ["f", "g", "h"]);
    type Wrong = fn([f64; 3], &mut [[f64; 3]; 3]);
    let made: [(&str, &[&str], Wrong); 20] = [
        ("y forgotten in sin z", &["inner derivative missing"], |[_, y, z], m| m[0][0] += (1.0 - y) * z.sin()),
        ("x of exp(x y) forgotten", &["inner derivative missing"], |[x, y, _], m| m[0][1] += (1.0 - x) * (x * y).exp()),
        ("exp(x y) left out", &["missing"], |[x, y, _], m| m[0][0] -= y * (x * y).exp()),
        ("cos z for sin z in one term", &["sine and cosine"], |[_, y, z], m| m[0][0] += y * (z.cos() - z.sin())),
        ("y for x in one term", &["is used instead of"], |[x, y, z], m| m[0][1] += (y - x) * z.sin()),
        ("z in degrees in one term", &["degrees"], |[_, y, z], m| m[0][0] += y * ((z * 180.0 / PI).sin() - z.sin())),
        ("sin z for cos z", &["sine and cosine"], |[x, y, z], m| m[0][2] = x * y * z.sin()),
        ("square of 1 + y² forgotten", &["(`y`² + 1)"], |[x, y, _], m| {
            let below = 1.0 + y * y;
            m[1][1] += 2.0 * x * x * y / (below * below) - 2.0 * x * x * y / below;
        }),
        ("sign of the quotient rule", &["sign"], |[x, y, _], m| m[1][1] += 4.0 * x * x * y / (1.0 + y * y).powi(2)),
        ("2 y forgotten", &["inner derivative missing"], |[x, y, _], m| {
            m[1][1] += (2.0 * y - 1.0) * x * x / (1.0 + y * y).powi(2);
        }),
        ("quotient rule left out", &["missing"], |[_, _, z], m| m[1][1] = z.abs()),
        ("factor 2 forgotten", &["½"], |_, m| m[1][0] *= 0.5),
        ("z for |z|", &["only where `z` < 0"], |[_, _, z], m| m[1][1] += z - z.abs()),
        ("sign of z forgotten", &["|`z`|"], |[_, y, _], m| m[1][2] = y),
        ("inner factor 2 forgotten", &["½", "inner derivative missing"], |[x, y, _], m| {
            m[2][1] -= 3.0 * (x + 2.0 * y).powi(2)
        }),
        ("sign of tanh", &["sign"], |[x, y, z], m| m[2][1] += 2.0 * z * (1.0 - (x - y).tanh().powi(2))),
        ("tanh for its derivative", &["is used instead of its derivative"], |[x, y, z], m| {
            let t = (x - y).tanh();
            m[2][0] += z * (t - 1.0 + t * t);
        }),
        ("|x| for x in one term", &["only where `x` < 0"], |[x, _, z], m| m[0][1] += (x.abs() - x) * z.sin()),
        ("wrong for large z", &["only where `z` >"], |[x, y, z], m| m[2][2] += if z > 0.3 { x * y } else { 0.0 }),
        ("two rows exchanged", &["exchanged"], |_, m| m.swap(0, 2)),
    ];
    let run = |(mistake, words, wrong): (&'static str, &'static [&'static str], Wrong)| {
        let hand = move |x: &[f64]| edit(mixture(x), |m| wrong([x[0], x[1], x[2]], m));
        (mistake, "mixture f_x", words, check::function(&Mixture, names.0, names.1).jacobian(hand).run())
    };
    made.into_iter().map(run).collect()
}

/// Whether a diagnosis names a mistake, or describes the error only.
fn is_name(found: &check::Diagnosis) -> bool {
    let describes = found.text.starts_with("a factor that is not constant");
    !matches!(found.mistake, Mistake::Unexplained | Mistake::FewDigits) && !describes
}

#[test]
fn mistakes_of_new_users_are_named() {
    let all = [kinetic_energies(), potential_energies(), forces(), constraints(), costs(), steps(), functions()];
    let cases: Vec<Case> = all.into_iter().flatten().collect();
    let (mut right, mut wrong) = (0, 0);
    println!("| # | block | mistake made | diagnosis | |\n|---|---|---|---|---|");
    for (k, (mistake, block, words, report)) in cases.iter().enumerate() {
        assert_eq!(report.verdict(), check::Verdict::Wrong, "{block}: {mistake}");
        let diagnoses = &report.blocks[0].diagnoses;
        let text = diagnoses.iter().map(|found| found.text.as_str()).collect::<Vec<_>>().join("; ");
        let is_named = diagnoses.iter().all(is_name);
        let is_right = is_named && words.iter().any(|words| text.contains(words));
        right += usize::from(is_right);
        wrong += usize::from(is_named && !is_right);
        let mark = if is_right {
            "right"
        } else if is_named {
            "WRONG NAME"
        } else {
            "not named"
        };
        println!("| {} | {block} | {mistake} | {text} | {mark} |", k + 1);
    }
    println!(
        "{} mistakes: {right} named right, {wrong} named wrong, {} not named",
        cases.len(),
        cases.len() - right - wrong
    );
    assert!(right == cases.len(), "{right} of {} named right, {wrong} named wrong", cases.len());
}

/// Right blocks, and what nonsense is made of each: random numbers, another function, a random change of each entry, random constants.
fn nonsense(kind: usize, right: DMatrix<f64>, x: &[f64], seed: u64) -> DMatrix<f64> {
    let (rows, columns) = right.shape();
    let mut of_point = Random::new(x.iter().fold(seed, |hash, x| hash.rotate_left(7) ^ x.to_bits()));
    let mut of_seed = Random::new(seed);
    let mut wave = |_: usize, _: usize| {
        let phase: f64 = x.iter().map(|x| x * of_seed.uniform(-2.0, 2.0)).sum();
        of_seed.uniform(0.5, 2.0) * (phase + of_seed.uniform(0.0, 6.0)).sin()
    };
    match kind {
        0 => right,
        1 => DMatrix::from_fn(rows, columns, |_, _| of_point.uniform(-2.0, 2.0)),
        2 => DMatrix::from_fn(rows, columns, wave),
        3 => &right + DMatrix::from_fn(rows, columns, wave) * 0.3,
        4 => right.component_mul(&DMatrix::from_fn(rows, columns, |i, j| 1.5 + wave(i, j))),
        _ => DMatrix::from_fn(rows, columns, |_, _| of_seed.uniform(-2.0, 2.0)),
    }
}

#[test]
fn nonsense_gets_no_name() {
    let dense = |m: Matrix2| DMatrix::from_fn(2, 2, |i, j| m[i][j]);
    let row = |m: [f64; 2]| DMatrix::from_row_slice(1, 2, &m);
    let names = ["right", "random numbers", "another function", "changed", "another factor", "constants"];
    let (mut blocks, mut named) = (0, 0);
    for seed in 0..12 {
        for (kind, name) in names.iter().enumerate() {
            let of = |right: DMatrix<f64>, x: &[f64]| nonsense(kind, right, x, seed);
            let list = |q: &[f64], v: &[f64]| [q, v].concat();
            let reports = [
                check::kinetic_energy(&CartPole, CART_POLE)
                    .random_points(12, seed)
                    .mass(|at| of(dense(cart_pole_mass(&at.q)), at.q.as_slice()))
                    .mass_v_q(|at| of(dense(cart_pole_mass_v_q(&at.q, &at.v)), &list(at.q.as_slice(), at.v.as_slice())))
                    .t_q(|at| of(row(cart_pole_t_q(&at.q, &at.v)), &list(at.q.as_slice(), at.v.as_slice())))
                    .run(),
                check::potential_energy(&Track, TRACK)
                    .random_points(12, seed)
                    .v_q(|at| of(row(track_q(&at.q)), at.q.as_slice()))
                    .v_qq(|at| of(dense(track_qq(&at.q)), at.q.as_slice()))
                    .run(),
                check::force(&Drag, DRAG)
                    .random_points(12, seed)
                    .q_v(|at| of(dense(drag_v(&at.q, &at.v)), &list(at.q.as_slice(), at.v.as_slice())))
                    .q_q(|at| of(dense(drag_q(&at.q, &at.v, at.u[0])), &list(at.q.as_slice(), at.u.as_slice())))
                    .run(),
                check::constraint(&Crank, CRANK)
                    .random_points(12, seed)
                    .phi_q(|at| of(row(crank_q(&at.q)), at.q.as_slice()))
                    .phi_q_v_q(|at| of(row(crank_q_v_q(&at.q, &at.v)), &list(at.q.as_slice(), at.v.as_slice())))
                    .run(),
                check::cost(&Reach, REACH)
                    .random_points(12, seed)
                    .h_q(|at| of(row(reach_q(&at.q, at.u[0])), at.q.as_slice()))
                    .run(),
            ];
            for block in reports.iter().flat_map(|report| &report.blocks) {
                if kind == 0 {
                    assert_eq!((block.verdict, block.diagnoses.len()), (check::Verdict::Right, 0), "{}", block.name);
                    continue;
                }
                blocks += 1;
                // That an entry should be zero is no name of what was done.
                let is_false = |found: &&check::Diagnosis| is_name(found) && found.mistake != Mistake::NotZero;
                for found in block.diagnoses.iter().filter(is_false) {
                    named += 1;
                    println!("{name}, seed {seed}, {}: {}", block.name, found.text);
                }
            }
        }
    }
    println!("{blocks} blocks of nonsense, {named} false names");
    assert_eq!(named, 0);
}
