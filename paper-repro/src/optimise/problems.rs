//! The optimisation problems, and their formulation for the methods.

use std::f64::consts::FRAC_PI_2;

use clap::ValueEnum;
use hamiltonian_adjoint::optimize::{Free, Interval};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Control, EndState, Error as MotionError, Grid, Inputs, Output, Settings, Sum, System};

/// Optimisation problem.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum Name {
    /// The paper's cost, below 1e-10
    Paper,
    /// 1e-4 ∫ u² dt, links upright at 2 s
    Effort,
    /// 1e-4 ∫ u² dt, links at rest at 2.5 s
    Rest,
    /// 1e-4 ∫ u² dt, links at rest at 2 s
    #[value(name = "rest-2")]
    RestSooner,
    /// The shortest time, |u| ≤ 50 N, links upright
    Time,
    /// The shortest time, |u| ≤ 50 N, links at rest
    TimeRest,
    /// The shortest time of a pendulum on a rail with ends, |u| ≤ 100 N, from hanging to rest above
    Rail,
    /// Three links with motors from hanging to rest upright in 1.5 s, least effort
    Arm,
    /// Three links as in `arm`, with limits of the elbow and of the tip at all of 201 nodes
    ArmLimits,
    /// Ten links with motors and friction in the joints from hanging to rest in a quarter of a circle in 2 s, least effort
    Chain,
    /// As `chain`, with 500 steps
    #[value(name = "chain-500")]
    ChainFiner,
    /// As `chain`, with 2,000 steps
    #[value(name = "chain-2000")]
    ChainFinest,
    /// Two links with a motor between them, |torque| ≤ 20 N m, from hanging to rest upright in 3 s, least effort
    Acrobot,
    /// A driven crank and rocker: periodic motion with one turn in 1 s and the least effort
    Periodic,
    /// Lengths and pivots of a crank and rocker for which a point follows an ellipse; best of 20 random starts
    FourBar,
    /// Mass, friction and spring of a slider-crank from 5 noisy records of its crank's angle
    Identify,
}

impl Name {
    pub fn text(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// True if the states at the start and at the end are known, so that `solve` has a guess.
    pub fn has_ends(self) -> bool {
        !matches!(self, Name::Paper | Name::Periodic | Name::FourBar | Name::Identify)
    }

    /// True for the problems of the paper's cart.
    pub fn is_cart(self) -> bool {
        use Name::{Effort, Paper, Rest, RestSooner, Time, TimeRest};
        matches!(self, Paper | Effort | Rest | RestSooner | Time | TimeRest)
    }

    fn at_rest(self) -> bool {
        matches!(self, Name::Rest | Name::RestSooner | Name::TimeRest)
    }

    /// s.
    pub fn duration(self) -> f64 {
        match self {
            Name::Rest | Name::TimeRest => 2.5,
            Name::Periodic => 1.0,
            _ => 2.0,
        }
    }
}

/// A problem: the system, the initial inputs, their free parts, and the outputs.
pub struct Posed {
    pub system: System,
    pub settings: Settings,
    pub inputs: Inputs,
    pub control: Control,
    pub free: Vec<Free>,
    /// Intervals of the outputs.
    pub constraints: Vec<(Output, Interval)>,
    /// The lines that animations draw for coordinates of no body.
    pub lines: &'static [Line],
}

/// The name of a line, and its points (x, y), m, as a function of the coordinates q.
pub type Line = (&'static str, fn(&[f64]) -> Vec<[f64; 2]>);

/// A problem of the paper's cart.
pub fn cart(name: Name) -> Result<Posed, MotionError> {
    let mut cart = CartPendulum::default().mechanism();
    let control = cart.force;
    let (place, angles) = (cart.cart.coordinates[0], cart.links.iter().map(|link| link.coordinates[2]).collect::<Vec<_>>());
    if name == Name::Paper {
        for (j, angle) in (1..).zip(&angles) {
            cart.scene.cost(&format!("angle {j}"), AngleError, Sum::Terminal, [*angle], [], [], [FRAC_PI_2.into()]);
        }
    }
    let states: Vec<EndState> = std::iter::once(place).chain(angles).map(|q| cart.scene.end_state(q)).collect();
    let (upright, speed) = (Interval::equal(FRAC_PI_2), if name.at_rest() { Interval::ZERO } else { Interval::FREE });
    let positions = states.iter().enumerate().map(|(j, of)| (of.position, if j == 0 { Interval::FREE } else { upright }));
    let constraints = positions.chain(states.iter().map(|of| (of.rate, speed))).collect();
    let is_timed = matches!(name, Name::Time | Name::TimeRest);
    if is_timed {
        cart.scene.time("time", 1.0);
    } else if name != Name::Paper {
        cart.scene.effort("effort", control, 1e-4);
    }
    let free = match is_timed {
        true => vec![Free::control(control).within(-50.0, 50.0).scaled(10.0), Free::duration().within(0.5, 5.0)],
        false => vec![Free::control(control)],
    };
    let system = cart.scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, name.duration() / 100.0));
    inputs.controls.fill(10.0);
    Ok(Posed { system, settings: Settings::default(), inputs, control, free, constraints, lines: &[] })
}
