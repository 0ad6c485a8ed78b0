//! [`Scene`] to and from JSON: its parts, in the order in which they were added.

use serde_json::{Value, json};

use super::fields::{Fields, wrong};
use super::formulas::{COST, ELEMENTS, EVENT, OUTPUT, TERM};
use super::names::Unique;
use super::writer::Writer;
use crate::scene::kinds::kinds;
use crate::scene::ready::Added;
use crate::{Error, Scene};

pub(super) const FORMAT: &str = "hamiltonian-adjoint scene";
pub(super) const VERSION: u32 = 2;
/// A version that lacks the kinds of the present one.
pub(super) const OLD: u32 = 1;

/// A scene read from a file, with the names of parts that the file could not contain.
#[derive(Debug)]
pub struct SceneFile {
    /// The scene; find handles of its parts by name ([`Scene::coordinate_named`], [`Scene::output_named`] and similar).
    pub scene: Scene,
    /// Names of user-defined elements, costs and events whose formulas branch on a value, of parts and costs whose parameters cannot be written as text,
    /// and of everything that belongs to such bodies or is connected to them. Without these the scene describes another mechanism or another J.
    pub left_out: Vec<String>,
}

impl SceneFile {
    /// The scene, if no part was left out.
    ///
    /// # Errors
    /// The name of the first part that was left out.
    pub fn complete(self) -> Result<Scene, Error> {
        match self.left_out.first() {
            None => Ok(self.scene),
            Some(name) => Err(wrong(
                "`left_out`",
                &format!(
                    "`{name}` cannot be stored (its formula branches on a value, or a name or number in it cannot be written), so the file contains only its name: add the part to `SceneFile::scene`"
                ),
            )),
        }
    }

    /// Reads a scene from JSON as [`Scene::to_json`] writes it.
    ///
    /// # Errors
    /// A malformed file (with line and column), or parts with wrong entries (with their names).
    pub fn from_json(json: &str) -> Result<Self, Error> {
        let Unique(file) = super::read_json("scene", json)?;
        let mut file = Fields::of("the file", &file)?;
        let version = file.get("version")?.to_string();
        let version = if version == OLD.to_string() { VERSION.to_string() } else { version };
        super::check_format("scene", (file.text("format")?, version), (FORMAT, VERSION))?;
        let mut scene = Scene::new();
        for (i, part) in file.list("parts")?.iter().enumerate() {
            scene.add_entry(&format!("part {}", i + 1), part)?;
        }
        let left_out = file.list("left_out")?.iter().map(|name| name.as_str().map(str::to_string));
        let left_out = left_out.collect::<Option<_>>().ok_or_else(|| wrong("`left_out`", "names are expected"))?;
        file.nothing_more()?;
        Ok(SceneFile { scene, left_out })
    }
}

