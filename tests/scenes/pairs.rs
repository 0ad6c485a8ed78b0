//! Scenes with and without each thing that a scene may lack, all else alike.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{Constraint, Control, Cost, CostPoint, Force, ForcePoint, Param, Scalar, Scene, Sum};
use nalgebra::{SVector, Vector1, Vector2};
use std::f64::consts::{FRAC_PI_2, PI};

use super::elements::{AirDrag, ConstantMass, CoupledArms, minimal};
use super::structures::{ladder, open_ladder};

/// The links of the cart that most rows are made of.
pub const LINKS: usize = 10;

/// One thing, and scenes that differ in it; the first has none of it.
pub struct Comparison {
    pub thing: &'static str,
    pub rows: Vec<(&'static str, Scene)>,
}

/// Every thing that a scene may lack.
pub fn all() -> Vec<Comparison> {
    let compare = |thing, rows| Comparison { thing, rows };
    vec![
        compare("constraints", vec![("without", free_bodies()), ("with", cart(|_| {}))]),
        compare("loops", vec![("without", open_ladder(4)), ("with", ladder(4))]),
        compare(
            "coordinates of a joint",
            vec![
                ("all linear", cart(|cart| rails(cart, 0.0, 0.0))),
                ("a sine", cart(|cart| rails(cart, 0.5, 0.0))),
                ("one nonlinear", cart(|cart| rails(cart, 0.0, 0.1))),
                ("two nonlinear", cart(|cart| rails(cart, 0.5, 0.1))),
            ],
        ),
        compare("mass that depends on q", vec![("without", minimal(ConstantMass)), ("with", minimal(CoupledArms))]),
        compare("forces of v", vec![("without", cart(|_| {})), ("linear", cart(friction)), ("nonlinear", cart(air_drag))]),
        compare("forces of q", vec![("without", cart(|_| {})), ("linear", cart(twists)), ("nonlinear", cart(springs))]),
        compare("control", vec![("without", undriven_cart()), ("with", cart(|_| {}))]),
        compare(
            "ten more controls",
            vec![("without", cart(|_| {})), ("unused", cart(idle_controls)), ("used", cart(motors))],
        ),
        compare(
            "design variables",
            vec![
                ("without", cart(|_| {})),
                ("unused", cart(idle_design)),
                ("one stiffness", cart(bound_stiffness)),
                ("all masses", cart_with_bound_masses()),
            ],
        ),
        compare(
            "running cost",
            vec![
                ("without", cart(|_| {})),
                ("of u", cart(effort)),
                ("of all angles", cart(angles)),
                ("of all accelerations", cart(accelerations)),
            ],
        ),
        compare("time", vec![("without", cart(|_| {})), ("in a force", cart(gusts)), ("in a constraint", shaken_cart())]),
    ]
}

/// A cart with a chain of links on it.
struct Cart {
    scene: Scene,
    cart: Body,
    links: Vec<Body>,
    force: Option<Control>,
}

impl Cart {
    /// The bodies at rest, hanging; a cost on the angles at the end.
    fn bodies(link_mass: impl Fn(&mut Scene) -> Param) -> Self {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let mass = link_mass(&mut scene);
        let cart = scene.body("cart", 0.8, 0.034, [0.0; 3]);
        let place = |j: usize| [0.0, -0.5 - j as f64, -FRAC_PI_2];
        let links: Vec<Body> = (0..LINKS).map(|j| scene.body(&format!("link {j}"), mass, 0.083, place(j))).collect();
        for (j, link) in links.iter().enumerate() {
            let (name, angle) = (format!("angle of link {j}"), link.coordinates[2]);
            scene.cost(&name, AngleError, Sum::Terminal, [angle], [], [], [FRAC_PI_2.into()]);
        }
        Cart { scene, cart, links, force: None }
    }

    fn hinge(&mut self) {
        let mut hook = self.cart.at(0.0, 0.0);
        for (j, link) in self.links.iter().enumerate() {
            self.scene.revolute(&format!("hinge {j}"), hook, link.at(-0.5, 0.0));
            hook = link.at(0.5, 0.0);
        }
    }

    fn rail(&mut self) {
        self.scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, self.cart.at(0.0, 0.0), 0.0);
    }

    fn drive(&mut self) {
        let force = self.scene.control("force on the cart");
        self.scene.actuator("drive", Body::GROUND.at(0.0, 0.0), 0.0, self.cart.at(0.0, 0.0), force);
        self.force = Some(force);
    }

    /// Bodies that follow each other, and a name for what is between them.
    fn neighbours(&self, what: &str) -> Vec<(String, Body, Body)> {
        let pairs = self.links.windows(2).enumerate();
        pairs.map(|(j, pair)| (format!("{what} {j}"), pair[0], pair[1])).collect()
    }
}

fn cart(more: impl FnOnce(&mut Cart)) -> Scene {
    cart_of(|_| 0.4.into(), more)
}

fn cart_of(link_mass: impl Fn(&mut Scene) -> Param, more: impl FnOnce(&mut Cart)) -> Scene {
    let mut cart = Cart::bodies(link_mass);
    cart.rail();
    cart.hinge();
    cart.drive();
    more(&mut cart);
    cart.scene
}

fn free_bodies() -> Scene {
    let mut cart = Cart::bodies(|_| 0.4.into());
    cart.drive();
    cart.scene
}

