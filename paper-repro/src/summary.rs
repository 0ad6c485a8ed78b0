//! `summary.json`: the measured numbers under fixed names.

use serde::Serialize;

use crate::constraints::Violations;
use crate::experiment::{Experiment, Gradients, Optimum};
use crate::statistics::{largest, median};
use crate::table::Claim;
use crate::timing::Timing;

/// Everything that was measured; what was not asked for is null.
#[derive(Serialize)]
pub struct Summary<'a> {
    assumed: Assumed,
    gradient: Option<GradientNumbers>,
    constraints: Option<ConstraintNumbers>,
    optimization: Option<OptimizationNumbers>,
    timing: Option<TimingNumbers>,
    /// What the library says of the motions.
    warnings: Vec<String>,
    claims: &'a [Claim],
}

/// Parameters that the paper does not state.
#[derive(Serialize)]
struct Assumed {
    link_length_m: f64,
    gravity_m_s2: f64,
    friction_joint: u16,
    line_search_alpha: f64,
    line_search_armijo: f64,
    line_search_backtrack: f64,
}

#[derive(Serialize)]
struct GradientNumbers {
    max_rel_error_vs_complex_step: f64,
    max_pointwise_rel_error_vs_complex_step: f64,
}

#[derive(Serialize)]
struct ConstraintNumbers {
    position_max: f64,
    position_median: f64,
    velocity_max: f64,
    acceleration_max: f64,
}

#[derive(Serialize)]
struct OptimizationNumbers {
    iterations: usize,
    iterations_to_1e_10: Option<usize>,
    initial_cost: f64,
    final_cost: f64,
    cart_rightmost_time_s: f64,
}

#[derive(Serialize)]
struct TimingNumbers {
    forward_s: f64,
    value_and_gradient_s: f64,
    complex_step_s: f64,
}

impl<'a> Summary<'a> {
    /// The numbers of all runs that were made.
    pub fn new(experiment: &Experiment, claims: &'a [Claim]) -> Self {
        let settings = &experiment.settings;
        let (violations, gradients, optimum, timing) = experiment.made();
        Summary {
            assumed: Assumed {
                link_length_m: settings.length,
                gravity_m_s2: settings.gravity,
                friction_joint: settings.friction_joint,
                line_search_alpha: settings.alpha,
                line_search_armijo: settings.armijo,
                line_search_backtrack: settings.backtrack,
            },
            gradient: gradients.map(GradientNumbers::from),
            constraints: violations.map(ConstraintNumbers::from),
            optimization: optimum.map(OptimizationNumbers::from),
            timing: timing.map(TimingNumbers::from),
            warnings: experiment.warnings(),
            claims,
        }
    }
}

impl From<&Gradients> for GradientNumbers {
    fn from(gradients: &Gradients) -> Self {
        GradientNumbers {
            max_rel_error_vs_complex_step: gradients.relative_error(),
            max_pointwise_rel_error_vs_complex_step: gradients.worst_component().1,
        }
    }
}

impl From<&Violations> for ConstraintNumbers {
    fn from(violations: &Violations) -> Self {
        ConstraintNumbers {
            position_max: largest(&violations.position),
            position_median: median(&violations.position),
            velocity_max: largest(&violations.velocity),
            acceleration_max: largest(&violations.acceleration),
        }
    }
}

impl From<&Optimum> for OptimizationNumbers {
    fn from(optimum: &Optimum) -> Self {
        OptimizationNumbers {
            iterations: optimum.history.len() - 1,
            iterations_to_1e_10: optimum.first_below(1e-10),
            initial_cost: optimum.history[0].cost,
            final_cost: optimum.end().cost,
            cart_rightmost_time_s: optimum.motion.times[optimum.cart_rightmost()],
        }
    }
}

impl From<&Timing> for TimingNumbers {
    fn from(timing: &Timing) -> Self {
        TimingNumbers {
            forward_s: timing.forward,
            value_and_gradient_s: timing.value_and_gradient,
            complex_step_s: timing.complex_step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{settings::Settings, table::Verdict};
    use clap::{Args, FromArgMatches};

    fn settings() -> Settings {
        let command = Settings::augment_args(clap::Command::new("test"));
        Settings::from_arg_matches(&command.get_matches_from(["test", "--iterations", "3"])).unwrap()
    }

    #[test]
    fn promised_keys_are_there() {
        let experiment = Experiment::new(settings()).unwrap();
        experiment.violations().unwrap();
        experiment.gradients().unwrap();
        experiment.optimum().unwrap();
        experiment.timing().unwrap();
        let word = String::new;
        let claims = [Claim { figure: word(), what: word(), paper: word(), ours: word(), verdict: Verdict::NotStated }];
        let json = serde_json::to_value(Summary::new(&experiment, &claims)).unwrap();
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
        let json = serde_json::to_value(Summary::new(&experiment, &[])).unwrap();
        assert!(json["timing"].is_null() && json["gradient"].is_null());
    }
}
