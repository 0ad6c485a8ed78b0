//! Right values in the wrong places: transposed, rows or columns exchanged, entries exchanged.

use super::mask::Mask;
use super::{Evidence, diagnosis};
use crate::check::report::{Diagnosis, Mistake};

pub(super) fn transposed(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    if evidence.rows() != evidence.columns() || mask.entries.iter().all(|(i, j)| i == j) {
        return None;
    }
    let of = |sign: f64| evidence.explains(mask, |p, i, j| sign * evidence.truth[p][(j, i)]);
    let word = if of(1.0) {
        "transposed"
    } else if of(-1.0) {
        "transposed, with the sign flipped,"
    } else {
        return None;
    };
    Some(diagnosis(Mistake::Transposed, format!("{word} {}", mask.place(evidence))))
}

/// Two rows, or two columns, exchanged: undoing it makes everything right.
pub(super) fn rows_or_columns(evidence: &Evidence, wrong: &Mask) -> Option<Diagnosis> {
    let (rows, columns) = (wrong.by_rows(), wrong.by_columns());
    let text = match (&rows[..], &columns[..]) {
        ([a, b], _) if exchanged(evidence, (a.entries[0].0, b.entries[0].0), true) => {
            let names = &evidence.block.rows;
            format!("the rows of {} and {} are exchanged", names[a.entries[0].0], names[b.entries[0].0])
        }
        (_, [a, b]) if exchanged(evidence, (a.entries[0].1, b.entries[0].1), false) => {
            let names = &evidence.block.columns;
            format!("the columns of {} and {} are exchanged", names[a.entries[0].1], names[b.entries[0].1])
        }
        _ => return reordered(evidence),
    };
    Some(diagnosis(Mistake::Swapped, text))
}

fn exchanged(evidence: &Evidence, (a, b): (usize, usize), rows: bool) -> bool {
    let other = |k: usize| {
        if k == a {
            b
        } else if k == b {
            a
        } else {
            k
        }
    };
    let truth = |p: usize, i: usize, j: usize| evidence.truth[p][if rows { (other(i), j) } else { (i, other(j)) }];
    evidence.explains(&Mask::all(evidence), truth)
}

/// All rows, or all columns, are there, in another order.
fn reordered(evidence: &Evidence) -> Option<Diagnosis> {
    let row = |i: usize, k: usize| evidence.holds(&line(evidence, i, true), |p, _, j| evidence.truth[p][(k, j)]);
    let column = |j: usize, k: usize| evidence.holds(&line(evidence, j, false), |p, i, _| evidence.truth[p][(i, k)]);
    let found = |count: usize, is: &dyn Fn(usize, usize) -> bool| -> Option<Vec<usize>> {
        let order: Option<Vec<usize>> = (0..count).map(|i| (0..count).find(|&k| is(i, k))).collect();
        let is_another = |order: &Vec<usize>| (0..count).all(|k| order.contains(&k)) && (0..count).any(|k| order[k] != k);
        order.filter(is_another)
    };
    let (word, names, order) = match found(evidence.rows(), &row) {
        Some(order) => ("rows", &evidence.block.rows, order),
        None => ("columns", &evidence.block.columns, found(evidence.columns(), &column)?),
    };
    let list: Vec<&str> = order.iter().map(|&k| names[k].as_str()).collect();
    Some(diagnosis(Mistake::Swapped, format!("the {word} are in another order: they belong to {}", list.join(", "))))
}

fn line(evidence: &Evidence, at: usize, row: bool) -> Mask {
    let entries = if row {
        (0..evidence.columns()).map(|j| (at, j)).collect()
    } else {
        (0..evidence.rows()).map(|i| (i, at)).collect()
    };
    Mask { entries }
}

/// A row, column or entry that holds the values of another one.
pub(super) fn entries(evidence: &Evidence, mask: &Mask) -> Option<Diagnosis> {
    let place = mask.place(evidence);
    let (names, others) = (&evidence.block.rows, &evidence.block.columns);
    let (rows, columns) = (mask.by_rows(), mask.by_columns());
    let says = |text: String| Some(diagnosis(Mistake::Swapped, text));
    if let ([one], true) = (&rows[..], mask.entries.len() > 1) {
        let own = one.entries[0].0;
        for k in (0..evidence.rows()).filter(|&k| k != own) {
            if evidence.explains(mask, |p, _, j| evidence.truth[p][(k, j)]) {
                return says(format!("{place} stand the values of the row of {}", names[k]));
            }
        }
    }
    if let ([one], true) = (&columns[..], mask.entries.len() > 1) {
        let own = one.entries[0].1;
        for k in (0..evidence.columns()).filter(|&k| k != own) {
            if evidence.explains(mask, |p, i, _| evidence.truth[p][(i, k)]) {
                return says(format!("{place} stand the values of the column of {}", others[k]));
            }
        }
    }
    if let [a, b] = mask.entries[..]
        && evidence.explains(mask, |p, i, j| evidence.truth[p][if (i, j) == a { b } else { a }])
    {
        let name = |(i, j): (usize, usize)| format!("d({})/d({})", names[i], others[j]);
        return says(format!("{} and {} are exchanged", name(a), name(b)));
    }
    let &[(i, j)] = &mask.entries[..] else { return None };
    for (k, l) in Mask::all(evidence).entries.into_iter().filter(|&e| e != (i, j) && (e.0 == i || e.1 == j)) {
        let varies = evidence.truth.windows(2).any(|t| t[0][(k, l)] != t[1][(k, l)]);
        if varies && evidence.explains(mask, |p, _, _| evidence.truth[p][(k, l)]) {
            return says(format!("{place} stands the value of d({})/d({})", names[k], others[l]));
        }
    }
    None
}
