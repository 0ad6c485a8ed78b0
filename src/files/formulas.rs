//! User-defined energies, forces, constraints, costs, terms and events in a scene file: formulas as text.
//!
//! A formula is written such that the scene that is read compiles to the same programs: in a readable form if this keeps the order of its operations,
//! otherwise with one operation in each part, and with the order of its arguments.

use serde_json::{Map, Value, json};
use std::cell::RefCell;

use super::fields::{Fields, wrong};
use super::lists::{Lists, key_of};
use crate::check::Function;
use crate::model::Param;
use crate::program::Symbol;
use crate::scene::Summed;
use crate::system::{Connections, ElementKind, GraphFormula, Placed, Recordable, Shape, Slot, Values};
use crate::text::{Mistake, Name, Parts, Reader, write};
use crate::{Error, Scalar, Scene, Sum};

/// The kinds of elements, with the lists of arguments that their formulas may read.
pub(super) const ELEMENTS: [(&str, ElementKind, &[&str]); 4] = [
    ("kinetic energy", ElementKind::Kinetic, &["q", "v", "b"]),
    ("potential energy", ElementKind::Potential, &["q", "b", "t"]),
    ("force", ElementKind::Applied, &["q", "v", "u", "b", "t"]),
    ("constraint", ElementKind::Holonomic, &["q", "b", "t"]),
];
pub(super) const COST: &str = "cost";
pub(super) const OUTPUT: &str = "output";
pub(super) const TERM: &str = "term";
pub(super) const EVENT: &str = "event";
pub(super) const OF_FUNCTIONS: &[&str] =
    &["q", "v", "p_star", "p_star_dot", "v_dot", "sigma", "lambda", "u", "u_dot", "b", "t"];

/// A formula as text: parts that precede it, its results, and the order of its arguments unless it is that of [`Shape::slots`].
struct Formula<'a> {
    parts: Vec<&'a str>,
    results: Vec<&'a str>,
    arguments: Option<Vec<&'a str>>,
}

impl Formula<'_> {
    /// Records the formula. `slot` returns the argument that a name denotes.
    fn record(&self, shape: Shape, slot: &dyn Fn(Name) -> Result<Slot, String>) -> Result<GraphFormula, FormulaError> {
        let order = match &self.arguments {
            Some(names) => names.iter().map(|name| argument(name, slot)).collect::<Result<Vec<_>, _>>()?,
            None => {
                let used = RefCell::new(Vec::new());
                let note = |name: Name| slot(name).inspect(|slot| used.borrow_mut().push(*slot));
                self.graph(shape, &[], &note)?;
                let used = used.into_inner();
                shape.slots().filter(|slot| used.contains(slot)).collect()
            }
        };
        self.graph(shape, &order, slot)
    }

    fn graph(
        &self,
        shape: Shape,
        first: &[Slot],
        slot: &dyn Fn(Name) -> Result<Slot, String>,
    ) -> Result<GraphFormula, FormulaError> {
        let mut mistake = None;
        let graph = GraphFormula::record(shape, first, |symbol, put| {
            let lookup = |name: Name| slot(name).map(symbol);
            mistake = self.evaluate(&mut Reader::new(&lookup), put).err();
        });
        match (mistake, graph) {
            (Some(mistake), _) => Err(mistake),
            (None, graph) => graph.map_err(|obstacle| FormulaError(format!("the formula cannot be recorded: {obstacle:?}"))),
        }
    }

    fn evaluate<'t>(&'t self, reader: &mut Reader<'t, Symbol>, put: &mut dyn FnMut(Symbol)) -> Result<(), FormulaError> {
        for (i, part) in self.parts.iter().enumerate() {
            reader.define(part).map_err(|mistake| FormulaError::new(&format!("part {}", i + 1), mistake))?;
        }
        for result in &self.results {
            put(reader.read(result).map_err(|mistake| FormulaError::new("`formula`", mistake))?);
        }
        Ok(())
    }
}

