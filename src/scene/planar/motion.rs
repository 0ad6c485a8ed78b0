//! Prescribed functions of time for driven joints, forces and torques.

use std::any::Any;

use nalgebra::SVector;

use crate::model::Param;
use crate::scene::ready::Part;
use crate::{Scalar, Scene};

/// A prescribed function of time, in rad, m, N or N m.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion with this number of parameters",
    note = "implement `Motion<P>` with P the number of given parameters"
)]
pub trait Motion<const P: usize>: Send + Sync + 'static {
    /// The value at time t (s) for the parameters b.
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, P>) -> S;
}

/// A constant function; `b = [value]`.
#[derive(Clone, Copy, Debug)]
pub struct Constant;

impl Motion<1> for Constant {
    fn value<S: Scalar>(&self, _t: S, b: &SVector<S, 1>) -> S {
        b[0]
    }
}

/// A linear function φ₀ + ω t; b = [φ₀, ω].
#[derive(Clone, Copy, Debug)]
pub struct ConstantSpeed;

impl Motion<2> for ConstantSpeed {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 2>) -> S {
        b[0] + b[1] * t
    }
}

/// A harmonic function φ₀ + A sin(ω t + ψ); b = [φ₀, A, ω, ψ].
#[derive(Clone, Copy, Debug)]
pub struct Harmonic;

impl Motion<4> for Harmonic {
    fn value<S: Scalar>(&self, t: S, b: &SVector<S, 4>) -> S {
        b[0] + b[1] * (b[2] * t + b[3]).sin()
    }
}

/// The ready-made functions of time, with their names in files and the numbers of their parameters.
pub(crate) const MOTIONS: [(&str, usize); 3] = [("constant", 1), ("constant speed", 2), ("harmonic", 4)];

fn name_of<F: Any>(motion: &F) -> Option<&'static str> {
    let motion: &dyn Any = motion;
    let is = [motion.is::<Constant>(), motion.is::<ConstantSpeed>(), motion.is::<Harmonic>()];
    is.into_iter().zip(MOTIONS).find(|(is, _)| *is).map(|(_, (name, _))| name)
}

/// Evaluates `$add` with the function of time of a part that was read from a file, and with its parameters.
macro_rules! with_motion {
    ($part:expr, $motion:ident, $parameters:ident, $add:expr) => {{
        use $crate::planar::{Constant, ConstantSpeed, Harmonic};
        match &$part.motion {
            Some(("constant", b)) => {
                let ($motion, $parameters) = (Constant, [b[0]]);
                $add;
            }
            Some(("constant speed", b)) => {
                let ($motion, $parameters) = (ConstantSpeed, [b[0], b[1]]);
                $add;
            }
            Some((_, b)) => {
                let ($motion, $parameters) = (Harmonic, [b[0], b[1], b[2], b[3]]);
                $add;
            }
            None => {}
        }
    }};
}

pub(in crate::scene) use with_motion;

impl Scene {
    /// Adds an element that depends on a function of time, recorded as a ready-made part if the function is ready-made.
    pub(in crate::scene) fn driven<F: Motion<P>, const P: usize>(
        &mut self,
        name: &str,
        part: Part,
        motion: F,
        parameters: [Param; P],
        add: impl FnOnce(&mut Self, F),
    ) {
        match name_of(&motion) {
            Some(of) => {
                let part = Part { motion: Some((of, parameters.to_vec())), ..part };
                self.noted(name, part, |scene, _| add(scene, motion));
            }
            None => add(self, motion),
        }
    }
}
