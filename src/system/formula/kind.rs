//! [`ElementKind`]: what an element contributes to the equations of a step, and which second derivatives it has.

use num_dual::DualNum;

/// A number that formulas and their derivatives are evaluated with.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// Kind of element, with its second derivatives besides qq (𝓛_qq + Q_q).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementKind {
    /// Kinetic energy: 𝓛_vv, 𝓛_vq = 𝓛_qvᵀ, 𝓛_qq.
    Kinetic,
    /// Potential energy: 𝓛_qq.
    Potential,
    /// Applied force: Q_v, Q_q.
    Applied,
    /// Constraint: 𝓛_vq = 𝓛_qv = σᵀΦ_qq, 𝓛_qq = σᵀ(dΦ/dt)_qq, Φ_q, (dΦ/dt)_q.
    Holonomic,
}

impl ElementKind {
    /// The number of n × n blocks.
    pub const fn squares(self) -> usize {
        match self {
            ElementKind::Kinetic => 3,
            ElementKind::Potential => 1,
            ElementKind::Applied | ElementKind::Holonomic => 2,
        }
    }

    /// The length of the blocks of an element with n coordinates and m equations.
    pub const fn length(self, n: usize, m: usize) -> usize {
        self.squares() * n * n + if matches!(self, ElementKind::Holonomic) { 2 * n * m } else { 0 }
    }
}
