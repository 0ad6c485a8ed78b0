//! Values that the paper does not state, as flags: they define the mechanism, its inputs and the line search.

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

/// The example; values that the paper does not state are marked as assumed.
#[derive(Parser, Clone, Debug, PartialEq)]
pub struct Settings {
    // Real-valued flags accept values that begin with a hyphen, because clap does not recognise -1e-3 as a negative number.
    /// Links of the pendulum
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=50), allow_negative_numbers = true)]
    pub links: u16,
    /// Length of a link in m [assumed: the paper does not state it]
    #[arg(long, value_name = "M", default_value_t = CartPendulum::default().link_length, value_parser = positive, allow_hyphen_values = true)]
    pub length: f64,
    /// Acceleration of gravity in m/s² (assumed)
    #[arg(long, value_name = "M/S²", default_value_t = CartPendulum::default().gravity, value_parser = finite, allow_hyphen_values = true)]
    pub gravity: f64,
    /// Hinge with the friction c_rot; 0 is the hinge between the cart and the first link (assumed)
    #[arg(long, value_name = "HINGE", default_value_t = 0, allow_negative_numbers = true)]
    pub friction_joint: u16,
    /// Iterations of steepest descent (300 in the paper); fewer are made if J cannot be lowered any more
    #[arg(long, value_name = "COUNT", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub iterations: u32,
    #[command(flatten)]
    pub search: LineSearch,
    /// Also draws the captions into the figures; without this flag they are in the SVG's description and in a text file beside it
    #[arg(long)]
    pub captions: bool,
}

impl Settings {
    /// The defaults.
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

    /// The initial state and the constant force from which the optimisation starts.
    pub fn inputs(&self, system: &System) -> Inputs {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(STEPS, DT));
        inputs.controls.fill(FORCE);
        inputs
    }

    /// True for the paper's mechanism with the default assumptions, for which reference values are known.
    pub fn usual_mechanism(&self) -> bool {
        self.example() == CartPendulum::default()
    }

    /// The values that the paper does not state, and our choices.
    pub fn assumptions(&self) -> Vec<Row> {
        let LineSearch { first, armijo, shorten } = self.search;
        let (first, armijo, shorten) = (shown(first), shown(armijo), shown(shorten));
        let most = match self.usual_mechanism() && self.search == LineSearch::USUAL {
            true => "; of the combinations that `assumptions` tests, this one reproduces the most of the paper's numbers",
            false => "",
        };
        let rows = [
            ("link length", format!("{} m, hinges at the ends, centre of mass in the middle", shown(self.length))),
            ("acceleration of gravity", format!("{} m/s²", shown(self.gravity))),
            ("hinge with friction", format!("that of {}", self.joined_with_friction())),
            (
                "backtracking line search",
                format!("Armijo: α = {first}, multiplied by {shorten} until the condition with c = {armijo} holds{most}"),
            ),
        ];
        rows.map(|(what, ours)| Row::new("Sect. 4", what, "not stated", ours, Verdict::Assumed)).to_vec()
    }

    /// Caption of a figure of the paper: its number, its particulars, and the assumptions, including the line search if it matters.
    pub fn caption(&self, figure: u8, particular: &str, with_search: bool) -> Caption {
        let LineSearch { first, armijo, shorten } = self.search;
        let search = format!(
            ";\nline search: Armijo, α = {}, multiplied by {} until the condition with c = {} holds",
            shown(first),
            shown(shorten),
            shown(armijo)
        );
        let assumed = format!(
            "Assumed, because the paper does not state it: links of {} m, g = {} m/s², friction in the hinge of {}",
            shown(self.length),
            shown(self.gravity),
            self.joined_with_friction()
        );
        let end = if with_search { &search } else { "" };
        let text = format!("Fig. {figure} of the paper, as computed here{particular}.\n{assumed}{end}.");
        Caption { text, shown: self.captions }
    }

    /// The bodies that the hinge with friction joins.
    pub fn joined_with_friction(&self) -> String {
        match self.friction_joint {
            0 => "the cart and link 1".to_owned(),
            joint => format!("links {joint} and {}", joint + 1),
        }
    }

    /// Checks that the flags are consistent.
    pub fn check(&self) -> Result<(), Error> {
        let (joint, links) = (self.friction_joint, self.links);
        let problem = || format!("--friction-joint {joint}: {links} link(s) have {links} hinge(s), numbered from 0");
        if joint < links { Ok(()) } else { Err(Error::Usage(problem())) }
    }
}
