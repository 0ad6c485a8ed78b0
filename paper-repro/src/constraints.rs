//! Constraint violations of a motion: Φ, dΦ/dt and d²Φ/dt².

use hamiltonian_adjoint::{Error, Inputs, Mechanics, Scheme, System, Trajectory};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;

/// The largest violation of any constraint equation at each node.
#[derive(Clone, Debug)]
pub struct Violations {
    /// Times in s, including nodes that halved steps inserted.
    pub times: Vec<f64>,
    /// ‖Φ(q)‖∞, m or rad.
    pub position: Vec<f64>,
    /// ‖dΦ/dt(q, v)‖∞, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// ‖d²Φ/dt²(q, v, a)‖∞ with the accelerations of the trapezoidal rule, m/s² or rad/s².
    pub acceleration: Vec<f64>,
}

impl Violations {
    pub fn of(system: &System, inputs: &Inputs, motion: &Trajectory) -> Result<Self, Error> {
        let (at_start, _) = Mechanics::at_node(system, inputs, motion, 0)?.accelerations()?;
        let accelerations = by_trapezoidal_rule(&inputs.grid.steps, &motion.v, &at_start);
        Ok(Violations {
            times: motion.times.clone(),
            position: norms(&motion.phi(system, inputs)?),
            velocity: norms(&motion.phi_dot(system, inputs)?),
            acceleration: norms(&phi_ddot(system, inputs, motion, &accelerations)?),
        })
    }
}

/// a_i = (2/Δt) (v_i − v_{i−1}) − a_{i−1}: the rule that the scheme has for q and p*, applied to v.
///
/// The accelerations are not unknowns of the scheme, and the paper does not state how it computes them: assumed.
fn by_trapezoidal_rule(steps: &[f64], v: &DMatrix<f64>, at_start: &DVector<f64>) -> DMatrix<f64> {
    let mut a = DMatrix::zeros(v.nrows(), v.ncols());
    a.set_column(0, at_start);
    for (i, dt) in (1..).zip(steps) {
        let next = (v.column(i) - v.column(i - 1)) * (2.0 / dt) - a.column(i - 1);
        a.set_column(i, &next);
    }
    a
}

/// d²Φ/dt² = Φ_q a + (dΦ/dt)_q v + …, the derivative of dΦ/dt along the motion.
fn phi_ddot(system: &System, inputs: &Inputs, motion: &Trajectory, a: &DMatrix<f64>) -> Result<DMatrix<f64>, Error> {
    let mut along = Trajectory::zeros(system, motion.times.len(), Scheme::TRAPEZOIDAL);
    along.computed = motion.computed;
    along.times = motion.times.iter().map(|t| Dual64::new(*t, 1.0)).collect();
    along.q = motion.q.zip_map(&motion.v, Dual64::new);
    along.v = motion.v.zip_map(a, Dual64::new);
    Ok(along.phi_dot(system, &inputs.lift())?.map(|rate| rate.eps))
}

/// ‖·‖∞ of each node.
pub fn norms(equations: &DMatrix<f64>) -> Vec<f64> {
    equations.column_iter().map(|column| column.amax()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hamiltonian_adjoint::scenes::CartPendulum;
    use hamiltonian_adjoint::{Grid, Settings};

    /// The motion of the paper's starting iteration.
    fn motion(system: &System) -> (Inputs, Trajectory) {
        let mut inputs = Inputs::at_rest(system, Grid::uniform(100, 0.02));
        inputs.controls.fill(10.0);
        let motion = hamiltonian_adjoint::simulate(system, &inputs, Settings::default()).unwrap();
        (inputs, motion)
    }

    #[test]
    fn consistent_accelerations_keep_the_constraints() {
        let system = CartPendulum::default().scene().compile().unwrap();
        let (inputs, motion) = motion(&system);
        let columns: Vec<DVector<f64>> = (0..=100)
            .map(|i| Mechanics::at_node(&system, &inputs, &motion, i).unwrap().accelerations().unwrap().0)
            .collect();
        let a = DMatrix::from_columns(&columns);
        assert!(norms(&phi_ddot(&system, &inputs, &motion, &a).expect("motion")).iter().all(|norm| *norm < 1e-10));
        let rule = by_trapezoidal_rule(&inputs.grid.steps, &motion.v, &columns[0]);
        // The rule has order two: its error is (Δt)² times derivatives of a.
        assert!((&a - rule).amax() < 0.1 * a.amax());
    }
}
