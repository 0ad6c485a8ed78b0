//! Ready-made parts from JSON: the entries of every [`Kind`].

use super::fields::{Fields, Read};
use super::lists::EQUATION;
use super::writer::QUANTITIES;
use crate::model::space::{Body, Marker};
use crate::model::{Axis, Param, Point};
use crate::planar::MOTIONS;
use crate::scene::ready::{Entry, Kind, Part, Place, Sort};
use crate::{Scene, planar};

impl Fields<'_> {
    /// The entries of a part of this kind.
    pub(super) fn part(&mut self, kind: &'static Kind, scene: &Scene) -> Read<Part> {
        let mut part = Part::of(kind);
        for place in kind.places {
            match kind.at {
                Place::Point | Place::Frame => part.points.push(self.point(place, kind.at, scene)?),
                Place::Marker | Place::Body => part.markers.push(self.marker(place, kind.at, scene)?),
            }
        }
        for what in kind.numbers.chunk_by(|a, b| a == b) {
            let (name, count) = (what[0], what.len());
            let is_left_out = kind.optional.contains(&name) && !self.all.contains_key(name);
            part.numbers.extend(match (is_left_out, count) {
                (true, _) => vec![0.0.into(); count],
                (false, 1) => vec![self.param(name, scene)?],
                (false, _) => self.params_of(name, count, scene)?,
            });
        }
        part.control = kind.control.map(|what| self.control(what, scene)).transpose()?;
        part.motion = if kind.moves { Some(self.motion(scene)?) } else { None };
        part.more = kind.more.iter().map(|(what, sort)| self.entry(what, *sort, scene)).collect::<Read<_>>()?;
        Ok(part)
    }

    fn motion(&mut self, scene: &Scene) -> Read<(&'static str, Vec<Param>)> {
        let (name, parameters) = (self.text("motion")?, self.params("parameters", scene)?);
        let known = || MOTIONS.map(|(name, _)| name).join(", ");
        let motion = MOTIONS.into_iter().find(|(known, _)| *known == name);
        let (name, wanted) = motion.ok_or_else(|| self.wrong(&format!("`{name}` is not one of the motions {}", known())))?;
        match parameters.len() == wanted {
            true => Ok((name, parameters)),
            false => {
                Err(self.wrong(&format!("a {name} motion has {wanted} parameters, but {} are given", parameters.len())))
            }
        }
    }

    /// The fields of the entry `name`.
    fn within(&mut self, name: &str) -> Read<Self> {
        Fields::of(&format!("{}, `{name}`", self.place), self.get(name)?)
    }

    /// Exactly `count` parameters.
    fn params_of(&mut self, name: &str, count: usize, scene: &Scene) -> Read<Vec<Param>> {
        let params = self.params(name, scene)?;
        let is_right = params.len() == count;
        is_right.then_some(params).ok_or_else(|| self.wrong(&format!("`{name}` must have {count} numbers")))
    }

    fn vector(&mut self, name: &str, scene: &Scene) -> Read<[Param; 3]> {
        let params = self.params_of(name, 3, scene)?;
        Ok(std::array::from_fn(|i| params[i]))
    }

    /// A point of a body, or of the ground if none is named.
    fn point(&mut self, name: &str, sort: Place, scene: &Scene) -> Read<Point> {
        let mut place = self.within(name)?;
        let frame = match place.all.get("body") {
            None => planar::Body::GROUND,
            Some(_) => place.named("body", "body", |name| scene.frame_named(name))?,
        };
        let point = match sort {
            Place::Point => match place.params("at", scene)?[..] {
                [x, y] => frame.at(x, y),
                _ => return Err(place.wrong("`at` must have x and y")),
            },
            _ => frame.origin(),
        };
        place.nothing_more()?;
        Ok(point)
    }

    /// A marker of a body, or of the ground if none is named.
    fn marker(&mut self, name: &str, sort: Place, scene: &Scene) -> Read<Marker> {
        let mut place = self.within(name)?;
        let body = match place.all.get("body") {
            None => Body::GROUND,
            Some(_) => place.named("body", "body in space", |name| scene.body_in_space_named(name))?,
        };
        let mut marker = body.origin();
        let has = |place: &Self, name: &str| sort == Place::Marker && place.all.contains_key(name);
        if has(&place, "at") {
            marker.at = place.vector("at", scene)?;
        }
        if has(&place, "turned") {
            marker = marker.turned(place.vector("turned", scene)?);
        } else if has(&place, "along") {
            let z = place.vector("along", scene)?;
            marker = match has(&place, "toward") {
                true => marker.along_and_toward(z, place.vector("toward", scene)?),
                false => marker.along(z),
            };
        }
        place.nothing_more()?;
        Ok(marker)
    }

    fn axis(&mut self, name: &str, scene: &Scene) -> Read<Axis> {
        if self.get(name)?.is_string() {
            return Ok(self.named(name, "coordinate", |name| scene.coordinate_named(name))?.into());
        }
        let (mut axis, place) = (Axis { q: Vec::new(), factors: Vec::new() }, format!("{}, `{name}`", self.place));
        for term in self.list(name)? {
            let mut term = Fields::of(&place, term)?;
            axis.q.push(term.named("coordinate", "coordinate", |name| scene.coordinate_named(name))?);
            axis.factors.push(term.param("factor", scene)?);
            term.nothing_more()?;
        }
        Ok(axis)
    }

    fn entry(&mut self, name: &str, sort: Sort, scene: &Scene) -> Read<Entry> {
        Ok(match sort {
            Sort::Coordinate => Entry::Coordinate(self.named(name, "coordinate", |name| scene.coordinate_named(name))?),
            Sort::Axis => Entry::Axis(self.axis(name, scene)?),
            Sort::Event => Entry::Event(self.named(name, "event", |name| scene.event_named(name))?),
            Sort::Equation => Entry::Equations(vec![self.named(name, EQUATION, |name| scene.multiplier_named(name))?]),
            Sort::Equations => {
                let names = self.texts(name)?;
                let equation = |name| self.known(EQUATION, name, scene.multiplier_named(name));
                Entry::Equations(names.into_iter().map(equation).collect::<Read<_>>()?)
            }
            Sort::Count => Entry::Count(self.count(name)?),
            Sort::Flag => {
                let flag = if self.all.contains_key(name) { self.get(name)?.as_bool() } else { Some(false) };
                Entry::Flag(flag.ok_or_else(|| self.wrong(&format!("`{name}` must be true or false")))?)
            }
            Sort::Quantity => Entry::Quantity(self.one_of(name, &QUANTITIES)?),
            Sort::Sum => Entry::Sum(self.sum(name)?),
            Sort::Number => Entry::Numbers(vec![self.number(name)?]),
            Sort::Numbers(count) => Entry::Numbers(self.numbers(name, count)?),
            Sort::Names => {
                let names: Option<_> = self.list(name)?.iter().map(|name| name.as_str().map(str::to_string)).collect();
                Entry::Names(names.ok_or_else(|| self.wrong(&format!("`{name}` must be names")))?)
            }
        })
    }

    /// The value whose name is in a field.
    fn one_of<T: Copy>(&mut self, name: &str, all: &[(&str, T)]) -> Read<T> {
        let text = self.text(name)?;
        let known = || all.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", ");
        let found = all.iter().find(|(known, _)| *known == text);
        found.map(|(_, value)| *value).ok_or_else(|| self.wrong(&format!("`{name}` must be one of {}", known())))
    }
}
