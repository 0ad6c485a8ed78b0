//! [`Lists`]: the coordinates, multipliers, controls and constants of a formula in a scene file.

use serde_json::{Map, Value, json};
use std::cell::RefCell;

use super::fields::Fields;
use crate::model::Param;
use crate::system::{Connections, Slot};
use crate::text::Name;
use crate::{Error, Scene};

/// The lists of a formula. A name in a formula that is not in its list is added to it.
pub(super) struct Lists<'a> {
    scene: &'a Scene,
    /// The lists that the formula may read.
    allowed: &'a [&'a str],
    to: RefCell<Connections>,
}

/// The names of the lists, in the order of [`Slot::ALL`].
pub(super) const LISTS: [&str; 10] = ["q", "v", "p_star", "p_star_dot", "v_dot", "lambda", "sigma", "u", "u_dot", "b"];

/// An equation of a constraint, in messages.
pub(super) const EQUATION: &str = "constraint equation";

/// The list and the key of a name such as `q[cart.x]`; no key for a word.
pub(super) fn key_of(name: &str) -> (&str, Option<&str>) {
    match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
        Some((list, key)) => (list, Some(key)),
        None => (name, None),
    }
}

impl Lists<'_> {
    /// The coordinates, equations, controls and constants that the formula is connected to.
    pub(super) fn connections(&self) -> Connections {
        self.to.borrow().clone()
    }

    /// The argument with a name: `t`, a design variable, or an entry of a list by its number there or by its name in the scene.
    pub(super) fn slot(&self, name: Name) -> Result<Slot, String> {
        match name {
            Name::Word("t") => self.allow("t").map(|()| Slot::T),
            Name::Word(design) => self.entry("b", design),
            Name::Entry { list, key } => self.entry(list, key),
        }
    }

    fn allow(&self, list: &str) -> Result<(), String> {
        match self.allowed.contains(&list) {
            true => Ok(()),
            false => {
                Err(format!("`{list}` is not an argument of such a formula; its arguments are {}", self.allowed.join(", ")))
            }
        }
    }

    fn entry(&self, list: &str, key: &str) -> Result<Slot, String> {
        self.allow(list)?;
        let which = LISTS.iter().position(|known| *known == list);
        let of = which.map_or(Slot::Q as fn(usize) -> Slot, |which| Slot::ALL[which]);
        let mut to = self.to.borrow_mut();
        let Connections { q, sigma, u, b } = &mut *to;
        let (what, place) = match list {
            "lambda" | "sigma" => (EQUATION, place(sigma, key, || Some(self.scene.multiplier_named(key)?.index()))),
            "u" | "u_dot" => ("control", place(u, key, || Some(self.scene.control_named(key)?.index()))),
            "b" => ("design variable", place(b, key, || self.scene.design_named(key).map(Param::from))),
            _ => ("coordinate", place(q, key, || Some(self.scene.coordinate_named(key)?.index()))),
        };
        place.map(of).ok_or_else(|| format!("no {what} `{key}` is defined before this part"))
    }
}

impl<'f> Fields<'f> {
    /// The lists of this entry, for a formula that may read the lists with these names.
    pub(super) fn lists<'a>(&mut self, allowed: &'a [&'a str], scene: &'a Scene) -> Result<Lists<'a>, Error> {
        let (q, sigma, u) = (self.given("q")?, self.given("sigma")?, self.given("u")?);
        let [q, sigma, u] = [q, sigma, u].map(Option::unwrap_or_default);
        let q = q.into_iter().map(|name| self.coordinate(name, scene).map(|q| q.index())).collect::<Result<_, _>>()?;
        let equation = |name: &str| scene.multiplier_named(name).map(|sigma| sigma.index());
        let control = |name: &str| scene.control_named(name).map(|u| u.index());
        let sigma = sigma.into_iter().map(|name| self.known(EQUATION, name, equation(name))).collect::<Result<_, _>>()?;
        let u = u.into_iter().map(|name| self.known("control", name, control(name))).collect::<Result<_, _>>()?;
        let b = if self.all.contains_key("b") { self.params("b", scene)? } else { Vec::new() };
        Ok(Lists { scene, allowed, to: RefCell::new(Connections { q, sigma, u, b }) })
    }

    /// The strings of a list that may be missing.
    pub(super) fn given(&mut self, name: &str) -> Result<Option<Vec<&'f str>>, Error> {
        self.all.contains_key(name).then(|| self.texts(name)).transpose()
    }

    /// The strings of a list.
    pub(super) fn texts(&mut self, name: &str) -> Result<Vec<&'f str>, Error> {
        let texts: Option<Vec<&'f str>> = self.list(name)?.iter().map(Value::as_str).collect();
        texts.ok_or_else(|| self.wrong(&format!("`{name}` must be a list of strings")))
    }
}

impl Scene {
    /// Writes the lists of a formula that are not empty; `None` if a parameter cannot be written.
    pub(super) fn write_lists(
        &self,
        to: &Connections,
        param: &dyn Fn(&Param) -> Option<Value>,
        fields: &mut Map<String, Value>,
    ) -> Option<()> {
        let coordinates = self.coordinate_names();
        let controls = self.control_names();
        let lists = [
            ("q", to.q.iter().map(|&i| json!(coordinates[i])).collect()),
            ("sigma", to.sigma.iter().map(|&j| json!(self.multiplier_name(j))).collect()),
            ("u", to.u.iter().map(|&k| json!(controls[k])).collect()),
            ("b", to.b.iter().map(param).collect::<Option<Vec<_>>>()?),
        ];
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            fields.insert(name.into(), Value::Array(list));
        }
        Some(())
    }
}

/// The place of an entry in a list: its number there, or its value, which is added to the list if it is not there.
fn place<T: PartialEq>(list: &mut Vec<T>, key: &str, value: impl Fn() -> Option<T>) -> Option<usize> {
    if let Some(i) = key.parse().ok().filter(|i: &usize| *i < list.len()) {
        return Some(i);
    }
    let value = value()?;
    Some(list.iter().position(|known| *known == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    }))
}
