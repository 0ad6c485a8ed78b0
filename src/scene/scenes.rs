//! Ready-made scenes: the paper's example and variants of it.

use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

use crate::model::element::{CostPoint, Sum};
use crate::scene::planar::Body;
use crate::{Control, Cost, Multiplier, Scalar, Scene};

/// Largest number of links: with more, their names would fill the memory before the scene could be rejected.
const MOST_LINKS: usize = 1_000_000;

/// The paper's example (section 4): a cart on a rail with a chain of hanging links, swung up by a force on the cart.
///
/// From the paper: the masses, moments of inertia, friction coefficients, three links hanging at rest and the cost.
/// **Assumed**, since the paper does not state them: `link_length` 1 m with hinges at the ends and the centre of mass in the middle,
/// `gravity` 9.81 m/s², and `friction_joint` 0 (cart and first link).
///
/// The coordinates are (x, y, φ) of the cart, then of link 1, 2, …; the one control is the force on the cart, in N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartPendulum {
    /// The number of links, from 1 to a million.
    pub links: usize,
    /// The mass of the cart, kg.
    pub cart_mass: f64,
    /// The moment of inertia of the cart about its centre, kg m².
    pub cart_inertia: f64,
    /// The mass of a link, kg.
    pub link_mass: f64,
    /// The moment of inertia of a link about its centre, kg m².
    pub link_inertia: f64,
    /// The length of a link, m. Assumed.
    pub link_length: f64,
    /// Viscous friction of the cart on the rail, N s/m.
    pub rail_friction: f64,
    /// Viscous friction in one hinge, N m s/rad.
    pub hinge_friction: f64,
    /// Index of the hinge with friction; 0 is the hinge between cart and first link. Assumed.
    pub friction_joint: usize,
    /// The acceleration of gravity, m/s². Assumed.
    pub gravity: f64,
    /// The angle of the links at the start, rad.
    pub start_angle: f64,
    /// The desired final angle φ_v of the cost, rad.
    pub target_angle: f64,
}

impl Default for CartPendulum {
    fn default() -> Self {
        CartPendulum {
            links: 3,
            cart_mass: 0.8,
            cart_inertia: 0.034,
            link_mass: 0.4,
            link_inertia: 0.083,
            link_length: 1.0,
            rail_friction: 0.5,
            hinge_friction: 0.2,
            friction_joint: 0,
            gravity: 9.81,
            start_angle: -FRAC_PI_2,
            target_angle: FRAC_PI_2,
        }
    }
}

/// The scene of a [`CartPendulum`] and its parts.
#[derive(Debug)]
pub struct CartScene {
    /// The scene, without a cost.
    pub scene: Scene,
    /// The force on the cart, N.
    pub force: Control,
    /// The cart.
    pub cart: Body,
    /// The links, from the cart outwards.
    pub links: Vec<Body>,
    /// The multipliers of the rail.
    pub rail: [Multiplier; 2],
    /// The multipliers of the hinges, from the cart outwards.
    pub hinges: Vec<[Multiplier; 2]>,
}

/// The terminal cost S = ½ (φ − φ_v)²; `b = [φ_v]`.
#[derive(Clone, Copy, Debug)]
pub struct AngleError;

impl Cost<1, 0, 0, 1> for AngleError {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        let error = at.q[0] - b[0];
        error * error * 0.5
    }
}

impl CartPendulum {
    /// The example with `links` links and the paper's other values.
    pub fn with_links(links: usize) -> Self {
        CartPendulum { links, ..CartPendulum::default() }
    }

    /// The scene with the terminal cost S = ½ Σ (φ_j − φ_v)² over the links.
    pub fn scene(&self) -> Scene {
        let CartScene { mut scene, links, .. } = self.mechanism();
        for (j, link) in (1..).zip(links) {
            let name = format!("angle of link {j}");
            scene.cost(&name, AngleError, Sum::Terminal, [link.coordinates[2]], [], [], [self.target_angle.into()]);
        }
        scene
    }

    /// The scene without a cost, with the handles of its parts for a cost or further elements of your own.
    pub fn mechanism(&self) -> CartScene {
        let mut scene = Scene::new();
        let fits = (1..=MOST_LINKS).contains(&self.links);
        scene.require(fits, "the number of links", self.links as f64, "from 1 to a million");
        let count = if fits { self.links } else { 0 };
        let joint = (self.friction_joint as f64, "less than the number of links (0 joins the cart and link 1)");
        scene.require(self.friction_joint < self.links.max(1), "the joint with friction", joint.0, joint.1);
        scene.gravity(0.0, -self.gravity);
        let force = scene.control("force on the cart");
        let cart = scene.body("cart", self.cart_mass, self.cart_inertia, [0.0; 3]);
        let (origin, centre) = (Body::GROUND.at(0.0, 0.0), cart.at(0.0, 0.0));
        let rail = scene.prismatic("rail", origin, 0.0, centre, 0.0);
        scene.sliding_friction("rail friction", origin, 0.0, centre, self.rail_friction);
        scene.actuator("drive", origin, 0.0, centre, force);

        let half = 0.5 * self.link_length;
        let (sin, cos) = self.start_angle.sin_cos();
        let (mut links, mut hinges) = (Vec::new(), Vec::new());
        let (mut inner, mut hinge) = (cart, centre);
        for j in 1..=count {
            let along = (2 * j - 1) as f64 * half;
            let place = [along * cos, along * sin, self.start_angle];
            let link = scene.body(&format!("link {j}"), self.link_mass, self.link_inertia, place);
            hinges.push(scene.revolute(&format!("hinge {j}"), hinge, link.at(-half, 0.0)));
            if j - 1 == self.friction_joint {
                scene.joint_friction(&format!("friction in hinge {j}"), inner, link, self.hinge_friction);
            }
            links.push(link);
            (inner, hinge) = (link, link.at(half, 0.0));
        }
        CartScene { scene, force, cart, links, rail, hinges }
    }
}
