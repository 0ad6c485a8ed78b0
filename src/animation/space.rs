//! [`Space`]: the shapes of a scene in space, in groups that move as a whole.

use std::ops::Range;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, Translation3, UnitQuaternion, Vector3};

use super::figure::{Figure, ROUNDING, UNIT};
use super::shapes::{AXES, INK, Shape};
use super::vector::COLOURS;
use crate::model::Param;
use crate::model::space::{
    Bodies, Carried, Connection, ConnectionKind, Frame, Inertia, Joint, Matrix, Motion, Vector, principal,
};
use crate::{Mechanics, System};

/// The shapes of a scene in space and their motion.
#[derive(Clone, Debug)]
pub(super) struct Space {
    /// The direction opposite to gravity.
    pub(super) up: Vector3<f64>,
    /// The frames of joints, the ground, and then the bodies in the plane.
    pub(super) groups: Vec<Group>,
    /// Lines between two points that move relative to each other.
    pub(super) links: Vec<Link>,
    /// The lowest and the highest coordinates in the whole motion, m.
    pub(super) bounds: [Point3<f64>; 2],
    /// The height of the lowest point, m.
    pub(super) floor: f64,
    /// Unit length of marks, m.
    pub(super) unit: f64,
    pub(super) frames: usize,
}

/// A frame with its shapes, and its pose in every picture; a single pose if it does not move.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub(super) poses: Vec<Isometry3<f64>>,
    pub(super) parts: Vec<Part>,
}

#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) colour: &'static str,
    pub(super) shape: Shape,
    /// The point of a body that leaves a trail.
    pub(super) trail: Option<Point3<f64>>,
}

#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) name: String,
    /// The width in units of marks.
    pub(super) width: f64,
    /// Groups, and points in them.
    pub(super) ends: [(usize, Point3<f64>); 2],
}

impl Group {
    pub(super) fn pose(&self, frame: usize) -> Isometry3<f64> {
        self.poses.get(frame).or(self.poses.first()).copied().unwrap_or_default()
    }

    fn add(&mut self, name: &str, colour: &'static str, shape: Shape) {
        self.parts.push(Part { name: name.into(), colour, shape, trail: None });
    }
}

impl Space {
    /// The bodies in space; `None` if there are none.
    pub(super) fn new(system: &System, states: &[Mechanics]) -> Option<Self> {
        let bodies = &system.sketch().space;
        if bodies.all.is_empty() {
            return None;
        }
        let number = |x: Param| states[0].parameter(x);
        let gravity = Vector3::from(system.sketch().gravity.map(|g| g.map_or(0.0, number)));
        let poses_of = |frame: usize| poses(states, bodies.frame(frame, &number));
        let moving = (0..bodies.frames.len()).map(|frame| Group { poses: poses_of(frame), parts: Vec::new() });
        let ground = Group { poses: vec![Isometry3::identity()], parts: Vec::new() };
        let mut space = Space {
            up: (-gravity).try_normalize(0.0).unwrap_or(Vector3::z()),
            groups: moving.chain([ground]).collect(),
            links: Vec::new(),
            bounds: [Point3::origin(); 2],
            floor: 0.0,
            unit: UNIT,
            frames: states.len(),
        };
        space.add_bodies(bodies, &number);
        space.add_skeletons(bodies, &number);
        for Joint { name, frames, .. } in &bodies.joints {
            space.add_joint(name, (bodies, frames.clone()), states);
        }
        bodies.connections.iter().for_each(|connection| space.add_connection(connection, bodies, &number));
        Some(space)
    }

    fn group(&mut self, frame: Option<usize>, bodies: &Bodies) -> &mut Group {
        &mut self.groups[frame.unwrap_or(bodies.frames.len())]
    }

    fn add_bodies(&mut self, bodies: &Bodies, number: &dyn Fn(Param) -> f64) {
        for (k, body) in bodies.all.iter().enumerate() {
            let Some(at) = &body.carried else { continue };
            let (group, pose) = (self.group(at.frame, bodies), local(at.turn, at.origin, number));
            match of_inertia(&body.inertia, pose, number) {
                Some(shape) => group.add(&body.name, COLOURS[k % COLOURS.len()], shape),
                None => (0..3).for_each(|axis| group.add(&body.name, AXES[axis], Shape::Axis(pose, axis))),
            }
            group.parts.iter_mut().rev().take(1).for_each(|part| part.trail = Some(part.shape.centre()));
        }
    }

