//! [`LinearModel`]: the linearised motion about a state, in independent coordinates.
//!
//! ```text
//!   q = R(ζ; b, t),  v = R_ζ ω + R_t          the states with E q = ζ, E v = ω that satisfy the constraints
//!   ω̇ = E v̇(q, v, u, t; b)                    v̇ and λ by K(0) (v̇, λ) = r, its changes by K(0) (v̇', λ') = (f', g')
//! ```
//!
//! f' and g' are the changes of the equations at constant v̇ and λ (`accelerations/`), along the derivatives of R (`assembly/retraction.rs`).

use nalgebra::{Complex, DMatrix, DVector};

use super::{independent, indices};
use crate::accelerations::Accelerations;
use crate::assembly::{Columns, Retraction};
use crate::linear::eigenvalues;
use crate::redundancy::{Scaled, is_singular};
use crate::system::NodeView;
use crate::{Coordinate, Error, Mechanics, Settings};

/// The motion near a state, linear in the changes of independent coordinates, their rates, controls and design variables.
///
/// ```text
///   z = (ζ, ω):    δż = a δz + b δu + by_design δb,      δq = q_z δz,      δv = v_z δz
/// ```
///
/// ζ are n − rank Φ_q of the coordinates and ω their rates; units are SI. Derivatives are exact. With constraints or forces that depend on time, the
/// matrices belong to the time of the state, and δz is the distance from the motion through it; eigenvalues then describe the motion only while the
/// matrices hardly change. The same is true of a state that is not an equilibrium.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// The independent coordinates ζ, by index.
    pub coordinates: Vec<Coordinate>,
    /// Their names.
    pub names: Vec<String>,
    /// ∂ż/∂z (2d × 2d, d = n − rank Φ_q); ζ first, then ω in the same order.
    pub a: DMatrix<f64>,
    /// ∂ż/∂u (2d × k).
    pub b: DMatrix<f64>,
    /// ∂ż/∂b by the design variables, for constant ζ and ω (2d × number of design variables).
    pub by_design: DMatrix<f64>,
    /// ∂q/∂z (n × 2d).
    pub q_z: DMatrix<f64>,
    /// ∂v/∂z (n × 2d).
    pub v_z: DMatrix<f64>,
    /// Eigenvalues of `a`, 1/s, those with the largest real parts first. A mode e^(st) grows if s has a positive real part.
    pub eigenvalues: Vec<Complex<f64>>,
}

