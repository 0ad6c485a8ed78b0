//! User-defined energies, forces, constraints, costs, terms and events in a scene file: formulas as text.
//!
//! A formula is written such that the scene that is read compiles to the same programs: in a readable form if this keeps the order of its operations,
//! otherwise with one operation in each part, and with the order of its arguments.

use serde_json::{Map, Value, json};

use super::fields::Fields;
use super::formula::{Formula, FormulaError};
use super::lists::{LISTS, Lists};
use super::sums::write_sum;
use crate::model::Param;
use crate::scene::Summed;
use crate::system::{Connections, ElementKind, GraphFormula, Placed, Recordable, Shape, Slot};
use crate::text::{Name, Parts, write};
use crate::{Error, Scene};

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

/// The name of an argument by its list and its number there.
fn indexed(slot: Slot) -> String {
    let (list, i) = slot.place();
    if slot == Slot::T { "t".into() } else { format!("{}[{i}]", LISTS[list]) }
}

/// The argument with a number in the list with a name.
fn slot_of(list: &str, i: usize) -> Option<Slot> {
    LISTS.iter().position(|known| *known == list).map(|which| Slot::ALL[which](i))
}

/// The fields of a formula; `None` if it has no graph.
fn write_formula<F: Recordable + ?Sized>(placed: &Placed<F>) -> Option<Map<String, Value>> {
    let wanted = placed.template().ok()?;
    let exact = (Parts::All, true);
    // Constants of the element that simplify its formula otherwise remain constants, if possible.
    let ways = [(true, &[(Parts::Long, false), (Parts::Long, true), exact][..]), (false, &[exact])];
    ways.into_iter().find_map(|(keeps_constants, forms)| {
        let graph = placed.as_graph(keeps_constants).ok()?;
        forms.iter().find_map(|(parts, is_ordered)| {
            let text = FormulaText::new(&graph, *parts, *is_ordered)?;
            let read = text.formula().record(placed.shape, &indexed_slot).ok()?;
            (placed.with(read).template().ok()? == wanted).then(|| text.fields())
        })
    })
}

/// The argument that a name with an index denotes.
fn indexed_slot(name: Name) -> Result<Slot, String> {
    match name {
        Name::Word(_) => Ok(Slot::T),
        Name::Entry { list, key } => {
            key.parse().ok().and_then(|i| slot_of(list, i)).ok_or_else(|| "an unknown argument".to_string())
        }
    }
}

/// A formula as it is written.
struct FormulaText {
    parts: Vec<String>,
    results: Vec<String>,
    arguments: Option<Vec<String>>,
}

impl FormulaText {
    /// The text of a graph, with the order of its arguments if `is_ordered`.
    fn new(graph: &GraphFormula, parts: Parts, is_ordered: bool) -> Option<Self> {
        let name = |expression| graph.slot(expression).map(indexed);
        let text = write(graph.graph().0, graph.graph().1, parts, &name)?;
        let results = text.results.into_iter().map(|result| result.into_text()).collect();
        let arguments = is_ordered.then(|| graph.arguments().into_iter().map(indexed).collect());
        Some(FormulaText { parts: text.parts, results, arguments })
    }

    fn formula(&self) -> Formula<'_> {
        fn all(texts: &[String]) -> Vec<&str> {
            texts.iter().map(String::as_str).collect()
        }
        Formula { parts: all(&self.parts), results: all(&self.results), arguments: self.arguments.as_deref().map(all) }
    }

    fn fields(&self) -> Map<String, Value> {
        let mut fields = Map::new();
        if let Some(arguments) = &self.arguments {
            fields.insert("arguments".into(), json!(arguments));
        }
        if !self.parts.is_empty() {
            fields.insert("parts".into(), json!(self.parts));
        }
        let formula = if let [only] = &self.results[..] { json!(only) } else { json!(self.results) };
        fields.insert("formula".into(), formula);
        fields
    }
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

impl Fields<'_> {
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
