//! [`Retraction`]: states that satisfy the constraints, as a function of independent coordinates ζ, their rates ω, and design variables.
//!
//! ```text
//!   E q = ζ,  Φ(q, t; b) = φ̂          E v = ω,  dΦ/dt = 0          p* = 𝓛_v(q, v, ŝ)
//! ```
//!
//! E selects n − rank Φ_q coordinates. The drift φ̂ and the gauge ŝ are constants; with those of the end of another motion, the state continues it.
//! With G = [E; Φ_q] and a change (q̇, v̇, ḃ) of the state,
//!
//! ```text
//!   G q̇ = [ζ̇; −Φ_b ḃ],    G v̇ = [ω̇; −Φ̇_q q̇ − Φ̇_b ḃ],    ṗ* = 𝓛_vq q̇ + 𝓛_vv v̇ + 𝓛_vb ḃ
//! ```
//!
//! For a function of (q, p*) with the gradient (a, c), second derivatives are those of Λ = c·𝓛_v + e·dΦ/dt − w·Φ along two changes, where
//!
//! ```text
//!   Gᵀ [·; −e] = 𝓛_vvᵀ c,    Gᵀ [·; w] = a + 𝓛_vqᵀ c + Φ̇_qᵀ e
//! ```

use nalgebra::{DMatrix, DVector};

use crate::motion::Report;
use crate::node::{ALONG, Linearisation, PhiAlong, SecondOrderPrograms};
use crate::number::{Real, largest};
use crate::redundancy::{decomposition, pivots};
use crate::system::{CostRows, Covector, InputRows, NodeView, Pair, StateRows, Sums};
use crate::{Coordinate, Error, Inputs, Multiplier, System};

const MOST_CORRECTIONS: usize = 30;
/// Corrections below this fraction of the largest coordinate are rounding.
const ROUNDING: f64 = 1e-14;
/// A correction that stops shrinking is rounding below this fraction.
const STALLED: f64 = 1e-10;
/// Singular values of Φ_q below this fraction of the largest one are zero.
const RANK: f64 = 1e-8;
/// Factor of the derivatives by coordinates that should not become dependent ones.
const UNWANTED: f64 = 1e-3;

/// The state for independent coordinates, with workspace for its derivatives.
pub(crate) struct Retraction {
    system: System,
    independent: Vec<usize>,
    dependent: Vec<usize>,
    /// Constraint equations with independent gradients.
    equations: Vec<usize>,
    /// φ̂ of all equations, m or rad.
    drift: Vec<f64>,
    at: Place,
    linearisation: Linearisation,
    programs: SecondOrderPrograms,
    phi: PhiAlong,
    sums: Sums<f64>,
    rows: StateRows,
    along: CostRows,
    report: Report,
}

/// The last state, with ŝ, N s or N m s, the inputs there, second derivatives, and G⁻¹.
struct Place {
    q: Vec<f64>,
    v: Vec<f64>,
    gauge: Vec<f64>,
    u: Vec<f64>,
    t: f64,
    design: Vec<f64>,
    /// The values of the parameters.
    parameters: Vec<f64>,
    blocks: Vec<f64>,
    inverse: DMatrix<f64>,
}

impl Place {
    fn here(&self) -> NodeView<'_, f64> {
        NodeView::of_equations([&self.q, &self.v, &self.gauge], (&self.u, self.t, &self.parameters))
    }
}

/// Derivatives of the state; a column for each ζ_i and ω_i, in turn, and for each of the design variables that were asked for.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    pub(crate) q: DMatrix<f64>,
    pub(crate) v: DMatrix<f64>,
    pub(crate) p_star: DMatrix<f64>,
    design: DMatrix<f64>,
}

impl Columns {
    /// The derivatives of a function by the columns, from its derivatives by q and p*.
    pub(crate) fn pull_back(&self, [a, c]: [&DVector<f64>; 2]) -> DVector<f64> {
        self.q.tr_mul(a) + self.p_star.tr_mul(c)
    }

