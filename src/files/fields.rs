//! [`Fields`]: an entry of a scene file, whose fields are read by name.

use serde_json::{Map, Value};

use crate::model::{Control, Coordinate, Param};
use crate::text::Mistake;
use crate::{Error, Scene};

pub(super) type Read<T> = Result<T, Error>;

/// The fields of an entry, and the names of those that were read.
pub(super) struct Fields<'a> {
    pub(super) place: String,
    pub(super) all: &'a Map<String, Value>,
    asked: Vec<String>,
}

impl<'a> Fields<'a> {
    pub(super) fn of(place: &str, value: &'a Value) -> Result<Self, Error> {
        let all = value.as_object().ok_or_else(|| wrong(place, "an object { … } is expected"))?;
        Ok(Fields { place: place.to_string(), all, asked: Vec::new() })
    }

    pub(super) fn wrong(&self, problem: &str) -> Error {
        wrong(&self.place, problem)
    }

    pub(super) fn get(&mut self, name: &str) -> Result<&'a Value, Error> {
        self.asked.push(name.to_string());
        self.all.get(name).ok_or_else(|| self.wrong(&format!("`{name}` is missing")))
    }

    pub(super) fn text(&mut self, name: &str) -> Result<&'a str, Error> {
        self.get(name)?.as_str().ok_or_else(|| self.wrong(&format!("`{name}` must be a string")))
    }

    pub(super) fn list(&mut self, name: &str) -> Result<&'a [Value], Error> {
        let list = self.get(name)?.as_array().ok_or_else(|| self.wrong(&format!("`{name}` must be a list")))?;
        Ok(list)
    }

    pub(super) fn number(&mut self, name: &str) -> Result<f64, Error> {
        self.get(name)?.as_f64().ok_or_else(|| self.wrong(&format!("`{name}` must be a number")))
    }

    pub(super) fn numbers(&mut self, name: &str, count: usize) -> Result<Vec<f64>, Error> {
        let numbers: Option<Vec<f64>> = self.list(name)?.iter().map(Value::as_f64).collect();
        let numbers = numbers.filter(|numbers| numbers.len() == count);
        numbers.ok_or_else(|| self.wrong(&format!("`{name}` must have {count} numbers")))
    }

    pub(super) fn count(&mut self, name: &str) -> Result<usize, Error> {
        let count = self.get(name)?.as_u64().and_then(|count| count.try_into().ok());
        count.ok_or_else(|| self.wrong(&format!("`{name}` must be 0, 1, 2 …")))
    }

    /// A part of the scene whose name is in a field.
    pub(super) fn named<T>(&mut self, name: &str, what: &str, find: impl FnOnce(&str) -> Option<T>) -> Result<T, Error> {
        let of = self.text(name)?;
        self.known(what, of, find(of))
    }

    /// The coordinate called `name`.
    pub(super) fn coordinate(&self, name: &str, scene: &Scene) -> Result<Coordinate, Error> {
        self.known("coordinate", name, scene.coordinate_named(name))
    }

    pub(super) fn known<T>(&self, what: &str, name: &str, found: Option<T>) -> Result<T, Error> {
        found.ok_or_else(|| self.wrong(&format!("no {what} `{name}` is defined before this part")))
    }

    /// The control whose name is in a field.
    pub(super) fn control(&mut self, name: &str, scene: &Scene) -> Result<Control, Error> {
        self.named(name, "control", |name| scene.control_named(name))
    }

    pub(super) fn nothing_more(&self) -> Result<(), Error> {
        match self.all.keys().find(|name| !self.asked.contains(name)) {
            Some(name) => Err(self.wrong(&format!("the field `{name}` does not exist here"))),
            None => Ok(()),
        }
    }

    pub(super) fn params(&mut self, name: &str, scene: &Scene) -> Result<Vec<Param>, Error> {
        self.list(name)?.iter().map(|value| self.as_param(name, value, scene)).collect()
    }

    pub(super) fn param(&mut self, name: &str, scene: &Scene) -> Result<Param, Error> {
        let value = self.get(name)?;
        self.as_param(name, value, scene)
    }

    fn as_param(&self, name: &str, value: &Value, scene: &Scene) -> Result<Param, Error> {
        match value {
            Value::Number(number) => number.as_f64().map(Param::from).ok_or_else(|| self.wrong("the number is too large")),
            Value::String(text) => Param::read(text, |design| scene.design_named(design).map(Param::from)).map_err(
                |Mistake { column, problem }| self.wrong(&format!("`{name}`, character {column} of its formula: {problem}")),
            ),
            _ => Err(self.wrong(&format!("`{name}` must be a number or a formula in quotes"))),
        }
    }
}

pub(super) fn wrong(place: &str, problem: &str) -> Error {
    Error::File { kind: "scene", place: place.to_string(), problem: problem.to_string() }
}
