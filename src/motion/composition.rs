//! Symmetric compositions of the trapezoidal rule: orders 4 and 6 by the choice of the time grid alone.
//!
//! The step of length Δt, Ψ(Δt), is symmetric: Ψ(−Δt) undoes it. So the s steps γ_1 Δt, …, γ_s Δt with γ_j = γ_{s+1−j},
//!
//! ```text
//! Ψ(γ_s Δt) ∘ … ∘ Ψ(γ_1 Δt),      Σ γ_j = 1,
//! ```
//!
//! are a symmetric step over Δt, the macro step. Its order is even; with c_j = γ_1 + … + γ_{j−1} + γ_j/2 it is
//!
//! ```text
//! 4 if also  Σ γ_j³ = 0,
//! 6 if also  Σ γ_j⁵ = 0  and  Σ γ_j³ c_j² = 0.
//! ```
//!
//! Above order 2 some γ_j must be negative. Sources: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed.,
//! Springer 2006 ("HLW" here), sections II.4 and V.3.2, and the articles named at [`Composition`].

use crate::{Grid, memory};

/// A symmetric composition of trapezoidal steps, named after its authors and its order.
///
/// | | stages | order | inner nodes, relative to the macro step | source |
/// |---|---|---|---|---|
/// | `Trapezoidal` | 1 | 2 | none | the rule itself |
/// | `Suzuki4` | 5 | 4 | inside | M. Suzuki, Phys. Lett. A 146 (1990) 319; E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed. (HLW), II.4 |
/// | `Yoshida6` | 7 | 6 | from −0.16 to 1.16 | H. Yoshida, Phys. Lett. A 150 (1990) 262, solution A; HLW V.3.2 |
/// | `KahanLi6` | 9 | 6 | inside | W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089; HLW V.3.2 |
///
/// The orders need controls and other functions of time that are smooth over all nodes of a macro step. With a control that has kinks,
/// the order is kept if the kinks are at ends of macro steps and all nodes of a macro step have the values of the smooth piece that
/// belongs to it, including nodes whose times lie outside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Composition {
    /// One stage: the trapezoidal rule.
    Trapezoidal,
    /// Five stages, order 4.
    Suzuki4,
    /// Seven stages, order 6.
    Yoshida6,
    /// Nine stages, order 6, with smaller errors than seven stages for the same number of steps.
    KahanLi6,
}

/// γ_1 = γ_2 = γ_4 = γ_5 = 1/(4 − 4^⅓), γ_3 = 1 − 4 γ_1.
const SUZUKI_4: [f64; 5] = {
    let (outer, inner) = (0.414_490_771_794_375_7, -0.657_963_087_177_503);
    [outer, outer, inner, outer, outer]
};

/// HLW (V.3.11).
const YOSHIDA_6: [f64; 7] = {
    let (a, b, c) = (0.784_513_610_477_557_3, 0.235_573_213_359_358_13, -1.177_679_984_178_871);
    [a, b, c, 1.315_186_320_683_911_2, c, b, a]
};

/// HLW (V.3.12).
const KAHAN_LI_6: [f64; 9] = {
    let (a, b) = (0.392_161_444_007_314_1, 0.332_599_136_789_359_43);
    let (c, d) = (-0.706_246_172_557_639_3, 0.082_213_596_293_550_8);
    [a, b, c, d, 0.798_543_990_934_83, d, c, b, a]
};

impl Composition {
    /// All compositions, by order and number of stages.
    pub const ALL: [Composition; 4] =
        [Composition::Trapezoidal, Composition::Suzuki4, Composition::Yoshida6, Composition::KahanLi6];

    /// Lengths γ_1 … γ_s of the stages, relative to the macro step.
    pub fn coefficients(self) -> &'static [f64] {
        match self {
            Composition::Trapezoidal => &[1.0],
            Composition::Suzuki4 => &SUZUKI_4,
            Composition::Yoshida6 => &YOSHIDA_6,
            Composition::KahanLi6 => &KAHAN_LI_6,
        }
    }

    /// s, the number of stages.
    pub fn stages(self) -> usize {
        self.coefficients().len()
    }

    /// The order of convergence.
    pub fn order(self) -> usize {
        match self {
            Composition::Trapezoidal => 2,
            Composition::Suzuki4 => 4,
            Composition::Yoshida6 | Composition::KahanLi6 => 6,
        }
    }

    /// Ends γ_1, γ_1 + γ_2, …, 1 of the stages, relative to the macro step; not monotone.
    pub fn stage_ends(self) -> Vec<f64> {
        let ends = self.coefficients().iter().scan(0.0, |end, gamma| {
            *end += gamma;
            Some(*end)
        });
        let mut ends: Vec<f64> = ends.collect();
        // Remove the rounding error of the sum.
        ends[self.stages() - 1] = 1.0;
        ends
    }
}

