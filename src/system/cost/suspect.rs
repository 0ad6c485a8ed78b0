//! [`Suspect`]: a formula that is not finite.

use super::rows::CostRows;
use crate::system::formula::Argument;

/// The element whose formula is not finite, and the arguments that cause it.
pub struct Suspect<'a> {
    pub element: &'a str,
    pub arguments: Vec<Argument>,
}

impl<'a> Suspect<'a> {
    /// The first of several named formulas whose derivatives are not finite; `rows` is overwritten.
    pub(in crate::system) fn first<T>(
        formulas: impl IntoIterator<Item = (&'a str, T)>,
        rows: &mut CostRows,
        add: impl Fn(T, &mut CostRows),
    ) -> Option<Self> {
        let element = formulas.into_iter().find_map(|(name, formula)| {
            rows.clear();
            add(formula, rows);
            (!rows.is_finite()).then_some(name)
        })?;
        Some(Suspect { element, arguments: rows.bad_arguments() })
    }
}
