//! SVG of scenes in space: a parallel projection, with the nearer shapes painted over those behind them.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::figure::Figure;
use super::shapes::{self, Shape};
use super::space::{Part, Space};
use super::text::{escaped, number};
use super::vector::{INK, Keys, picture};

/// The direction from which pictures are seen: its angle about the vertical and above the floor, rad.
pub(super) const VIEW: [f64; 2] = [0.6, 0.4];
/// Size of the picture in its own unit of length, and decimals of positions in it.
const SIZE: f64 = 640.0;
const DIGITS: usize = 1;
/// Maximum number of frames of an animated picture.
const MOST_KEYS: usize = 60;
/// The margin relative to the size.
const MARGIN: f64 = 0.05;
/// Number of squares of the floor along the scene.
const SQUARES: f64 = 8.0;
const MOST_SQUARES: f64 = 20.0;
/// The direction of light: to the right, up, and toward the eye.
const LIGHT: [f64; 3] = [-0.34, 0.77, 0.53];
const GRID: &str = "#dddddd";
const METAL: &str = "#a3a9b2";

/// A shape, and its points in some frames: to the right, up, and toward the eye.
struct Item {
    name: String,
    kind: Kind,
    colour: &'static str,
    points: Vec<Vec<Vector3<f64>>>,
}

enum Kind {
    /// One side of a face of a solid is seen.
    Face { is_body: bool, is_solid: bool },
    /// With a width.
    Line(f64),
    /// With a radius.
    Ball(f64),
}

impl Item {
    fn depth(&self) -> f64 {
        let all = || self.points.iter().flatten().map(|point| point.z);
        all().sum::<f64>() / all().count().max(1) as f64
    }

    /// False for a face whose inside is turned to the eye in the first frame.
    fn is_seen(&self) -> bool {
        let points = &self.points[0];
        let next = points.iter().cycle().skip(1);
        let twice_area: f64 = points.iter().zip(next).map(|(a, b)| a.x * b.y - a.y * b.x).sum();
        !matches!(self.kind, Kind::Face { is_solid: true, .. }) || twice_area > 0.0
    }

    /// The brightness of a face in a frame.
    fn light(&self, frame: usize) -> f64 {
        let [a, b, c, ..] = self.points[frame][..] else { return 1.0 };
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or(Vector3::z());
        let toward = if normal.z < 0.0 { -normal } else { normal };
        0.72 + 0.45 * toward.dot(&Vector3::from(LIGHT)).max(0.0)
    }

    /// The attributes that change with the frame.
    fn geometry(&self, frame: usize) -> Vec<(&'static str, String)> {
        let (points, n) = (&self.points[frame], |x: f64| number(x, DIGITS));
        if let Kind::Ball(_) = self.kind {
            return points.iter().flat_map(|at| [("cx", n(at.x)), ("cy", n(at.y))]).collect();
        }
        let texts: Vec<String> = points.iter().map(|at| format!("{} {}", n(at.x), n(at.y))).collect();
        let end = if let Kind::Face { .. } = self.kind { "Z" } else { "" };
        vec![("d", format!("M{}{end}", texts.join("L")))]
    }

