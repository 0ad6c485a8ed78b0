//! [`NodeView`]: what formulas may depend on, at one node or stage.

/// The paper's y at a node, in the scene's numbering, with its time, controls and design variables.
#[derive(Clone, Copy)]
pub struct NodeView<'a, R> {
    pub q: &'a [R],
    pub v: &'a [R],
    /// p* and ṗ* are for costs alone: empty where equations are evaluated.
    pub p_star: &'a [R],
    pub p_star_dot: &'a [R],
    /// v̇ and λ, for costs that depend on them: empty elsewhere.
    pub v_dot: &'a [R],
    pub lambda: &'a [R],
    pub sigma: &'a [R],
    pub u: &'a [R],
    /// u̇, likewise.
    pub u_dot: &'a [R],
    pub t: R,
    /// Design variables, then the expressions of them that are parameters of elements.
    pub design: &'a [R],
}

impl<'a, R> NodeView<'a, R> {
    /// What the equations depend on: (q, v, σ), and u, t and the design variables.
    #[inline]
    pub fn of_equations([q, v, sigma]: [&'a [R]; 3], (u, t, design): (&'a [R], R, &'a [R])) -> Self {
        NodeView { q, v, p_star: &[], p_star_dot: &[], v_dot: &[], lambda: &[], sigma, u, u_dot: &[], t, design }
    }

    /// What the equations depend on alone.
    pub fn without_momenta(self) -> Self {
        NodeView { p_star: &[], p_star_dot: &[], v_dot: &[], lambda: &[], u_dot: &[], ..self }
    }

    /// The same state with these controls and design variables.
    #[inline]
    pub fn with_inputs(self, (u, design): (&'a [R], &'a [R])) -> Self {
        NodeView { u, design, ..self }
    }

    /// ẋ = (v, ṗ*).
    #[inline]
    pub fn rates(self) -> (&'a [R], &'a [R]) {
        (self.v, self.p_star_dot)
    }
}
