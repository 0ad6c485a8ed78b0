//! [`Kind`]: a kind of ready-made parts, with the names of its entries, and [`Part`]: the entries of one part.

use super::Scene;
use crate::model::element::Sum;
use crate::model::space::{Marker, Quantity};
use crate::model::{Axis, Control, Coordinate, Event, Frame, Multiplier, Param, Point};

/// What the places are at which a part is attached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// Points of the plane.
    Point,
    /// Bodies and particles in the plane.
    Frame,
    /// Markers of bodies in space.
    Marker,
    /// Bodies in space, each represented by the marker at its origin.
    Body,
}

/// What an entry is that is neither a place nor a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sort {
    Coordinate,
    Axis,
    Event,
    Equation,
    Equations,
    /// 0, 1, 2 …
    Count,
    /// True or false; false if it is missing.
    Flag,
    Quantity,
    Sum,
    /// A number that is no formula.
    Number,
    /// So many numbers that are no formulas.
    Numbers(usize),
    /// A list of names.
    Names,
}

/// An entry that is neither a place nor a number.
#[derive(Clone, Debug)]
pub(crate) enum Entry {
    Coordinate(Coordinate),
    Axis(Axis),
    Event(Event),
    Equations(Vec<Multiplier>),
    Count(usize),
    Flag(bool),
    Quantity(Quantity),
    Sum(Sum),
    Numbers(Vec<f64>),
    Names(Vec<String>),
}

/// A ready-made part.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) kind: &'static Kind,
    /// Points, as many as the kind has places in the plane; a frame without a point is represented by its origin.
    pub(crate) points: Vec<Point>,
    /// Markers, as many as the kind has places in space.
    pub(crate) markers: Vec<Marker>,
    pub(crate) numbers: Vec<Param>,
    pub(crate) control: Option<Control>,
    /// Name and parameters of a ready-made function of time.
    pub(crate) motion: Option<(&'static str, Vec<Param>)>,
    /// The other entries, in the order of the kind.
    pub(crate) more: Vec<Entry>,
}

impl Part {
    /// A part of this kind without entries.
    pub(crate) fn of(kind: &'static Kind) -> Self {
        let (points, markers, numbers, more) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Part { kind, points, markers, numbers, control: None, motion: None, more }
    }

    /// A part at markers.
    pub(crate) fn at_markers(kind: &'static Kind, markers: &[Marker], numbers: &[Param]) -> Self {
        Part { markers: markers.to_vec(), numbers: numbers.to_vec(), ..Part::of(kind) }
    }

    /// A part along an axis.
    pub(crate) fn along(kind: &'static Kind, axis: Axis, numbers: &[Param]) -> Self {
        Part { numbers: numbers.to_vec(), more: vec![Entry::Axis(axis)], ..Part::of(kind) }
    }

    /// The number `i`.
    pub(crate) fn number(&self, i: usize) -> Param {
        self.numbers[i]
    }

    /// The numbers from `first` on.
    pub(crate) fn numbers_from<const N: usize>(&self, first: usize) -> [Param; N] {
        std::array::from_fn(|i| self.numbers[first + i])
    }

    /// Both points.
    pub(crate) fn both(&self) -> [Point; 2] {
        [self.points[0], self.points[1]]
    }

    /// Both markers.
    pub(crate) fn pair(&self) -> [Marker; 2] {
        [self.markers[0], self.markers[1]]
    }

    /// The control that drives the part, for kinds that have a control.
    pub(crate) fn by(&self) -> [Control; 1] {
        self.control.map_or_else(|| unreachable!("a part of this kind has a control"), |control| [control])
    }

    /// The frames of both points.
    pub(crate) fn frames(&self) -> (Frame, Frame) {
        (self.points[0].frame, self.points[1].frame)
    }

    /// All numbers that are no formulas.
    pub(crate) fn fixed_numbers(&self) -> Vec<f64> {
        self.more.iter().flat_map(|entry| if let Entry::Numbers(of) = entry { of.clone() } else { Vec::new() }).collect()
    }

