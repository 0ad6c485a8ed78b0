//! `summary.json`: the measured numbers under fixed names.

use serde_json::{Value, json};

use crate::experiment::Experiment;
use crate::statistics::{largest, median};
use crate::table::{Row, Rows};

/// The rows, with the paper's statements.
pub fn rows(rows: &[Row]) -> Rows<'_> {
    Rows { keys: ["figure", "what", "paper", "ours"], heads: ["Figure", "What", "Paper", "Ours"], rows }
}

/// The numbers of all runs; runs that were not requested are null.
pub fn of(experiment: &Experiment, claims: &[Row]) -> Value {
    let Experiment { settings, violations, gradients, optimum, timing, .. } = experiment;
    json!({
        // What the paper does not state.
        "assumed": {
            "link_length_m": settings.length,
            "gravity_m_s2": settings.gravity,
            "friction_joint": settings.friction_joint,
            "line_search_alpha": settings.search.first,
            "line_search_armijo": settings.search.armijo,
            "line_search_backtrack": settings.search.shorten,
        },
        "gradient": gradients.get().map(|gradients| json!({
            "max_rel_error_vs_complex_step": gradients.relative_error(),
            "max_pointwise_rel_error_vs_complex_step": gradients.worst_component().1,
        })),
        "constraints": violations.get().map(|violations| json!({
            "position_max": largest(&violations.position),
            "position_median": median(&violations.position),
            "velocity_max": largest(&violations.velocity),
            "acceleration_max": largest(&violations.acceleration),
        })),
        "optimization": optimum.get().map(|optimum| json!({
            "iterations": optimum.iterations(),
            "iterations_to_1e_10": optimum.first_below(1e-10),
            "initial_cost": optimum.history[0].cost,
            "final_cost": optimum.end().cost,
            "cart_rightmost_time_s": optimum.cart_rightmost_time(),
        })),
        "timing": timing.get().map(|timing| json!({
            "forward_s": timing.forward,
            "value_and_gradient_s": timing.value_and_gradient,
            "complex_step_s": timing.complex_step,
        })),
        // Warnings of the library for the motions.
        "warnings": experiment.warnings,
        "claims": rows(claims),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{settings::Settings, table::Verdict};

    fn settings() -> Settings {
        Settings { iterations: 3, ..Settings::usual() }
    }

    #[test]
    fn promised_keys_are_there() {
        let experiment = Experiment::new(settings()).unwrap();
        experiment.violations().unwrap();
        experiment.gradients().unwrap();
        experiment.optimum().unwrap();
        experiment.timing().unwrap();
        let json = of(&experiment, &[Row::new("", "", "", "", Verdict::NotStated)]);
        for key in [
            "/gradient/max_rel_error_vs_complex_step",
            "/constraints/position_max",
            "/constraints/position_median",
            "/constraints/velocity_max",
            "/optimization/iterations",
            "/optimization/initial_cost",
            "/optimization/final_cost",
            "/optimization/cart_rightmost_time_s",
            "/timing/forward_s",
            "/timing/value_and_gradient_s",
            "/timing/complex_step_s",
        ] {
            assert!(json.pointer(key).is_some_and(|value| value.is_number()), "{key}: {json}");
        }
        for key in ["figure", "what", "ours", "paper", "verdict"] {
            assert!(json["claims"][0][key].is_string(), "{key}");
        }
        assert_eq!(json["optimization"]["iterations"], 3);
    }

    #[test]
    fn what_was_not_run_is_null() {
        let experiment = Experiment::new(settings()).unwrap();
        let json = of(&experiment, &[]);
        assert!(json["timing"].is_null() && json["gradient"].is_null());
    }
}
