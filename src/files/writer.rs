//! [`Writer`]: ready-made parts as JSON, the entries of every kind.

use serde_json::{Map, Value, json};

use super::sums::write_sum;
use crate::model::space::{Axes, Body, Marker, Quantity};
use crate::model::{Axis, Control, Coordinate, Event, Multiplier, Param, Point};
use crate::scene::Summed;
use crate::scene::ready::{Entry, Part, Place, Referred, Sizes, Sort};
use crate::{Scene, planar};

pub(super) const QUANTITIES: [(&str, Quantity); 8] = [
    ("position", Quantity::Position),
    ("velocity", Quantity::Velocity),
    ("acceleration", Quantity::Acceleration),
    ("x axis", Quantity::XAxis),
    ("y axis", Quantity::YAxis),
    ("z axis", Quantity::ZAxis),
    ("angular velocity", Quantity::AngularVelocity),
    ("angular acceleration", Quantity::AngularAcceleration),
];

/// The parts of a scene that a file contains so far. Later parts can refer to these only; what refers to others cannot be written.
pub(super) struct Writer<'a> {
    scene: &'a Scene,
    designs: Vec<&'a str>,
    /// For each of what parts can refer to, true if it is in the file.
    has: [Vec<bool>; 6],
}

/// Zero with a positive sign, which a file need not contain.
fn is_zero(param: &Param) -> bool {
    param.constant().is_some_and(|value| value.to_bits() == 0)
}