    /// The change of q and p* along a direction.
    pub(crate) fn push_forward(&self, direction: &DVector<f64>) -> [DVector<f64>; 2] {
        [&self.q * direction, &self.p_star * direction]
    }
}

impl Retraction {
    /// Independent coordinates at the start of inputs that satisfies the constraints, if possible the preferred ones.
    pub(crate) fn choose(system: &System, preferred: &[usize], inputs: &Inputs) -> Vec<Coordinate> {
        let (q, v, sigma) = (inputs.start.q().as_slice(), vec![0.0; system.n()], vec![0.0; system.m()]);
        let parameters = system.parameters().values(inputs.design.as_slice());
        let at = NodeView::of_equations([q, &v, &sigma], (inputs.controls_at(0), inputs.grid.start, &parameters));
        let weight = |i: &usize| if preferred.contains(i) { UNWANTED } else { 1.0 };
        let mut phi_q = DMatrix::zeros(system.m(), system.n());
        let is_closed = |row: usize| !inputs.open.iter().any(|of| of.index() == row);
        let entries = system.phi_q(&at).into_iter().filter(|entry| is_closed(entry.row));
        entries.for_each(|entry| phi_q[(entry.row, entry.col)] += entry.value * weight(&entry.col));
        let dependent: Vec<usize> = pivots(phi_q).into_iter().map(|[_, column]| column).collect();
        (0..system.n()).filter(|i| !dependent.contains(i)).map(|i| system.coordinate(i)).collect()
    }

    /// The retraction for a selection of independent coordinates, near the coordinates of inputs that satisfy the constraints.
    ///
    /// # Errors
    /// Coordinates that constraints determine, or that do not determine all others; formulas without values.
    pub(crate) fn new(system: &System, independent: &[usize], inputs: &Inputs) -> Result<Self, Error> {
        let (n, m, k) = (system.n(), system.m(), system.k());
        let design = inputs.design.as_slice().to_vec();
        let at = Place {
            q: inputs.start.q().as_slice().to_vec(),
            v: vec![0.0; n],
            gauge: vec![0.0; m],
            u: inputs.controls_at(0).to_vec(),
            t: inputs.grid.start,
            parameters: system.parameters().values(&design).to_vec(),
            design,
            blocks: Vec::new(),
            inverse: DMatrix::zeros(0, 0),
        };
        let mut retraction = Retraction {
            system: system.clone(),
            independent: independent.to_vec(),
            dependent: (0..n).filter(|i| !independent.contains(i)).collect(),
            equations: Vec::new(),
            drift: vec![0.0; m],
            at,
            linearisation: Linearisation::new(system),
            programs: SecondOrderPrograms::default(),
            phi: PhiAlong::new(system),
            sums: Sums::new(n, m),
            rows: StateRows::new(n, m),
            along: CostRows::new((n, m, k), system.parameters().len(), system.outputs()),
            report: Report::default(),
        };
        let phi_q = retraction.phi_q();
        let open: Vec<usize> = inputs.open.iter().map(Multiplier::index).collect();
        let (dependent, closed) = (&retraction.dependent, (0..m).filter(|j| !open.contains(j)).collect::<Vec<usize>>());
        let found = pivots(phi_q.select_rows(&closed).select_columns(dependent));
        let is_singular = found.len() < dependent.len();
        let rank = if is_singular { dependent.len() } else { pivots(phi_q.select_rows(&closed)).len() };
        if rank > dependent.len() || closed.len() < dependent.len() {
            return Err(retraction.held());
        }
        let mut equations: Vec<usize> = found.into_iter().map(|[row, _]| closed[row]).collect();
        // Equations that depend on others in a singular position may not elsewhere.
        let others: Vec<usize> = closed.into_iter().filter(|row| !equations.contains(row)).collect();
        equations.extend(&others[..dependent.len() - equations.len()]);
        equations.sort_unstable();
        retraction.equations = equations;
        Ok(retraction)
    }

