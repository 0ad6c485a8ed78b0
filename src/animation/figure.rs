//! [`Figure`]: the shapes of a scene in the frames of its bodies, and the poses of these frames.

use std::collections::HashMap;
use std::ops::{Range, RangeInclusive};

use crate::model::{Drawn, Frame, Owner, Point, Shape};
use crate::{Coordinate, Mechanics, System};

/// The motion, m, below which a mechanism without any length counts as at rest.
pub(super) const ROUNDING: f64 = 1e-12;

/// Unit length of marks, relative to the larger side of the view.
pub(super) const UNIT: f64 = 0.012;
/// Powers of ten of the larger side in m that are drawn without scaling, because pictures use single precision and few digits.
const DRAWN: RangeInclusive<i32> = -3..=5;
/// Limit of the scaling exponent: larger powers of 10 overflow.
const MOST_POWER: i32 = 300;

/// The drawn shapes of a scene and their motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Figure {
    pub(super) bodies: Vec<Piece>,
    /// The marks of joints, each in one frame.
    pub(super) marks: Vec<Mark>,
    /// Shapes between two points.
    pub(super) links: Vec<Link>,
    pub(super) arrows: Vec<Arrow>,
    /// Left, bottom, width and height of the view; lengths are in m, or all in m times a power of ten.
    pub(super) view: [f64; 4],
    pub(super) unit: f64,
    pub(super) frames: usize,
}

/// A body: its outline in its own frame, and x, y, φ in every picture of the animation.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) name: String,
    pub(super) outline: Outline,
    pub(super) poses: Vec<[f64; 3]>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outline {
    /// The convex hull of the points that are fixed to the body.
    Hull(Vec<[f64; 2]>),
    /// A carriage around a point, turned by an angle.
    Carriage([f64; 2], f64),
    Disc,
    /// One of the points of a drawn line.
    Dot,
}

/// A point of a body, or of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) body: Option<usize>,
    pub(super) at: [f64; 2],
}

#[derive(Clone, Debug)]
pub(super) struct Mark {
    pub(super) kind: MarkKind,
    pub(super) place: Place,
    pub(super) name: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MarkKind {
    Hinge,
    /// A rail at an angle, rad.
    Rail(f64),
    Weld,
    /// The surface of a half-plane with its outer normal, rad.
    Surface(f64),
    /// A wheel with a radius, m.
    Wheel(f64),
    /// A wall from the mark's point to another point of the frame.
    Wall([f64; 2]),
    /// A fixed disc with a radius, m.
    Obstacle(f64),
    Target,
}

#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) kind: LinkKind,
    pub(super) ends: [Place; 2],
    pub(super) name: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinkKind {
    Rod,
    Spring,
    Cylinder,
}

/// A force at a point, along an axis of another frame, or a torque; values are relative to the largest of the motion.
#[derive(Clone, Debug)]
pub(super) struct Arrow {
    pub(super) place: Place,
    /// The frame of the axis and its angle there; `None` for a torque.
    pub(super) axis: Option<(Option<usize>, f64)>,
    pub(super) values: Vec<f64>,
    pub(super) name: String,
}

impl Figure {
    pub(super) fn new(system: &System, states: &[Mechanics], controls: &[Vec<f64>]) -> Self {
        let sketch = system.sketch();
        let first = &states[0];
        let owners = sketch.bodies.iter().enumerate().map(|(body, (_, frame))| (frame.owner(), body));
        let owners: HashMap<Owner, usize> = owners.collect();
        let index = |frame: Frame| owners.get(&frame.owner()).copied();
        let place = |point: Point| Place { body: index(point.frame()), at: point.at().map(|x| first.parameter(x)) };
        let poses = |frame: Frame| states.iter().map(|at| frame.place(|q: Coordinate| at.q()[q.index()])).collect();
        let fixed = fixed(sketch.bodies.len(), &sketch.drawn, &place, first);
        let bodies = sketch.bodies.iter().zip(fixed).enumerate().map(|(body, ((name, frame), fixed))| Piece {
            name: name.clone(),
            outline: outline(fixed, sketch.point_masses.contains(&body)),
            poses: poses(*frame),
        });
        let mut figure = Figure {
            bodies: bodies.collect(),
            marks: Vec::new(),
            links: Vec::new(),
            arrows: Vec::new(),
            view: [0.0; 4],
            unit: 0.0,
            frames: states.len(),
        };
        sketch.drawn.iter().for_each(|drawn| figure.add(drawn, &place, (first, controls)));
        figure
    }

    /// The figure with its view, scaled to numbers that pictures can show.
    pub(super) fn framed(&self) -> Self {
        let mut figure = self.clone();
        figure.look();
        let scale = scale_of(figure.view[2].max(figure.view[3]));
        if scale != 1.0 {
            figure.scale(scale);
        }
        figure
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.marks.is_empty() && self.links.is_empty()
    }

