//! Comma-separated values, numbers in the fewest digits that read back the same.

use super::Point;

/// A line of fields, each quoted where it must be.
pub(super) fn line(fields: impl IntoIterator<Item = String>) -> String {
    let fields: Vec<String> = fields.into_iter().map(quoted).collect();
    fields.join(",") + "\n"
}

/// The number, with an exponent where it is very small or large.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Named series: a column to each if all have the same x, else in long form.
pub(super) fn series([x_label, y_label]: [&str; 2], series: &[(String, &[Point])]) -> String {
    let Some(((_, first), rest)) = series.split_first() else {
        return String::new();
    };
    let same_x = |points: &[Point]| points.iter().map(|point| point.0).eq(first.iter().map(|point| point.0));
    if !rest.iter().all(|(_, points)| same_x(points)) {
        return line(["series", x_label, y_label].map(str::to_owned)) + &long(series, None);
    }
    let names = series.iter().map(|(name, _)| name.clone());
    let mut out = line(std::iter::once(x_label.to_owned()).chain(names));
    for (row, (x, _)) in first.iter().enumerate() {
        let values = series.iter().filter_map(|(_, points)| points.get(row));
        out += &line(std::iter::once(number(*x)).chain(values.map(|(_, y)| number(*y))));
    }
    out
}

/// The rows of the long form, without header, led by the panel if there is one.
pub(super) fn long(series: &[(String, &[Point])], panel: Option<&str>) -> String {
    let row = |name: &str, (x, y): Point| {
        let lead = panel.map(str::to_owned).into_iter();
        line(lead.chain([name.to_owned(), number(x), number(y)]))
    };
    series.iter().flat_map(|(name, points)| points.iter().map(move |point| row(name, *point))).collect()
}

/// The field, in quotes if it has a comma, a quote or a line break.
fn quoted(field: String) -> String {
    if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_x_makes_columns() {
        let table = series(["t [s]", "y"], &[("a, b".into(), &[(0.5, 1e-12)]), ("c".into(), &[(0.5, f64::NAN)])]);
        assert_eq!(table, "t [s],\"a, b\",c\n0.5,1e-12,NaN\n");
    }

    #[test]
    fn other_x_makes_rows() {
        let table = series(["t", "y [m]"], &[("a".into(), &[(0.0, 1.0)]), ("b".into(), &[(2.0, 3.0)])]);
        assert_eq!(table, "series,t,y [m]\na,0.0,1.0\nb,2.0,3.0\n");
    }
}