    fn held(&self) -> Error {
        let coordinate = self.independent.first().map_or("", |&i| self.system.coordinate_name(i));
        Error::Held { coordinate: coordinate.to_string() }
    }

    /// The number of independent coordinates.
    pub(crate) fn freedoms(&self) -> usize {
        self.independent.len()
    }

    /// Sets φ̂ and ŝ to those of the end of a motion that the next states continue.
    pub(crate) fn continue_from(&mut self, drift: Vec<f64>, gauge: Vec<f64>) {
        (self.drift, self.at.gauge) = (drift, gauge);
    }

    /// The coordinates of the last state.
    pub(crate) fn q(&self) -> &[f64] {
        &self.at.q
    }

    /// The changes of all coordinates with each ζ_i at the last state (n × n − rank Φ_q).
    pub(crate) fn motions(&self) -> DMatrix<f64> {
        self.at.inverse.columns(0, self.freedoms()).into_owned()
    }

    /// The change of dependent coordinates that reduces Φ to zero with G of the last state; `None` before the first one.
    pub(crate) fn correction(&self, phi: &[f64]) -> Option<DVector<f64>> {
        let none = vec![0.0; self.freedoms()];
        (self.at.inverse.nrows() == self.system.n()).then(|| -self.solve(&none, phi))
    }

    /// λ, for all equations, of forces r on all coordinates at the last state, so that r − Φ_qᵀ λ acts on independent coordinates only.
    pub(crate) fn reactions(&self, forces: &DVector<f64>) -> Vec<f64> {
        self.solve_transposed(forces)
    }

    fn phi_q(&self) -> DMatrix<f64> {
        let mut phi_q = DMatrix::zeros(self.system.m(), self.system.n());
        let at = self.at.here();
        self.system.phi_q(&at).iter().for_each(|entry| phi_q[(entry.row, entry.col)] += entry.value);
        phi_q
    }

    /// Computes G⁻¹ at the current coordinates: with D and I, the columns of Φ_q of dependent and independent coordinates, the dependent ones change
    /// by D⁻¹ (φ − I ζ).
    fn invert(&mut self) -> Result<(), Error> {
        let (n, d, phi_q) = (self.system.n(), self.freedoms(), self.phi_q().select_rows(&self.equations));
        let inverse = phi_q.select_columns(&self.dependent).try_inverse();
        let inverse = inverse.filter(|of| of.iter().all(|x| x.is_finite())).ok_or_else(|| self.held())?;
        let of_zeta = -(&inverse * phi_q.select_columns(&self.independent));
        let mut all = DMatrix::zeros(n, n);
        self.independent.iter().enumerate().for_each(|(column, &i)| all[(i, column)] = 1.0);
        for (row, &i) in self.dependent.iter().enumerate() {
            all.view_mut((i, 0), (1, d)).copy_from(&of_zeta.row(row));
            all.view_mut((i, d), (1, n - d)).copy_from(&inverse.row(row));
        }
        self.at.inverse = all;
        Ok(())
    }

    /// G⁻¹ [ζ; φ], with φ of all equations.
    fn solve(&self, zeta: &[f64], phi: &[f64]) -> DVector<f64> {
        let rows = zeta.iter().copied().chain(self.equations.iter().map(|&j| phi[j]));
        &self.at.inverse * DVector::from_iterator(self.system.n(), rows)
    }

    /// The parts of G⁻ᵀ x that belong to the equations, for all equations.
    fn solve_transposed(&self, x: &DVector<f64>) -> Vec<f64> {
        let x = self.at.inverse.tr_mul(x);
        let mut all = vec![0.0; self.system.m()];
        self.equations.iter().enumerate().for_each(|(row, &j)| all[j] = x[self.freedoms() + row]);
        all
    }

