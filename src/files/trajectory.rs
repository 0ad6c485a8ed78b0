//! [`Trajectory`] to CSV: a row for each node, a column for each number, with its unit where it is known.

use super::inputs::{controls, coordinates};
use crate::model::Owner;
use crate::motion::column;
use crate::{Error, Inputs, System, Trajectory};

/// The unit of a coordinate.
#[derive(Clone, Copy, PartialEq)]
enum Unit {
    Length,
    Angle,
    Unknown,
}

impl Trajectory {
    /// As CSV: t, q, v, p*, σ and u of all nodes that were computed, to the last digit. Names that a spreadsheet would take for formulas are preceded by `'`.
    ///
    /// # Errors
    /// Inputs that do not belong to the motion.
    pub fn to_csv(&self, system: &System, inputs: &Inputs) -> Result<String, Error> {
        self.check_fits(system, inputs)?;
        let units = units(system);
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut header = vec!["t [s]".to_string()];
        for (before, length, angle) in [("", "m", "rad"), ("v of ", "m/s", "rad/s"), ("p* of ", "N s", "N m s")] {
            header.extend(coordinates(system).zip(&units).map(|(name, unit)| match unit {
                Unit::Length => format!("{before}{name} [{length}]"),
                Unit::Angle => format!("{before}{name} [{angle}]"),
                Unit::Unknown => format!("{before}{name}"),
            }));
        }
        header.extend((0..system.m()).map(|j| format!("σ of {}", system.equation_name(j))));
        header.extend(controls(system).map(str::to_string));
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

/// Those of the coordinates of bodies are known.
fn units(system: &System) -> Vec<Unit> {
    let mut units = vec![Unit::Unknown; system.n()];
    for frame in system.sketch().bodies.iter().map(|(_, frame)| frame) {
        match frame.owner() {
            Owner::Body([x, y, phi]) => {
                [x, y].into_iter().for_each(|q| units[q.index()] = Unit::Length);
                units[phi.index()] = Unit::Angle;
            }
            Owner::Particle(q) => q.into_iter().for_each(|q| units[q.index()] = Unit::Length),
            Owner::Ground => {}
        }
    }
    units
}

/// A name that no spreadsheet evaluates.
fn harmless(name: &str) -> String {
    if name.starts_with(['=', '+', '-', '@', '\t', '\r']) { format!("'{name}") } else { name.to_string() }
}
