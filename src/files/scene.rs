//! [`Scene`] to and from JSON: its parts, in the order in which they were added.

use serde_json::{Map, Value, json};

use super::fields::{Fields, wrong};
use super::formulas::{COST, ELEMENTS, EVENT, OUTPUT, TERM};
use super::names::Unique;
use super::ready_costs::{EFFORT, END_STATE, READING, TIME};
use crate::model::{Frame, Owner, Param, Point};
use crate::planar::{Body, KINDS, MOTIONS};
use crate::scene::ready::{Added, Kind, Part, ReadyCost};
use crate::system::Connections;
use crate::{Error, Scene};

const FORMAT: &str = "hamiltonian-adjoint scene";
const VERSION: u32 = 2;
/// A version that lacks the kinds of the present one.
const OLD: u32 = 1;

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
        let mut left_out: Vec<String> = self.own().to_vec();
        let mut parts = Vec::new();
        let designs = self.design_names();
        let mut missing: Vec<Frame> = Vec::new();
        for (name, added) in self.added() {
            match self.write(name, added, &designs).filter(|_| !self.is_joined(added, &missing, &left_out)) {
                Some(part) => parts.push(part),
                None => {
                    if let Added::Body(..) | Added::Particle(..) = added {
                        missing.extend(self.frame_named(name));
                    }
                    left_out.push(match added {
                        Added::Place(of, _) => self.coordinate_name(*of).to_string(),
                        Added::Cost(ReadyCost::EndState { .. }) => format!("end state of {name}"),
                        _ => name.to_string(),
                    });
                }
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

    /// A part as JSON, if a file can store it.
    fn write(&self, name: &str, added: &Added, designs: &[&str]) -> Option<Value> {
        let param = |param: &Param| match param.constant() {
            Some(number) => Some(json!(number)),
            None => param.text(designs).map(Value::String),
        };
        Some(match added {
            Added::Element(place) => self.write_element(*place, &param)?,
            Added::Function(which) => self.write_function(*which, &param)?,
            Added::Output => json!({ "kind": OUTPUT, "name": name }),
            Added::Cost(cost) => self.write_cost(name, cost, param)?,
            Added::Control => json!({ "kind": "control", "name": name }),
            Added::Design(value) => json!({ "kind": "design variable", "name": name, "value": value }),
            Added::Coordinates(names) => json!({ "kind": "coordinates", "name": name, "coordinates": names }),
            Added::Place(of, value) => {
                json!({ "kind": "initial value", "name": self.coordinate_name(*of), "value": value })
            }
            Added::Gravity([x, y, z]) => {
                let mut entry = json!({ "kind": "gravity", "name": name, "x": param(x)?, "y": param(y)? });
                if z.constant() != Some(0.0) {
                    entry["z"] = param(z)?;
                }
                entry
            }
            Added::Body([mass, inertia], place) => json!({
                "kind": "body", "name": name, "mass": param(mass)?, "inertia": param(inertia)?, "place": place,
            }),
            Added::Particle(mass, place) => {
                json!({ "kind": "particle", "name": name, "mass": param(mass)?, "place": place })
            }
            Added::Part(part) => {
                let mut entry = Map::new();
                entry.insert("kind".into(), json!(part.kind.name));
                entry.insert("name".into(), json!(name));
                for (place, point) in part.kind.places.iter().zip(&part.points) {
                    let mut at = Map::new();
                    if point.frame.owner() != Owner::Ground {
                        at.insert("body".into(), json!(self.frame_name(point.frame)?));
                    }
                    if part.kind.at_points {
                        at.insert("at".into(), json!([param(&point.at[0])?, param(&point.at[1])?]));
                    }
                    entry.insert((*place).into(), Value::Object(at));
                }
                for (what, number) in part.kind.numbers.iter().zip(&part.numbers) {
                    entry.insert((*what).into(), param(number)?);
                }
                if let (Some(what), Some(control)) = (part.kind.control, part.control) {
                    entry.insert(what.into(), json!(self.control_name(control)));
                }
                if let Some((motion, parameters)) = &part.motion {
                    entry.insert("motion".into(), json!(motion));
                    entry.insert("parameters".into(), json!(parameters.iter().map(param).collect::<Option<Vec<_>>>()?));
                }
                Value::Object(entry)
            }
        })
    }
}

impl Fields<'_> {
    /// Adds the part of this entry.
    fn add(&mut self, kind: &str, name: &str, scene: &mut Scene) -> Result<(), Error> {
        match kind {
            "control" => drop(scene.control(name)),
            "design variable" => drop(scene.design(name, self.number("value")?)),
            "coordinates" => {
                let names: Option<Vec<&str>> = self.list("coordinates")?.iter().map(Value::as_str).collect();
                scene.coordinate_group(name, &names.ok_or_else(|| self.wrong("`coordinates` must be names"))?);
            }
            "initial value" => {
                let value = self.number("value")?;
                scene.place(self.coordinate(name, scene)?, value);
            }
            "gravity" => {
                let [x, y] = [self.param("x", scene)?, self.param("y", scene)?];
                let z = if self.all.contains_key("z") { self.param("z", scene)? } else { 0.0.into() };
                scene.spatial().gravity([x, y, z]);
            }
            "body" => {
                let [mass, inertia] = [self.param("mass", scene)?, self.param("inertia", scene)?];
                scene.body(name, mass, inertia, self.numbers("place")?);
            }
            "particle" => {
                let mass = self.param("mass", scene)?;
                scene.particle(name, mass, self.numbers("place")?);
            }
            EFFORT | TIME | END_STATE | READING => self.add_cost(kind, name, scene)?,
            COST | OUTPUT | TERM | EVENT => self.add_function(kind, name, scene)?,
            _ => {
                if let Some((_, element, lists)) = ELEMENTS.into_iter().find(|(known, ..)| *known == kind) {
                    return self.add_element((element, lists), name, scene);
                }
                let known = || KINDS.map(|kind| kind.name).join(", ");
                let kind = KINDS.into_iter().find(|known| known.name == kind);
                let kind = kind
                    .ok_or_else(|| self.wrong(&format!("this kind does not exist; the available kinds are {}", known())))?;
                let part = self.part(kind, scene)?;
                scene.ready(name, part);
            }
        }
        Ok(())
    }

    fn part(&mut self, kind: &'static Kind, scene: &Scene) -> Result<Part, Error> {
        let points = kind.places.iter().map(|place| self.point(place, kind, scene)).collect::<Result<_, _>>()?;
        let numbers = kind.numbers.iter().map(|what| self.param(what, scene)).collect::<Result<_, _>>()?;
        let control = kind.control.map(|what| self.control(what, scene)).transpose()?;
        let motion = if kind.moves { Some(self.motion(scene)?) } else { None };
        Ok(Part { kind, points, numbers, control, motion })
    }

    fn motion(&mut self, scene: &Scene) -> Result<(&'static str, Vec<Param>), Error> {
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

    /// A point of a body, or of the ground if none is named.
    fn point(&mut self, name: &str, kind: &Kind, scene: &Scene) -> Result<Point, Error> {
        let mut place = Fields::of(&format!("{}, `{name}`", self.place), self.get(name)?)?;
        let frame = match place.all.get("body") {
            None => Body::GROUND,
            Some(_) => {
                let body = place.text("body")?;
                scene
                    .frame_named(body)
                    .ok_or_else(|| place.wrong(&format!("no body `{body}` is defined before this part")))?
            }
        };
        let point = match kind.at_points {
            false => frame.origin(),
            true => match place.params("at", scene)?[..] {
                [x, y] => frame.at(x, y),
                _ => return Err(place.wrong("`at` must have x and y")),
            },
        };
        place.nothing_more()?;
        Ok(point)
    }
}

impl Scene {
    /// The name of a body of this scene.
    fn frame_name(&self, frame: Frame) -> Option<&str> {
        self.sketched().find(|(_, known)| *known == frame).map(|(name, _)| name)
    }

    /// True if the item belongs to one of these bodies, or is connected to one or to a constraint with one of these names.
    fn is_joined(&self, added: &Added, bodies: &[Frame], names: &[String]) -> bool {
        let reads = |to: &Connections| {
            let is_missing = |j: &usize| self.constraint_of(*j).is_some_and(|name| names.iter().any(|known| known == name));
            to.q.iter().any(|q| is_of(*q, bodies)) || to.sigma.iter().any(is_missing)
        };
        match added {
            Added::Place(of, _)
            | Added::Cost(ReadyCost::EndState { coordinate: of } | ReadyCost::Reading { coordinate: of, .. }) => {
                is_of(of.index(), bodies)
            }
            Added::Part(part) => part.points.iter().any(|point| bodies.contains(&point.frame)),
            Added::Element(place) => reads(&self.element(*place).to),
            Added::Function(which) => reads(&self.function(*which).0.of.to),
            _ => false,
        }
    }
}

/// True if the coordinate belongs to one of these bodies.
fn is_of(coordinate: usize, bodies: &[Frame]) -> bool {
    bodies.iter().any(|body| match body.owner() {
        Owner::Ground => false,
        Owner::Body(q) => q.iter().any(|q| q.index() == coordinate),
        Owner::Particle(q) => q.iter().any(|q| q.index() == coordinate),
    })
}

fn has_null(part: &Value) -> bool {
    match part {
        Value::Null => true,
        Value::Array(list) => list.iter().any(has_null),
        Value::Object(fields) => fields.values().any(has_null),
        Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    }
}