    /// Finds q and p* for z = (ζ_1, ω_1, ζ_2, …) at the start of inputs, beginning at given coordinates.
    ///
    /// # Errors
    /// No such state near these coordinates; formulas without values.
    pub(crate) fn place(&mut self, z: &[f64], near: &[f64], inputs: &Inputs) -> Result<[DVector<f64>; 2], Error> {
        let [zeta, omega] = [0, 1].map(|first| z.iter().skip(first).step_by(2).copied().collect::<Vec<f64>>());
        self.take(near, inputs)?;
        self.independent.iter().zip(zeta).for_each(|(&i, zeta)| self.at.q[i] = zeta);
        self.close()?;
        let (no_v, mut left) = (vec![0.0; self.system.n()], Pair::new(self.system.n(), self.system.m()));
        let at = NodeView { v: &no_v, ..self.at.here() };
        self.linearisation.l_v_and_phi_dot(&self.system, &at, &mut left, &mut self.report);
        left.sigma.iter_mut().for_each(|x| *x = -*x);
        self.at.v = self.solve(&omega, &left.sigma).as_slice().to_vec();
        let at = self.at.here();
        self.linearisation.l_v_and_phi_dot(&self.system, &at, &mut left, &mut self.report);
        if left.v.iter().any(|p| !p.is_finite()) {
            return Err(self.system.find_not_finite(&at, 0).unwrap_or(Error::AssemblyStalled { correction: f64::NAN }));
        }
        self.at.blocks.clone_from(&self.linearisation.evaluation.blocks);
        Ok([DVector::from_column_slice(&self.at.q), DVector::from_vec(left.v)])
    }

    /// Sets the point and the design variables.
    fn take(&mut self, near: &[f64], inputs: &Inputs) -> Result<(), Error> {
        self.at.q.copy_from_slice(near);
        self.at.u.copy_from_slice(inputs.controls_at(0));
        self.at.t = inputs.grid.start;
        self.at.design.copy_from_slice(inputs.design.as_slice());
        self.at.parameters = self.system.parameters().values(&self.at.design).to_vec();
        let at = self.at.here();
        self.linearisation.evaluation.set_start(&self.system, &at)
    }

    /// Newton's method for Φ = φ̂ with the independent coordinates fixed.
    fn close(&mut self) -> Result<(), Error> {
        let (none, mut phi, mut last) = (vec![0.0; self.freedoms()], vec![0.0; self.system.m()], f64::INFINITY);
        for _ in 0..MOST_CORRECTIONS {
            self.invert()?;
            let at = self.at.here();
            self.linearisation.evaluation.phi(&self.system, &at, &mut phi);
            phi.iter_mut().zip(&self.drift).for_each(|(phi, drift)| *phi -= drift);
            let correction = self.solve(&none, &phi);
            let (size, of) = (largest(&self.at.q).max(1.0), correction.amax());
            self.at.q.iter_mut().zip(correction.iter()).for_each(|(q, by)| *q -= by);
            if of <= ROUNDING * size {
                return Ok(());
            }
            if of >= 0.5 * last && of <= STALLED * size {
                return self.invert();
            }
            last = of;
        }
        Err(Error::AssemblyStalled { correction: last })
    }

    /// Coordinates that satisfy Φ = φ̂ at the inputs of the last state, near those that others reach with a change of ζ: all coordinates then change as
    /// little as possible. `None` if Newton's method finds none.
    pub(crate) fn closest(&mut self, others: &[f64], change: &[f64]) -> Option<&[f64]> {
        self.at.q.copy_from_slice(others);
        self.invert().ok()?;
        let moved = self.motions() * DVector::from_column_slice(change);
        self.at.q.iter_mut().zip(moved.iter()).for_each(|(q, by)| *q += by);
        let mut phi = vec![0.0; self.system.m()];
        for _ in 0..MOST_CORRECTIONS {
            let at = self.at.here();
            self.linearisation.evaluation.phi(&self.system, &at, &mut phi);
            let left = self.equations.iter().map(|&j| phi[j] - self.drift[j]);
            let left = DVector::from_iterator(self.equations.len(), left);
            let svd = decomposition(self.phi_q().select_rows(&self.equations))?;
            let correction = svd.solve(&left, RANK * svd.singular_values.max()).ok()?;
            self.at.q.iter_mut().zip(correction.iter()).for_each(|(q, by)| *q -= by);
            if correction.amax() <= STALLED * largest(&self.at.q).max(1.0) {
                return Some(&self.at.q);
            }
        }
        None
    }

