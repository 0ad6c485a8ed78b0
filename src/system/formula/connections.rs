//! [`Connections`]: the arguments of a formula in the numbering of the scene.

use super::argument::Argument;
use super::shape::Slot;
use super::view::NodeView;
use crate::Scalar;
use crate::model::Param;

/// The coordinates, equations, controls and constants that a formula is connected to.
#[derive(Clone, Debug, Default)]
pub struct Connections {
    pub q: Vec<usize>,
    pub sigma: Vec<usize>,
    pub u: Vec<usize>,
    pub b: Vec<Param>,
}

impl Connections {
    /// The value of an argument at a node; zero if the node lacks the list, which then no formula depends on.
    #[inline]
    pub fn read<R: Scalar>(&self, at: &NodeView<R>, slot: Slot) -> R {
        let of = |list: &[R], place: usize| list.get(place).copied().unwrap_or(R::zero());
        match slot {
            Slot::Q(i) => of(at.q, self.q[i]),
            Slot::V(i) => of(at.v, self.q[i]),
            Slot::PStar(i) => of(at.p_star, self.q[i]),
            Slot::PStarDot(i) => of(at.p_star_dot, self.q[i]),
            Slot::VDot(i) => of(at.v_dot, self.q[i]),
            Slot::Sigma(j) => of(at.sigma, self.sigma[j]),
            Slot::Lambda(j) => of(at.lambda, self.sigma[j]),
            Slot::U(k) => of(at.u, self.u[k]),
            Slot::UDot(k) => of(at.u_dot, self.u[k]),
            Slot::T => at.t,
            Slot::B(p) => self.b[p].value(at.design),
        }
    }

    /// The derivative of an argument along a direction.
    pub fn rate(&self, along: &NodeView<f64>, slot: Slot) -> f64 {
        let of_design = |(place, factor): (usize, f64)| along.design.get(place).map_or(0.0, |rate| factor * rate);
        match slot {
            Slot::B(p) => self.b[p].bound().map_or(0.0, of_design),
            _ => self.read(along, slot),
        }
    }

    /// The scene's argument for an argument of the formula, and the factor between the two: zero for a plain number.
    pub fn argument(&self, slot: Slot) -> (Argument, f64) {
        let argument = match slot {
            Slot::Q(i) => Argument::Coordinate(self.q[i]),
            Slot::V(i) => Argument::Velocity(self.q[i]),
            Slot::PStar(i) => Argument::Momentum(self.q[i]),
            Slot::PStarDot(i) => Argument::Force(self.q[i]),
            Slot::VDot(i) => Argument::Acceleration(self.q[i]),
            Slot::Sigma(j) => Argument::Multiplier(self.sigma[j]),
            Slot::Lambda(j) => Argument::Reaction(self.sigma[j]),
            Slot::U(k) => Argument::Control(self.u[k]),
            Slot::UDot(k) => Argument::ControlRate(self.u[k]),
            Slot::T => Argument::Time,
            Slot::B(p) => {
                let of_design = |(place, factor)| (Argument::Design(place), factor);
                return self.b[p].bound().map_or((Argument::Time, 0.0), of_design);
            }
        };
        (argument, 1.0)
    }

    /// Whether each constant is bound to a design variable.
    pub fn bound(&self) -> Vec<bool> {
        Param::which_are_bound(&self.b)
    }

    /// The values of the constants.
    pub fn constants<'a>(&'a self, design: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.b.iter().map(|b| b.value(design))
    }
}