impl Mechanics {
    /// The linearised motion about this state, with its controls, design variables and time.
    ///
    /// The independent coordinates include those in `chosen`, which may be empty; the others are selected such that the dependent ones follow from them
    /// as accurately as possible. Positions of a node of a motion ([`at_node`](Self::at_node)) may have drifted from Φ = 0; the drift is constant in the
    /// linear model.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Mechanics, Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// scene.gravity(0.0, -9.81);
    /// let bob = scene.body("bob", 2.0, 0.0, [0.0, 0.5, 0.0]); // kg, kg m²; x, y, φ: upright
    /// scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), bob.at(0.0, -0.5));
    /// let system = scene.compile()?;
    /// let q = system.initial_coordinates();
    /// let linear = Mechanics::new(&system, q.as_slice(), &[0.0; 3])?.linear_model(&[bob.coordinates[2]])?;
    /// assert_eq!(linear.names, ["bob.φ"]);
    /// assert!((linear.a[(1, 0)] - 9.81 / 0.5).abs() < 1e-12);
    /// assert!((linear.eigenvalues[0].re - (9.81f64 / 0.5).sqrt()).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// A state that violates constraints; a coordinate of another scene, or a chosen one that the others determine; a singular
    /// configuration or mass matrix; forces or derivatives that are not finite.
    pub fn linear_model(&self, chosen: &[Coordinate]) -> Result<LinearModel, Error> {
        let system = self.system();
        let chosen = indices("Mechanics::linear_model", chosen, system)?;
        let none = vec![0.0; system.m()];
        let at = self.view(&none);
        system.check_panics(&at)?;
        self.check_admissible()?;
        if let Some(error) = Scaled::at(system, &at).and_then(|here| is_singular(&here, system, &at)) {
            return Err(error);
        }
        let (independent, columns) = self.columns(&chosen)?;
        let mut accelerations = Accelerations::new(system);
        accelerations.evaluate(system, &at, (0, &self.compliances()))?;
        let (d, k) = (independent.len(), system.k());
        // The columns of the retraction are ζ_1, ω_1, ζ_2, …, then the design variables.
        let (of_z, of_design) = ((0..2 * d).map(|j| 2 * (j % d) + j / d), 2 * d..columns.q.ncols());
        let (still, no_u, no_design) = (vec![0.0; system.n()], vec![0.0; k], vec![0.0; system.parameters().len()]);
        let mut rates = |q: &[f64], v: &[f64], u: &[f64], design: &[f64]| {
            let along = NodeView::of_equations([q, v, &none], (u, 0.0, design));
            let [_, change] = accelerations.along(system, &at, &along);
            let v = independent.iter().map(|&i| v[i]);
            DVector::from_iterator(2 * d, v.chain(independent.iter().map(|&i| change.v[i])))
        };
        let [mut a, mut b, mut by_design] = [2 * d, k, system.designs()].map(|columns| DMatrix::zeros(2 * d, columns));
        let [mut q_z, mut v_z] = [(); 2].map(|()| DMatrix::zeros(system.n(), 2 * d));
        for (j, column) in of_z.enumerate() {
            let (q, v) = (columns.q.column(column).into_owned(), columns.v.column(column).into_owned());
            a.set_column(j, &rates(q.as_slice(), v.as_slice(), &no_u, &no_design));
            q_z.set_column(j, &q);
            v_z.set_column(j, &v);
        }
        for (p, column) in of_design.enumerate() {
            let (q, v) = (columns.q.column(column).into_owned(), columns.v.column(column).into_owned());
            let mut unit = vec![0.0; system.designs()];
            unit[p] = 1.0;
            let design = system.parameters().along(&at.design[..unit.len()], &unit);
            by_design.set_column(p, &rates(q.as_slice(), v.as_slice(), &no_u, &design));
        }
        for j in 0..k {
            let mut unit = no_u.clone();
            unit[j] = 1.0;
            b.set_column(j, &rates(&still, &still, &unit, &no_design));
        }
        let not_finite = Error::Overflow { what: "a derivative of the motion at a state".into(), value: f64::NAN };
        if b.iter().chain(&by_design).any(|x| !x.is_finite()) {
            return Err(not_finite);
        }
        let eigenvalues = eigenvalues(a.clone()).ok_or(not_finite)?;
        let coordinates = independent.iter().map(|&i| system.coordinate(i)).collect();
        let names = independent.iter().map(|&i| system.coordinate_name(i).to_string()).collect();
        Ok(LinearModel { coordinates, names, a, b, by_design, q_z, v_z, eigenvalues })
    }

    /// Independent coordinates, and the derivatives of q and v by them, their rates, and the design variables.
    fn columns(&self, chosen: &[usize]) -> Result<(Vec<usize>, Columns), Error> {
        let (system, inputs) = (self.system(), self.inputs());
        let independent = independent(self, chosen)?;
        let mut retraction = Retraction::new(system, &independent, &inputs)?;
        if self.is_node() {
            retraction.continue_from(self.phi().as_slice().to_vec(), vec![0.0; system.m()]);
        }
        let z: Vec<f64> = independent.iter().flat_map(|&i| [self.q()[i], self.v()[i]]).collect();
        retraction.place(&z, self.q(), &inputs)?;
        let designs: Vec<(usize, f64)> = (0..system.designs()).map(|b| (b, 1.0)).collect();
        let columns = retraction.columns(&designs)?;
        Ok((independent, columns))
    }

    /// Returns an error if this state violates a constraint.
    fn check_admissible(&self) -> Result<(), Error> {
        let (system, none, settings) = (self.system(), vec![0.0; self.system().m()], Settings::default());
        let at = self.view(&none);
        let is_open = |j: usize| self.open().iter().any(|open| open.index() == j);
        let is_constant = |j: usize| self.is_node() || system.held().any(|held| held == j);
        let (mut phi, mut phi_dot) = (self.phi(), self.phi_dot());
        (0..system.m()).filter(|&j| is_open(j) || is_constant(j)).for_each(|j| phi[j] = 0.0);
        (0..system.m()).filter(|&j| is_open(j)).for_each(|j| phi_dot[j] = 0.0);
        system.take_rounding(&at, self.q(), phi.as_mut_slice());
        system.take_rounding(&at, self.v(), phi_dot.as_mut_slice());
        for (values, tolerance, is_rate) in
            [(phi, settings.position_tolerance, false), (phi_dot, settings.velocity_tolerance, true)]
        {
            let worst = (0..values.len()).max_by(|&i, &j| values[i].abs().total_cmp(&values[j].abs()));
            let Some((j, violation)) = worst.map(|j| (j, values[j])) else { continue };
            if !violation.is_finite() {
                return Err(system.constraint_not_finite(&at, j));
            }
            if violation.abs() > tolerance {
                let equation = system.equation_name(j).to_string();
                return Err(Error::InadmissibleState { equation, violation, tolerance, is_rate });
            }
        }
        Ok(())
    }
}