/// A vector function as text, with the grammar of formulas in scene files and the arguments `x[0]`, `x[1]`, …, for
/// [`check::function`](crate::check::function).
///
/// ```
/// use hamiltonian_adjoint::{TextFunction, check};
///
/// let polar = TextFunction::read(&["cos(x[1])", "sin(x[1])"], &["x[0] * $1", "x[0] * $2"], 2)?;
/// let hand = |x: &[f64]| [[x[1].cos(), -x[0] * x[1].sin()], [x[1].sin(), x[0] * x[1].cos()]];
/// check::function(&polar, ["r", "φ"], ["x", "y"]).jacobian(hand).run().assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub struct TextFunction(GraphFormula);

impl TextFunction {
    /// Reads a function of `arguments` numbers: parts that precede its results, and the results.
    ///
    /// # Errors
    /// A mistake in a text, with its column.
    pub fn read(parts: &[&str], results: &[&str], arguments: usize) -> Result<Self, Error> {
        let formula = Formula { parts: parts.to_vec(), results: results.to_vec(), arguments: None };
        let slot = |name: Name| match name {
            Name::Entry { list: "x", key } => key.parse().ok().filter(|i| *i < arguments).map(Slot::Q),
            _ => None,
        };
        let slot =
            |name: Name| slot(name).ok_or_else(|| format!("arguments are x[0] to x[{}]", arguments.saturating_sub(1)));
        let graph = formula.graph(Shape { n: arguments, ..Shape::default() }, &[], &slot);
        graph.map(TextFunction).map_err(|FormulaError(problem)| wrong("the function", &problem))
    }
}

impl Function for TextFunction {
    fn value<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut results = Vec::new();
        let read = |slot: Slot| if let Slot::Q(i) = slot { x[i] } else { S::zero() };
        self.0.values(&read, &mut |y| results.push(y));
        results
    }
}

/// What is wrong with a formula.
struct FormulaError(String);

impl FormulaError {
    fn new(place: &str, Mistake { column, problem }: Mistake) -> Self {
        FormulaError(format!("{place}, character {column}: {problem}"))
    }
}

/// The argument that one name denotes.
fn argument(name: &str, slot: &dyn Fn(Name) -> Result<Slot, String>) -> Result<Slot, FormulaError> {
    let (list, key) = key_of(name);
    let found = key.map_or_else(|| slot(Name::Word(list)), |key| slot(Name::Entry { list, key }));
    found.map_err(|problem| FormulaError(format!("`arguments`: {problem}")))
}

/// The name of an argument by its list and its number there.
fn indexed(slot: Slot) -> String {
    let (list, i) = slot.place();
    if slot == Slot::T { "t".into() } else { format!("{}[{i}]", LISTS[list]) }
}

/// The names of the lists, in the order of [`Slot::ALL`].
pub(super) const LISTS: [&str; 10] = ["q", "v", "p_star", "p_star_dot", "v_dot", "lambda", "sigma", "u", "u_dot", "b"];

/// The argument with a number in the list with a name.
fn slot_of(list: &str, i: usize) -> Option<Slot> {
    LISTS.iter().position(|known| *known == list).map(|which| Slot::ALL[which](i))
}

