//! Fig. 1: the layout of the mechanism.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

use hamiltonian_adjoint::scenes::CartPendulum;

use super::{CART, arc, cart, hinge, line, trail};
use crate::error::Error;
use crate::experiment::Experiment;
use crate::flags::shown;
use crate::plot::{Axis, Chart, Colour, Panels, Point, Series, Side, Style, colour};
use crate::table::{Row, Verdict};

/// Angles of the links in the sketch, repeated for longer chains.
const ANGLES: [f64; 3] = [-0.19 * TAU, -0.09 * TAU, -0.16 * TAU];

/// The width in points.
const WIDTH: f64 = 700.0;
/// The link with the dimension line, or the only link.
const DIMENSIONED: usize = 1;

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let links = usize::from(experiment.settings.links);
    let mut series = surroundings();
    let (mut hinge, mut low) = ((0.0, 0.0), 0.0f64);
    for j in 0..links {
        let angle = ANGLES[j % ANGLES.len()];
        let tip = (hinge.0 + angle.cos(), hinge.1 + angle.sin());
        series.extend(link(j, hinge, tip, angle));
        if j == DIMENSIONED.min(links - 1) {
            series.extend(dimension(hinge, tip, experiment.settings.length));
        }
        (hinge, low) = (tip, tip.1.min(low));
    }
    series.push(gravity(experiment.settings.gravity));
    let (left, right) = (-1.65, hinge.0.max(1.75) + 0.3);
    let axis = |label, range| Axis { range: Some(range), ..Axis::linear(label) };
    let (x, y) = (axis("x [link lengths]", (left, right)), axis("y [link lengths]", (low - 0.15, 0.9)));
    let caption = experiment.settings.caption(1, &notes(experiment), false);
    let chart = Chart { x, y, series, caption, framed: false, ..Chart::default() };
    Panels::new(vec![chart.equally_scaled(WIDTH)], 1).save_shapes(stem)?;
    Ok(claims(experiment))
}

/// The rail, the cart, its force and the axes; lengths are in link lengths.
fn surroundings() -> Vec<Series> {
    let floor = -0.5 * CART.1;
    let centre = (0.0, 0.0);
    let origin = (-1.45, 0.3);
    let force = ((-0.95, 0.0), (-0.5 * CART.0, 0.0));
    let middle = (0.5 * (force.0.0 + force.1.0), 0.0);
    vec![
        Series::shape("ground", vec![(-1.55, floor), (1.8, floor)], colour::BLACK, Style::Hatched, 1.0),
        cart(centre, 1.0, colour::SKY, Style::Filled),
        cart(centre, 1.0, colour::BLACK, Style::Line),
        arrow(force.0, force.1, colour::RED).noted("u = F(t)", middle, (0.0, 9.5), Side::Center),
        arrow(origin, (origin.0 + 0.4, origin.1), colour::BLACK),
        arrow(origin, (origin.0, origin.1 + 0.4), colour::BLACK),
        text((origin.0 + 0.47, origin.1), "x", Side::Center),
        text((origin.0, origin.1 + 0.47), "y", Side::Center),
    ]
}

fn arrow(from: Point, to: Point, colour: Colour) -> Series {
    Series::shape("arrow", vec![from, to], colour, Style::Arrow(1), 1.5)
}

fn text(at: Point, words: &str, side: Side) -> Series {
    Series::shape("text", vec![at], colour::BLACK, Style::Line, 0.0).noted(words, at, (0.0, 0.0), side)
}

/// The dimension line below the link.
fn dimension(hinge: Point, tip: Point, length: f64) -> [Series; 2] {
    const AWAY: f64 = 0.14;
    let (across, up) = (AWAY * (tip.1 - hinge.1), -AWAY * (tip.0 - hinge.0));
    let (from, to) = ((hinge.0 + across, hinge.1 + up), (tip.0 + across, tip.1 + up));
    let words = format!("link length {} m (assumed)", shown(length));
    let below = (0.5 * (from.0 + to.0) - 0.6, 0.5 * (from.1 + to.1) - 0.16);
    [Series::shape("dimension", vec![from, to], colour::BLACK, Style::Arrow(2), 0.75), text(below, &words, Side::Center)]
}

/// A link, its centre of mass and its angle against the x axis.
fn link(j: usize, at: Point, tip: Point, angle: f64) -> Vec<Series> {
    let centre = (0.5 * (at.0 + tip.0), 0.5 * (at.1 + tip.1));
    let ((sin, cos), radius) = ((0.5 * angle).sin_cos(), 0.3);
    let middle = (at.0 + radius * cos, at.1 + radius * sin);
    vec![
        trail(vec![at, (at.0 + 0.42, at.1)], colour::BLACK),
        Series::shape("arc", arc(at, radius, angle), colour::BLACK, Style::Line, 0.75).noted(
            format!("φ{}", subscript(j + 1)),
            middle,
            (9.0 * cos, 9.0 * sin),
            Side::Left,
        ),
        line(vec![at, tip], colour::BLUE, 4.0),
        Series::shape("circle", arc(centre, 0.025, TAU), colour::BLACK, Style::Filled, 0.0),
        hinge(at, colour::BLACK),
    ]
}

fn gravity(value: f64) -> Series {
    let (from, to) = ((0.85, 0.7), (0.85, 0.25));
    let words = format!("g = {} m/s² (assumed)", shown(value));
    arrow(from, to, colour::BLACK).noted(words, (0.85, 0.5 * (from.1 + to.1)), (10.0, 0.0), Side::Left)
}

/// Masses and friction in words.
fn notes(experiment: &Experiment) -> String {
    let CartPendulum { cart_mass, link_mass, cart_inertia, link_inertia, rail_friction, hinge_friction, .. } =
        experiment.settings.example();
    format!(
        ": cart of {cart_mass} kg, {cart_inertia} kg m²; links of {link_mass} kg, {link_inertia} kg m²;\n\
         friction of {rail_friction} N s/m on the rail and of {hinge_friction} N m s/rad in one hinge"
    )
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
