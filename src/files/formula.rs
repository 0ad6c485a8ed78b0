//! [`Formula`]: a formula as text that is recorded.

use std::cell::RefCell;

use super::lists::key_of;
use crate::program::Symbol;
use crate::system::{GraphFormula, Shape, Slot};
use crate::text::{Mistake, Name, Reader};

/// A formula as text: parts that precede it, its results, and the order of its arguments unless it is that of [`Shape::slots`].
pub(super) struct Formula<'a> {
    pub(super) parts: Vec<&'a str>,
    pub(super) results: Vec<&'a str>,
    pub(super) arguments: Option<Vec<&'a str>>,
}

impl Formula<'_> {
    /// Records the formula. `slot` returns the argument that a name denotes.
    pub(super) fn record(
        &self,
        shape: Shape,
        slot: &dyn Fn(Name) -> Result<Slot, String>,
    ) -> Result<GraphFormula, FormulaError> {
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

    /// As [`record`](Self::record), with `first` as the first arguments.
    pub(super) fn graph(
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

/// A mistake in a formula, with its place.
pub(super) struct FormulaError(pub(super) String);

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