    /// Adds a line through moving points, given for every picture.
    pub(super) fn add_line(&mut self, name: &str, frames: &[Vec<[f64; 2]>]) {
        let (first, count) = (self.bodies.len(), frames.first().map_or(0, Vec::len));
        for k in 0..count {
            let poses = frames.iter().map(|points| [points[k][0], points[k][1], 0.0]).collect();
            let outline = if count == 1 { Outline::Disc } else { Outline::Dot };
            self.bodies.push(Piece { name: name.into(), outline, poses });
        }
        for k in first..(first + count).saturating_sub(1) {
            let ends = [k, k + 1].map(|body| Place { body: Some(body), at: [0.0; 2] });
            self.links.push(Link { kind: LinkKind::Rod, ends, name: name.into() });
        }
    }

    /// Adds a mark that is fixed to the ground.
    pub(super) fn add_fixed(&mut self, name: &str, kind: MarkKind, at: [f64; 2]) {
        self.marks.push(Mark { kind, place: Place { body: None, at }, name: name.into() });
    }

    fn add(&mut self, drawn: &Drawn, place: &dyn Fn(Point) -> Place, (first, controls): (&Mechanics, &[Vec<f64>])) {
        let (a, b, name) = (place(drawn.a), place(drawn.b), drawn.name.clone());
        let number = |x| first.parameter(x);
        let mut mark = |kind, place| self.marks.push(Mark { kind, place, name: name.clone() });
        match drawn.shape {
            Shape::Hinge => mark(MarkKind::Hinge, a),
            Shape::Weld => mark(MarkKind::Weld, a),
            Shape::Slider { axis } => mark(MarkKind::Rail(number(axis)), a),
            Shape::Ground { normal } => mark(MarkKind::Surface(number(normal)), a),
            Shape::Wheel { radius } => mark(MarkKind::Wheel(number(radius).abs()), b),
            Shape::Rod => self.links.push(Link { kind: LinkKind::Rod, ends: [a, b], name }),
            Shape::Spring => self.links.push(Link { kind: LinkKind::Spring, ends: [a, b], name }),
            Shape::Cylinder { .. } => self.links.push(Link { kind: LinkKind::Cylinder, ends: [a, b], name }),
            Shape::Force { axis, control } => {
                let values = shares(&controls[control.index()]);
                self.arrows.push(Arrow { place: b, axis: Some((a.body, number(axis))), values, name });
            }
            Shape::Torque { control } => {
                let values = shares(&controls[control.index()]);
                self.arrows.push(Arrow { place: b, axis: None, values, name });
            }
        }
    }

    /// Position of a point in one picture.
    pub(super) fn position(&self, place: Place, frame: usize) -> [f64; 2] {
        let [x, y, phi] = place.body.map_or([0.0; 3], |body| self.bodies[body].poses[frame]);
        let ([along, across], (sin, cos)) = (place.at, phi.sin_cos());
        [x + cos * along - sin * across, y + sin * along + cos * across]
    }

    /// The lower left and the upper right corner of all bodies and marks in some frames; infinite if there are none.
    pub(super) fn extent(&self, frames: Range<usize>) -> [[f64; 2]; 2] {
        let mut places: Vec<Place> = self.marks.iter().map(|mark| mark.place).collect();
        places.extend(self.links.iter().flat_map(|link| link.ends));
        for (body, piece) in self.bodies.iter().enumerate() {
            let points = if let Outline::Hull(points) = &piece.outline { points.as_slice() } else { &[[0.0; 2]] };
            places.extend(points.iter().map(|&at| Place { body: Some(body), at }));
        }
        let places = &places;
        let moving = frames.flat_map(|frame| places.iter().map(move |&place| self.position(place, frame)));
        let of_mark = |mark: &Mark| {
            let [x, y] = self.position(mark.place, 0);
            match mark.kind {
                MarkKind::Wheel(r) | MarkKind::Obstacle(r) => vec![[x - r, y - r], [x + r, y + r]],
                MarkKind::Wall(end) => vec![end],
                _ => Vec::new(),
            }
        };
        corners(moving.chain(self.marks.iter().flat_map(of_mark)))
    }

    /// Determines the view, which contains all bodies and marks at all times and a margin.
    fn look(&mut self) {
        let [[left, bottom], [right, top]] = self.extent(0..self.frames);
        let at_start = self.extent(0..1);
        let (mut width, mut height) = (right - left, top - bottom);
        // Of a mechanism without any length, such a motion is rounding.
        if at_start[0] == at_start[1] && width.max(height) < ROUNDING {
            (width, height) = (0.0, 0.0);
        }
        let size = if width.max(height) > 0.0 { width.max(height) } else { 1.0 };
        let (width, height) = if width.is_finite() { (width, height) } else { (1.0, 1.0) };
        let [left, bottom] = if left.is_finite() { [left, bottom] } else { [0.0; 2] };
        let margin = 0.08 * size;
        // The view is no flatter than 1 to 4, so that marks have room.
        let (wide, high) = ((width + 2.0 * margin).max(0.25 * size), (height + 2.0 * margin).max(0.25 * size));
        self.view = [left + 0.5 * (width - wide), bottom + 0.5 * (height - high), wide, high];
        self.unit = UNIT * size;
    }