fn undriven_cart() -> Scene {
    let mut cart = Cart::bodies(|_| 0.4.into());
    cart.rail();
    cart.hinge();
    cart.scene
}

fn shaken_cart() -> Scene {
    let mut cart = Cart::bodies(|_| 0.4.into());
    let [_, y, angle] = cart.cart.coordinates;
    cart.scene.constraint("rail", ShakenRail, [y, angle], [0.02.into(), 25.0.into()]);
    cart.hinge();
    cart.drive();
    cart.scene
}

fn cart_with_bound_masses() -> Scene {
    cart_of(|scene| scene.design("mass of a link", 0.4).into(), |_| {})
}

fn friction(cart: &mut Cart) {
    for (name, a, b) in cart.neighbours("friction") {
        cart.scene.joint_friction(&name, a, b, 0.1);
    }
}

fn air_drag(cart: &mut Cart) {
    for (j, link) in cart.links.iter().enumerate() {
        let [x, y, _] = link.coordinates;
        cart.scene.force(&format!("drag {j}"), AirDrag, [x, y], [], [0.05.into()]);
    }
}

fn twists(cart: &mut Cart) {
    for (name, a, b) in cart.neighbours("torsional spring") {
        cart.scene.torsional_spring_damper(&name, a, b, 0.5, 0.0, 0.0);
    }
}

fn springs(cart: &mut Cart) {
    for (name, a, b) in cart.neighbours("spring") {
        cart.scene.spring_damper(&name, a.at(0.0, 0.0), b.at(0.0, 0.0), 2.0, 1.0, 0.0);
    }
}

/// Every other link keeps a point of it on a curve x + c y² = const.
fn rails(cart: &mut Cart, arm: f64, curvature: f64) {
    for (j, link) in cart.links.iter().enumerate().skip(1).step_by(2) {
        let height = -0.5 - j as f64 - arm;
        let constants = [arm, curvature, -curvature * height * height].map(Param::from);
        cart.scene.constraint(&format!("rail {j}"), CurvedRail, link.coordinates, constants);
    }
}

fn idle_controls(cart: &mut Cart) {
    controls(cart);
}

fn motors(cart: &mut Cart) {
    let controls = controls(cart);
    for ((name, a, b), torque) in cart.neighbours("motor").into_iter().zip(controls) {
        cart.scene.torque_actuator(&name, a, b, torque);
    }
}

fn controls(cart: &mut Cart) -> Vec<Control> {
    (0..LINKS).map(|j| cart.scene.control(&format!("torque {j}"))).collect()
}

fn idle_design(cart: &mut Cart) {
    cart.scene.design("idle", 0.5);
}

fn bound_stiffness(cart: &mut Cart) {
    let stiffness = cart.scene.design("stiffness", 0.5);
    cart.scene.torsional_spring_damper("bound spring", cart.links[0], cart.links[1], stiffness, 0.0, 0.0);
}

fn effort(cart: &mut Cart) {
    if let Some(force) = cart.force {
        cart.scene.cost("effort", Effort, Sum::Trapezoidal, [], [], [force], []);
    }
}

fn angles(cart: &mut Cart) {
    for (j, link) in cart.links.iter().enumerate() {
        let (name, angle) = (format!("angle of link {j} all along"), link.coordinates[2]);
        cart.scene.cost(&name, AngleError, Sum::Trapezoidal, [angle], [], [], [FRAC_PI_2.into()]);
    }
}

/// The square of v̇.
struct Jolt;

impl Cost<1> for Jolt {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.v_dot[0] * at.v_dot[0]
    }
}

fn accelerations(cart: &mut Cart) {
    for (j, link) in cart.links.iter().enumerate() {
        let (name, angle) = (format!("jolt of link {j}"), link.coordinates[2]);
        cart.scene.cost(&name, Jolt, Sum::Trapezoidal, [angle], [], [], []);
    }
}

fn gusts(cart: &mut Cart) {
    let [x, ..] = cart.cart.coordinates;
    cart.scene.force("gusts", Gusts, [x], [], [0.5.into(), PI.into()]);
}

/// Φ = x + s cos φ + c (y + s sin φ)² + d, b = [s, c, d].
struct CurvedRail;

impl Constraint<3, 1, 3> for CurvedRail {
    fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 3>, _t: S) -> Vector1<S> {
        let height = q[1] + b[0] * q[2].sin();
        Vector1::new(q[0] + b[0] * q[2].cos() + b[1] * height * height + b[2])
    }
}

/// h = ½ u².
struct Effort;

impl Cost<0, 0, 1> for Effort {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 0, 0, 1>, _b: &SVector<S, 0>) -> S {
        at.u[0] * at.u[0] * 0.5
    }
}

/// Q = A sin ω t, b = [A, ω].
pub struct Gusts;

impl Force<1, 0, 2> for Gusts {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &Vector2<S>) -> Vector1<S> {
        Vector1::new(b[0] * (b[1] * at.t).sin())
    }
}

/// Φ = (y − A (1 − cos ω t), φ), b = [A, ω].
pub struct ShakenRail;

impl Constraint<2, 2, 2> for ShakenRail {
    fn phi<S: Scalar>(&self, q: &Vector2<S>, b: &Vector2<S>, t: S) -> Vector2<S> {
        let lift = b[0] * (-(b[1] * t).cos() + 1.0);
        Vector2::new(q[0] - lift, q[1])
    }
}
