//! Right values in the wrong places: transposed, rows or columns exchanged, entries exchanged.

use super::evidence::{At, Evidence};
use super::mask::{Lines, Mask};
use crate::check::report::{Diagnosis, Mistake};

pub(super) fn transposed(mask: &Mask) -> Option<Diagnosis> {
    if mask.of.rows() != mask.of.columns() || mask.entries.iter().all(|(i, j)| i == j) {
        return None;
    }
    if mask.explains(|p, (i, j)| 0.5 * (mask.truth(p, (i, j)) + mask.truth(p, (j, i)))) {
        return Some(mask.says(Mistake::Transposed, "only the symmetric part is present"));
    }
    let sign = mask.up_to_sign(|p, (i, j)| mask.truth(p, (j, i)))?;
    let word = if sign > 0.0 { "transposed" } else { "transposed, with the sign flipped," };
    Some(mask.says(Mistake::Transposed, word))
}

/// Diagnosis of two exchanged rows or columns: undoing the exchange makes everything right.
pub(super) fn rows_or_columns(wrong: &Mask) -> Option<Diagnosis> {
    for lines in Lines::BOTH {
        let [a, b] = &wrong.by(lines)[..] else { continue };
        let [a, b] = [a, b].map(|line| lines.of(line.entries[0]));
        let other = |entry: At| match lines.of(entry) {
            k if k == a => lines.entry_in(b, entry),
            k if k == b => lines.entry_in(a, entry),
            _ => entry,
        };
        if Mask::all(wrong.of).explains(|p, e| wrong.truth(p, other(e))) {
            let (word, names) = (lines.word(), lines.names(wrong.of));
            let text = format!("the {word}s of {} and {} are exchanged", names[a], names[b]);
            return Some(Diagnosis::new(Mistake::Swapped, text));
        }
    }
    reordered(wrong.of)
}

/// Diagnosis if all rows, or all columns, are present in another order.
fn reordered(evidence: &Evidence) -> Option<Diagnosis> {
    let order = |lines: Lines| {
        let all = Mask::all(evidence).by(lines);
        let holds = |at: &Mask, k: usize| at.holds(|p, e| at.truth(p, lines.entry_in(k, e)));
        let order: Option<Vec<usize>> = all.iter().map(|at| (0..all.len()).find(|&k| holds(at, k))).collect();
        let is_another = |order: &Vec<usize>| (0..all.len()).all(|k| order.contains(&k)) && !order.is_sorted();
        Some((lines, order.filter(is_another)?))
    };
    let (lines, order) = Lines::BOTH.into_iter().find_map(order)?;
    let list: Vec<&str> = order.iter().map(|&k| lines.names(evidence)[k].as_str()).collect();
    let text = format!("the {}s are in another order: they belong to {}", lines.word(), list.join(", "));
    Some(Diagnosis::new(Mistake::Swapped, text))
}

/// Diagnosis if a row, column or entry has the values of another one.
pub(super) fn entries(mask: &Mask) -> Option<Diagnosis> {
    let place = mask.place();
    let (names, others) = (&mask.of.block.rows, &mask.of.block.columns);
    let says = |text: String| Some(Diagnosis::new(Mistake::Swapped, text));
    for lines in Lines::BOTH.into_iter().filter(|_| mask.entries.len() > 1) {
        let [one] = &mask.by(lines)[..] else { continue };
        let (own, names) = (lines.of(one.entries[0]), lines.names(mask.of));
        let holds = |k: usize| mask.explains(|p, e| mask.truth(p, lines.entry_in(k, e)));
        if let Some(k) = (0..names.len()).find(|&k| k != own && holds(k)) {
            return says(format!("the values of the {} of {} are {place}", lines.word(), names[k]));
        }
    }
    if let [a, b] = mask.entries[..]
        && mask.explains(|p, e| mask.truth(p, if e == a { b } else { a }))
    {
        let name = |(i, j): At| format!("d({})/d({})", names[i], others[j]);
        return says(format!("{} and {} are exchanged", name(a), name(b)));
    }
    let &[(i, j)] = &mask.entries[..] else { return None };
    for (k, l) in Mask::all(mask.of).entries.into_iter().filter(|&e| e != (i, j) && (e.0 == i || e.1 == j)) {
        let varies = mask.of.at.windows(2).any(|at| at[0].truth[(k, l)] != at[1].truth[(k, l)]);
        if varies && mask.explains(|p, _| mask.truth(p, (k, l))) {
            return says(format!("the value of d({})/d({}) is {place}", names[k], others[l]));
        }
    }
    None
}
