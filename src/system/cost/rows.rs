//! Costs and their derivatives h_y, h_u, S_y at one node (Eq. 5, 8).

use super::cost_factors::CostFactors;
use crate::number::all_finite;
use crate::system::formula::{Argument, LISTS};

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
    /// Derivatives with respect to the lengths of the steps before and after the node.
    pub steps: [f64; 2],
    /// Σ h of the costs that are summed with the weights of the scheme, for the steps before and after the node.
    pub integrands: [f64; 2],
    /// The number of costs evaluated so far.
    pub evaluations: usize,
    /// Whether any of the costs may read the state. Costs of controls alone never contribute to the equations before their node.
    pub has_read_state: bool,
    /// Factors of the costs in the weighted sum that is differentiated.
    pub factors: CostFactors,
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

    fn lists(&self) -> [&[f64]; LISTS] {
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, time, .. } = self;
        [q, v, p_star, p_star_dot, v_dot, lambda, sigma, u, u_dot, design, std::slice::from_ref(time)]
    }

    pub fn is_finite(&self) -> bool {
        let lengths = [self.steps, self.integrands];
        self.value.is_finite() && all_finite(lengths.as_flattened()) && self.lists().into_iter().all(all_finite)
    }

    /// The arguments whose derivatives are not finite. If these are design variables only, all arguments with a nonzero derivative.
    pub fn bad_arguments(&self) -> Vec<Argument> {
        let bad = self.arguments_where(|slope| !slope.is_finite());
        let is_constant = |argument: &Argument| matches!(argument, Argument::B(_));
        if bad.iter().all(is_constant) { self.arguments_where(|slope| slope != 0.0) } else { bad }
    }

    fn arguments_where(&self, is: fn(f64) -> bool) -> Vec<Argument> {
        let of_list = |(list, of): (&[f64], fn(usize) -> Argument)| {
            (0..list.len()).filter(|&i| is(list[i])).map(of).collect::<Vec<Argument>>()
        };
        self.lists().into_iter().zip(Argument::ALL).flat_map(of_list).collect()
    }

    /// The derivative with respect to an argument.
    #[inline]
    pub fn of(&mut self, argument: Argument) -> &mut f64 {
        match argument {
            Argument::Q(i) => &mut self.q[i],
            Argument::V(i) => &mut self.v[i],
            Argument::PStar(i) => &mut self.p_star[i],
            Argument::PStarDot(i) => &mut self.p_star_dot[i],
            Argument::VDot(i) => &mut self.v_dot[i],
            Argument::Lambda(j) => &mut self.lambda[j],
            Argument::Sigma(j) => &mut self.sigma[j],
            Argument::U(k) => &mut self.u[k],
            Argument::UDot(k) => &mut self.u_dot[k],
            Argument::B(p) => &mut self.design[p],
            Argument::T => &mut self.time,
        }
    }

    /// Adds a derivative with respect to an argument.
    #[inline]
    pub fn add(&mut self, argument: Argument, x: f64) {
        *self.of(argument) += x;
    }

    /// Clears the derivatives with respect to u̇, v̇ and λ after they have been propagated to other variables.
    pub fn clear_passed_on(&mut self) {
        [&mut self.u_dot, &mut self.v_dot, &mut self.lambda].into_iter().for_each(|list| list.fill(0.0));
    }

    pub fn clear(&mut self) {
        let CostRows { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design, .. } = self;
        [q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, design].into_iter().for_each(|list| list.fill(0.0));
        (self.value, self.time, self.evaluations, self.has_read_state) = (0.0, 0.0, 0, false);
        (self.steps, self.integrands) = ([0.0; 2], [0.0; 2]);
    }
}
