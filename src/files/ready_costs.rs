//! Ready-made costs and outputs in a scene file.

use serde_json::{Value, json};

use super::fields::Fields;
use crate::model::Param;
use crate::scene::ready::ReadyCost;
use crate::{Error, Scene};

pub(super) const EFFORT: &str = "effort";
pub(super) const TIME: &str = "time";
pub(super) const END_STATE: &str = "end state";
pub(super) const READING: &str = "reading";

impl Scene {
    /// A ready-made cost or output as JSON, if a file can store it; an end state has the name of its coordinate.
    pub(super) fn write_cost(&self, name: &str, cost: &ReadyCost, param: impl Fn(&Param) -> Option<Value>) -> Option<Value> {
        Some(match cost {
            ReadyCost::Effort { control, weight } => json!({
                "kind": EFFORT, "name": name, "control": self.control_name(*control), "weight": param(weight)?,
            }),
            ReadyCost::Time { weight } => json!({ "kind": TIME, "name": name, "weight": param(weight)? }),
            ReadyCost::EndState { .. } => json!({ "kind": END_STATE, "name": name }),
            ReadyCost::Reading { coordinate, node, value, weight } => json!({
                "kind": READING, "name": name, "coordinate": self.coordinate_name(*coordinate),
                "node": node, "value": value, "weight": weight,
            }),
        })
    }
}

impl Fields<'_> {
    /// Adds the ready-made cost or output of this entry.
    pub(super) fn add_cost(&mut self, kind: &str, name: &str, scene: &mut Scene) -> Result<(), Error> {
        match kind {
            EFFORT => {
                let control = self.control("control", scene)?;
                scene.effort(name, control, self.param("weight", scene)?);
            }
            TIME => scene.time(name, self.param("weight", scene)?),
            END_STATE => drop(scene.end_state(self.coordinate(name, scene)?)),
            _ => {
                let of = self.text("coordinate")?;
                let coordinate = self.coordinate(of, scene)?;
                let (node, value, weight) = (self.count("node")?, self.number("value")?, self.number("weight")?);
                scene.reading(name, coordinate, node, value, weight);
            }
        }
        Ok(())
    }
}
