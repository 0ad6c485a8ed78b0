//! Checks of hand-derived blocks of the step's tangent matrices ∂f_i/∂y_i, ∂f_i/∂y_{i−1}, ∂f_i/∂u_i (Eq. 10, 11), and of f_i itself.
//!
//! Everything refers to the step from node i − 1 to node i; where the paper's Eq. (10) has i and i + 1, read i − 1 and i.

mod point;
mod terms;

pub use point::{State, StepPoint};
pub use terms::Terms;

use std::ops::Range;

use super::block::{Block, Change};
use super::draw::{Drawn, check_tolerance};
use super::formula::Formula;
use super::matrix::Matrix;
use super::plan::Plan;
use super::reference::Jacobian;
use super::report::Report;
use super::setting::Setting;
use crate::motion::check_size;
use crate::number::Random;
use crate::number::Real;
use crate::paper_system::{Arguments, Equation, PaperSystem, Variable, part};
use crate::program::Symbol;
use crate::system::NodeView;
use crate::{Error, Scalar, System};
use point::{Part, Places};

const TITLE: &str = "tangent matrices of a step";
/// Distance of random points from the motion, relative to the sizes that occur in it.
const SPREAD: f64 = 0.3;

/// A check of hand-derived blocks of the tangent matrices of a step, created by [`step`].
#[must_use = "a check does nothing until it is run"]
pub struct StepCheck<'a> {
    paper: &'a PaperSystem<'a>,
    nodes: Vec<usize>,
    seed: u64,
    spread: f64,
    tolerance: f64,
    /// The names of the constraint equations.
    equations: Vec<String>,
    /// The blocks, each with the equation of its rows.
    blocks: Vec<(Equation, Block<'a>)>,
}

/// Checks hand-derived blocks of the tangent matrices of a step, at nodes of a motion.
///
/// The points are random states near the motion for which Eq. (2) holds. On the motion itself symmetry or rest may hide wrong terms.
///
/// ```
/// use hamiltonian_adjoint::paper_system::{Equation::F5, PaperSystem, Variable::V};
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, check, scenes::CartPendulum, simulate};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
/// inputs.controls.fill(10.0);
/// let motion = simulate(&system, &inputs, Settings::default())?;
/// let paper = PaperSystem::new(&system, &inputs, &motion)?;
/// let report = check::step(&paper).f_y_previous(F5, V, |at| -at.terms().phi_q).run();
/// report.assert_passed();
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
pub fn step<'a>(paper: &'a PaperSystem<'a>) -> StepCheck<'a> {
    let last = paper.inputs.grid.steps.len();
    let mut random = Random::new(7);
    let nodes = if last == 0 { Vec::new() } else { (0..4).map(|_| 1 + random.below(last)).collect() };
    let equations = (0..paper.system.m()).map(|j| paper.system.equation_name(j).to_string()).collect();
    StepCheck { paper, nodes, seed: 1, spread: SPREAD, tolerance: 1e-11, equations, blocks: Vec::new() }
}

/// Rows of f_i as a function of y_i, y_{i−1}, u_i, b and the index i.
struct Residual<'a> {
    paper: &'a PaperSystem<'a>,
    rows: Range<usize>,
}

impl Formula for Residual<'_> {
    fn value<R: Real>(&self, x: &[R]) -> Vec<R> {
        let places = Places(self.paper);
        let list = |range: Range<usize>| nalgebra::DVector::from_column_slice(&x[range]);
        let len = places.len_of_y();
        let at = Arguments {
            y: list(0..len),
            y_previous: list(len..2 * len),
            u: list(places.of(Part::Controls)),
            u_beside: [0, 1].map(|_| list(places.of(Part::Controls))),
            b: list(places.of(Part::Design)),
        };
        let node = x[places.of(Part::Node).start].part(0).round() as usize;
        self.paper.residual(node, &at).as_slice()[self.rows.clone()].to_vec()
    }

    /// The elements at y_i, for which V = v_i.
    fn symbols(&self, x: &[Symbol]) -> Vec<Symbol> {
        let (paper, places) = (self.paper, Places(self.paper));
        let state = [Variable::Q, Variable::V, Variable::Sigma].map(|variable| &x[places.of(Part::Y(variable))]);
        let node = x[places.of(Part::Node).start].re().round() as usize;
        let time = Symbol::from(paper.trajectory.times[node]);
        let design = paper.system.parameters().values(&x[places.of(Part::Design)]);
        paper.system.symbols(&NodeView::of_equations(state, (&x[places.of(Part::Controls)], time, &design)))
    }
}

impl<'a> StepCheck<'a> {
    /// Sets the nodes, 1 … N, at which to compare (4 random ones by default).
    pub fn nodes(mut self, nodes: impl IntoIterator<Item = usize>) -> Self {
        self.nodes = nodes.into_iter().collect();
        self
    }

    /// Sets the seed of the random states.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Compares on the motion itself instead of at random states near it.
    pub fn on_the_motion(mut self) -> Self {
        self.spread = 0.0;
        self
    }

