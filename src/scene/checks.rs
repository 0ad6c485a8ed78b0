//! Checks of a scene while it is built. The first error is stored and returned by [`Scene::compile`].

use std::collections::HashSet;

use super::Scene;
use super::ready::Part;
use crate::Error;
use crate::model::{Coordinate, Handle, Param};

impl Scene {
    pub(super) fn check(&mut self, element: &str, kind: &'static str, handles: impl IntoIterator<Item = Handle>) -> bool {
        let foreign = handles.into_iter().any(|handle| !self.parts.scene.owns(&handle));
        if foreign {
            self.report(Error::Foreign { element: element.to_string(), kind });
        }
        !foreign
    }

    pub(super) fn check_params(&mut self, element: &str, params: &[Param]) -> bool {
        let known = params.iter().all(|p| p.belongs_to(self.parts.scene.numbers()));
        if !known {
            self.report(Error::Foreign { element: element.to_string(), kind: "design variable" });
        }
        self.check_finite(params.iter().enumerate().map(|(i, p)| (*p, move || format!("parameter {i} of `{element}`"))));
        known
    }

    /// Reports numbers of a ready-made part that are not finite, by their names in this part.
    pub(super) fn check_part(&mut self, name: &str, part: &Part) {
        let ends = part.points.iter().zip(part.kind.places);
        self.check_finite(ends.flat_map(|(point, end)| point.at.map(|x| (x, move || format!("point `{end}` of `{name}`")))));
        let numbers = part.numbers.iter().zip(part.kind.numbers);
        let of = part.any_axis().map_or_else(|| format!("`{name}`"), |axis| self.along(name, axis));
        let of = &of;
        self.check_finite(numbers.map(|(x, number)| (*x, move || format!("`{number}` of {of}"))));
    }

    fn check_finite<F: Fn() -> String>(&mut self, mut params: impl Iterator<Item = (Param, F)>) {
        if let Some((param, what)) = params.find(|(param, _)| !param.factor().is_finite()) {
            self.report(Error::NotFinite { what: what(), value: param.factor() });
        }
    }

    pub(super) fn check_distinct(&mut self, element: &str, q: &[Coordinate]) -> bool {
        let mut seen = HashSet::new();
        let Some(twice) = q.iter().find(|q| !seen.insert(q.index())) else { return true };
        let coordinate = self.parts.coordinates[twice.index()].clone();
        self.report(Error::RepeatedCoordinate { element: element.to_string(), coordinate });
        false
    }

    /// Reports a parameter that does not satisfy a condition.
    pub(crate) fn require(&mut self, holds: bool, what: &str, value: f64, must_be: &'static str) {
        if !holds {
            self.report(Error::Parameter { what: what.to_string(), value, must_be });
        }
    }

    /// Stores the first error.
    pub(crate) fn report(&mut self, error: Error) {
        self.problem.get_or_insert(error);
    }

    pub(super) fn check_names(&self) -> Result<(), Error> {
        let designs: Vec<&String> = self.parts.designs.iter().map(|(name, _)| name).collect();
        let groups: Vec<&String> = self.parts.groups.iter().map(|(name, _)| name).collect();
        unique("body or coordinate group", groups)?;
        unique("body in space", self.parts.sketch.space.all.iter().map(|body| &body.name).collect())?;
        unique("coordinate", self.parts.coordinates.iter().collect())?;
        unique("element", self.elements.iter().collect())?;
        unique("output", self.parts.outputs.iter().collect())?;
        unique("event", self.parts.events.iter().collect())?;
        unique("cost", self.costs_named.iter().collect())?;
        unique("control", self.parts.controls.iter().collect())?;
        unique("design variable", designs)
    }
}

fn unique(kind: &'static str, names: Vec<&String>) -> Result<(), Error> {
    let mut seen = HashSet::new();
    match names.into_iter().find(|name| !seen.insert(*name)) {
        Some(name) => Err(Error::DuplicateName { kind, name: name.clone() }),
        None => Ok(()),
    }
}