/// The fields of a formula; `None` if it has no graph.
fn write_formula<F: Recordable + ?Sized>(placed: &Placed<F>) -> Option<Map<String, Value>> {
    let wanted = placed.template().ok()?;
    let ways = [(true, Parts::Long, false), (true, Parts::Long, true), (true, Parts::All, true), (false, Parts::All, true)];
    ways.into_iter().find_map(|(keeps_constants, parts, is_ordered)| {
        let graph = placed.as_graph(keeps_constants).ok()?;
        let name = |expression| graph.slot(expression).map(indexed);
        let text = write(graph.graph().0, graph.graph().1, parts, &name)?;
        let results: Vec<String> = text.results.into_iter().map(|result| result.into_text()).collect();
        let arguments: Option<Vec<String>> = is_ordered.then(|| graph.arguments().into_iter().map(indexed).collect());
        let formula = Formula {
            parts: text.parts.iter().map(String::as_str).collect(),
            results: results.iter().map(String::as_str).collect(),
            arguments: arguments.as_ref().map(|names| names.iter().map(String::as_str).collect()),
        };
        let slot = |name: Name| match name {
            Name::Word(_) => Ok(Slot::T),
            Name::Entry { list, key } => {
                key.parse().ok().and_then(|i| slot_of(list, i)).ok_or_else(|| "an unknown argument".to_string())
            }
        };
        let read = formula.record(placed.shape, &slot).ok()?;
        (placed.with(read).template().ok()? == wanted).then(|| {
            let mut fields = Map::new();
            if let Some(arguments) = &arguments {
                fields.insert("arguments".into(), json!(arguments));
            }
            if !text.parts.is_empty() {
                fields.insert("parts".into(), json!(text.parts));
            }
            let formula = if results.len() == 1 { json!(results[0]) } else { json!(results) };
            fields.insert("formula".into(), formula);
            fields
        })
    })
}

impl Scene {
    /// A user-defined element as JSON, if its formula has a graph.
    pub(super) fn write_element(&self, place: (usize, usize), param: &dyn Fn(&Param) -> Option<Value>) -> Option<Value> {
        let item = self.element(place);
        let kind = ELEMENTS.iter().find(|(_, kind, _)| *kind == item.formula.kind()).map(|(name, ..)| *name)?;
        let mut fields = Map::new();
        fields.insert("kind".into(), json!(kind));
        fields.insert("name".into(), json!(item.name));
        let of_constraint = Connections { sigma: Vec::new(), ..item.to.clone() };
        self.write_lists(&of_constraint, param, &mut fields)?;
        if place.1 > 0 {
            fields.insert("like".into(), json!(self.element((place.0, 0)).name));
        }
        fields.extend(write_formula(item)?);
        Some(Value::Object(fields))
    }

    /// A user-defined cost, term or event as JSON, if its formula has a graph.
    pub(super) fn write_function(&self, which: usize, param: &dyn Fn(&Param) -> Option<Value>) -> Option<Value> {
        let (cost, of) = self.function(which);
        let mut fields = Map::new();
        let kind = match of {
            Summed::Cost(_) => COST,
            Summed::Term(..) => TERM,
            Summed::Event => EVENT,
        };
        fields.insert("kind".into(), json!(kind));
        fields.insert("name".into(), json!(cost.of.name));
        if let Summed::Term(output, _) = of {
            fields.insert("output".into(), json!(self.output_name(output)));
        }
        if let Summed::Term(_, sum) | Summed::Cost(sum) = of {
            fields.insert("sum".into(), write_sum(sum));
        }
        self.write_lists(&cost.of.to, param, &mut fields)?;
        fields.extend(write_formula(&cost.of)?);
        Some(Value::Object(fields))
    }
}

pub(super) fn write_sum(sum: Sum) -> Value {
    match sum {
        Sum::Node(node) => json!({ "node": node }),
        Sum::Event(event) => json!({ "event": event }),
        Sum::AfterEvent(event) => json!({ "after event": event }),
        named => json!(SUMS.iter().find(|(_, sum)| *sum == named).map(|(name, _)| *name)),
    }
}

pub(super) const SUMS: [(&str, Sum); 6] = [
    ("plain", Sum::Plain),
    ("all nodes", Sum::AllNodes),
    ("rectangle", Sum::Rectangle),
    ("trapezoidal", Sum::Trapezoidal),
    ("integral", Sum::Integral),
    ("terminal", Sum::Terminal),
];