    /// Multiplies all lengths by a factor.
    fn scale(&mut self, by: f64) {
        let larger = |lengths: &mut [f64]| lengths.iter_mut().for_each(|x| *x *= by);
        for piece in &mut self.bodies {
            piece.poses.iter_mut().for_each(|[x, y, _]| (*x, *y) = (*x * by, *y * by));
            match &mut piece.outline {
                Outline::Hull(points) => points.iter_mut().for_each(|point| larger(point)),
                Outline::Carriage(at, _) => larger(at),
                Outline::Disc | Outline::Dot => {}
            }
        }
        for mark in &mut self.marks {
            larger(&mut mark.place.at);
            match &mut mark.kind {
                MarkKind::Wheel(radius) | MarkKind::Obstacle(radius) => *radius *= by,
                MarkKind::Wall(end) => larger(end),
                _ => {}
            }
        }
        self.links.iter_mut().flat_map(|link| &mut link.ends).for_each(|end| larger(&mut end.at));
        self.arrows.iter_mut().for_each(|arrow| larger(&mut arrow.place.at));
        larger(&mut self.view);
        self.unit *= by;
    }
}

/// The power of ten by which lengths of this size are multiplied.
pub(super) fn scale_of(size: f64) -> f64 {
    let power = size.log10().floor() as i32;
    if DRAWN.contains(&power) { 1.0 } else { 10f64.powi(-power.clamp(-MOST_POWER, MOST_POWER)) }
}

/// The lower left and the upper right corner of the smallest rectangle that contains all points.
fn corners(points: impl Iterator<Item = [f64; 2]>) -> [[f64; 2]; 2] {
    points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], point| {
        [[0, 1].map(|k| low[k].min(point[k])), [0, 1].map(|k| high[k].max(point[k]))]
    })
}

/// Values relative to the largest; zeros if all are zero.
fn shares(values: &[f64]) -> Vec<f64> {
    let largest = values.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    values.iter().map(|x| if largest > 0.0 { x / largest } else { 0.0 }).collect()
}

/// Points fixed to a body (its centre and points of parts), and point and angle of its first slider.
struct Fixed {
    points: Vec<[f64; 2]>,
    carriage: Option<([f64; 2], f64)>,
}

/// The fixed points of each body.
fn fixed(bodies: usize, drawn: &[Drawn], place: &dyn Fn(Point) -> Place, first: &Mechanics) -> Vec<Fixed> {
    let mut fixed: Vec<Fixed> = (0..bodies).map(|_| Fixed { points: vec![[0.0; 2]], carriage: None }).collect();
    for part in drawn {
        if matches!(part.shape, Shape::Torque { .. } | Shape::Wheel { .. }) {
            continue;
        }
        for (which, point) in [part.a, part.b].into_iter().map(place).enumerate() {
            let Some(of) = point.body.map(|body| &mut fixed[body]) else { continue };
            if let (1, Shape::Slider { axis }) = (which, part.shape) {
                of.carriage = of.carriage.or(Some((point.at, first.parameter(axis))));
            }
            of.points.push(point.at);
        }
    }
    fixed
}

/// The outline of a body, from its fixed points.
fn outline(Fixed { points, carriage }: Fixed, is_point_mass: bool) -> Outline {
    let mut hull = hull(points);
    if let [p, q] = hull[..]
        && [p, q].contains(&[0.0; 2])
        && !is_point_mass
    {
        // A body held at one point is drawn as a rod with its centre in the middle, a point mass at the end of its rod.
        let end = if p == [0.0; 2] { q } else { p };
        hull = vec![end.map(|x| -x), end];
    }
    match carriage {
        _ if hull.len() > 1 => Outline::Hull(hull),
        Some((at, angle)) => Outline::Carriage(at, angle),
        None => Outline::Disc,
    }
}

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup_by(|a, b| (a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-9 * a[0].hypot(a[1]));
    if points.len() < 3 {
        return points;
    }
    let turns = |[o, a, b]: [[f64; 2]; 3]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() > 1 && turns([chain[chain.len() - 2], chain[chain.len() - 1], point]) <= 0.0 {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut points.iter().copied());
    corners.extend(chain(&mut points.iter().rev().copied()));
    corners
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn the_hull_of_some_points_has_their_corners() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(hull([square.as_slice(), &[[0.5, 0.5], [0.5, 0.0], [1.0, 1.0]]].concat()), square);
        assert_eq!(hull(vec![[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]), [[-1.0, 0.0], [1.0, 0.0]]);
        assert_eq!(hull(vec![[2.0, 3.0]; 3]), [[2.0, 3.0]]);
    }
}
