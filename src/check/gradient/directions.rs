//! Random directions of the inputs, and the gradient along them.

use crate::check::Input;
use crate::number::Random;
use crate::{Gradient, Inputs};

/// A part of the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Part {
    /// All controls.
    Controls,
    /// All design variables.
    Design,
    /// q₀.
    Coordinates,
    /// v₀ or p*₀.
    Rates,
    /// The step lengths.
    Steps,
}

impl Part {
    const ALL: [Part; 5] = [Part::Controls, Part::Design, Part::Coordinates, Part::Rates, Part::Steps];

    /// The parts that are not empty in these inputs.
    pub(super) fn all_of(inputs: &Inputs) -> Vec<Part> {
        Part::ALL.into_iter().filter(|part| !part.of(inputs).is_empty()).collect()
    }

    pub(super) fn name(self) -> &'static str {
        ["controls", "design variables", "initial coordinates", "initial rates", "step lengths"][self as usize]
    }

    /// The numbers of this part of the inputs.
    pub(super) fn of(self, inputs: &Inputs) -> &[f64] {
        match self {
            Part::Controls => inputs.controls.as_slice(),
            Part::Design => inputs.design.as_slice(),
            Part::Coordinates => inputs.start.q().as_slice(),
            Part::Rates => inputs.start.rate().as_slice(),
            Part::Steps => &inputs.grid.steps,
        }
    }

    /// Number of values at each node or step, for parts that are series in time.
    pub(super) fn channels(self, inputs: &Inputs) -> Option<usize> {
        match self {
            Part::Controls => Some(inputs.controls.nrows()),
            Part::Steps => Some(1),
            Part::Design | Part::Coordinates | Part::Rates => None,
        }
    }

    /// All inputs of this part.
    pub(super) fn inputs(self, inputs: &Inputs) -> Vec<Input> {
        let before: usize = Part::ALL.iter().take_while(|part| **part != self).map(|part| part.of(inputs).len()).sum();
        Input::all(inputs)[before..][..self.of(inputs).len()].to_vec()
    }
}

/// A random direction in some parts, which changes each number by about its size.
pub(super) fn random(sizes: &Inputs, parts: &[Part], random: &mut Random) -> Inputs {
    let mut direction = sizes.no_change();
    for &part in parts {
        let moves = part.inputs(sizes).into_iter().zip(part.of(sizes));
        moves.for_each(|(input, &size)| *input.of(&mut direction) = random.away_from_zero(size));
    }
    direction
}

/// The direction of one input alone.
pub(super) fn only(inputs: &Inputs, input: Input, d: f64) -> Inputs {
    let mut direction = inputs.no_change();
    *input.of(&mut direction) = d;
    direction
}

/// Σ g_j d_j, and its size if its terms do not cancel, √Σ (g_j d_j)².
pub(super) fn product(gradient: &Gradient, direction: &Inputs) -> (f64, f64) {
    let mut d = direction.clone();
    let terms = Input::all(direction).into_iter().map(|input| input.in_gradient(gradient) * *input.of(&mut d));
    let terms: Vec<f64> = terms.collect();
    (terms.iter().sum(), terms.iter().map(|x| x * x).sum::<f64>().sqrt())
}
