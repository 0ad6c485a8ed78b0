//! Comma-separated values; numbers have the fewest digits that reproduce them exactly.

use super::Point;

/// A line of fields, quoted if necessary.
pub(super) fn line(fields: &[impl AsRef<str>]) -> String {
    fields.iter().map(|field| quoted(field.as_ref())).collect::<Vec<_>>().join(",") + "\n"
}

/// Named series: one column for each if all have the same x, else in long form.
pub(super) fn series([x_label, y_label]: [&str; 2], series: &[(String, &[Point])]) -> String {
    let Some(((_, first), rest)) = series.split_first() else {
        return String::new();
    };
    let same_x = |points: &[Point]| points.iter().map(|point| point.0).eq(first.iter().map(|point| point.0));
    if !rest.iter().all(|(_, points)| same_x(points)) {
        let rows = series.iter().map(|(name, of_series)| points(&[name], of_series));
        return line(&["series", x_label, y_label]) + &rows.collect::<String>();
    }
    let names = series.iter().map(|(name, _)| name.as_str());
    let mut out = line(&std::iter::once(x_label).chain(names).collect::<Vec<_>>());
    for (row, (x, _)) in first.iter().enumerate() {
        let values = series.iter().filter_map(|(_, points)| points.get(row)).map(|point| point.1);
        out += &line(&std::iter::once(*x).chain(values).map(number).collect::<Vec<_>>());
    }
    out
}

/// A row for each point, preceded by the common fields.
pub(super) fn points(common: &[&str], points: &[Point]) -> String {
    let row = |(x, y): &Point| line(&[common, &[&number(*x), &number(*y)]].concat());
    points.iter().map(row).collect()
}

/// The number, with an exponent where it is very small or large.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// The field, in quotes if it contains a comma, a quote or a line break.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
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
