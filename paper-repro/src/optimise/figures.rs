//! Figures of runs: controls, progress, motions before and after, residuals of a fit.

use std::path::Path;

use hamiltonian_adjoint::{Animation, Inputs, Solver};

use super::problems::{Name, Posed};
use super::runs::{Found, Run};
use crate::error::Error;
use crate::files;
use crate::plot::{Axis, Chart, Colour, Panels, Series, Style, colour};

/// Colours of methods and of records.
const COLOURS: [Colour; 5] = [colour::BLUE, colour::RED, colour::GREEN, colour::ORANGE, colour::PURPLE];

/// The optimal forces, and the progress of violation and gradient, with a panel for each problem.
pub fn draw(runs: &[Run], folder: &Path) -> Result<(), Error> {
    let panels = |x: Axis, y: fn(Name) -> Axis, points: fn(&Run) -> Vec<(f64, f64)>| {
        let chart = |runs: &[Run]| {
            let line = |(run, colour): (&Run, Colour)| {
                let (end, style) = match run.outcome.reason.is_converged() {
                    true => ("", Style::Line),
                    false => (" (not converged)", Style::Dashed),
                };
                Series::new(format!("{}{end}", run.method), points(run), colour, style)
            };
            panel(runs[0].name.text(), [x.clone(), y(runs[0].name)], runs.iter().zip(COLOURS).map(line).collect())
        };
        of_problems(runs).map(chart).collect()
    };
    let force = |run: &Run| run.found.as_ref().map_or_else(Vec::new, |found| found.control(&found.inputs));
    save(panels(Axis::linear("time t [s]"), control, force), &folder.join("optimise_force"))?;
    let history = |run: &Run| -> Vec<(f64, f64)> {
        run.outcome.history.iter().map(|it| (it.evaluations as f64, it.violation.max(it.stationarity))).collect()
    };
    let error = |_| Axis::log("violation or ‖∇L‖∞, the larger", 1e-12);
    save(panels(Axis::log("simulations", 0.0), error, history), &folder.join("optimise_progress"))
}

/// Panels in two columns; no figure if there are no panels.
fn save(charts: Vec<Chart>, stem: &Path) -> Result<(), Error> {
    if charts.is_empty() { Ok(()) } else { Panels::new(charts, 2).save(stem) }
}

/// The force at five iterations from the start to the best one; the number of iterations between them about doubles.
pub fn iterations(runs: &[Run], folder: &Path) -> Result<(), Error> {
    const STAGES: [Colour; 5] = [colour::GREY, colour::ORANGE, colour::SKY, colour::BLUE, colour::RED];
    let chart = |(run, found): (&Run, &Found)| {
        let last = found.iterates.len() - 1;
        let mut chosen = vec![0, last.div_ceil(8), last.div_ceil(4), last.div_ceil(2), last];
        chosen.dedup();
        let line = |(&k, colour): (&usize, Colour)| {
            let name = if k == 0 { "start".to_owned() } else { format!("iteration {k}") };
            Series::new(name, found.control(&found.iterates[k]), colour, Style::Line)
        };
        let lines = chosen.iter().zip(STAGES[5 - chosen.len()..].iter().copied()).map(line).collect();
        panel(format!("{}, {}", run.name.text(), run.method), [Axis::linear("time t [s]"), control(run.name)], lines)
    };
    let seen = of_problems(runs).filter_map(best).filter(|(_, found)| !found.iterates.is_empty());
    save(seen.map(chart).collect(), &folder.join("optimise_iterations"))
}

/// One of two panels side by side.
fn panel(title: String, [x, y]: [Axis; 2], series: Vec<Series>) -> Chart {
    Chart { title, x, y, series, size: (560.0, 330.0), ..Chart::default() }
}

fn control(of: Name) -> Axis {
    match of {
        Name::Periodic => Axis::linear("torque on the crank [N m]"),
        Name::Arm | Name::ArmLimits | Name::Chain | Name::ChainFiner | Name::ChainFinest => {
            Axis::linear("torque in the first joint [N m]")
        }
        Name::Acrobot => Axis::linear("torque between the links [N m]"),
        _ => Axis::linear("force on the cart F [N]"),
    }
}

/// The lowest value to which a method converged.
fn best(runs: &[Run]) -> Option<(&Run, &Found)> {
    let converged = runs.iter().filter(|run| run.outcome.reason.is_converged());
    let best = converged.min_by(|one, other| one.outcome.value.total_cmp(&other.outcome.value))?;
    Some((best, best.found.as_ref()?))
}

/// The runs of each problem with a motion.
fn of_problems(runs: &[Run]) -> impl Iterator<Item = &[Run]> {
    runs.chunk_by(|one, other| one.name == other.name).filter(|runs| runs[0].found.is_some())
}

/// The initial motion of each problem and the best one, as pages.
pub fn motions(runs: &[Run], folder: &Path) -> Result<(), Error> {
    for (best, found) in of_problems(runs).filter_map(best) {
        let name = best.name.text();
        for (when, inputs) in [("before", &found.posed.inputs), ("after", &found.inputs)] {
            let page = page(&found.posed, inputs, &format!("{name}, {when}"))?;
            files::write(&folder.join(format!("optimise_{name}_{when}.html")), page)?;
        }
    }
    Ok(())
}

fn page(Posed { system, settings, lines, .. }: &Posed, inputs: &Inputs, title: &str) -> Result<String, Error> {
    let mut solver = Solver::new(system, *settings);
    let motion = solver.simulate(inputs)?.clone();
    let drawn = Animation::new(system, solver.inputs(), &motion)?.title(title);
    let drawn = lines.iter().try_fold(drawn, |drawn, (name, points)| drawn.line(name, |q, _t| points(q)))?;
    Ok(drawn.html())
}

/// Residuals of the readings in standard deviations; they must show no trend.
pub fn residuals(residuals: &[f64], times: &[f64], folder: &Path) -> Result<(), Error> {
    let records = residuals.chunks(times.len()).zip(COLOURS).enumerate();
    let series = records
        .map(|(k, (record, colour))| Series::over(times, record, format!("record {}", k + 1), colour, Style::Circles));
    let chart = Chart {
        title: "identify: residuals of the crank's angle".into(),
        x: Axis::linear("time t [s]"),
        y: Axis::linear("residual [standard deviations]"),
        series: series.collect(),
        ..Chart::default()
    };
    Panels::new(vec![chart], 1).save(&folder.join("optimise_residuals"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_motions_there_are_no_figures() {
        let folder = std::env::temp_dir().join(format!("paper-repro-optimise-{}", std::process::id()));
        let folder = files::folder(Some(&folder)).unwrap();
        draw(&[], &folder).unwrap();
        iterations(&[], &folder).unwrap();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
