//! Effect of L-stability: errors of a motion with a part that is far stiffer than any step resolves, over the step length.

use hamiltonian_adjoint::{Error, Scheme, Settings, Trajectory, simulate};
use serde::Serialize;

use crate::plot::{Axis, Chart, Colour, Place, Series, Style, colour};
use crate::stress::stiff::{FAST, masses};

/// A damper that would stop its masses relative to each other within some nanoseconds, N s/m.
const DAMPER: f64 = 1e8;
/// Duration of the motion, s.
const END: f64 = 1.0;
/// Number of steps of the reference motion.
const FINE: usize = 20_000;
const COLOURS: [Colour; 5] = [colour::BLUE, colour::SKY, colour::GREEN, colour::ORANGE, colour::PURPLE];

/// The errors of one scheme.
#[derive(Clone, Debug, Serialize)]
pub struct Stiff {
    pub scheme: &'static str,
    /// (Δt in s, largest error of a velocity at the end, relative to the largest velocity of the motion).
    pub errors: Vec<(f64, f64)>,
}

pub fn measure() -> Result<Vec<Stiff>, Error> {
    let motion = |scheme, steps: usize| -> Result<Trajectory, Error> {
        let (system, inputs) = masses(0.0, DAMPER, steps, END / steps as f64)?;
        Ok(simulate(&system, &inputs, Settings { scheme, ..Settings::default() })?)
    };
    let fine = motion(Scheme::ESDIRK5, FINE)?;
    let error = |scheme, steps: usize| -> Result<(f64, f64), Error> {
        let found = motion(scheme, steps)?;
        let difference = found.v.column(steps) - fine.v.column(FINE);
        Ok((END / steps as f64, difference.amax() / FAST))
    };
    let of_scheme = |scheme: Scheme| -> Result<Stiff, Error> {
        let errors: Result<Vec<_>, Error> =
            [10, 20, 40, 80, 160, 320].into_iter().map(|steps| error(scheme, steps)).collect();
        Ok(Stiff { scheme: scheme.name, errors: errors? })
    };
    Scheme::ALL.into_iter().map(of_scheme).collect()
}

/// The figure.
pub fn chart(measured: &[Stiff]) -> Chart {
    let series =
        |(stiff, colour): (&Stiff, Colour)| Series::new(stiff.scheme, stiff.errors.clone(), colour, Style::LineAndCircles);
    Chart {
        title: "two masses on a damper, rate 2e8 per s".to_owned(),
        x: Axis::log("Δt [s]", 0.0),
        y: Axis::log("error of the velocities at 1 s / largest velocity", 0.0),
        legend: Place::LowerRight,
        series: measured.iter().zip(COLOURS).map(series).collect(),
        ..Chart::default()
    }
}