impl Grid {
    /// A grid of macro steps of equal length `dt`, s, from t = 0, each divided into the stages of a composition: s · `macro_steps` steps.
    ///
    /// Node s·j is the end of macro step j, at t = j · `dt`; the motion has the order of the composition only at these nodes. The
    /// intermediate nodes have controls of their own, but their times are not monotone and may lie outside the macro step
    /// ([`Composition::stage_ends`]).
    ///
    /// The gradient is exact for the composed scheme. dJ/du_i at an intermediate node is the derivative with respect to the control at this
    /// stage. It may have either sign, may be large and nearly cancel with the values at neighbouring nodes, and does not approximate a
    /// density in time. If the control is a function of a few parameters, u_i = u(t_i; x), then dJ/dx = Σ (du_i/dx)ᵀ dJ/du_i converges with
    /// the order of the composition.
    ///
    /// Restarts ([`Settings`](crate::Settings)) take place at ends of macro steps only, and the motion keeps its order.
    ///
    /// A running cost with [`Sum::Trapezoidal`](crate::Sum::Trapezoidal) is the same scheme applied to J̇ = h and has its order, in contrast to
    /// [`Sum::Plain`](crate::Sum::Plain), [`Sum::AllNodes`](crate::Sum::AllNodes) and [`Sum::Rectangle`](crate::Sum::Rectangle).
    ///
    /// ```
    /// use hamiltonian_adjoint::{Composition, Grid};
    ///
    /// let grid = Grid::composed(20, 0.1, Composition::Suzuki4);
    /// assert_eq!(grid.steps.len(), 100);
    /// assert!((grid.times()[100] - 2.0).abs() < 1e-14);
    /// ```
    ///
    /// # Panics
    /// If the grid does not fit into memory.
    pub fn composed(macro_steps: usize, dt: f64, composition: Composition) -> Self {
        memory::require("the steps of a grid", macro_steps, composition.stages() * size_of::<f64>());
        let stages = composition.coefficients().iter().map(|gamma| gamma * dt);
        let steps = stages.cycle().take(macro_steps * composition.stages()).collect();
        Grid { stages: composition.stages(), ..Grid::new(0.0, steps) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ γ_j^power.
    fn power_sum(composition: Composition, power: i32) -> f64 {
        composition.coefficients().iter().map(|gamma| gamma.powi(power)).sum()
    }

    /// Σ γ_j³ c_j².
    fn mixed_sum(composition: Composition) -> f64 {
        let mut start = 0.0;
        let terms = composition.coefficients().iter().map(|gamma| {
            let middle: f64 = start + 0.5 * gamma;
            start += gamma;
            gamma.powi(3) * middle * middle
        });
        terms.sum()
    }

    #[test]
    fn coefficients_are_symmetric_and_fulfil_the_conditions_of_their_order_and_no_more() {
        for composition in Composition::ALL {
            let (gamma, order) = (composition.coefficients(), composition.order());
            assert!(gamma.iter().eq(gamma.iter().rev()), "{composition:?}");
            assert!((power_sum(composition, 1) - 1.0).abs() < 5e-16, "{composition:?}");
            let conditions = [(4, power_sum(composition, 3)), (6, power_sum(composition, 5)), (6, mixed_sum(composition))];
            for (needed, sum) in conditions {
                assert_eq!(sum.abs() < 2e-15, order >= needed, "{composition:?}: {sum:e} for order {needed}");
            }
        }
    }

    #[test]
    fn suzuki_s_coefficient_is_the_closed_form() {
        assert!((SUZUKI_4[0] - 1.0 / (4.0 - 4f64.cbrt())).abs() < 1e-16);
    }

    #[test]
    fn exponential_growth_has_the_order_of_the_composition() {
        // For y' = λ y, a trapezoidal step multiplies y by (1 + hλ)/(1 − hλ), h = γ Δt/2; the exact factor is exp(λ Δt).
        let error = |composition: Composition, dt: f64| {
            let factor = |gamma: &f64| (1.0 + 0.5 * gamma * dt) / (1.0 - 0.5 * gamma * dt);
            (composition.coefficients().iter().map(factor).product::<f64>() / dt.exp()).ln().abs()
        };
        for composition in Composition::ALL {
            let order = (error(composition, 0.4) / error(composition, 0.2)).log2() - 1.0;
            assert!((order - composition.order() as f64).abs() < 0.2, "{composition:?}: {order}");
        }
    }

    #[test]
    fn one_stage_is_the_uniform_grid() {
        assert_eq!(Grid::composed(7, 0.1, Composition::Trapezoidal), Grid::uniform(7, 0.1));
    }

    #[test]
    fn stages_end_where_the_times_say() {
        let times = Grid::composed(1, 1.0, Composition::Yoshida6).times();
        let ends = Composition::Yoshida6.stage_ends();
        assert!(times[1..].iter().zip(&ends).all(|(t, end)| (t - end).abs() < 1e-15));
        assert!(ends.iter().any(|end| *end < 0.0) && ends.iter().any(|end| *end > 1.0));
    }
}
