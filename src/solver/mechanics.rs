//! [`Mechanics`]: mechanical quantities at a single state, without a motion.

use nalgebra::{DMatrix, DVector};

use crate::accelerations::Accelerations;
use crate::forward::ForwardSweep;
use crate::motion::{check_open, column, open, with_open};
use crate::redundancy::{Scaled, mass_matrix};
use crate::scene::planar::Point;
use crate::scene::spatial::{Marker, MarkerState};
use crate::system::{NodeView, Pair, Sums};
use crate::{Error, Grid, Inputs, Multiplier, Param, Settings, Start, System, Trajectory};

/// The mechanics of a system at one state: constraints, energies, momenta, accelerations and reactions, positions of points.
///
/// ```
/// use hamiltonian_adjoint::{Mechanics, Scene, planar::Body};
///
/// let mut scene = Scene::new();
/// scene.gravity(0.0, -9.81);
/// let bob = scene.body("bob", 2.0, 0.1, [0.6, -0.8, 0.0]);
/// let hook = Body::GROUND.at(0.0, 0.0);
/// scene.distance("rod", hook, bob.at(0.0, 0.0), 1.0);
/// let system = scene.compile()?;
/// let at = Mechanics::new(&system, &[0.6, -0.8, 0.0], &[0.8, 0.6, 0.0])?;
/// assert!((at.energy() - (1.0 - 2.0 * 9.81 * 0.8)).abs() < 1e-12);
/// let (v_dot, _lambda) = at.accelerations()?;
/// let centripetal = -(0.6 * v_dot[0] - 0.8 * v_dot[1]); // v²/l
/// assert!((centripetal - 1.0).abs() < 1e-12);
/// assert_eq!(at.velocity(bob.at(0.5, 0.0)), [0.8, 0.6]);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mechanics {
    system: System,
    q: Vec<f64>,
    v: Vec<f64>,
    u: Vec<f64>,
    t: f64,
    design: Vec<f64>,
    /// The equations that are open.
    open: Vec<usize>,
    /// True for a node of a motion, whose positions may have drifted from Φ = 0.
    is_node: bool,
}

impl Mechanics {
    /// The mechanics at coordinates q (m, rad) and velocities v (m/s, rad/s), with zero controls, the design of the scene and t = 0. Equations that some
    /// event closes are open ([`System::open_equations`]).
    ///
    /// # Errors
    /// Vectors whose length differs from [`System::n`], or numbers that are not finite.
    pub fn new(system: &System, q: &[f64], v: &[f64]) -> Result<Self, Error> {
        let design = system.parameters().values(system.design_values().as_slice()).into_owned();
        let here = Mechanics {
            system: system.clone(),
            q: q.to_vec(),
            v: v.to_vec(),
            u: vec![0.0; system.k()],
            t: 0.0,
            design,
            open: system.open_at_start(),
            is_node: false,
        };
        check("q", system.n(), q)?;
        check("v", system.n(), v)?;
        Ok(here)
    }

    /// The mechanics at the start of a motion. If the start is a guess, it is assembled first; if momenta are given, the velocities are
    /// computed from them.
    ///
    /// # Errors
    /// As [`Solver::simulate`](crate::Solver::simulate).
    pub fn at_start(system: &System, inputs: &Inputs) -> Result<Self, Error> {
        let settings = Settings::default();
        let mut forward = ForwardSweep::new(system, settings.scheme);
        forward.begin(system, inputs, 1, &settings)?;
        let start = forward.motion.at(0);
        let mut here = Self::new(system, start.q, start.v)?.at_time(start.t)?;
        here.open = inputs.open.iter().map(Multiplier::index).collect();
        here.with_controls(inputs.controls_at(0))?.with_design(inputs.design.as_slice())
    }

