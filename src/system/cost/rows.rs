//! Costs and their derivatives h_y, h_u, S_y at one node (Eq. 5, 8).

use super::cost_factors::CostFactors;
use super::cost_formula::CostMemory;
use crate::number::all_finite;
use crate::system::formula::Argument;

/// The cost at one node and its derivatives J_q, J_v, J_p*, J_ṗ*, J_v̇, J_σ, J_λ, J_u, J_u̇, J_b, J_t.
#[derive(Clone, Debug, Default)]
pub struct CostRows {
    pub value: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub p_star: Vec<f64>,
    pub p_star_dot: Vec<f64>,
    pub v_dot: Vec<f64>,
    pub sigma: Vec<f64>,
    pub lambda: Vec<f64>,
    pub u: Vec<f64>,
    pub u_dot: Vec<f64>,
    pub design: Vec<f64>,
    pub time: f64,
    /// Derivatives with respect to the length of the step before the node and of the one after it.
    pub step_before: f64,
    pub step_after: f64,
    /// Σ h of the costs that are summed with the weights of the scheme, for the step before the node and for the step after it.
    pub integrand_before: f64,
    pub integrand_after: f64,
    /// The number of costs evaluated so far.
    pub evaluations: usize,
    /// Whether any of the costs may read the state. Costs of controls alone never contribute to the equations before their node.
    pub has_read_state: bool,
    /// Factors of the costs in the weighted sum that is differentiated.
    pub factors: CostFactors,
    pub memory: CostMemory,
}

impl CostRows {
    pub fn new((n, m, k): (usize, usize, usize), designs: usize, outputs: usize) -> Self {
        let zeros = |len| vec![0.0; len];
        CostRows {
            q: zeros(n),
            v: zeros(n),
            p_star: zeros(n),
            p_star_dot: zeros(n),
            v_dot: zeros(n),
            sigma: zeros(m),
            lambda: zeros(m),
            u: zeros(k),
            u_dot: zeros(k),
            design: zeros(designs),
            factors: CostFactors::of_cost(outputs),
            ..CostRows::default()
        }
    }

    /// Whether all derivatives with respect to the state are zero.
    pub fn has_no_state(&self) -> bool {
        let CostRows { q, v, p_star, p_star_dot, sigma, .. } = self;
        [q, v, p_star, p_star_dot, sigma].into_iter().flatten().all(|x| *x == 0.0)
    }

    fn lists(&self) -> [&Vec<f64>; 10] {
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, .. } = self;
        [q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design]
    }

    pub fn is_finite(&self) -> bool {
        let lengths = [self.step_before, self.step_after, self.integrand_before, self.integrand_after];
        all_finite(&[self.value, self.time]) && all_finite(&lengths) && self.lists().into_iter().all(|list| all_finite(list))
    }

    /// The arguments whose derivatives are not finite. If these are design variables only, all arguments with a nonzero derivative.
    pub fn bad_arguments(&self) -> Vec<Argument> {
        let bad = self.arguments_where(|slope| !slope.is_finite());
        let is_constant = |argument: &Argument| matches!(argument, Argument::Design(_));
        if bad.iter().all(is_constant) { self.arguments_where(|slope| slope != 0.0) } else { bad }
    }

    fn arguments_where(&self, is: fn(f64) -> bool) -> Vec<Argument> {
        let lists = self.lists();
        let kinds: [fn(usize) -> Argument; 10] = [
            Argument::Coordinate,
            Argument::Velocity,
            Argument::Momentum,
            Argument::Force,
            Argument::Acceleration,
            Argument::Multiplier,
            Argument::Reaction,
            Argument::Control,
            Argument::ControlRate,
            Argument::Design,
        ];
        let of_list = |list: &[f64]| (0..list.len()).filter(|&i| is(list[i])).collect::<Vec<_>>();
        let time = is(self.time).then_some(Argument::Time);
        lists.into_iter().zip(kinds).flat_map(|(list, of)| of_list(list).into_iter().map(of)).chain(time).collect()
    }

    /// Memory for the programs, and the derivatives as lists that can be added to.
    pub fn memory_and_slopes(&mut self) -> (&mut CostMemory, Slopes<'_>) {
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, time, memory, .. } = self;
        (memory, Slopes { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, time })
    }

    /// Adds a derivative with respect to an argument.
    pub fn add(&mut self, argument: Argument, x: f64) {
        *self.memory_and_slopes().1.of(argument) += x;
    }

    /// Clears the derivatives with respect to u̇, v̇ and λ after they have been propagated to other variables.
    pub fn clear_passed_on(&mut self) {
        [&mut self.u_dot, &mut self.v_dot, &mut self.lambda].into_iter().for_each(|list| list.fill(0.0));
    }

    pub fn clear(&mut self) {
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, .. } = self;
        [q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design].into_iter().for_each(|list| list.fill(0.0));
        (self.value, self.time, self.evaluations, self.has_read_state) = (0.0, 0.0, 0, false);
        (self.step_before, self.step_after, self.integrand_before, self.integrand_after) = (0.0, 0.0, 0.0, 0.0);
    }
}

/// The derivatives of a cost, to be added to.
pub struct Slopes<'a> {
    q: &'a mut [f64],
    v: &'a mut [f64],
    p_star: &'a mut [f64],
    p_star_dot: &'a mut [f64],
    v_dot: &'a mut [f64],
    sigma: &'a mut [f64],
    lambda: &'a mut [f64],
    u: &'a mut [f64],
    u_dot: &'a mut [f64],
    design: &'a mut [f64],
    time: &'a mut f64,
}

impl Slopes<'_> {
    /// The derivative with respect to an argument.
    #[inline]
    pub fn of(&mut self, argument: Argument) -> &mut f64 {
        match argument {
            Argument::Coordinate(i) => &mut self.q[i],
            Argument::Velocity(i) => &mut self.v[i],
            Argument::Momentum(i) => &mut self.p_star[i],
            Argument::Force(i) => &mut self.p_star_dot[i],
            Argument::Acceleration(i) => &mut self.v_dot[i],
            Argument::Reaction(j) => &mut self.lambda[j],
            Argument::Multiplier(j) => &mut self.sigma[j],
            Argument::Control(k) => &mut self.u[k],
            Argument::ControlRate(k) => &mut self.u_dot[k],
            Argument::Design(p) => &mut self.design[p],
            Argument::Time => self.time,
        }
    }
}
