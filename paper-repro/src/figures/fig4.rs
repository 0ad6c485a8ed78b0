//! Fig. 4: constraint violations of the starting iteration.

use std::path::Path;

use crate::constraints::Violations;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::plot::{Axis, Chart, Place, Series, Style, colour};
use crate::statistics::{largest, median};
use crate::table::{Row, Verdict};

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let violations = experiment.violations()?;
    // Node 0 is the given start, where no integration error exists yet.
    let series =
        |name: &str, values: &[f64], colour| Series::over(&violations.times[1..], &values[1..], name, colour, Style::Line);
    let chart = Chart {
        x: Axis::linear("time t [s]"),
        y: Axis { range: Some((1e-18, 1.0)), ..Axis::log("largest violation of any constraint equation", 1e-18) },
        legend: Place::UpperMiddle,
        series: vec![
            series("position ‖Φ‖∞ [m, rad]", &violations.position, colour::BLUE),
            series("velocity ‖dΦ/dt‖∞ [m/s, rad/s]", &violations.velocity, colour::RED),
            series(
                "acceleration ‖d²Φ/dt²‖∞ [m/s², rad/s²], by the trapezoidal rule (assumed)",
                &violations.acceleration,
                colour::GREEN,
            ),
        ],
        caption: experiment.settings.caption(4, " for the starting iteration; node 0, the given start, is omitted", false),
        ..Chart::default()
    };
    chart.save(stem)?;
    Ok(claims(violations))
}

fn claims(violations: &Violations) -> Vec<Row> {
    let Violations { position, velocity, acceleration, .. } = violations;
    let (middle, worst) = (median(position), largest(position));
    let within = position.iter().filter(|norm| (1e-5..=1e-4).contains(*norm)).count();
    let share = 100.0 * within as f64 / position.len() as f64;
    let speed = largest(velocity);
    let speed_verdict = match speed {
        speed if speed > 1e-11 || speed.is_nan() => Verdict::Failed,
        speed => Verdict::reproduced_if(speed < 1e-13),
    };
    let (half, most) = (median(acceleration), largest(acceleration));
    vec![
        Row::new(
            "Fig. 4",
            "position level ‖Φ‖∞, to its order of magnitude",
            "generally between 1e-5 and 1e-4",
            format!("median {middle:.1e}, at most {worst:.1e}, {share:.0} % of the nodes in that range"),
            position_verdict(middle, worst),
        ),
        Row::new("Fig. 4", "velocity level ‖dΦ/dt‖∞", "up to 1e-14", format!("at most {speed:.1e}"), speed_verdict),
        Row::new(
            "Fig. 4",
            "acceleration level ‖d²Φ/dt²‖∞",
            "curve only; the source of the accelerations is not stated",
            format!("median {half:.1e}, at most {most:.1e}, with accelerations by the trapezoidal rule from the velocities"),
            Verdict::Assumed,
        ),
    ]
}

/// The median must lie in the paper's range; single nodes may deviate from it by at most a factor of 5.
///
/// The drift depends on the step length and on assumed parameters, so values outside the range are not a failure.
fn position_verdict(median: f64, largest: f64) -> Verdict {
    match median {
        _ if largest > 1e-2 || largest.is_nan() => Verdict::Failed,
        median if (1e-5..=1e-4).contains(&median) && largest < 5e-4 => Verdict::Reproduced,
        _ => Verdict::Differs,
    }
}
