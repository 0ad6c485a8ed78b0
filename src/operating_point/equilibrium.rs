//! [`Equilibrium`]: a configuration in which all forces balance.

use nalgebra::{Complex, DMatrix, DVector};

use super::descent::MOST_STEPS;
use super::indices;
use super::sensitivity::Sensitivity;
use super::statics::{Balance, Statics};
use crate::linear::eigenvalues;
use crate::motion::Held;
use crate::redundancy::{Scaled, is_singular};
use crate::{Coordinate, Error, Inputs, Mechanics, Start};

/// Growth of a mode, relative to the largest eigenvalue, that is rounding.
const GROWS: f64 = 1e-9;
/// Largest number of steps to an equilibrium that need not be found.
const FEW_STEPS: usize = 50;

/// A configuration at rest in which all forces balance, with its derivatives and the stability of small motions.
///
/// ```text
///   𝓛_q + Q − Φ_qᵀ λ + holding = 0,      Φ(q, t) = 0      at v = 0
/// ```
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// The state: q in equilibrium, v = 0.
    pub state: Mechanics,
    /// The reactions λ (m), N or N m. For dependent constraints λ is not unique, but Φ_qᵀλ is; that of an open equation is 0.
    pub lambda: DVector<f64>,
    /// The forces that hold the held coordinates (n), N or N m; zero for all others.
    pub holding: DVector<f64>,
    /// Eigenvalues of the linearised motion in which the held coordinates rest, 1/s, those with the largest real parts first.
    pub eigenvalues: Vec<Complex<f64>>,
    /// Derivatives with respect to the controls; a column for each.
    pub by_controls: Sensitivity,
    /// Derivatives with respect to the design variables; a column for each.
    pub by_design: Sensitivity,
}

impl Equilibrium {
    /// True if no small motion grows; a free oscillation without damping counts as stable.
    pub fn is_stable(&self) -> bool {
        let most = self.eigenvalues.iter().map(|s| s.norm()).fold(0.0, f64::max);
        self.eigenvalues.iter().all(|s| s.re <= GROWS * most)
    }
}

impl Mechanics {
    /// The equilibrium near these coordinates, stable or not, with the controls, design variables and time of this state.
    ///
    /// The coordinates are a guess and need not satisfy the constraints; the velocities are ignored. Held coordinates keep their values. Hold a
    /// coordinate if no force acts on it and the equilibrium would not be unique, such as that of a cart on a rail, or to compute the force that
    /// holds it. Newton's method finds the equilibrium; if it does not converge, the result is that of [`stable_equilibrium`](Self::stable_equilibrium).
    ///
    /// ```
    /// use hamiltonian_adjoint::{Mechanics, Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// scene.gravity(0.0, -10.0);
    /// let length = scene.design("length", 0.5); // m
    /// let arm = scene.body("arm", 2.0, 0.1, [0.5, 0.0, 0.0]); // kg, kg m²; x, y, φ
    /// scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), arm.at(-1.0 * length, 0.0));
    /// let torque = scene.control("torque");
    /// scene.torque_actuator("motor", Body::GROUND, arm, torque);
    /// let system = scene.compile()?;
    ///
    /// // 5 N m balance 2 kg · 10 m/s² · 0.5 m · cos φ.
    /// let guess = system.initial_coordinates();
    /// let arm_at = Mechanics::new(&system, guess.as_slice(), &[0.0; 3])?.with_controls(&[5.0])?.equilibrium(&[])?;
    /// let phi = arm_at.state.q()[2];
    /// assert!((phi.cos() - 0.5).abs() < 1e-12);
    /// assert!((arm_at.by_controls.q[(2, 0)] + 1.0 / (10.0 * phi.sin())).abs() < 1e-12); // rad/(N m)
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// A coordinate of another scene, or held coordinates that determine each other; a guess from which the constraints cannot be satisfied; no
    /// equilibrium, or one that is not isolated; a constraint that moves; a singular configuration or mass matrix; forces that are not finite.
    pub fn equilibrium(&self, held: &[Coordinate]) -> Result<Equilibrium, Error> {
        self.find(held, |statics, start| match statics.newton(start)? {
            Some(found) => Ok(found),
            None => statics.descend(start, MOST_STEPS),
        })
    }

