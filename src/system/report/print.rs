//! An element's programs as text.

use std::fmt::{self, Write};

use crate::System;
use crate::program::{Kernel, Program};
use crate::system::formula::{Block, BlockEntry, Component, Element, Kernels, Place, Slot};

impl Slot {
    fn name(self) -> String {
        match self {
            Slot::Q(i) => format!("q{i}"),
            Slot::V(i) => format!("v{i}"),
            Slot::Sigma(j) => format!("sigma{j}"),
            Slot::U(k) => format!("u{k}"),
            Slot::T => "t".into(),
            Slot::B(p) => format!("b{p}"),
            Slot::PStar(i) => format!("p_star{i}"),
            Slot::PStarDot(i) => format!("p_star_dot{i}"),
            Slot::VDot(i) => format!("v_dot{i}"),
            Slot::Lambda(j) => format!("lambda{j}"),
            Slot::UDot(k) => format!("u_dot{k}"),
        }
    }
}

impl Place {
    fn name(self) -> String {
        match self {
            Place::Of(slot) => slot.name(),
            Place::C(i) => format!("c{i}"),
            Place::D(i) => format!("d{i}"),
            Place::E(j) => format!("e{j}"),
            Place::Rate(slot) => format!("d{}", slot.name()),
        }
    }
}

impl Component {
    fn name(self) -> String {
        match self {
            Component::Momentum(i) => format!("L_v{i}"),
            Component::Force(i) => format!("force{i}"),
            Component::Equation(j) => format!("phi_dot{j}"),
        }
    }
}

impl BlockEntry {
    fn name(&self) -> String {
        let block = match self.block {
            Block::Vv => "L_vv",
            Block::Vq => "L_vq",
            Block::Qq => "L_qq",
            Block::ForceV => "Q_v",
            Block::ForceQ => "Q_q",
            Block::PhiQq => "sigma phi_qq",
            Block::PhiDotQq => "sigma phi_dot_qq",
            Block::PhiQ => "phi_q",
            Block::PhiDotQ => "phi_dot_q",
        };
        format!("{block}[{}, {}]", self.row, self.col)
    }
}

impl System {
    /// The programs of the element `name` as text: the instructions that run once and those that run at every point.
    pub fn program(&self, name: &str) -> Option<String> {
        self.0.formulas.elements.iter().find(|element| element.name == name).map(print)
    }
}

/// The text of all programs of an element.
fn print(element: &Element) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_all(element, &mut text);
    text
}

fn write_all(element: &Element, text: &mut String) -> fmt::Result {
    let formula = &element.formula;
    let Some(kernels) = &formula.kernels else {
        return writeln!(text, "`{}` has no program: num-dual differentiates it at every point", element.name);
    };
    let mut part = |what: &str, kernel: &Kernel, stage: usize, results: Vec<Names>| -> fmt::Result {
        if results.is_empty() {
            return Ok(());
        }
        let program = kernel.stage(stage);
        writeln!(text, "{what} of `{}`: {} instructions, {} registers", element.name, program.len(), program.registers())?;
        if stage == 0 {
            write_arguments(text, kernel, |which| formula.shape.place(which).name())?;
        } else {
            writeln!(text, "  after the first derivatives, in the same registers:")?;
        }
        write_program(text, program, &results)
    };
    part("constant second derivatives", &kernels.fixed, 0, formula.fixed.iter().map(|entry| plain(entry.name())).collect())?;
    if formula.is_varying() {
        part("first derivatives", &kernels.state, 0, names_of_components(kernels))?;
        let names = |(sign, part): (f64, BlockEntry)| (if sign < 0.0 { "-" } else { "" }, part.name());
        let entries = formula.varying.iter().map(|entry| entry.signed_parts().map(names).collect());
        part("second derivatives", &kernels.state, Kernels::SECOND, entries.collect())?;
    }
    let inputs = kernels.inputs.of.iter().map(|slot| format!("by {}", slot.name()));
    part("input derivatives", &kernels.inputs.kernel, 0, inputs.map(plain).collect())
}

/// The name of each result, with a sign.
type Names = Vec<(&'static str, String)>;

fn plain(name: String) -> Names {
    vec![("", name)]
}

fn names_of_components(kernels: &Kernels) -> Vec<Names> {
    let mut names: Vec<Names> = kernels.components.iter().map(|of| plain(of.name())).collect();
    names.iter_mut().zip(&kernels.negatives).for_each(|(names, of)| names.push(("-", of.name())));
    names
}

/// Lists the registers that are filled first: results of the prelude, and arguments.
fn write_arguments(text: &mut String, kernel: &Kernel, name: impl Fn(usize) -> String) -> fmt::Result {
    let fixed: Vec<String> = (0..kernel.fixed()).map(|k| format!("f{k}")).collect();
    if !fixed.is_empty() {
        writeln!(text, "  once, from b and the numbers in the formula:")?;
        write_registers(text, (0..kernel.prelude().arguments()).map(|p| format!("b{p}")))?;
        write_program(text, kernel.prelude(), &fixed.iter().cloned().map(plain).collect::<Vec<_>>())?;
        writeln!(text, "  at every point:")?;
    }
    write_registers(text, kernel.inputs().iter().map(|&which| name(which)).chain(fixed))
}

fn write_registers(text: &mut String, names: impl Iterator<Item = String>) -> fmt::Result {
    names.enumerate().try_for_each(|(register, name)| writeln!(text, "    r{register} = {name}"))
}

fn write_program(text: &mut String, program: &Program, results: &[Names]) -> fmt::Result {
    for line in program.to_string().lines() {
        writeln!(text, "    {line}")?;
    }
    for (register, names) in program.results().zip(results) {
        names.iter().try_for_each(|(sign, name)| writeln!(text, "    {name} = {sign}r{register}"))?;
    }
    Ok(())
}
