//! Fig. 6: the gradient by the adjoint and by complex step.

use std::path::Path;

use super::with_kink;
use crate::error::Error;
use crate::experiment::{Experiment, Gradients};
use crate::plot::{Axis, Chart, Panels, Place, Series, Style, colour};
use crate::statistics::largest;
use crate::table::{Row, Verdict};

pub fn draw(experiment: &Experiment, stem: &Path) -> Result<Vec<Row>, Error> {
    let (gradients, times) = (experiment.gradients()?, experiment.inputs.grid.times());
    let above = Chart {
        y: Axis::linear("dJ/duᵢ [rad²/N]"),
        series: vec![
            Series::over(&times, &gradients.complex_step, "complex step", colour::RED, Style::Circles),
            with_kink(Series::over(&times, &gradients.adjoint, "adjoint", colour::BLUE, Style::Line), 0),
        ],
        legend: Place::UpperLeft,
        size: (700.0, 290.0),
        caption: experiment.settings.caption(
            6,
            "; below, the absolute difference (in the paper, it is relative to the gradient)",
            false,
        ),
        ..Chart::default()
    };
    let below = Chart {
        x: Axis::linear("time tᵢ [s]"),
        y: Axis::log("|difference| [rad²/N]", 1e-20),
        series: vec![Series::over(&times, &gradients.differences(), "|difference|", colour::BLACK, Style::Line)],
        ..above.clone()
    };
    Panels::new(vec![above, below], 1).save(stem)?;
    Ok(claims(gradients, &times))
}

fn claims(gradients: &Gradients, times: &[f64]) -> Vec<Row> {
    let (node, pointwise) = gradients.worst_component();
    let (error, time) = (gradients.relative_error(), times[node]);
    let share = gradients.complex_step[node].abs() / largest(&gradients.complex_step);
    vec![
        Row::new(
            "Fig. 6",
            "largest difference of the gradients, relative to the gradient at that time",
            "0.5 %, at t = 0.52 s",
            format!(
                "{pointwise:.1e}, at t = {time:.2} s, where the gradient is {share:.0e} of its largest value: only rounding, \
                 so neither the scheme nor its adjoint accounts for 0.5 %"
            ),
            // Rounding, magnified because the gradient passes through zero.
            if pointwise < 1e-6 { Verdict::Differs } else { Verdict::Failed },
        ),
        Row::new(
            "Fig. 6",
            "largest difference of the gradients, relative to the largest gradient",
            "curves only",
            format!("{error:.1e}"),
            if error < 1e-10 { Verdict::Reproduced } else { Verdict::Failed },
        ),
    ]
}
