//! [`Kernel`]: a program for elements with a common formula, in two parts: one runs once, the other at every point.

use super::expression::Node;
use super::graph::Graph;
use super::program::Program;

/// Programs that compute some nodes of a graph.
///
/// The `prelude` computes everything that depends on constants and parameters only, once per element and set of design variables. Its results are
/// arguments of the `main` program, after the inputs. `main` may have stages; each continues at the same point, with the registers of earlier stages.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    /// The numbers of the inputs that are used, in the order of the program's arguments.
    inputs: Vec<usize>,
    prelude: Program,
    stages: Vec<Program>,
}

impl Kernel {
    /// Compiles results for elements with `parameters` parameters; `None` if a program is too long.
    pub(crate) fn new(graph: &mut Graph, parameters: usize, results: &[Node]) -> Option<Self> {
        Kernel::in_stages(graph, parameters, &[results])
    }

    /// As [`new`](Self::new), with the results of each stage.
    pub(crate) fn in_stages(graph: &mut Graph, parameters: usize, results: &[&[Node]]) -> Option<Self> {
        let parameters: Vec<Node> = (0..parameters).map(|which| graph.parameter(which)).collect();
        let all = graph.factored(&results.concat());
        let mut rest = &all[..];
        let stages: Vec<&[Node]> = results.iter().map(|stage| rest.split_off(..stage.len()).unwrap_or_default()).collect();
        let (mut inputs, mut arguments, mut fixed) = (Vec::new(), Vec::new(), Vec::new());
        for node in graph.edge(&all) {
            if let Some(which) = graph.expression(node).input() {
                inputs.push(which);
                arguments.push(node);
            } else {
                fixed.push(node);
            }
        }
        let prelude = Program::in_stages(graph, &parameters, &[&fixed])?.pop()?;
        arguments.extend(fixed);
        Some(Kernel { inputs, prelude, stages: Program::in_stages(graph, &arguments, &stages)? })
    }

    /// The numbers of the inputs that are used.
    pub(crate) fn inputs(&self) -> &[usize] {
        &self.inputs
    }

    /// The number of results of the prelude.
    pub(crate) fn fixed(&self) -> usize {
        self.prelude.results().len()
    }

    /// The program that runs at every point, or its first stage.
    pub(crate) fn main(&self) -> &Program {
        self.stage(0)
    }

    pub(crate) fn stage(&self, which: usize) -> &Program {
        &self.stages[which]
    }

    pub(crate) fn prelude(&self) -> &Program {
        &self.prelude
    }

    /// Runs the prelude for one element.
    pub(crate) fn run_prelude(&self, parameters: &[f64], put: impl FnMut(usize, f64)) {
        run_once(std::slice::from_ref(&self.prelude), parameters, put);
    }

    /// The results of all stages for one element; slow, for use once per run.
    pub(crate) fn evaluate(&self, parameters: &[f64], input: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut arguments: Vec<f64> = self.inputs.iter().map(|&which| input(which)).collect();
        self.run_prelude(parameters, |_, value| arguments.push(value));
        let mut results = Vec::new();
        run_once(&self.stages, &arguments, |_, value| results.push(value));
        results
    }
}

fn run_once(stages: &[Program], arguments: &[f64], mut put: impl FnMut(usize, f64)) {
    let mut registers = vec![[0.0; 1]; stages.first().map_or(0, Program::registers)];
    for program in stages {
        let given = arguments[..program.arguments()].iter().chain(program.constants());
        registers.iter_mut().zip(given).for_each(|(register, value)| *register = [*value]);
        program.run(&mut registers);
        program.results().enumerate().for_each(|(k, register)| put(k, registers[register][0]));
    }
}