    /// The axis, for parts that have one.
    pub(crate) fn any_axis(&self) -> Option<&Axis> {
        self.more.iter().find_map(|entry| if let Entry::Axis(axis) = entry { Some(axis) } else { None })
    }
}

/// The entries that a part of a kind has, by their sorts.
macro_rules! entries {
    ($($name:ident: $sort:ident($value:ident) -> $type:ty = $result:expr;)*) => {
        impl Part {$(
            pub(crate) fn $name(&self) -> $type {
                let found = self.more.iter().find_map(|entry| if let Entry::$sort($value) = entry { Some($result) } else { None });
                found.unwrap_or_else(|| unreachable!("a part of this kind has this entry"))
            }
        )*}
    };
}

entries! {
    coordinate: Coordinate(q) -> Coordinate = *q;
    axis: Axis(axis) -> &Axis = axis;
    event: Event(event) -> Event = *event;
    equations: Equations(equations) -> &[Multiplier] = equations.as_slice();
    count: Count(count) -> usize = *count;
    flag: Flag(flag) -> bool = *flag;
    quantity: Quantity(quantity) -> Quantity = *quantity;
    sum: Sum(sum) -> Sum = *sum;
    names: Names(names) -> &[String] = names.as_slice();
}

/// A kind of ready-made parts.
#[cfg_attr(not(feature = "files"), expect(dead_code, reason = "read only by `files`"))]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Names of the places at which the part is attached.
    pub(crate) places: &'static [&'static str],
    pub(crate) at: Place,
    /// Names of the numbers; equal names that follow each other are those of one list.
    pub(crate) numbers: &'static [&'static str],
    /// Names of the numbers and lists that a file need not contain if they are 0.
    pub(crate) optional: &'static [&'static str],
    /// Name of the control, if there is one.
    pub(crate) control: Option<&'static str>,
    /// True if the part depends on a function of time.
    pub(crate) moves: bool,
    /// Names and sorts of the other entries. The entry `name` is what the part belongs to, and has no name of its own.
    pub(crate) more: &'static [(&'static str, Sort)],
    /// Adds the elements of a part. As a function of this crate it is compiled once, for all programs that use it.
    pub(crate) add: fn(&mut Scene, &str, &Part),
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Kind {
    /// A kind without places.
    pub(crate) const fn new(name: &'static str, numbers: &'static [&'static str], add: fn(&mut Scene, &str, &Part)) -> Self {
        let (places, at, optional, control, moves, more) = (&[], Place::Point, &[], None, false, &[]);
        Kind { name, places, at, numbers, optional, control, moves, more, add }
    }

    /// A kind between a point of a and a point of b.
    pub(crate) const fn of_points(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind { places: &["a", "b"], ..Kind::new(name, numbers, add) }
    }

    /// A kind between the frames a and b.
    pub(crate) const fn of_frames(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind { at: Place::Frame, ..Kind::of_points(name, numbers, add) }
    }

    /// A kind between the markers a and b.
    pub(crate) const fn of_markers(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind { at: Place::Marker, ..Kind::of_points(name, numbers, add) }
    }

    /// A kind along an axis.
    pub(crate) const fn of_axis(
        name: &'static str,
        numbers: &'static [&'static str],
        add: fn(&mut Scene, &str, &Part),
    ) -> Self {
        Kind::new(name, numbers, add).with(&[("axis", Sort::Axis)])
    }

    pub(crate) const fn driven_by(self, control: &'static str) -> Self {
        Kind { control: Some(control), ..self }
    }

    pub(crate) const fn moving(self) -> Self {
        Kind { moves: true, ..self }
    }

    pub(crate) const fn at(self, places: &'static [&'static str]) -> Self {
        Kind { places, ..self }
    }

    pub(crate) const fn with(self, more: &'static [(&'static str, Sort)]) -> Self {
        Kind { more, ..self }
    }
}
