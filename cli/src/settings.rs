//! Options of the simulation; the library checks their values.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use hamiltonian_adjoint::{Scheme, Settings};

/// The names of [`Scheme::ALL`].
const SCHEMES: [&str; 5] = ["trapezoidal", "tr-bdf2", "esdirk3", "esdirk4", "esdirk5"];

#[derive(Args)]
#[command(next_help_heading = "Motion")]
pub struct Motion {
    /// Integration scheme
    #[arg(long, default_value = SCHEMES[0], value_parser = PossibleValuesParser::new(SCHEMES).map(scheme))]
    scheme: Scheme,
    /// Tolerance of Newton's method, relative to the size of velocities and multipliers
    #[arg(long, default_value = "1e-14", value_name = "X")]
    tolerance: f64,
    /// Largest number of Newton iterations in a step
    #[arg(long, default_value_t = Settings::default().max_iterations, value_name = "N")]
    max_iterations: usize,
    /// Largest violation of a constraint at the start, m or rad
    #[arg(long, default_value = "1e-9", value_name = "X")]
    position_tolerance: f64,
    /// Largest violation of a constraint by the velocities at the start, m/s or rad/s
    #[arg(long, default_value = "1e-9", value_name = "X")]
    velocity_tolerance: f64,
    /// Largest number of times that a step without a solution is halved
    #[arg(long, default_value_t = Settings::default().max_halvings, value_name = "N")]
    max_halvings: usize,
    /// Violation of constraints at which positions are projected, m or rad; `inf` for never
    #[arg(long, default_value_t = Settings::default().drift_bound, value_name = "X")]
    drift_bound: f64,
    /// Number of macro steps after which multipliers are reset; 0 for never, 1 for motions of many thousand steps
    #[arg(long, default_value_t = Settings::default().rebase_every, value_name = "N")]
    rebase_every: usize,
}

fn scheme(name: String) -> Scheme {
    Scheme::ALL[SCHEMES.iter().position(|known| *known == name).unwrap_or(0)]
}

impl Motion {
    pub fn settings(&self) -> Settings {
        Settings {
            scheme: self.scheme,
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            position_tolerance: self.position_tolerance,
            velocity_tolerance: self.velocity_tolerance,
            max_halvings: self.max_halvings,
            drift_bound: self.drift_bound,
            rebase_every: self.rebase_every,
            ..Settings::default()
        }
    }
}