    /// The mechanics at a node of a motion. `inputs` are those of the motion, on the grid that was used:
    /// [`Solver::inputs`](crate::Solver::inputs).
    ///
    /// # Errors
    /// Inputs that do not belong to the motion, or a node that does not exist or was not computed.
    pub fn at_node(system: &System, inputs: &Inputs, motion: &Trajectory, node: usize) -> Result<Self, Error> {
        motion.check_fits(system, inputs)?;
        if node >= motion.times.len() {
            let (what, value) = (format!("the node of a motion with {} nodes", motion.times.len()), node as f64);
            return Err(Error::Parameter { what, value, must_be: "less than the number of nodes (counted from 0)" });
        }
        if node >= motion.computed {
            return Err(Error::Incomplete { expected: node + 1, computed: motion.computed });
        }
        let mut here = Self::new(system, column(&motion.q, node), column(&motion.v, node))?.at_time(motion.times[node])?;
        here.open = open(motion.compliance_from(node)).collect();
        here.is_node = true;
        here.with_controls(inputs.controls_at(node))?.with_design(inputs.design.as_slice())
    }

    /// The same state with other controls.
    ///
    /// # Errors
    /// A number of controls that differs from [`System::k`], or numbers that are not finite.
    pub fn with_controls(mut self, u: &[f64]) -> Result<Self, Error> {
        check("controls", self.system.k(), u)?;
        self.u = u.to_vec();
        Ok(self)
    }

    /// The same state with other values of the design variables.
    ///
    /// # Errors
    /// A number of values that differs from [`System::designs`], or values that are not finite or out of range.
    pub fn with_design(mut self, design: &[f64]) -> Result<Self, Error> {
        check("design variables", self.system.designs(), design)?;
        self.system.check_design(design)?;
        self.design = self.system.parameters().values(design).into_owned();
        Ok(self)
    }

    /// The same state at another time, s.
    ///
    /// # Errors
    /// A time that is not finite.
    pub fn at_time(mut self, t: f64) -> Result<Self, Error> {
        check("t", 1, &[t])?;
        self.t = t;
        Ok(self)
    }

    /// The same state with these equations open and all others closed.
    ///
    /// # Errors
    /// A multiplier of another scene, or an equation that no event opens, closes or hits.
    pub fn with_open(mut self, open: &[Multiplier]) -> Result<Self, Error> {
        check_open("Mechanics::with_open", open, &self.system)?;
        self.open = open.iter().map(Multiplier::index).collect();
        Ok(self)
    }

    /// Φ(q, t), m or rad.
    pub fn phi(&self) -> DVector<f64> {
        let (sigma, mut phi) = (vec![0.0; self.system.m()], DVector::zeros(self.system.m()));
        self.system.phi(&self.view(&sigma), phi.as_mut_slice());
        phi
    }

    /// Φ_q (m × n).
    pub fn phi_q(&self) -> DMatrix<f64> {
        let (sigma, mut phi_q) = (vec![0.0; self.system.m()], DMatrix::zeros(self.system.m(), self.system.n()));
        self.system.phi_q(&self.view(&sigma)).iter().for_each(|entry| phi_q[(entry.row, entry.col)] += entry.value);
        phi_q
    }

    /// dΦ/dt = Φ_q v + Φ_t (1c), m/s or rad/s.
    pub fn phi_dot(&self) -> DVector<f64> {
        DVector::from_column_slice(self.sums().phi_dot())
    }

    /// The mass matrix M = T_vv (n × n).
    pub fn mass(&self) -> DMatrix<f64> {
        mass_matrix(&self.system, &self.view(&vec![0.0; self.system.m()]))
    }

    /// Momenta T_v, without impulses of constraints (1a), N s or N m s.
    pub fn momenta(&self) -> DVector<f64> {
        DVector::from_column_slice(self.sums().l_v())
    }