    /// The element of the last frame; with a timing, it moves through all of them.
    fn svg(&self, timing: Option<&str>) -> String {
        let (last, colour) = (self.points.len().saturating_sub(1), self.colour);
        let (tag, style) = match self.kind {
            Kind::Face { is_body, .. } => {
                // Moving faces are transparent instead of shaded, because their order does not change.
                let (light, opacity) = if timing.is_some() { (1.0, 0.55) } else { (self.light(last), 0.85) };
                let fill = shaded(colour, light);
                let edge = if is_body { shaded(colour, 0.6) } else { fill.clone() };
                let opacity = if is_body { opacity } else { 1.0 };
                ("path", format!("fill=\"{fill}\" fill-opacity=\"{opacity}\" stroke=\"{edge}\" stroke-linejoin=\"round\""))
            }
            Kind::Line(width) => {
                let width = number(width.max(1.0), 1);
                ("path", format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\""))
            }
            Kind::Ball(radius) => ("circle", format!("r=\"{}\" fill=\"{colour}\"", number(radius.max(2.0), 1))),
        };
        let geometry = self.geometry(last);
        let attributes: String = geometry.iter().map(|(name, value)| format!("{name}=\"{value}\" ")).collect();
        let animate = |timing: &str| {
            let all: Vec<_> = (0..=last).map(|frame| self.geometry(frame)).collect();
            let animate = |(k, (name, _)): (usize, &(&str, String))| {
                let values = all.iter().map(|geometry| geometry[k].1.as_str()).collect::<Vec<_>>().join(";");
                format!("<animate attributeName=\"{name}\" values=\"{values}\" {timing}/>")
            };
            geometry.iter().enumerate().map(animate).collect::<String>()
        };
        let is_moving = self.points.iter().any(|points| *points != self.points[last]);
        let animations = timing.filter(|_| is_moving).map(animate).unwrap_or_default();
        format!("<{tag} {attributes}{style}><title>{}</title>{animations}</{tag}>", escaped(&self.name))
    }
}

/// A scene as it is seen: the axes of the picture (to the right, up, and toward the eye) as rows, and its scale.
struct Eye<'a> {
    space: &'a Space,
    axes: Matrix3<f64>,
    scale: f64,
}

impl<'a> Eye<'a> {
    fn new(space: &'a Space) -> Self {
        let size = (space.bounds[1] - space.bounds[0]).norm().max(space.unit);
        let (up, [right, away]) = (space.up, space.level());
        let ((sin, cos), (rise, run)) = (VIEW[0].sin_cos(), VIEW[1].sin_cos());
        let ahead = away * cos - right * sin;
        let axes = [right * cos + away * sin, up * run + ahead * rise, up * rise - ahead * run];
        Eye { space, axes: Matrix3::from_columns(&axes).transpose(), scale: SIZE / size }
    }

    fn seen(&self, pose: &Isometry3<f64>, at: &Point3<f64>) -> Vector3<f64> {
        let seen = self.axes * ((pose * at) - self.space.bounds[0]) * self.scale;
        seen.map(|x| if x.is_finite() { x } else { 0.0 })
    }

    /// All shapes in some frames. In pictures that move, hinges are lines, which need fewer numbers.
    fn items(&self, frames: &[usize], is_moving: bool) -> Vec<Item> {
        let mut items = Vec::new();
        for group in &self.space.groups {
            let poses: Vec<Isometry3<f64>> = frames.iter().map(|&frame| group.pose(frame)).collect();
            for part in &group.parts {
                let mut add = |points: &[Point3<f64>], kind, colour| {
                    let points = poses.iter().map(|pose| points.iter().map(|at| self.seen(pose, at)).collect()).collect();
                    items.push(Item { name: part.name.clone(), kind, colour, points });
                };
                let is_hinge = matches!(part.shape, Shape::Hinge(..));
                let drawn = if is_moving { part.shape.short(self.space.unit) } else { part.shape.drawn(self.space.unit) };
                let (is_body, is_solid) = (part.trail.is_some(), part.shape.is_solid());
                let (solid, line) = (colour(part, METAL), colour(part, if is_hinge { METAL } else { INK }));
                drawn.faces.iter().for_each(|face| add(face, Kind::Face { is_body, is_solid }, solid));
                drawn.lines.iter().for_each(|(points, width)| add(points, Kind::Line(width * self.scale), line));
                drawn.balls.iter().for_each(|(at, radius)| add(&[*at], Kind::Ball(radius * self.scale), solid));
            }
        }
        for link in &self.space.links {
            let ends = |&frame: &usize| {
                let seen = |(group, at): &(usize, _)| self.seen(&self.space.groups[*group].pose(frame), at);
                link.ends.iter().map(seen).collect()
            };
            let (kind, points) = (Kind::Line(link.width * self.space.unit * self.scale), frames.iter().map(ends).collect());
            items.push(Item { name: link.name.clone(), kind, colour: INK, points });
        }
        items
    }