impl Fields<'_> {
    pub(super) fn sum(&mut self, field: &str) -> Result<Sum, Error> {
        let value = self.get(field)?;
        if let Some(name) = value.as_str() {
            let known = || SUMS.map(|(name, _)| name).join(", ");
            let sum = SUMS.into_iter().find(|(known, _)| *known == name).map(|(_, sum)| sum);
            return sum
                .ok_or_else(|| self.wrong(&format!("`{name}` is not one of the sums {}, or {{\"node\": i}}", known())));
        }
        let mut entry = Fields::of(&format!("{}, `{field}`", self.place), value)?;
        let name = ["node", "event", "after event"].into_iter().find(|name| entry.all.contains_key(*name));
        let name = name.ok_or_else(|| entry.wrong("`node`, `event` or `after event` is expected"))?;
        let which = entry.count(name)?;
        let sum = match name {
            "node" => Sum::Node(which),
            "event" => Sum::Event(which),
            _ => Sum::AfterEvent(which),
        };
        entry.nothing_more()?;
        Ok(sum)
    }

    /// Adds the user-defined element of this entry.
    pub(super) fn add_element(
        &mut self,
        (kind, of): (ElementKind, &[&str]),
        name: &str,
        scene: &mut Scene,
    ) -> Result<(), Error> {
        let lists = self.lists(of, scene)?;
        let results = self.results()?;
        let like = match self.all.contains_key("like") {
            false => None,
            true => {
                let like = self.text("like")?;
                let batch = scene.batch_of(like).filter(|batch| scene.element((*batch, 0)).formula.kind() == kind);
                Some(batch.ok_or_else(|| self.wrong(&format!("no such element `{like}` is defined before this part")))?)
            }
        };
        let m = if kind == ElementKind::Holonomic { results } else { 0 };
        let (formula, to) = self.formula(&lists, m)?;
        let expected = match kind {
            ElementKind::Kinetic | ElementKind::Potential => 1,
            ElementKind::Applied => to.q.len(),
            ElementKind::Holonomic => results,
        };
        if results != expected || results == 0 {
            return Err(self.wrong(&format!(
                "`formula` has {results} components; {expected} are expected, one for each coordinate of a force"
            )));
        }
        let sigma = if m > 0 { scene.add_equations(name, m) } else { Vec::new() };
        scene.add_element(name, (kind, formula), Connections { sigma, ..to }, like);
        Ok(())
    }

    /// Adds the user-defined cost, term, event or output of this entry.
    pub(super) fn add_function(&mut self, kind: &str, name: &str, scene: &mut Scene) -> Result<(), Error> {
        let of = match kind {
            OUTPUT => {
                scene.output(name);
                return Ok(());
            }
            COST => Summed::Cost(self.sum("sum")?),
            EVENT => Summed::Event,
            _ => {
                let output = self.text("output")?;
                let found = scene.output_named(output);
                let found = found.ok_or_else(|| self.wrong(&format!("no output `{output}` is defined before this part")))?;
                Summed::Term(found, self.sum("sum")?)
            }
        };
        let lists = self.lists(OF_FUNCTIONS, scene)?;
        if self.results()? != 1 {
            return Err(self.wrong("`formula` must be a single formula"));
        }
        let (formula, to) = self.formula(&lists, 0)?;
        scene.add_function(name, of, formula, to);
        Ok(())
    }

    /// The number of results of the formula.
    fn results(&mut self) -> Result<usize, Error> {
        Ok(self.get("formula")?.as_array().map_or(1, Vec::len))
    }

    /// The formula of this entry with `m` equations of its own, and what it is connected to.
    fn formula(&mut self, lists: &Lists, m: usize) -> Result<(GraphFormula, Connections), Error> {
        let formula = self.get("formula")?;
        let results = match formula.as_array() {
            Some(_) => self.texts("formula")?,
            None => vec![self.text("formula")?],
        };
        let parts = self.given("parts")?.unwrap_or_default();
        let formula = Formula { parts, results, arguments: self.given("arguments")? };
        let slot = |name: Name| lists.slot(name);
        // Names that are not in the lists are added to them, so their lengths are known afterwards.
        let place = |FormulaError(problem)| self.wrong(&problem);
        formula.graph(Shape::default(), &[], &slot).map_err(place)?;
        let to = lists.connections();
        let shape = Shape { n: to.q.len(), m: to.sigma.len() + m, k: to.u.len(), p: to.b.len() };
        Ok((formula.record(shape, &slot).map_err(place)?, to))
    }
}
