//! [`Trajectory`] to CSV: a row for each node and a column for each quantity, with its unit if known.

use std::collections::HashMap;

use super::inputs::{controls, coordinates};
use crate::model::{FORCE, Shape, Unit};
use crate::motion::column;
use crate::{Error, Inputs, System, Trajectory};

impl Trajectory {
    /// The motion as CSV: t, q, v, p*, σ and u of all computed nodes, to the last digit. Names that a spreadsheet would interpret as
    /// formulas are preceded by `'`.
    ///
    /// # Errors
    /// Inputs that do not belong to the motion.
    pub fn to_csv(&self, system: &System, inputs: &Inputs) -> Result<String, Error> {
        self.check_fits(system, inputs)?;
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut header = vec!["t [s]".to_string()];
        let of_coordinates = system.sketch().units_of_coordinates(system.n());
        for (before, length, angle) in [("", "m", "rad"), ("v of ", "m/s", "rad/s"), ("p* of ", "N s", "N m s")] {
            let unit_of = |unit: &Unit| unit.of((length, angle));
            header.extend(coordinates(system).zip(&of_coordinates).map(|(name, unit)| beside(before, name, unit_of(unit))));
        }
        let of_equations = equations(system);
        header.extend(of_equations.iter().map(|(name, unit)| beside("σ of ", name, unit.of(("N s", "N m s")))));
        let of_controls = system.sketch().units_of_controls(system.k(), system.n());
        header.extend(controls(system).zip(&of_controls).map(|(name, unit)| beside("", name, unit.of(FORCE))));
        let wrong = |error: csv::Error| Error::File { kind: "a table", place: "writing".into(), problem: error.to_string() };
        writer.write_record(header.iter().map(|name| harmless(name))).map_err(wrong)?;
        for i in 0..self.computed {
            let parts = [&self.q, &self.v, &self.p_star, &self.sigma, &inputs.controls].map(|part| column(part, i));
            let numbers = [self.times[i]].into_iter().chain(parts.into_iter().flatten().copied());
            writer.write_record(numbers.map(|x| x.to_string())).map_err(wrong)?;
        }
        let bytes = writer.into_inner().map_err(|error| wrong(error.into_error().into()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// Names and units of the equations; only units of joints are known.
fn equations(system: &System) -> Vec<(&str, Unit)> {
    let of_shape = |shape: Shape| -> &[Unit] {
        match shape {
            Shape::Hinge => &[Unit::Length, Unit::Length],
            Shape::Weld => &[Unit::Length, Unit::Length, Unit::Angle],
            // A slider with a single equation is a driven one.
            Shape::Slider { .. } => &[Unit::Length, Unit::Angle],
            Shape::Rod | Shape::Cylinder { .. } => &[Unit::Length],
            _ => &[],
        }
    };
    let drawn = system.sketch().drawn.iter();
    let known: HashMap<&str, &[Unit]> = drawn.map(|part| (part.name.as_str(), of_shape(part.shape))).collect();
    let units = system.constraints().iter().flat_map(|(name, rows)| {
        let units = known.get(name.as_str()).copied().unwrap_or_default();
        (0..*rows).map(|row| units.get(row).copied().unwrap_or(Unit::Unknown))
    });
    (0..system.m()).map(|j| system.equation_name(j)).zip(units).collect()
}

/// A name with its unit, if known.
fn beside(before: &str, name: &str, unit: &str) -> String {
    if unit.is_empty() { format!("{before}{name}") } else { format!("{before}{name} [{unit}]") }
}

/// A name that no spreadsheet evaluates as a formula.
fn harmless(name: &str) -> String {
    if name.starts_with(['=', '+', '-', '@', '\t', '\r']) { format!("'{name}") } else { name.to_string() }
}