    /// The derivatives of the state by ζ, ω and design variables, each given with a factor.
    ///
    /// # Errors
    /// Formulas without programs.
    pub(crate) fn columns(&mut self, designs: &[(usize, f64)]) -> Result<Columns, Error> {
        let (n, d, all) = (self.system.n(), self.freedoms(), 2 * self.freedoms() + designs.len());
        let at = self.at.here();
        self.programs.prepare(&self.system, &self.linearisation.evaluation, &at)?;
        let zeros = || DMatrix::zeros(n, all);
        let mut columns =
            Columns { q: zeros(), v: zeros(), p_star: zeros(), design: DMatrix::zeros(self.system.designs(), all) };
        for column in 0..all {
            let unit = |rate: usize| (0..d).map(|i| if column == 2 * i + rate { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
            if let Some(&(b, factor)) = column.checked_sub(2 * d).map(|which| &designs[which]) {
                columns.design[(b, column)] = factor;
            }
            let (q, v, p) = self.change(&unit(0), &unit(1), columns.design.column(column).as_slice());
            columns.q.set_column(column, &q);
            columns.v.set_column(column, &v);
            columns.p_star.set_column(column, &p);
        }
        Ok(columns)
    }

    /// (q̇, v̇, ṗ*) along a direction.
    fn change(&mut self, zeta: &[f64], omega: &[f64], design: &[f64]) -> (DVector<f64>, DVector<f64>, DVector<f64>) {
        let (n, m) = (self.system.n(), self.system.m());
        let (none, no_sigma, no_u) = (vec![0.0; n], vec![0.0; m], vec![0.0; self.system.k()]);
        let parameters = self.system.parameters().along(&self.at.design, design);
        let mut right = vec![0.0; m];
        if design.iter().any(|b| *b != 0.0) {
            let at = self.at.here();
            self.phi.set(&at, &NodeView::of_equations([&none, &none, &no_sigma], (&no_u, 0.0, &parameters)));
            right.iter_mut().zip(self.phi.evaluate(&self.system)).for_each(|(x, phi)| *x = -phi.part(ALONG));
        }
        let q = self.solve(zeta, &right);
        self.push_forward([q.as_slice(), &none], &parameters);
        right.iter_mut().zip(self.sums.phi_dot()).for_each(|(x, rate)| *x = -rate);
        let v = self.solve(omega, &right);
        self.push_forward([q.as_slice(), v.as_slice()], &parameters);
        (q, v, DVector::from_column_slice(self.sums.l_v()))
    }

    /// The changes of 𝓛_v and dΦ/dt.
    fn push_forward(&mut self, [q, v]: [&[f64]; 2], parameters: &[f64]) {
        let (no_sigma, no_u) = (vec![0.0; self.system.m()], vec![0.0; self.system.k()]);
        let along = NodeView::of_equations([q, v, &no_sigma], (&no_u, 0.0, parameters));
        let at = self.at.here();
        self.programs.changes(
            (&self.system, &self.linearisation.evaluation),
            (&at, &self.at.blocks),
            &along,
            &mut self.sums,
        );
    }

    /// The second derivatives of a function of (q, p*) with this gradient by the columns, without those of the function itself.
    pub(crate) fn curvature(&mut self, columns: &Columns, [a, c]: [&DVector<f64>; 2]) -> DMatrix<f64> {
        let (n, m, count) = (self.system.n(), self.system.m(), columns.q.ncols());
        let (none, no_sigma, no_u) = (vec![0.0; n], vec![0.0; m], vec![0.0; self.system.k()]);
        let [e, w] = self.multipliers([a, c]);
        let of_momenta = Covector { c: c.as_slice(), d: &none, e: &e };
        let of_phi = Covector { c: &none, d: &none, e: &w };
        let has_design = columns.design.iter().any(|b| *b != 0.0);
        let by_parameters = if has_design { self.by_parameters(&of_momenta, &w) } else { Vec::new() };
        let mut curvature = DMatrix::zeros(count, count);
        for column in 0..count {
            let [q, v, design] =
                [&columns.q, &columns.v, &columns.design].map(|of| of.column(column).iter().copied().collect::<Vec<_>>());
            let parameters = self.system.parameters().along(&self.at.design, &design);
            let at = self.at.here();
            let of = (&self.system, &self.linearisation.evaluation);
            let along = NodeView::of_equations([&q, &v, &no_sigma], (&no_u, 0.0, &parameters));
            self.programs.rows_along(of, (&at, &self.at.blocks), &along, &of_momenta, &mut self.along);
            let [mut by_q, by_v] = [&self.along.q, &self.along.v].map(|rows| DVector::from_column_slice(rows));
            let mut by_design = self.along.design.clone();
            // Of w·dΦ/dt, the derivative by v is Φ_qᵀ w.
            let still = NodeView { v: &none, ..along };
            self.programs.rows_along(of, (&at, &self.at.blocks), &still, &of_phi, &mut self.along);
            by_q -= DVector::from_column_slice(&self.along.v);
            let mut entries = columns.q.tr_mul(&by_q) + columns.v.tr_mul(&by_v);
            if has_design {
                self.phi.set(&at, &still);
                self.phi.add_change(&self.system, (&w, -1.0), (&mut by_design, &mut 0.0));
                let mut own = vec![0.0; self.system.designs()];
                let given = [&self.at.design[..], &by_parameters];
                self.system.parameters().pull_back_along(given, [&design, &by_design], &mut own);
                entries += columns.design.tr_mul(&DVector::from_vec(own));
            }
            curvature.set_column(column, &entries);
        }
        curvature
    }

    /// e and w.
    fn multipliers(&mut self, [a, c]: [&DVector<f64>; 2]) -> [Vec<f64>; 2] {
        let (none, no_sigma) = (vec![0.0; self.system.n()], vec![0.0; self.system.m()]);
        let (evaluation, blocks) = (&self.linearisation.evaluation, &self.at.blocks);
        let with = Covector { c: c.as_slice(), d: &none, e: &no_sigma };
        evaluation.pull_back(&self.system, blocks, &with, &mut self.rows);
        let mut e = self.solve_transposed(&DVector::from_column_slice(&self.rows.v));
        e.iter_mut().for_each(|e| *e = -*e);
        let with = Covector { c: c.as_slice(), d: &none, e: &e };
        evaluation.pull_back(&self.system, blocks, &with, &mut self.rows);
        let w = self.solve_transposed(&(a + DVector::from_column_slice(&self.rows.q)));
        [e, w]
    }

    /// The derivatives of Λ with respect to the parameters.
    fn by_parameters(&mut self, of_momenta: &Covector, w: &[f64]) -> Vec<f64> {
        let (mut design, mut u) = (vec![0.0; self.system.parameters().len()], vec![0.0; self.system.k()]);
        let minus: Vec<f64> = w.iter().map(|w| -w).collect();
        let at = self.at.here();
        let rows = &mut InputRows { u: &mut u, design: &mut design, time: &mut 0.0, evaluations: &mut 0 };
        self.linearisation.evaluation.pull_back_inputs(&self.system, &at, of_momenta, rows);
        self.system.placed().for_each(|item| item.pull_back_phi(&at, &minus, rows));
        design
    }
}