    /// Lines from the joint of a body to the joints of the bodies that it carries, or else to its centre of mass.
    fn add_skeletons(&mut self, bodies: &Bodies, number: &dyn Fn(Param) -> f64) {
        let first_in =
            |frame: usize| bodies.all.iter().position(|body| body.carried.is_some_and(|at| at.frame == Some(frame)));
        for frame in 0..bodies.frames.len() {
            let Some(body) = first_in(frame) else { continue };
            let children = bodies.frames.iter().filter(|child| child.parent == Some(frame));
            let mut ends: Vec<Point3<f64>> = children.map(|child| Point3::from(child.origin.map(number))).collect();
            if ends.is_empty() {
                ends.extend(self.groups[frame].parts.iter().filter_map(|part| part.trail));
            }
            let ends = ends.into_iter().filter(|end| end.coords != Vector3::zeros());
            let lines: Vec<Shape> = ends.map(|end| Shape::Line(vec![Point3::origin(), end], 0.6)).collect();
            let (name, colour) = (&bodies.all[body].name, COLOURS[body % COLOURS.len()]);
            lines.into_iter().for_each(|line| self.groups[frame].add(name, colour, line));
        }
    }

    fn add_joint(&mut self, name: &str, (bodies, frames): (&Bodies, Range<usize>), states: &[Mechanics]) {
        let number = |x: Param| states[0].parameter(x);
        let slides = bodies.frames[frames.clone()].iter().filter(|frame| matches!(frame.motion, Motion::Slide(..))).count();
        for which in frames {
            let Frame { parent, turn, origin, motion, .. } = &bodies.frames[which];
            match motion {
                Motion::Turn(axis, _) => self.groups[which].add(name, INK, Shape::Hinge(Point3::origin(), axis_of(*axis))),
                Motion::Slide(axis, of) if slides == 1 => {
                    let (factor, offset) = (number(of.factor), number(of.offset));
                    let moved = states.iter().map(|at| factor * at.q()[of.coordinate.index()] + offset);
                    let (low, high) = moved.fold((0.0f64, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
                    let (pose, axis) = (local(*turn, *origin, &number), axis_of(*axis));
                    let ends = [low, high].map(|x| pose * Point3::from(axis * x));
                    self.group(*parent, bodies).add(name, INK, Shape::Rail(ends, pose * axis));
                }
                Motion::Ball(_) if slides == 0 => self.groups[which].add(name, INK, Shape::Ball(Point3::origin(), 1.5)),
                Motion::Slide(..) | Motion::Ball(_) => {}
            }
        }
    }

    fn add_connection(&mut self, of: &Connection, bodies: &Bodies, number: &dyn Fn(Param) -> f64) {
        let Connection { name, ends, kind } = of;
        let [a, b] = ends.each_ref().map(|end| local(end.turn, end.origin, number));
        let shape = match kind {
            ConnectionKind::Line(width) => {
                let group = |end: &Carried| end.frame.unwrap_or(bodies.frames.len());
                let ends = [(group(&ends[0]), a * Point3::origin()), (group(&ends[1]), b * Point3::origin())];
                return self.links.push(Link { name: name.clone(), width: *width, ends });
            }
            ConnectionKind::Ball => Shape::Ball(a * Point3::origin(), 1.5),
            ConnectionKind::Hinge => Shape::Hinge(a * Point3::origin(), a * axis_of(2)),
        };
        self.group(ends[0].frame, bodies).add(name, INK, shape);
    }

    /// The scene together with the bodies in the plane, and with its size.
    pub(super) fn framed(&self, figure: &Figure) -> Self {
        let mut space = self.clone();
        let all = space.extent(figure, 0..self.frames);
        let start = space.extent(figure, 0..1);
        let size = (all[1] - all[0]).amax();
        let is_seen = size.is_finite() && (size > ROUNDING || start[0] != start[1] && size > 0.0);
        space.unit = UNIT * if is_seen { size } else { 1.0 };
        space.bounds = if size.is_finite() { all } else { [Point3::origin(); 2] };
        space.add_flat(figure);
        let heights = space.points(0..self.frames).map(|point| point.coords.dot(&self.up));
        let lowest = heights.fold(f64::INFINITY, f64::min);
        space.floor = if lowest.is_finite() { lowest } else { 0.0 };
        space
    }

    /// Two directions of the floor, the first one that of the x axis as far as possible.
    pub(super) fn level(&self) -> [Vector3<f64>; 2] {
        let x = if self.up.x.abs() > 0.9 { Vector3::y() } else { Vector3::x() };
        let right = (x - self.up * self.up.dot(&x)).normalize();
        [right, self.up.cross(&right)]
    }

    /// The points of all shapes and links in some frames.
    fn points(&self, frames: Range<usize>) -> impl Iterator<Item = Point3<f64>> {
        let ends = self.links.iter().flat_map(|link| link.ends);
        let of_links: Vec<Point3<f64>> =
            ends.flat_map(|(group, end)| frames.clone().map(move |frame| self.groups[group].pose(frame) * end)).collect();
        let of_group = move |group: &Group| {
            let points: Vec<Point3<f64>> = group.parts.iter().flat_map(|part| part.shape.points()).collect();
            let frames = if group.poses.len() > 1 { frames.clone() } else { 0..1 };
            let moved =
                frames.flat_map(|frame| points.iter().map(move |point| group.pose(frame) * point).collect::<Vec<_>>());
            moved.collect::<Vec<_>>()
        };
        self.groups.iter().flat_map(of_group).chain(of_links)
    }

    fn extent(&self, figure: &Figure, frames: Range<usize>) -> [Point3<f64>; 2] {
        let flat = figure.extent(frames.clone());
        let flat = flat.into_iter().filter(|at| at[0].is_finite()).map(|[x, y]| Point3::new(x, y, 0.0));
        let none = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
        self.points(frames).chain(flat).fold(none, |[low, high], point| [low.inf(&point), high.sup(&point)])
    }
}

fn axis_of(k: usize) -> Vector3<f64> {
    Vector3::ith(k, 1.0)
}

/// A rotation and an origin.
fn local(turn: Matrix, origin: Vector, number: &dyn Fn(Param) -> f64) -> Isometry3<f64> {
    pose(Matrix3::from_fn(|i, j| number(turn[i][j])), origin.map(number))
}

fn pose(turn: Matrix3<f64>, origin: [f64; 3]) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    Isometry3::from_parts(Translation3::from(origin), turn)
}

/// The poses of a frame. The signs of Euler parameters are those that make them continuous.
fn poses(states: &[Mechanics], place: impl Fn(&[f64]) -> ([f64; 3], [[f64; 3]; 3])) -> Vec<Isometry3<f64>> {
    let mut last = UnitQuaternion::identity();
    let next = |at: &Mechanics| {
        let (origin, axes) = place(at.q());
        let mut next = pose(Matrix3::from_fn(|i, j| axes[j][i]), origin);
        if next.rotation.coords.dot(&last.coords) < 0.0 {
            next.rotation = UnitQuaternion::new_unchecked(-next.rotation.into_inner());
        }
        last = next.rotation;
        next
    };
    states.iter().map(next).collect()
}

/// The homogeneous cuboid with this mass and these moments of inertia, in the frame in which the body is fixed. Its edges a_i along the principal axes
/// follow from J_j + J_k − J_i = m a_i²/6. Point masses are balls; a body without mass is shown by its axes instead (`None`).
fn of_inertia(inertia: &Inertia, body: Isometry3<f64>, number: &dyn Fn(Param) -> f64) -> Option<Shape> {
    let mass = number(inertia.mass);
    if mass <= 0.0 {
        return None;
    }
    let centre = Translation3::from(inertia.centre.map(number));
    let Some(SymmetricEigen { eigenvalues: j, eigenvectors: mut axes }) = principal(inertia.tensor.map(number)) else {
        return Some(Shape::Ball(body * Point3::from(centre.vector), 1.6));
    };
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2));
    }
    let edges = [0, 1, 2].map(|i| (6.0 * (j.sum() - 2.0 * j[i]) / mass).max(0.0).sqrt());
    Some(Shape::Cuboid(body * centre * pose(axes, [0.0; 3]), edges))
}