    /// Names the constraint equations, in the scene's order.
    pub fn equations<'n>(mut self, names: impl IntoIterator<Item = &'n str>) -> Self {
        self.equations = names.into_iter().map(|name| format!("`{name}`")).collect();
        self
    }

    /// Sets the tolerance of an entry, relative to the size of its row and column (1e-11 by default).
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Adds the values of one equation of f_i itself.
    pub fn f<A: Matrix>(self, equation: Equation, hand: impl Fn(&StepPoint) -> A + 'a) -> Self {
        self.block(format!("{}_i", equation.name()), equation, Part::One, hand)
    }

    /// Adds a block of ∂f_i/∂y_i, the left matrix of Eq. (10).
    pub fn f_y<A: Matrix>(self, equation: Equation, variable: Variable, hand: impl Fn(&StepPoint) -> A + 'a) -> Self {
        self.block(format!("∂{}_i/∂{}_i", equation.name(), variable.name()), equation, Part::Y(variable), hand)
    }

    /// Adds a block of ∂f_i/∂y_{i−1}, the right matrix of Eq. (10).
    pub fn f_y_previous<A: Matrix>(
        self,
        equation: Equation,
        variable: Variable,
        hand: impl Fn(&StepPoint) -> A + 'a,
    ) -> Self {
        let name = format!("∂{}_i/∂{}_(i−1)", equation.name(), variable.name());
        self.block(name, equation, Part::Previous(variable), hand)
    }

    /// Adds the rows of one equation of ∂f_i/∂u_i.
    pub fn f_u<A: Matrix>(self, equation: Equation, hand: impl Fn(&StepPoint) -> A + 'a) -> Self {
        self.block(format!("∂{}_i/∂u_i", equation.name()), equation, Part::Controls, hand)
    }

    /// Adds the rows of one equation of ∂f_i/∂b.
    pub fn f_b<A: Matrix>(self, equation: Equation, hand: impl Fn(&StepPoint) -> A + 'a) -> Self {
        self.block(format!("∂{}_i/∂b", equation.name()), equation, Part::Design, hand)
    }

    fn block<A: Matrix>(mut self, name: String, equation: Equation, by: Part, hand: impl Fn(&StepPoint) -> A + 'a) -> Self {
        let (paper, places) = (self.paper, Places(self.paper));
        let f = Residual { paper, rows: part(equation as usize, paper.system.n(), paper.system.m()) };
        let hand = Box::new(move |x: &[f64]| hand(&StepPoint::new(paper, x)).dense());
        let block = Block {
            terms: terms::of_block(paper, equation, by),
            others: terms::all(paper),
            elsewhere: other_nodes(places),
            ..Block::new(name, Jacobian::new(f, places.of(by)), hand)
        };
        self.blocks.push((equation, block));
        self
    }

    /// Compares all given blocks.
    ///
    /// If nothing can be compared, the report's `refused` gives the reason: an invalid tolerance, or a wrong number of equation names.
    pub fn run(self) -> Report {
        Plan::run(self.plan(), TITLE.to_string())
    }

    /// The points and the true values of all given blocks as JSON, for a program in another language that adds its own values: see
    /// [`Answers`](super::Answers).
    ///
    /// # Errors
    /// The reasons for which [`run`](Self::run) compares nothing.
    #[cfg(feature = "files")]
    pub fn worksheet(self) -> Result<String, Error> {
        let paper = self.paper;
        Ok(self.plan()?.worksheet(TITLE, |x| StepPoint::new(paper, x)))
    }

    fn plan(self) -> Result<Plan<'a>, Error> {
        check_size("names of the constraint equations", self.paper.system.m(), self.equations.len())?;
        check_tolerance(self.tolerance)?;
        let steps = self.paper.inputs.grid.steps.len();
        let mut setting = self.setting(Places(self.paper));
        if self.nodes.iter().any(|&node| node == 0 || node > steps) {
            setting.drawn.notes.push(format!("nodes outside 1 … {steps} were left out: f_0 is not a step"));
        }
        let rows = |equation| row_names(self.paper.system, equation, &self.equations);
        let blocks = self.blocks.into_iter().map(|(equation, block)| Block { rows: rows(equation), ..block });
        Ok(Plan::new(setting, blocks))
    }

    fn setting(&self, places: Places<'a>) -> Setting<'a> {
        let mut random = Random::new(self.seed);
        let (paper, steps) = (self.paper, &self.paper.inputs.grid.steps);
        let nodes = || self.nodes.iter().copied().filter(|&node| node > 0 && node <= steps.len());
        let magnitudes = point::magnitudes(paper);
        let near = |node| places.near(node, &magnitudes, self.spread, &mut random);
        let drawn = Drawn::of(nodes().map(near).collect());
        let dt: Vec<f64> = nodes().map(|node| steps[node - 1]).collect();
        let factor = |dt: f64| [("γ", 2.0 / dt), ("Δt", dt), ("γ²", 4.0 / (dt * dt))].map(|(name, x)| (name.to_string(), x));
        let same = dt.windows(2).all(|pair| pair[0] == pair[1]);
        Setting {
            free: places.free(),
            settle: Box::new(move |x| places.settle(x)),
            factors: dt.first().filter(|_| same).map(|&dt| factor(dt).to_vec()).unwrap_or_default(),
            ..Setting::new(drawn, self.seed, self.tolerance, point::names(paper, &self.equations), magnitudes)
        }
    }
}

fn row_names(system: &System, equation: Equation, equations: &[String]) -> Vec<String> {
    match equation {
        Equation::F5 => equations.iter().map(|name| format!("dΦ/dt of {name}")).collect(),
        _ => (0..system.n()).map(|i| format!("{} of `{}`", equation.name(), system.coordinate_name(i))).collect(),
    }
}

/// Changes of a point that replace parts of the present state by those of the previous node.
fn other_nodes(places: Places) -> Vec<(String, Change)> {
    let other = |name: &str, which: &'static [Variable]| -> (String, Change) {
        (format!("at {name} of node i − 1 instead of i"), Box::new(move |x| places.take_previous(x, which)))
    };
    vec![
        other("q, v, σ", &[Variable::Q, Variable::V, Variable::Sigma]),
        other("q", &[Variable::Q]),
        other("v", &[Variable::V]),
        other("σ", &[Variable::Sigma]),
        other("q and v", &[Variable::Q, Variable::V]),
        other("q and σ", &[Variable::Q, Variable::Sigma]),
    ]
}