impl Scene {
    /// The scene as JSON: coordinates, controls, design variables, bodies, ready-made parts, costs, outputs and events. Formulas of user-defined
    /// elements and costs are written as text, such that the scene that is read compiles to the same programs; of those that branch on a value, only the
    /// names are written.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Scene, SceneFile, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// scene.gravity(0.0, -9.81);
    /// let length = scene.design("length", 1.0);
    /// let rod = scene.body("rod", 0.4, length * length * 0.4 / 12.0, [0.0, -0.5, -1.57]);
    /// scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), rod.at(length * -0.5, 0.0));
    ///
    /// let file = scene.to_json()?;
    /// assert!(file.contains("\"-0.5 * length\""));
    /// let system = SceneFile::from_json(&file)?.complete()?.compile()?;
    /// assert_eq!((system.n(), system.m(), system.designs()), (3, 2, 1));
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`compile`](Self::compile) for these parts, or numbers that are not finite.
    pub fn to_json(&self) -> Result<String, Error> {
        if let Some(problem) = self.problem() {
            return Err(problem.clone());
        }
        let mut left_out: Vec<String> = Vec::new();
        let (mut parts, mut to) = (Vec::new(), Writer::new(self));
        for ((name, added), sizes) in self.added().iter().zip(self.sizes_after()) {
            let part = match added {
                Added::Part(part) => to.part(name, part),
                Added::Element(place) => to.element(*place),
                Added::Function(which) => to.function(*which),
                Added::Output => Some(json!({ "kind": OUTPUT, "name": name })),
            };
            to.advance(*sizes, part.is_some());
            match (part, added) {
                (Some(part), _) => parts.push(part),
                (None, Added::Part(part)) if part.kind.name == "end state" => left_out.push(format!("end state of {name}")),
                (None, _) => left_out.push(name.to_string()),
            }
        }
        let file = json!({ "format": FORMAT, "version": VERSION, "parts": parts, "left_out": left_out });
        if let Some(place) = parts.iter().find(|part| has_null(part)) {
            return Err(wrong(&place["name"].to_string(), "a number that is not finite"));
        }
        serde_json::to_string_pretty(&file).map_err(|error| wrong("the whole file", &error.to_string()))
    }

    /// Adds a part from JSON, as an entry of `parts` in a scene file.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, gradient};
    ///
    /// let mut scene = Scene::new();
    /// for part in [
    ///     r#"{"kind": "design variable", "name": "mass", "value": 2.0}"#,
    ///     r#"{"kind": "coordinates", "name": "cart", "coordinates": ["x"]}"#,
    ///     r#"{"kind": "control", "name": "force"}"#,
    ///     r#"{"kind": "kinetic energy", "name": "motion", "formula": "0.5 * mass * v[cart.x]^2"}"#,
    ///     r#"{"kind": "force", "name": "drag", "q": ["cart.x"], "formula": "u[force] - 0.1 * v[0]^3"}"#,
    ///     r#"{"kind": "cost", "name": "distance", "sum": "terminal", "formula": "q[cart.x]"}"#,
    /// ] {
    ///     scene.add_json(part)?;
    /// }
    /// let system = scene.compile()?;
    /// let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.05));
    /// inputs.controls.fill(1.0);
    /// let gradient = gradient(&system, &inputs, Settings::default())?;
    /// assert!(gradient.value > 0.2 && gradient.design[0] < 0.0);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// Malformed JSON, or wrong entries with their names.
    pub fn add_json(&mut self, part: &str) -> Result<(), Error> {
        let Unique(part) = super::read_json("scene", part)?;
        self.add_entry("the part", &part)
    }

    fn add_entry(&mut self, place: &str, part: &Value) -> Result<(), Error> {
        let mut part = Fields::of(place, part)?;
        let (kind, name) = (part.text("kind")?, part.text("name")?);
        part.place = format!("{place}, {kind} `{name}`");
        part.add(kind, name, self)?;
        part.nothing_more()
    }
}

impl Fields<'_> {
    /// Adds the part of this entry.
    fn add(&mut self, kind: &str, name: &str, scene: &mut Scene) -> Result<(), Error> {
        if let Some((_, element, lists)) = ELEMENTS.into_iter().find(|(known, ..)| *known == kind) {
            return self.add_element((element, lists), name, scene);
        }
        if [COST, OUTPUT, TERM, EVENT].contains(&kind) {
            return self.add_function(kind, name, scene);
        }
        let found = kinds().find(|known| known.name == kind).ok_or_else(|| {
            let known: Vec<&str> = SceneFile::kinds().map(|kind| kind.name).collect();
            self.wrong(&format!("this kind does not exist; the available kinds are {}", known.join(", ")))
        })?;
        let part = self.part(found, scene)?;
        self.nothing_more()?;
        scene.ready(name, part);
        Ok(())
    }
}

fn has_null(part: &Value) -> bool {
    match part {
        Value::Null => true,
        Value::Array(list) => list.iter().any(has_null),
        Value::Object(fields) => fields.values().any(has_null),
        Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}
