//! Fig. 1: the layout of the mechanism.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

use hamiltonian_adjoint::scenes::CartPendulum;

use super::CART;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::plot::{Point, Scene, SceneChart, Shape, colour};
use crate::table::{Row, Verdict};

/// Angles of the links in the sketch, repeated for longer chains.
const ANGLES: [f64; 3] = [-0.19 * TAU, -0.09 * TAU, -0.16 * TAU];

/// The length of a link in points.
const UNIT: f64 = 150.0;
/// Where the last line of the notes is.
const LOWEST_NOTE: f64 = -2.2;
/// The link that carries the dimension, or the only one.
const DIMENSIONED: usize = 1;

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let links = usize::from(experiment.settings.links);
    let mut shapes = cart();
    let (mut hinge, mut low) = ((0.0, 0.0), LOWEST_NOTE);
    for j in 0..links {
        let angle = ANGLES[j % ANGLES.len()];
        let tip = (hinge.0 + angle.cos(), hinge.1 + angle.sin());
        shapes.extend(link(j, hinge, tip, angle));
        if j == DIMENSIONED.min(links - 1) {
            shapes.extend(dimension(hinge, tip, experiment.settings.length));
        }
        (hinge, low) = (tip, tip.1.min(low));
    }
    shapes.extend(notes(experiment));
    let (left, right) = (-1.65, hinge.0.max(1.75) + 0.3);
    let range = Some(((left, low - 0.15), (right, 0.9)));
    let scenes = vec![Scene { title: String::new(), shapes }];
    let chart = SceneChart { scenes, range, width: (UNIT * (right - left)).min(2000.0), ..SceneChart::default() };
    chart.save(stem)?;
    Ok(claims(experiment))
}

/// The rail, the cart, its force and the axes; lengths are in link lengths.
fn cart() -> Vec<Shape> {
    let floor = -0.5 * CART.1;
    let centre = (0.0, 0.0);
    let origin = (-1.45, 0.3);
    vec![
        Shape::ground((-1.55, floor), (1.8, floor)),
        Shape::rectangle(centre, CART, colour::SKY, true),
        Shape::rectangle(centre, CART, colour::BLACK, false),
        Shape::arrow((-0.95, 0.0), (-0.5 * CART.0, 0.0), colour::RED, "u = F(t)"),
        Shape::arrow(origin, (origin.0 + 0.4, origin.1), colour::BLACK, ""),
        Shape::arrow(origin, (origin.0, origin.1 + 0.4), colour::BLACK, ""),
        Shape::text((origin.0 + 0.47, origin.1), "x"),
        Shape::text((origin.0, origin.1 + 0.47), "y"),
    ]
}

/// The length below the link.
fn dimension(hinge: Point, tip: Point, length: f64) -> [Shape; 2] {
    const AWAY: f64 = 0.14;
    let (across, up) = (AWAY * (tip.1 - hinge.1), -AWAY * (tip.0 - hinge.0));
    let (from, to) = ((hinge.0 + across, hinge.1 + up), (tip.0 + across, tip.1 + up));
    let words = format!("link length {length} m (assumed)");
    let below = (0.5 * (from.0 + to.0) - 0.6, 0.5 * (from.1 + to.1) - 0.16);
    [Shape::dimension(from, to), Shape::text(below, &words)]
}

/// A link, its centre of mass and its angle against the x axis.
fn link(j: usize, hinge: Point, tip: Point, angle: f64) -> Vec<Shape> {
    let centre = (0.5 * (hinge.0 + tip.0), 0.5 * (hinge.1 + tip.1));
    let reference = vec![hinge, (hinge.0 + 0.42, hinge.1)];
    vec![
        Shape::trail(reference, colour::BLACK),
        Shape::angle(hinge, 0.3, angle, &format!("φ{}", subscript(j + 1))),
        Shape::line(vec![hinge, tip], colour::BLUE, 4.0),
        Shape::disc(centre, 0.025, colour::BLACK),
        Shape::hinge(hinge, colour::BLACK),
    ]
}

/// Gravity; masses and friction in words.
fn notes(experiment: &Experiment) -> Vec<Shape> {
    let example = experiment.settings.example();
    let lines = [
        format!("cart: {} kg, {} kg m²", example.cart_mass, example.cart_inertia),
        format!("each link: {} kg, {} kg m²", example.link_mass, example.link_inertia),
        format!("friction on the rail: {} N s/m", example.rail_friction),
        format!("friction in hinge {} (assumed): {} N m s/rad", example.friction_joint + 1, example.hinge_friction),
    ];
    let row = |row: u32, line: &String| Shape::text((-0.72, LOWEST_NOTE + 0.14 * f64::from(3 - row)), line);
    let gravity = format!("g = {} m/s² (assumed)", example.gravity);
    let down = Shape::arrow((0.85, 0.7), (0.85, 0.25), colour::BLACK, &gravity);
    (0..).zip(&lines).map(|(index, line)| row(index, line)).chain([down]).collect()
}

/// The number in subscript digits.
fn subscript(number: usize) -> String {
    let digit = |digit: char| digit.to_digit(10).and_then(|d| char::from_u32(0x2080 + d)).unwrap_or(digit);
    number.to_string().chars().map(digit).collect()
}

fn claims(experiment: &Experiment) -> Vec<Row> {
    let example = experiment.settings.example();
    let same = example.links == 3 && example.start_angle == -FRAC_PI_2 && example.target_angle == FRAC_PI_2;
    let CartPendulum { links, cart_mass, link_mass, cart_inertia, link_inertia, rail_friction, hinge_friction, .. } =
        example;
    let (n, m) = (experiment.system.n(), experiment.system.m());
    vec![Row::new(
        "Fig. 1",
        "mechanism: cart, links, masses, inertias, friction, start at rest",
        "3 links; 0.8 and 0.4 kg; 0.034 and 0.083 kg m²; 0.5 N s/m, 0.2 N m s/rad; φ = −π/2",
        format!(
            "{links} links; {cart_mass} and {link_mass} kg; {cart_inertia} and {link_inertia} kg m²; {rail_friction} N s/m, \
             {hinge_friction} N m s/rad; φ = −π/2; n = {n}, m = {m}"
        ),
        Verdict::reproduced_if(same),
    )]
}
