//! [`NodeView`]: the quantities at a node or stage that formulas may depend on. [`NodeValues`]: the same quantities with owned lists.

use num_traits::Zero;

/// The paper's y at a node, in the scene's numbering, with its time, controls and design variables.
#[derive(Clone, Copy)]
pub struct NodeView<'a, R> {
    pub q: &'a [R],
    pub v: &'a [R],
    /// p* and ṗ*, which only costs use; empty when equations are evaluated.
    pub p_star: &'a [R],
    pub p_star_dot: &'a [R],
    /// v̇ and λ, for costs that depend on them; otherwise empty.
    pub v_dot: &'a [R],
    pub lambda: &'a [R],
    pub sigma: &'a [R],
    pub u: &'a [R],
    /// u̇, for costs that depend on it; otherwise empty.
    pub u_dot: &'a [R],
    pub t: R,
    /// The parameters of elements: the design variables, followed by expressions of them.
    pub design: &'a [R],
}

impl<'a, R> NodeView<'a, R> {
    /// A view of (q, v, σ), and of u, t and the design variables, for the evaluation of equations.
    #[inline]
    pub fn of_equations([q, v, sigma]: [&'a [R]; 3], (u, t, design): (&'a [R], R, &'a [R])) -> Self {
        NodeView { q, v, p_star: &[], p_star_dot: &[], v_dot: &[], lambda: &[], sigma, u, u_dot: &[], t, design }
    }

    /// The same view without the quantities that only costs use.
    pub fn without_momenta(self) -> Self {
        NodeView { p_star: &[], p_star_dot: &[], v_dot: &[], lambda: &[], u_dot: &[], ..self }
    }

    /// The list of arguments with a given number: the lists of [`Slot`](super::shape::Slot), in their order.
    #[inline]
    pub fn list(&self, which: usize) -> &[R] {
        match which {
            0 => self.q,
            1 => self.v,
            2 => self.p_star,
            3 => self.p_star_dot,
            4 => self.v_dot,
            5 => self.lambda,
            6 => self.sigma,
            7 => self.u,
            8 => self.u_dot,
            9 => self.design,
            _ => std::slice::from_ref(&self.t),
        }
    }

    /// The same state with other controls and design variables.
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

/// The quantities of a [`NodeView`] with owned lists, for example on another number type.
#[derive(Clone, Debug)]
pub struct NodeValues<R> {
    pub q: Vec<R>,
    pub v: Vec<R>,
    pub sigma: Vec<R>,
    pub u: Vec<R>,
    pub t: R,
    pub design: Vec<R>,
    /// p*, ṗ*, v̇, λ and u̇, which only costs use.
    pub of_costs: [Vec<R>; 5],
}

impl<R: Copy> NodeValues<R> {
    /// Zeros for n coordinates, m equations, k controls and `designs` parameters.
    pub fn zeros((n, m, k): (usize, usize, usize), designs: usize) -> Self
    where
        R: Zero,
    {
        let [q, v, sigma, u, design] = [n, n, m, k, designs].map(|len| vec![R::zero(); len]);
        NodeValues { q, v, sigma, u, t: R::zero(), design, of_costs: Default::default() }
    }

    /// Converts the arguments of the equations, number by number.
    pub fn of_equations<S: Copy>(at: &NodeView<S>, number: impl Fn(S) -> R) -> Self {
        let list = |x: &[S]| x.iter().map(|x| number(*x)).collect();
        let [q, v, sigma, u, design] = [at.q, at.v, at.sigma, at.u, at.design].map(list);
        NodeValues { q, v, sigma, u, t: number(at.t), design, of_costs: Default::default() }
    }

    /// Converts the arguments of the equations and of costs, number by number.
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