    /// The lines of the floor below the scene.
    fn floor(&self) -> Vec<Item> {
        let Space { up, bounds: [low, high], floor, .. } = self.space;
        let size = (high - low).amax().max(self.space.unit);
        let (directions, step) = (self.space.level(), size / SQUARES);
        let range = directions.map(|axis| {
            let of_corner = |side: Point3<f64>| axis.dot(&(low + (high - low).component_mul(&side.coords)).coords);
            let half = Isometry3::translation(0.5, 0.5, 0.5);
            let corners = shapes::corners(&half, [1.0; 3]).map(of_corner);
            let [first, last] = corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
            let (first, last) = ((first / step).floor(), (last / step).ceil());
            [first, last.clamp(first + 1.0, first + MOST_SQUARES)]
        });
        let at = |[a, b]: [f64; 2]| {
            let at = up * (floor - 0.015 * size) + (directions[0] * a + directions[1] * b) * step;
            self.seen(&Isometry3::identity(), &at.into())
        };
        let line = |ends: [[f64; 2]; 2]| {
            let points = vec![ends.map(at).to_vec()];
            Item { name: "floor".into(), kind: Kind::Line(1.0), colour: GRID, points }
        };
        let all = |[first, last]: [f64; 2]| (0..=(last - first) as usize).map(move |k| first + k as f64);
        let along = all(range[0]).map(|a| line(range[1].map(|b| [a, b])));
        let across = all(range[1]).map(|b| line(range[0].map(|a| [a, b])));
        along.chain(across).collect()
    }

    /// A picture of items, large enough for the floor and the whole motion.
    fn picture(&self, mut items: Vec<Item>, timing: Option<&str>, title: &str) -> String {
        items.sort_by(|a, b| a.depth().total_cmp(&b.depth()));
        let all: Vec<usize> = (0..self.space.frames).collect();
        let (all, floor) = (self.items(&all, true), self.floor());
        let points = all.iter().chain(&floor).flat_map(|item| item.points.iter().flatten());
        let none = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        let [low, high] = points.fold(none, |[low, high], at| [low.inf(at), high.sup(at)]);
        let margin = MARGIN * SIZE;
        let view = [low.x - margin, low.y - margin, high.x - low.x + 2.0 * margin, high.y - low.y + 2.0 * margin];
        let figure = Figure { view, unit: 1.0, frames: self.space.frames, ..Figure::default() };
        let [floor, items] = [floor, items].map(|items| items.iter().map(|item| item.svg(timing)).collect::<String>());
        picture(&figure, title, [&floor, &items, ""])
    }
}

fn colour(part: &Part, ink: &'static str) -> &'static str {
    if part.colour == shapes::INK { ink } else { part.colour }
}

/// A colour #rrggbb with another brightness.
fn shaded(colour: &str, light: f64) -> String {
    let channel = |k: usize| {
        let value = colour.get(k..k + 2).and_then(|text| u8::from_str_radix(text, 16).ok()).unwrap_or_default();
        format!("{:02x}", (f64::from(value) * light).min(255.0) as u8)
    };
    format!("#{}{}{}", channel(1), channel(3), channel(5))
}

/// A picture of one frame.
pub(super) fn still(space: &Space, frame: usize, title: &str) -> String {
    let eye = Eye::new(space);
    let items = eye.items(&[frame], false).into_iter().filter(Item::is_seen).collect();
    eye.picture(items, None, title)
}

/// All frames in an endless loop. The order of the faces is that of their mean depths.
pub(super) fn animated(space: &Space, times: &[f64], title: &str) -> String {
    match Keys::new(space.frames, times, MOST_KEYS) {
        Some(Keys { frames, timing }) => {
            let eye = Eye::new(space);
            eye.picture(eye.items(&frames, true), Some(&timing), title)
        }
        None => still(space, space.frames.saturating_sub(1), title),
    }
}
