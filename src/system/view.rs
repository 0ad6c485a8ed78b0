//! [`NodeView`]: what formulas may depend on, at one node or stage; [`NodeValues`]: the same in lists of its own.

use num_traits::Zero;

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

/// The same in lists of its own: other numbers, or one part of all of them.
#[derive(Clone, Debug)]
pub struct NodeValues<R> {
    pub q: Vec<R>,
    pub v: Vec<R>,
    pub sigma: Vec<R>,
    pub u: Vec<R>,
    pub t: R,
    pub design: Vec<R>,
    /// p*, ṗ*, v̇, λ and u̇, for costs alone.
    pub of_costs: [Vec<R>; 5],
}

impl<R: Copy> NodeValues<R> {
    /// For n coordinates, m equations, k controls and so many parameters.
    pub fn zeros((n, m, k): (usize, usize, usize), designs: usize) -> Self
    where
        R: Zero,
    {
        let [q, v, sigma, u, design] = [n, n, m, k, designs].map(|len| vec![R::zero(); len]);
        NodeValues { q, v, sigma, u, t: R::zero(), design, of_costs: Default::default() }
    }

    /// What the equations depend on, number by number.
    pub fn of_equations<S: Copy>(at: &NodeView<S>, number: impl Fn(S) -> R) -> Self {
        let list = |x: &[S]| x.iter().map(|x| number(*x)).collect();
        let [q, v, sigma, u, design] = [at.q, at.v, at.sigma, at.u, at.design].map(list);
        NodeValues { q, v, sigma, u, t: number(at.t), design, of_costs: Default::default() }
    }

    /// With what costs may depend on besides.
    pub fn of_costs<S: Copy>(at: &NodeView<S>, number: impl Fn(S) -> R) -> Self {
        let of_costs = [at.p_star, at.p_star_dot, at.v_dot, at.lambda, at.u_dot];
        let of_costs = of_costs.map(|x| x.iter().map(|x| number(*x)).collect());
        NodeValues { of_costs, ..NodeValues::of_equations(at, number) }
    }

    pub fn view(&self) -> NodeView<'_, R> {
        let [p_star, p_star_dot, v_dot, lambda, u_dot] = &self.of_costs;
        let equations = NodeView::of_equations([&self.q, &self.v, &self.sigma], (&self.u, self.t, &self.design));
        NodeView { p_star, p_star_dot, v_dot, lambda, u_dot, ..equations }
    }
}
