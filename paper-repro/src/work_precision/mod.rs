//! `work-precision`: errors against run time, for schemes of order 2 to 6 and for ways to the gradient.
//!
//! The problem is the paper's mechanism under the constant force that its optimisation starts from. J(x) with a force that is
//! piecewise linear on 101 knots with values x, 0.02 s apart, is a smooth function of x as long as nothing but the motion between knots
//! is discretised. Where macro steps end on all knots and each has the values of its own linear piece, a scheme of order p solves a smooth
//! problem between knots: J_Δt(x) − J(x) = C(x) Δt^p + …, and so has its gradient order p, kinks or not. Grids coarser than
//! the knots see only some of the x, and their gradients are not compared.

mod convergence;
mod exactness;
mod figures;
mod findings;
mod knots;
mod methods;
mod order;
mod reference;
mod stopwatch;
mod tables;

use std::path::PathBuf;
use std::time::Duration;

use hamiltonian_adjoint::{Composition, scenes::CartPendulum};
use serde::Serialize;

use crate::error::Error;
use crate::files;
use crate::table::Verdict;
use convergence::{Convergence, Reading};
use exactness::Exactness;
use methods::Methods;
use stopwatch::Repeats;

/// Measures errors against run time and writes figures, tables and numbers
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Folder for the files [default: paper-repro/out]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Fewer grids and repeats: some seconds, for tests of the program
    #[arg(long)]
    short: bool,
}

/// Everything that was measured.
#[derive(Serialize)]
pub struct Measured {
    convergence: Vec<Convergence>,
    exactness: Vec<Exactness>,
    methods: Methods,
}

/// Measures, writes the files, prints the table; false if an order or an exactness is not as it must be.
pub fn run(options: &Options) -> Result<bool, Error> {
    let folder = files::folder(options.out.as_deref())?;
    let measured = measure(options.short)?;
    figures::draw(&measured, &folder)?;
    let findings = findings::all(&measured);
    let tables = tables::all(&measured, &findings);
    let markdown: Vec<String> = tables.iter().map(|table| table.markdown.clone()).collect();
    files::write(&folder.join("work_precision.md"), markdown.join("\n"))?;
    let mut json = serde_json::json!(measured);
    json["findings"] = serde_json::json!(findings::rows(&findings));
    files::write_json(&folder.join("work_precision.json"), &json)?;
    let text: String = tables.iter().map(|table| table.text.clone() + "\n").collect();
    let place = folder.display();
    files::print(&format!("{text}figures, work_precision.md and work_precision.json are in {place}\n"))?;
    Ok(findings.iter().all(|finding| finding.verdict != Verdict::Failed))
}

/// Measures everything.
fn measure(short: bool) -> Result<Measured, Error> {
    let system = CartPendulum::default().scene().compile()?;
    let repeats = match short {
        true => Repeats { turns: 3, turn: Duration::from_millis(2) },
        false => Repeats { turns: 9, turn: Duration::from_millis(30) },
    };
    let mut cases = Composition::ALL.map(|composition| (composition, Reading::Piece)).to_vec();
    cases.push((Composition::Yoshida6, Reading::Time));
    let macro_steps: &[usize] = if short { &[25] } else { &[25, 50, 100, 200] };
    let decades = if short { 1 } else { 3 };
    let sizes: Vec<f64> = (0..=12 * decades).map(|i| 10f64.powf(-f64::from(i) / f64::from(decades))).collect();
    Ok(Measured {
        convergence: convergence::measure(&system, &cases, short, repeats)?,
        exactness: exactness::measure(&system, macro_steps)?,
        methods: methods::measure(&system, &sizes, repeats)?,
    })
}

/// What a composition is called in figures and tables.
fn name(composition: Composition) -> &'static str {
    match composition {
        Composition::Trapezoidal => "trapezoidal rule",
        Composition::Suzuki4 => "Suzuki, order 4",
        Composition::Yoshida6 => "Yoshida, order 6",
        Composition::KahanLi6 => "Kahan–Li, order 6",
    }
}

#[cfg(test)]
mod tests {
    use crate::{Cli, Command};
    use clap::{CommandFactory, Parser};

    #[test]
    fn it_stands_beside_the_parts_of_the_paper() {
        Cli::command().debug_assert();
        let command = |line: &str| Cli::try_parse_from(line.split(' ')).map(|cli| (cli.command, cli.parts.len()));
        let options = match command("paper-repro work-precision --short --out folder") {
            Ok((Some(Command::WorkPrecision(options)), 0)) => options,
            _ => panic!("not understood"),
        };
        assert!(options.short && options.out.is_some());
        assert!(matches!(command("paper-repro fig1 timing --out folder"), Ok((None, 2))));
        assert!(matches!(command("paper-repro"), Ok((None, 0))));
        // Its problem is that of the references, without flags for another.
        assert!(command("paper-repro work-precision --links 2").is_err());
    }
}
