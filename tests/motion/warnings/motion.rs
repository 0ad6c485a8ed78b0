//! A motion on grids of any fineness, and how far its gradient changes with them.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::{Composition, Gradient, Grid, Inputs, Scene, Settings, Solver, Sum, System, Warning};

use super::elements::{self, Element};

/// Functions of time that the controls are made of, hats over the duration.
const HATS: usize = 6;

pub struct Motion {
    pub system: System,
    pub what: Vec<Element>,
    pub duration: f64,
    pub steps: usize,
    pub composition: Composition,
    pub settings: Settings,
    v0: Option<Vec<f64>>,
    push: f64,
    frequency: f64,
}

/// A number between two, all decades alike.
pub fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.uniform(0.0, 1.0))
}

impl Motion {
    /// Masses in a row on springs that are not linear, with some elements on the last of them.
    pub fn new(random: &mut Random, masses: usize, what: Vec<Element>, duration: f64, steps: usize) -> Self {
        let mut scene = Scene::new();
        let (design, stiffness) =
            (scene.design("m", between(random, 0.5, 2.0)), scene.design("k", between(random, 1.0, 50.0)));
        let mut x = Vec::new();
        let mut start = 0.0;
        for i in 0..masses {
            start = 0.6 * random.uniform(0.0, 1.0) - 0.3;
            let mass = if i == 0 { design.into() } else { between(random, 0.5, 2.0).into() };
            x.push(elements::mass(&mut scene, &format!("mass {i}"), mass, start));
        }
        let u = scene.control("u");
        elements::drive(&mut scene, x[0], u);
        elements::anchor(&mut scene, x[0], [stiffness.into(), between(random, 0.1, 20.0).into()]);
        for i in 1..masses {
            let b = [between(random, 1.0, 50.0), between(random, 0.1, 20.0)];
            elements::spring(&mut scene, &format!("spring {i}"), [x[i - 1], x[i]], b.map(Into::into));
        }
        what.iter().enumerate().for_each(|(i, element)| element.add(&mut scene, &format!("element {i}"), &x, start));
        let aim = 2.0 * random.uniform(0.0, 1.0) - 1.0;
        elements::aim(&mut scene, "end", Sum::Terminal, x[masses - 1], aim);
        elements::aim(&mut scene, "way", Sum::Trapezoidal, x[0], -aim);
        let system = scene.compile().expect("a scene");
        let is_free = what.iter().all(|element| element.is_free());
        let v0 = is_free.then(|| (0..system.n()).map(|_| 3.0 * random.uniform(0.0, 1.0) - 1.5).collect());
        let (push, frequency) = (between(random, 0.5, 10.0), 1.0 + 7.0 * random.uniform(0.0, 1.0));
        let (composition, settings) = (Composition::Trapezoidal, Settings::default());
        Motion { system, what, duration, steps, composition, settings, v0, push, frequency }
    }

    pub fn inputs(&self, factor: usize) -> Inputs {
        let steps = self.steps * factor;
        let mut inputs =
            Inputs::at_rest(&self.system, Grid::composed(steps, self.duration / steps as f64, self.composition));
        let times = inputs.grid.times();
        inputs.controls.iter_mut().zip(times).for_each(|(u, t)| *u = self.push * (self.frequency * t).sin());
        if let Some(v0) = &self.v0 {
            inputs.start.rate_mut().copy_from_slice(v0);
        }
        inputs
    }

    /// What the motion and its gradient say of themselves.
    pub fn warnings(&self) -> Option<Vec<Warning>> {
        let mut solver = Solver::new(&self.system, self.settings);
        solver.simulate(&self.inputs(1)).ok()?;
        Some(solver.gradient().ok()?.warnings.clone())
    }

    /// By how much the gradient changes where steps are halved and halved again, relative to all of it.
    pub fn change(&self) -> Option<f64> {
        let of = |factor: usize| {
            let inputs = self.inputs(factor);
            let gradient = hamiltonian_adjoint::gradient(&self.system, &inputs, self.settings).ok()?;
            Some(self.numbers(&inputs, &gradient))
        };
        let [one, two, four] = [of(1)?, of(2)?, of(4)?];
        let size = |x: &[f64]| x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let apart = |x: &[f64], y: &[f64]| size(&x.iter().zip(y).map(|(x, y)| x - y).collect::<Vec<_>>());
        let largest = apart(&one, &two).max(apart(&two, &four)).max(apart(&one, &four));
        Some(largest / size(&four))
    }

    /// Derivatives by numbers that are the same on all grids, each for a change of its own size.
    pub fn numbers(&self, inputs: &Inputs, gradient: &Gradient) -> Vec<f64> {
        let mut numbers = vec![0.0; HATS];
        for (t, u) in inputs.grid.times().iter().zip(gradient.controls.iter()) {
            let place = t / self.duration * (HATS - 1) as f64;
            let hat = |k: usize| (1.0 - (place - k as f64).abs()).max(0.0);
            numbers.iter_mut().enumerate().for_each(|(k, sum)| *sum += self.push * hat(k) * u);
        }
        numbers.extend(gradient.design.iter().zip(inputs.design.iter()).map(|(by, value)| by * value));
        if self.v0.is_some() {
            numbers.extend(gradient.start.q().iter().chain(gradient.start.rate()).copied());
        }
        numbers
    }
}