    /// The equilibrium in which a mechanism with strong friction comes to rest from these coordinates.
    ///
    /// Every step follows the forces, so that for forces of a potential the equilibrium is a minimum of the potential energy. Otherwise as
    /// [`equilibrium`](Self::equilibrium).
    ///
    /// ```
    /// use hamiltonian_adjoint::{Mechanics, Scene, planar::Body};
    ///
    /// let mut scene = Scene::new();
    /// scene.gravity(0.0, -9.81);
    /// let rod = scene.body("rod", 1.0, 0.1, [0.0, 0.5, 0.0]); // upright
    /// scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), rod.at(0.0, -0.5));
    /// let system = scene.compile()?;
    /// let upright = Mechanics::new(&system, &[0.0, 0.5, 0.0], &[0.0; 3])?;
    /// assert!(!upright.equilibrium(&[])?.is_stable());
    /// let hanging = upright.stable_equilibrium(&[])?;
    /// assert!(hanging.is_stable() && (hanging.state.q()[1] + 0.5).abs() < 1e-12);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`equilibrium`](Self::equilibrium).
    pub fn stable_equilibrium(&self, held: &[Coordinate]) -> Result<Equilibrium, Error> {
        self.find(held, |statics, start| statics.descend(start, MOST_STEPS))
    }

    fn find(
        &self,
        held: &[Coordinate],
        search: impl FnOnce(&mut Statics, &Balance) -> Result<Balance, Error>,
    ) -> Result<Equilibrium, Error> {
        let system = self.system();
        let (mut statics, start) = self.balanced(held)?;
        let found = search(&mut statics, &start)?;
        found.check()?;
        let none = vec![0.0; system.m()];
        let at = found.state.view(&none);
        if let Some(error) = Scaled::at(system, &at).and_then(|here| is_singular(&here, system, &at)) {
            return Err(error);
        }
        statics.describe(found)
    }

    /// A stable equilibrium, which need not be isolated, close to these coordinates; `None` if a few steps lead to none.
    pub(crate) fn settled(&self, held: &[Coordinate]) -> Option<Mechanics> {
        let (mut statics, start) = self.balanced(held).ok()?;
        Some(statics.descend(&start, FEW_STEPS).ok()?.state)
    }

    fn balanced(&self, held: &[Coordinate]) -> Result<(Statics, Balance), Error> {
        let start = self.assembled(held, "Mechanics::equilibrium")?;
        let mut statics = Statics::new(&start, held.iter().map(Coordinate::index).collect())?;
        let start = statics.balance(&start)?;
        Ok((statics, start))
    }

    /// The state at rest nearest to these coordinates that satisfies the constraints and keeps the held coordinates.
    fn assembled(&self, held: &[Coordinate], caller: &str) -> Result<Mechanics, Error> {
        let system = self.system();
        indices(caller, held, system)?;
        let held = Held { coordinates: held.to_vec(), velocities: Vec::new() };
        let q = DVector::from_column_slice(self.q());
        let start = Start::Assembled { q, v: DVector::zeros(system.n()), held };
        let start = Mechanics::at_start(system, &Inputs { start, ..self.inputs() })?;
        self.resting_at(start.q())
    }
}

impl Statics {
    /// Reactions, stability and derivatives of an equilibrium.
    fn describe(&mut self, found: Balance) -> Result<Equilibrium, Error> {
        let holding = self.holding(&found);
        let lambda = self.reactions(&found, &holding)?;
        let eigenvalues = self.eigenvalues(&found)?;
        let [by_controls, by_design] = self.sensitivities(&found, &lambda)?;
        let (holding, lambda) = (DVector::from_vec(holding), DVector::from_vec(lambda));
        Ok(Equilibrium { state: found.state, lambda, holding, eigenvalues, by_controls, by_design })
    }

    /// Eigenvalues of δ̈ = −k δ − d δ̇, with d = −Pᵀ r_v P.
    fn eigenvalues(&mut self, found: &Balance) -> Result<Vec<Complex<f64>>, Error> {
        let f = found.free.ncols();
        let damping = self.force_changes(&found.state, &found.lambda, [&DMatrix::zeros(0, 0), &found.free])?;
        let mut a = DMatrix::zeros(2 * f, 2 * f);
        a.view_mut((0, f), (f, f)).fill_with_identity();
        a.view_mut((f, 0), (f, f)).copy_from(&-&found.stiffness);
        a.view_mut((f, f), (f, f)).copy_from(&found.free.tr_mul(&damping));
        eigenvalues(a).ok_or_else(|| Error::Overflow { what: "an eigenvalue of the equilibrium".into(), value: f64::NAN })
    }
}
