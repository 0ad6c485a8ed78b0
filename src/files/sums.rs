//! Rules of summation in scene files.

use serde_json::{Value, json};

use super::fields::Fields;
use crate::{Error, Sum};

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
    /// The rule of summation in a field.
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
}
