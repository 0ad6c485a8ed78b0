//! [`PositionConstraints`]: evaluates Φ of all constraints by programs; at a node, the stored sines and cosines are used for sinusoidal constraints,
//!
//! ```text
//!   Φ_j = c_j + Σ a q + Σ (α sin q + β cos q),      c_j = Φ_j(0) − Σ β
//! ```

use super::constants::Constants;
use super::sinusoidal_constraints::Sines;
use crate::System;
use crate::program::Kernel;
use crate::system::formula::{Alike, Element, ElementKind, ElementPrograms, Entry, Formula, Labelled, Layout, NodeView};

/// Programs for Φ, created when Φ is first needed during a motion.
pub(crate) struct PositionConstraints {
    layout: Layout,
    sinusoidal: Vec<ElementPrograms<usize>>,
    others: Vec<ElementPrograms<usize>>,
    /// Constraints without a program.
    plain: Vec<(usize, usize)>,
    point: Vec<f64>,
    /// c and a of the sinusoidal equations.
    rest: Vec<f64>,
    linear: Vec<Entry>,
}

impl PositionConstraints {
    pub(crate) fn new(system: &System, elements: &[Element]) -> Self {
        let layout = system.layout();
        let (mut sinusoidal, mut others, mut plain) = (Vec::new(), Vec::new(), Vec::new());
        for alike in Alike::all(elements).iter().filter(|alike| alike.formula.kind == ElementKind::Holonomic) {
            let Some(kernel) = kernel(alike.formula) else {
                plain.extend(alike.places());
                continue;
            };
            let program = Labelled { kernel: kernel.into(), of: (0..alike.formula.shape.m).collect() };
            let programs = if alike.formula.sinusoidal { &mut sinusoidal } else { &mut others };
            programs.extend(ElementPrograms::new(&layout, alike, program, |element, j: usize| element.to.sigma[j]));
        }
        let (point, rest) = (vec![0.0; layout.len()], vec![0.0; system.m()]);
        PositionConstraints { layout, sinusoidal, others, plain, point, rest, linear: Vec::new() }
    }

    /// Runs all preludes and computes c and a.
    pub(crate) fn fix(&mut self, elements: &[Element], design: &[f64], constants: &Constants) {
        let PositionConstraints { sinusoidal, others, point, rest, linear, .. } = self;
        let programs = sinusoidal.iter_mut().chain(others);
        programs.for_each(|programs| programs.fix(|e| elements[e].parameters(design)));
        point.fill(0.0);
        let mut is_sinusoidal = vec![false; rest.len()];
        for programs in sinusoidal {
            programs.run(point, |&equation, value| (rest[equation], is_sinusoidal[equation]) = (value, true));
        }
        constants.waves.iter().for_each(|wave| rest[wave.equation] -= wave.cosine);
        linear.clear();
        linear.extend(constants.phi_q.iter().filter(|entry| is_sinusoidal[entry.row]));
    }

    /// Evaluates Φ at any point.
    pub(crate) fn evaluate(&mut self, system: &System, at: &NodeView<f64>, phi: &mut [f64]) {
        self.layout.load(at, &mut self.point);
        for programs in &mut self.sinusoidal {
            programs.run(&self.point, |&equation, value| phi[equation] = value);
        }
        self.evaluate_others(system, at, phi);
    }

    /// Evaluates Φ at a node for which the blocks of the sinusoidal constraints are stored.
    pub(crate) fn evaluate_node(
        &mut self,
        system: &System,
        at: &NodeView<f64>,
        (sines, blocks): (&Sines, &[f64]),
        phi: &mut [f64],
    ) {
        phi.copy_from_slice(&self.rest);
        self.linear.iter().for_each(|entry| phi[entry.row] += entry.value * at.q[entry.col]);
        sines.add_phi(blocks, phi);
        if !self.others.is_empty() {
            self.layout.load(at, &mut self.point);
        }
        self.evaluate_others(system, at, phi);
    }

    fn evaluate_others(&mut self, system: &System, at: &NodeView<f64>, phi: &mut [f64]) {
        for programs in &mut self.others {
            programs.run(&self.point, |&equation, value| phi[equation] = value);
        }
        for item in self.plain.iter().map(|&place| system.item(place)) {
            item.phi(at, |j, x| phi[j] = x);
        }
    }
}

fn kernel(formula: &Formula) -> Option<Kernel> {
    let template = &formula.kernels.as_ref()?.template;
    let (mut graph, values) = template.graph();
    Kernel::new(&mut graph, template.parameters, &values)
}

#[cfg(test)]
mod tests {
    use crate::planar::Body;
    use crate::scene::scenes::CartPendulum;
    use crate::{Error, Grid, Inputs, Settings, Solver};

    #[test]
    fn at_a_node_they_are_those_at_its_point() -> Result<(), Error> {
        let mut scene = CartPendulum::with_links(3).scene();
        let arm = scene.design("arm", 0.4);
        let bob = scene.body("bob", 1.0, 0.1, [3.0, 0.0, 0.3]);
        scene.distance("rope", Body::GROUND.at(2.0, 0.0), bob.at(0.0, 0.0), 1.0);
        let wheel = scene.body("wheel", 1.0, 0.1, [0.0, 0.0, 0.0]);
        scene.revolute("axle", Body::GROUND.at(-0.4, 0.3), wheel.at(arm * -1.0, 0.3));
        let system = scene.compile()?;
        let mut solver = Solver::new(&system, Settings::default());
        let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.02));
        inputs.controls.fill(10.0);
        for arm in [0.4, 0.6] {
            // The second design moves the wheel's centre to the position that the axle requires.
            inputs.design[0] = arm;
            inputs.start.set_coordinate(wheel.coordinates[0], arm - 0.4);
            solver.simulate(&inputs)?;
            let forward = solver.forward_mut();
            let (motion, evaluation) = (&forward.motion, &mut forward.stepper.newton.linearisation.evaluation);
            let [mut by_programs, mut by_blocks] = [0, 1].map(|_| vec![0.0; system.m()]);
            for node in 1..motion.nodes() {
                evaluation.phi(&system, &motion.at(node), &mut by_programs);
                evaluation.phi_of_node(&system, &motion.at(node), motion.node_blocks(node), &mut by_blocks);
                let differences = by_programs.iter().zip(&by_blocks).map(|(x, y)| (x - y).abs());
                assert!(differences.fold(0.0, f64::max) < 1e-14, "{by_programs:?} {by_blocks:?}");
            }
        }
        Ok(())
    }
}