    /// T, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.system.energies(&self.view(&vec![0.0; self.system.m()]))[0]
    }

    /// V, J.
    pub fn potential_energy(&self) -> f64 {
        self.system.energies(&self.view(&vec![0.0; self.system.m()]))[1]
    }

    /// T + V, J.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.potential_energy()
    }

    /// v̇ (m/s², rad/s²) and λ = dσ/dt (N, N m), from (1a)–(1c) differentiated in time at σ = 0:
    ///
    /// ```text
    ///   M v̇ + Φ_qᵀ λ = 𝓛_q + Q − (T_v)_q v − (T_v)_t      Φ_q v̇ = −(dΦ/dt)_q v − (dΦ/dt)_t
    /// ```
    ///
    /// For dependent constraints λ is not unique, but Φ_qᵀλ is; that of an open equation is 0.
    ///
    /// # Errors
    /// A singular mass matrix or configuration, or forces that are not finite.
    pub fn accelerations(&self) -> Result<(DVector<f64>, DVector<f64>), Error> {
        let (mut accelerations, none) = (Accelerations::new(&self.system), vec![0.0; self.system.m()]);
        accelerations.evaluate(&self.system, &self.view(&none), (0, &self.compliances()))?;
        let Pair { v, sigma } = accelerations.found();
        Ok((DVector::from_vec(v), DVector::from_vec(sigma)))
    }

    /// The number of velocities that the constraints leave free, here and nearby: n − rank Φ_q.
    pub fn degrees_of_freedom(&self) -> usize {
        let (system, sigma) = (&self.system, vec![0.0; self.system.m()]);
        let at = self.view(&sigma);
        let rank = Scaled::at(system, &at).map_or(system.m(), |here| here.rank(system, &at));
        system.n().saturating_sub(rank)
    }

    /// Position of a point of a body or of the ground in the inertial frame, m.
    ///
    /// # Panics
    /// If the point belongs to another scene, or its position in the body is an expression of design variables created after the scene was
    /// compiled.
    pub fn position(&self, point: Point) -> [f64; 2] {
        let ([x, y, phi], [along, across]) = self.frame(point);
        let (sin, cos) = phi.sin_cos();
        [x + cos * along - sin * across, y + sin * along + cos * across]
    }

    /// Velocity of a point of a body or of the ground in the inertial frame, m/s.
    ///
    /// # Panics
    /// As [`position`](Self::position).
    pub fn velocity(&self, point: Point) -> [f64; 2] {
        let ([_, _, phi], [along, across]) = self.frame(point);
        let (sin, cos) = phi.sin_cos();
        let [x_dot, y_dot, phi_dot] = point.frame().place(|q| self.v[q.index()]);
        [x_dot - phi_dot * (sin * along + cos * across), y_dot + phi_dot * (cos * along - sin * across)]
    }

    /// Position and motion of a marker in space, with its accelerations for the present controls.
    ///
    /// ```
    /// use hamiltonian_adjoint::spatial::{Body, Inertia};
    /// use hamiltonian_adjoint::{Mechanics, Scene};
    ///
    /// let mut scene = Scene::new();
    /// let mut space = scene.spatial();
    /// let wheel = space.body("wheel", Inertia::sphere(1.0, 0.2));
    /// space.revolute("axle", Body::GROUND.origin(), wheel.origin());
    /// let system = scene.compile()?;
    /// let rim = Mechanics::new(&system, &[0.0], &[3.0])?.marker(wheel.at([0.2, 0.0, 0.0]))?;
    /// assert!((rim.velocity[1] - 0.6).abs() < 1e-15 && (rim.acceleration[0] + 1.8).abs() < 1e-15);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// A marker of another scene, or of a body that no joint carries, and as [`accelerations`](Self::accelerations).
    pub fn marker(&self, marker: Marker) -> Result<MarkerState<f64>, Error> {
        let v_dot = self.accelerations()?.0;
        self.moving(marker, v_dot.as_slice())
    }

    /// Position and motion of a marker with the accelerations that follow from these v̇.
    pub(crate) fn moving(&self, marker: Marker, v_dot: &[f64]) -> Result<MarkerState<f64>, Error> {
        if marker.body().0.is_some_and(|body| !self.system.owns(body)) {
            return Err(Error::Foreign { element: "Mechanics::marker".into(), kind: "body" });
        }
        if !marker.params().into_iter().all(|param| self.system.knows(param)) {
            return Err(Error::Foreign { element: "Mechanics::marker".into(), kind: "parameter" });
        }
        self.system.sketch().space.state_of(marker, &|param| self.parameter(param), [&self.q, &self.v, v_dot])
    }

    /// The coordinates q, m or rad.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// The velocities v, m/s or rad/s.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// The controls u.
    pub fn controls(&self) -> &[f64] {
        &self.u
    }

    /// The time, s.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// The multipliers of the equations that are open.
    pub fn open(&self) -> Vec<Multiplier> {
        self.open.iter().map(|&j| self.system.multiplier(j)).collect()
    }

    /// The value of a parameter.
    pub(crate) fn parameter(&self, param: Param) -> f64 {
        self.system.parameters().value_of(param, &self.design)
    }

    /// x, y and φ of a point's frame, and the position of the point in it.
    fn frame(&self, point: Point) -> ([f64; 3], [f64; 2]) {
        let place = point.frame().place(|q| {
            assert!(self.system.owns(q.0), "the point belongs to a body of another scene");
            self.q[q.index()]
        });
        let at = point.at().map(|param| {
            assert!(
                self.system.knows(param),
                "the point's position depends on design variables of another scene or on an expression created after compilation"
            );
            self.parameter(param)
        });
        (place, at)
    }

    /// The system.
    pub(crate) fn system(&self) -> &System {
        &self.system
    }

    /// Inputs of a motion that starts here with constant controls, with a grid of one step.
    pub(crate) fn inputs(&self) -> Inputs {
        let grid = Grid::new(self.t, vec![1.0]);
        let (q, v) = (DVector::from_column_slice(&self.q), DVector::from_column_slice(&self.v));
        let mut inputs =
            Inputs { start: Start::Velocity { q, v }, open: self.open(), ..Inputs::at_rest(&self.system, grid) };
        inputs.design.copy_from_slice(&self.design[..self.system.designs()]);
        inputs.controls.column_iter_mut().for_each(|mut column| column.copy_from_slice(&self.u));
        inputs
    }

    /// The state at rest at other coordinates.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    pub(crate) fn resting_at(&self, q: &[f64]) -> Result<Self, Error> {
        check("q", self.system.n(), q)?;
        Ok(Mechanics { q: q.to_vec(), v: vec![0.0; q.len()], is_node: false, ..self.clone() })
    }

    /// True for a node of a motion, whose positions may have drifted from Φ = 0.
    pub(crate) fn is_node(&self) -> bool {
        self.is_node
    }

    /// The compliances of the open equations.
    pub(crate) fn compliances(&self) -> Vec<(usize, f64)> {
        with_open(&[], &self.open)
    }

    /// The state with these multipliers.
    pub(crate) fn view<'a>(&'a self, sigma: &'a [f64]) -> NodeView<'a, f64> {
        NodeView::of_equations([&self.q, &self.v, sigma], (&self.u, self.t, &self.design))
    }

    /// 𝓛_v, 𝓛_q + Q and dΦ/dt at σ = 0.
    fn sums(&self) -> Sums<f64> {
        let (mut sums, sigma) = (Sums::new(self.system.n(), self.system.m()), vec![0.0; self.system.m()]);
        self.system.plain_sums(&self.view(&sigma), &mut sums);
        sums
    }
}

fn check(what: &'static str, expected: usize, x: &[f64]) -> Result<(), Error> {
    if x.len() != expected {
        return Err(Error::Size { what, expected, found: x.len() });
    }
    match x.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        Some((i, &value)) => Err(Error::NotFinite { what: format!("{what}, entry {i},"), value }),
        None => Ok(()),
    }
}
