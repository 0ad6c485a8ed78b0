//! What the paper leaves open, as flags: they decide the mechanism, its inputs and the line search.

use clap::Parser;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, System};

use crate::error::Error;
use crate::flags::{finite, positive, shown};
use crate::plot::Caption;
use crate::steepest_descent::LineSearch;
use crate::table::{Row, Verdict};

/// N of the paper: t_f = 2 s in steps of 0.02 s.
const STEPS: usize = 100;
/// Δt of the paper, s.
const DT: f64 = 0.02;
/// The initial force F₀ of the paper, N.
const FORCE: f64 = 10.0;

/// The example, with everything the paper does not state marked as assumed.
#[derive(Parser, Clone, Debug, PartialEq)]
pub struct Settings {
    // What takes a real number takes whatever begins with a hyphen, since to clap -1e-3 is no negative number.
    /// Links of the pendulum
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=50), allow_negative_numbers = true)]
    pub links: u16,
    /// Length of a link in m [assumed: the paper does not state it]
    #[arg(long, value_name = "M", default_value_t = CartPendulum::default().link_length, value_parser = positive, allow_hyphen_values = true)]
    pub length: f64,
    /// Acceleration of gravity in m/s² (assumed)
    #[arg(long, value_name = "M/S²", default_value_t = CartPendulum::default().gravity, value_parser = finite, allow_hyphen_values = true)]
    pub gravity: f64,
    /// Hinge that has the friction c_rot, 0 being that of the cart and the first link (assumed)
    #[arg(long, value_name = "HINGE", default_value_t = 0, allow_negative_numbers = true)]
    pub friction_joint: u16,
    /// Iterations of steepest descent; the paper shows 300, and all are made unless J cannot be lowered any more
    #[arg(long, value_name = "COUNT", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub iterations: u32,
    #[command(flatten)]
    pub search: LineSearch,
    /// Draws the captions into the figures too; without it they are in the SVG's description and in a text file beside it
    #[arg(long)]
    pub captions: bool,
}

impl Settings {
    /// What they are without flags.
    pub fn usual() -> Self {
        Self::parse_from([""])
    }

    pub fn example(&self) -> CartPendulum {
        CartPendulum {
            links: self.links.into(),
            link_length: self.length,
            gravity: self.gravity,
            friction_joint: self.friction_joint.into(),
            ..CartPendulum::default()
        }
    }

    /// Its initial state and the constant force from which the optimisation starts.
    pub fn inputs(&self, system: &System) -> Inputs {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(STEPS, DT));
        inputs.controls.fill(FORCE);
        inputs
    }

    /// Whether the mechanism is that of the paper with the usual assumptions, for which reference values are known.
    pub fn usual_mechanism(&self) -> bool {
        self.example() == CartPendulum::default()
    }

    /// What the paper leaves open, and our choice.
    pub fn assumptions(&self) -> Vec<Row> {
        let LineSearch { first, armijo, shorten } = self.search;
        let (first, armijo, shorten) = (shown(first), shown(armijo), shown(shorten));
        let most = match self.usual_mechanism() && self.search == LineSearch::USUAL {
            true => "; of the choices that `assumptions` tries, this reproduces most of the paper's numbers",
            false => "",
        };
        let rows = [
            ("link length", format!("{} m, hinges at the ends, centre of mass in the middle", shown(self.length))),
            ("acceleration of gravity", format!("{} m/s²", shown(self.gravity))),
            ("hinge with friction", format!("that of {}", self.joined_with_friction())),
            ("backtracking line search", format!("Armijo: α = {first}, times {shorten} until c = {armijo} holds{most}")),
        ];
        rows.map(|(what, ours)| Row::new("Sect. 4", what, "not stated", ours, Verdict::Assumed)).to_vec()
    }

    /// Caption of a figure of the paper: whose it is, what is particular about it, and what is assumed, of the line search too where it counts.
    pub fn caption(&self, figure: u8, particular: &str, with_search: bool) -> Caption {
        let LineSearch { first, armijo, shorten } = self.search;
        let search = format!(
            ";\nline search: Armijo, α = {}, times {} until c = {} holds",
            shown(first),
            shown(shorten),
            shown(armijo)
        );
        let assumed = format!(
            "Assumed, since the paper does not state it: links of {} m, g = {} m/s², friction in the hinge of {}",
            shown(self.length),
            shown(self.gravity),
            self.joined_with_friction()
        );
        let end = if with_search { &search } else { "" };
        let text = format!("Fig. {figure} of the paper, as computed here{particular}.\n{assumed}{end}.");
        Caption { text, shown: self.captions }
    }

    /// What the hinge with friction joins.
    pub fn joined_with_friction(&self) -> String {
        match self.friction_joint {
            0 => "the cart and link 1".to_owned(),
            joint => format!("links {joint} and {}", joint + 1),
        }
    }

    /// Refuses flags that do not go together.
    pub fn check(&self) -> Result<(), Error> {
        let (joint, links) = (self.friction_joint, self.links);
        let problem =
            || format!("--friction-joint {joint}: hinges are numbered from 0, and {links} link(s) have {links} of them");
        if joint < links { Ok(()) } else { Err(Error::Usage(problem())) }
    }
}
