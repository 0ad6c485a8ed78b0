//! The HTML page: the template with a picture and the script that moves it, and the data of the motion.

use nalgebra::{Isometry3, Point3};

use super::Animation;
use super::figure::scale_of;
use super::isometric::VIEW;
use super::shapes::AXES;
use super::space::{Group, Link, Part, Space};
use super::text::{digits, escaped, list, number, quoted};
use super::vector::{COLOURS, groups, instead, opened, passed, poses};

const TEMPLATE: &str = include_str!("page.html");
/// The script of the picture, by the kind of scene.
const PLANE: &str = include_str!("plane.js");
const SPACE: [&str; 2] = [include_str!("space.html"), include_str!("space.js")];
/// Decimals of Euler parameters.
const DIGITS_OF_TURNS: usize = 4;

pub(super) fn html(animation: &Animation) -> String {
    let Animation { title, times, plots, .. } = animation;
    let (picture, script, shapes) = match &animation.space {
        Some(space) => {
            (filled(SPACE[0], &[("title", escaped(title))]), SPACE[1], in_space(&space.framed(&animation.figure)))
        }
        None => in_plane(animation),
    };
    let plots = plots.iter().map(|plot| {
        format!("{{\"name\":{},\"unit\":{},\"values\":{}}}", quoted(&plot.name), quoted(&plot.unit), list(&plot.values))
    });
    let plots = joined(plots, ",\n");
    let seconds = passed(times).last().and_then(|duration| instead(*duration)).map_or("null".into(), |s| s.to_string());
    let data = format!("{{\"times\":{},\n\"seconds\":{seconds},\n{shapes},\n\"plots\":[{plots}]}}", list(times));
    let texts = [("title", escaped(title)), ("picture", picture), ("script", script.into()), ("data", data)];
    filled(TEMPLATE, &texts)
}

/// The picture of a scene in the plane, its script, and the data of its groups.
fn in_plane(animation: &Animation) -> (String, &'static str, String) {
    let figure = &animation.figure.framed();
    let (groups, [under, above]) = groups(figure);
    let moving: String = groups.iter().map(|group| format!("<g class=\"moving\">{}</g>", group.shapes)).collect();
    let picture = format!(
        "{}<g>{under}</g><g id=\"trails\"></g>{moving}<g>{above}</g></g></svg>",
        opened(figure, &animation.title, "id=\"picture\"")
    );
    let poses = joined(groups.iter().map(poses), ",\n");
    let bodies = joined(groups.iter().map(|group| group.is_body.to_string()), ",");
    let colours = COLOURS.map(quoted).join(",");
    (picture, PLANE, format!("\"poses\":[{poses}],\n\"bodies\":[{bodies}],\n\"colours\":[{colours}]"))
}

/// Writer of lengths in m, or in m times a power of ten.
struct Writer {
    scale: f64,
    digits: usize,
}

/// The data of the groups of a scene in space.
fn in_space(space: &Space) -> String {
    let size = (space.bounds[1] - space.bounds[0]).amax().max(space.unit);
    let scale = scale_of(size);
    let writer = Writer { scale, digits: digits(scale * size) };
    let groups = joined(space.groups.iter().map(|group| writer.group(group, space.unit)), ",\n");
    let links = joined(space.links.iter().map(|link| writer.link(link, space.unit)), ",");
    let [low, high] = space.bounds.map(|at| writer.point(&at));
    let (up, view) = (joined(space.up.iter().map(f64::to_string), ","), joined(VIEW.iter().map(f64::to_string), ","));
    let axes = AXES.map(quoted).join(",");
    let (floor, unit) = (writer.n(space.floor), writer.n(space.unit));
    format!(
        "\"up\":[{up}],\"view\":[{view}],\"bounds\":[[{low}],[{high}]],\"floor\":{floor},\"unit\":{unit},\"axes\":[{axes}],\n\"groups\":[{groups}],\n\"links\":[{links}]"
    )
}

impl Writer {
    fn n(&self, x: f64) -> String {
        if x.is_finite() { number(x * self.scale, self.digits) } else { "null".into() }
    }

    fn point(&self, at: &Point3<f64>) -> String {
        joined(at.iter().map(|x| self.n(*x)), ",")
    }

    fn points(&self, points: &[Point3<f64>]) -> String {
        joined(points.iter().map(|at| self.point(at)), ",")
    }

    /// x, y, z and the Euler parameters in every frame; a single number if one of them does not change.
    fn group(&self, group: &Group, unit: f64) -> String {
        let parts = joined(group.parts.iter().map(|part| self.part(part, unit)), ",");
        let column = |of: &dyn Fn(&Isometry3<f64>) -> String| {
            let values: Vec<String> = group.poses.iter().map(of).collect();
            match &values[..] {
                [first, rest @ ..] if rest.iter().all(|other| other == first) => first.clone(),
                _ => format!("[{}]", values.join(",")),
            }
        };
        let places = (0..3).map(|k| column(&|pose| self.n(pose.translation.vector[k])));
        // The vector part is stored first.
        let turns = [3, 0, 1, 2].map(|k| column(&|pose| number(pose.rotation.coords[k], DIGITS_OF_TURNS)));
        // The pose of a group without shapes is needed only by links, which hold to shapes.
        let poses = if group.parts.is_empty() { "0,0,0,1,0,0,0".into() } else { joined(places.chain(turns), ",") };
        format!("{{\"poses\":[{poses}],\"parts\":[{parts}]}}")
    }

    fn part(&self, part: &Part, unit: f64) -> String {
        let drawn = part.shape.drawn(unit);
        let faces = joined(drawn.faces.iter().map(|face| format!("[{}]", self.points(face))), ",");
        let lines = drawn.lines.iter().map(|(points, width)| format!("[{},{}]", self.n(*width), self.points(points)));
        let balls = drawn.balls.iter().map(|(at, radius)| format!("[{},{}]", self.n(*radius), self.point(at)));
        let mut all = format!("{{\"name\":{},\"colour\":{}", quoted(&part.name), quoted(part.colour));
        for (name, list) in [("faces", faces), ("lines", joined(lines, ",")), ("balls", joined(balls, ","))] {
            if !list.is_empty() {
                all += &format!(",\"{name}\":[{list}]");
            }
        }
        if let Some(trail) = &part.trail {
            all += &format!(",\"trail\":[{}]", self.point(trail));
        }
        all + if part.shape.is_solid() { "}" } else { ",\"flat\":true}" }
    }

    fn link(&self, link: &Link, unit: f64) -> String {
        let [a, b] = link.ends.map(|(group, at)| format!("[{group},{}]", self.point(&at)));
        format!("{{\"name\":{},\"width\":{},\"ends\":[{a},{b}]}}", quoted(&link.name), self.n(link.width * unit))
    }
}

fn joined(texts: impl IntoIterator<Item = String>, with: &str) -> String {
    texts.into_iter().collect::<Vec<_>>().join(with)
}

/// A template with its placeholders replaced; the replacements are not searched for placeholders.
fn filled(template: &str, texts: &[(&str, String)]) -> String {
    let text = |place: &str| texts.iter().find(|(name, _)| *name == place).map_or("", |(_, text)| text);
    let piece = |piece: &str| match piece.split_once("}}") {
        Some((place, rest)) => format!("{}{rest}", text(place)),
        None => piece.to_string(),
    };
    template.split("{{").map(piece).collect()
}
