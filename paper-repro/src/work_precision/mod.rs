//! `work-precision`: error against run time, for schemes of order 2 to 6 and for several methods to compute the gradient.
//!
//! The problem is the paper's mechanism under the constant force at which its optimisation starts. The force is piecewise linear on 101
//! knots with values x, 0.02 s apart, and J(x) is a smooth function of x. If macro steps end at all knots and each uses the values of its
//! own linear piece, a scheme of order p solves a smooth problem between knots: J_Δt(x) − J(x) = C(x) Δt^p + …, and the gradient has
//! order p despite the kinks. Grids coarser than the knots depend on some of the x only, and their gradients are not compared.

mod convergence;
mod exactness;
mod figures;
mod findings;
mod knots;
mod methods;
mod order;
mod reference;
mod stiff;
mod tables;
mod tolerance;

use std::path::Path;
use std::time::Duration;

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Composition, Grid, Inputs, Scheme, Settings, System};
use serde::Serialize;

use crate::bar::bar;
use crate::error::Error;
use crate::files;
use crate::plot::{Colour, colour};
use crate::stopwatch::Repeats;
use crate::table::Verdict;
use convergence::Convergence;
use exactness::Exactness;
use knots::Reading;
use methods::Methods;
use reference::{END, FORCE};
use stiff::Stiff;
use tolerance::Tolerance;

/// Measures errors against run time and writes figures, tables and numbers
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Use fewer grids and repeats; takes some seconds, for tests of the program
    #[arg(long)]
    pub short: bool,
}

/// A method for a macro step: a scheme and the composition of its steps.
#[derive(Clone, Copy, Debug)]
struct Method {
    /// Name in figures and tables.
    name: &'static str,
    scheme: Scheme,
    composition: Composition,
    /// Number of macro steps of the finest grid, at the onset of rounding errors, and of the finest grid of short runs.
    finest: usize,
    finest_short: usize,
    colour: Colour,
}

const fn method(
    name: &'static str,
    scheme: Scheme,
    composition: Composition,
    (finest, finest_short): (usize, usize),
    colour: Colour,
) -> Method {
    Method { name, scheme, composition, finest, finest_short, colour }
}

const RULE: Scheme = Scheme::TRAPEZOIDAL;

/// The method whose inner nodes lie outside their macro steps.
const YOSHIDA: Method = method("Yoshida, order 6", RULE, Composition::Yoshida6, (800, 400), colour::GREEN);

/// The methods that are compared; a further method needs only a line here.
const METHODS: [Method; 6] = [
    method("trapezoidal rule", RULE, Composition::Trapezoidal, (3200, 800), colour::BLUE),
    method("Suzuki, order 4", RULE, Composition::Suzuki4, (1600, 400), colour::RED),
    YOSHIDA,
    method("Kahan–Li, order 6", RULE, Composition::KahanLi6, (800, 400), colour::PURPLE),
    method("TR-BDF2", Scheme::TR_BDF2, Composition::Trapezoidal, (3200, 800), colour::SKY),
    method("ESDIRK4", Scheme::ESDIRK4, Composition::Trapezoidal, (1600, 400), colour::ORANGE),
];

impl Method {
    /// Implicit stages per macro step.
    fn stages(&self) -> usize {
        self.composition.stages() * self.scheme.stages()
    }

    /// The theoretical order; a composition raises that of the trapezoidal rule.
    fn order(&self) -> usize {
        self.composition.order().max(self.scheme.order)
    }

    fn settings(&self) -> Settings {
        Settings { scheme: self.scheme, ..Settings::default() }
    }

    /// The motion of the references on the given grid.
    fn constant_force(&self, system: &System, macro_steps: usize) -> Inputs {
        let grid = Grid::composed(macro_steps, END / macro_steps as f64, self.composition);
        let mut inputs = Inputs::at_rest(system, grid);
        inputs.controls.fill(FORCE);
        inputs
    }
}

#[derive(Serialize)]
pub struct Measured {
    convergence: Vec<Convergence>,
    exactness: Vec<Exactness>,
    methods: Methods,
    tolerances: Vec<Tolerance>,
    stiff: Vec<Stiff>,
}

/// Measures, writes the files and prints the table; false if an order or an error is not as required.
pub fn run(options: &Options, folder: &Path) -> Result<bool, Error> {
    let measured = measure(options.short)?;
    figures::draw(&measured, folder)?;
    let findings = findings::all(&measured);
    let tables = tables::all(&measured, &findings);
    let markdown = tables.each_ref().map(|(title, table)| format!("### {title}\n\n{}", table.markdown()));
    files::write(&folder.join("work_precision.md"), markdown.join("\n"))?;
    let mut json = serde_json::json!(measured);
    json["findings"] = serde_json::json!(findings::rows(&findings));
    files::write_json(&folder.join("work_precision.json"), &json)?;
    let text: String = tables.iter().map(|(title, table)| format!("{title}\n\n{}\n", table.text())).collect();
    let place = folder.display();
    files::print(&format!("{text}figures, work_precision.md and work_precision.json are in {place}\n"))?;
    Ok(findings.iter().all(|finding| finding.verdict != Verdict::Failed))
}

fn measure(short: bool) -> Result<Measured, Error> {
    let system = CartPendulum::default().scene().compile()?;
    let repeats = match short {
        true => Repeats { turns: 3, turn: Duration::from_millis(2) },
        false => Repeats { turns: 9, turn: Duration::from_millis(30) },
    };
    let mut cases = METHODS.map(|method| (method, Reading::Piece)).to_vec();
    cases.push((YOSHIDA, Reading::Time));
    let macro_steps: &[usize] = if short { &[25] } else { &[25, 50, 100, 200] };
    let decades = if short { 1 } else { 3 };
    let sizes: Vec<f64> = (0..=12 * decades).map(|i| 10f64.powf(-f64::from(i) / f64::from(decades))).collect();
    let bar = bar("work-precision", 5);
    let begin = |part: &'static str| {
        bar.set_message(part);
        bar.tick();
        bar.inc(1);
    };
    begin("convergence");
    let convergence = convergence::measure(&system, &cases, short, repeats)?;
    begin("exactness");
    let exactness = exactness::measure(&system, macro_steps)?;
    begin("methods for the gradient");
    let methods = methods::measure(&system, &sizes, repeats)?;
    begin("grids by tolerance");
    let tolerances = tolerance::measure(short)?;
    begin("stiffness");
    let stiff = stiff::measure()?;
    bar.finish_and_clear();
    Ok(Measured { convergence, exactness, methods, tolerances, stiff })
}