impl<'a> Writer<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Writer { scene, designs: scene.design_names(), has: Default::default() }
    }

    /// Records whether the file contains the part after which the scene has these sizes.
    pub(super) fn advance(&mut self, sizes: Sizes, is_written: bool) {
        self.has.iter_mut().zip(sizes).for_each(|(has, size)| has.resize(size, is_written));
    }

    fn has(&self, which: Referred, index: usize) -> Option<()> {
        self.has[which as usize].get(index).is_some_and(|has| *has).then_some(())
    }

    fn param(&self, param: &Param) -> Option<Value> {
        match param.constant() {
            Some(number) => Some(json!(number)),
            None => param.text(&self.designs).map(Value::String),
        }
    }

    fn params(&self, params: &[Param]) -> Option<Value> {
        params.iter().map(|param| self.param(param)).collect::<Option<_>>().map(Value::Array)
    }

    fn coordinate(&self, of: Coordinate) -> Option<&'a str> {
        self.has(Referred::Coordinate, of.index())?;
        Some(self.scene.coordinate_name(of))
    }

    fn control(&self, of: Control) -> &'a str {
        self.scene.control_name(of)
    }

    fn equation(&self, of: Multiplier) -> Option<Value> {
        self.has(Referred::Equation, of.index())?;
        Some(json!(self.scene.multiplier_name(of.index())))
    }

    fn event(&self, of: Event) -> Option<&'a str> {
        self.has(Referred::Event, of.index())?;
        Some(self.scene.event_name(of))
    }

    fn point(&self, place: Place, point: &Point) -> Option<Value> {
        let mut at = Map::new();
        if point.frame != planar::Body::GROUND {
            point.frame.own_coordinates().into_iter().try_for_each(|q| self.has(Referred::Coordinate, q.index()))?;
            at.insert("body".into(), json!(self.scene.frame_name(point.frame)?));
        }
        if place == Place::Point {
            at.insert("at".into(), self.params(&point.at)?);
        }
        Some(Value::Object(at))
    }

    fn marker(&self, marker: &Marker) -> Option<Value> {
        let mut at = Map::new();
        if let Body(Some(body)) = marker.body {
            self.has(Referred::BodyInSpace, body.index)?;
            at.insert("body".into(), json!(self.scene.name_of_body_in_space(body.index)));
        }
        if !marker.at.iter().all(is_zero) {
            at.insert("at".into(), self.params(&marker.at)?);
        }
        match &marker.axes {
            Axes::OfBody => {}
            Axes::Turned(angles) => drop(at.insert("turned".into(), self.params(angles)?)),
            Axes::Along(z) => drop(at.insert("along".into(), self.params(z)?)),
            Axes::Toward(z, x) => {
                at.insert("along".into(), self.params(z)?);
                at.insert("toward".into(), self.params(x)?);
            }
        }
        Some(Value::Object(at))
    }

    fn axis(&self, axis: &Axis) -> Option<Value> {
        if let ([q], [factor]) = (&axis.q[..], &axis.factors[..])
            && factor.constant() == Some(1.0)
        {
            return self.coordinate(*q).map(Value::from);
        }
        let term = |(q, factor): (&Coordinate, &Param)| {
            Some(json!({ "coordinate": self.coordinate(*q)?, "factor": self.param(factor)? }))
        };
        axis.q.iter().zip(&axis.factors).map(term).collect::<Option<_>>().map(Value::Array)
    }

    fn entry(&self, sort: Sort, entry: &Entry) -> Option<Value> {
        Some(match entry {
            Entry::Coordinate(q) => json!(self.coordinate(*q)?),
            Entry::Axis(axis) => self.axis(axis)?,
            Entry::Event(event) => json!(self.event(*event)?),
            Entry::Equations(of) if sort == Sort::Equation => self.equation(*of.first()?)?,
            Entry::Equations(of) => of.iter().map(|of| self.equation(*of)).collect::<Option<_>>().map(Value::Array)?,
            Entry::Count(count) => json!(count),
            Entry::Flag(flag) => json!(flag),
            Entry::Quantity(of) => json!(QUANTITIES.iter().find(|(_, known)| known == of)?.0),
            Entry::Numbers(of) => {
                if let (Sort::Number, [x]) = (sort, &of[..]) {
                    json!(x)
                } else {
                    json!(of)
                }
            }
            Entry::Names(names) => json!(names),
            Entry::Sum(of) => write_sum(*of),
        })
    }

    /// A part as JSON; `None` if a file cannot contain it.
    pub(super) fn part(&self, name: &str, part: &Part) -> Option<Value> {
        let (kind, mut entry) = (part.kind, Map::new());
        entry.insert("kind".into(), json!(kind.name));
        entry.insert("name".into(), json!(name));
        for (place, point) in kind.places.iter().zip(&part.points) {
            entry.insert((*place).into(), self.point(kind.at, point)?);
        }
        for (place, marker) in kind.places.iter().zip(&part.markers) {
            entry.insert((*place).into(), self.marker(marker)?);
        }
        let mut numbers = part.numbers.iter();
        for what in kind.numbers.chunk_by(|a, b| a == b) {
            let own: Vec<Param> = numbers.by_ref().take(what.len()).copied().collect();
            if !(kind.optional.contains(&what[0]) && own.iter().all(is_zero)) {
                entry.insert(what[0].into(), if let [number] = &own[..] { self.param(number)? } else { self.params(&own)? });
            }
        }
        if let (Some(what), Some(control)) = (kind.control, part.control) {
            entry.insert(what.into(), json!(self.control(control)));
        }
        if let Some((motion, parameters)) = &part.motion {
            entry.insert("motion".into(), json!(motion));
            entry.insert("parameters".into(), self.params(parameters)?);
        }
        for ((what, sort), more) in kind.more.iter().zip(&part.more).filter(|(_, more)| !matches!(more, Entry::Flag(false)))
        {
            entry.insert((*what).into(), self.entry(*sort, more)?);
        }
        Some(Value::Object(entry))
    }

    fn has_all(&self, which: Referred, of: &[usize]) -> Option<()> {
        of.iter().try_for_each(|index| self.has(which, *index))
    }

    /// A user-defined element as JSON; `None` if a file cannot contain it.
    pub(super) fn element(&self, place: (usize, usize)) -> Option<Value> {
        self.has_all(Referred::Coordinate, &self.scene.element(place).to.q)?;
        let mut element = self.scene.write_element(place, &|param| self.param(param))?;
        let like = element.get("like").and_then(Value::as_str).map(|like| self.scene.number_of_element(like));
        if like.is_some_and(|like| self.has(Referred::Element, like).is_none()) {
            element.as_object_mut()?.remove("like");
        }
        Some(element)
    }

    /// A user-defined cost, term or event as JSON; `None` if a file cannot contain it.
    pub(super) fn function(&self, which: usize) -> Option<Value> {
        let (cost, of) = self.scene.function(which);
        self.has_all(Referred::Coordinate, &cost.of.to.q)?;
        self.has_all(Referred::Equation, &cost.of.to.sigma)?;
        if let Summed::Term(output, _) = of {
            self.has(Referred::Output, output.index())?;
        }
        self.scene.write_function(which, &|param| self.param(param))
    }
}
