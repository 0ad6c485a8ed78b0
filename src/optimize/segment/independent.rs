//! [`IndependentStart`]: the start of a segment as a function of independent coordinates, their rates, and design variables.

use nalgebra::{DMatrix, DVector};

use super::super::motion_problem::MotionProblem;
use super::super::variables::Variables;
use crate::assembly::{Columns, Retraction};
use crate::motion::indices;
use crate::{Coordinate, Error, Held, Inputs, Start, System};

/// The start (q, p*) of a segment, whose motion has the variables (others, q, p*) where the segment has (others, ζ_1, ω_1, ζ_2, …).
pub(in super::super) struct IndependentStart {
    pub(super) retraction: Retraction,
    coordinates: Vec<Coordinate>,
    /// The coordinates of the current point, near which others are sought.
    near: Vec<f64>,
    /// True if there is a current point: a start that is not near it is not sought with care.
    is_settled: bool,
    derived: Option<Derived>,
}

/// Derivatives at the last point.
struct Derived {
    columns: Columns,
    /// The variable of each design variable.
    designs: Vec<usize>,
    /// The part of the last gradient that comes through the start, by the other variables.
    through: Vec<f64>,
    /// The last gradient by (q, p*), and the second derivatives of the start that it is multiplied with, once they are needed.
    gradient: Option<[DVector<f64>; 2]>,
    curvature: Option<DMatrix<f64>>,
}

impl std::fmt::Debug for IndependentStart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("IndependentStart").field("coordinates", &self.coordinates).finish_non_exhaustive()
    }
}

impl IndependentStart {
    pub(super) fn new(system: &System, coordinates: &[Coordinate], inputs: &Inputs) -> Result<Self, Error> {
        let retraction = Retraction::new(system, &indices(coordinates), inputs)?;
        let coordinates = coordinates.to_vec();
        Ok(IndependentStart {
            retraction,
            coordinates,
            near: inputs.start.q().as_slice().to_vec(),
            is_settled: false,
            derived: None,
        })
    }

    /// The number of variables of the start.
    pub(super) fn len(&self) -> usize {
        2 * self.coordinates.len()
    }

    /// z of a state.
    pub(super) fn of(&self, q: &DVector<f64>, v: &DVector<f64>) -> Vec<f64> {
        self.coordinates.iter().flat_map(|of| [q[of.index()], v[of.index()]]).collect()
    }

    /// The coordinates near which the start is sought.
    pub(super) fn near(&mut self) -> &mut Vec<f64> {
        &mut self.near
    }

    /// Continues a motion whose constraints have this drift and these multipliers at its end.
    pub(super) fn continue_from(&mut self, [drift, gauge]: [Vec<f64>; 2]) {
        self.retraction.continue_from(drift, gauge);
    }

    /// (q, p*) for z, with the variables of the motion, of which only the others count.
    pub(super) fn place(&mut self, z: &[f64], own: &[f64], motion: &mut MotionProblem) -> Result<[DVector<f64>; 2], Error> {
        self.derived = None;
        let inputs = motion.next_inputs(own);
        let node = inputs.grid.around[0];
        match self.retraction.place(z, &self.near, inputs) {
            Err(Error::AssemblyStalled { .. } | Error::Held { .. }) if !self.is_settled => {}
            placed => return placed.map_err(|error| error.started_at(node)),
        }
        // From far away, with more care.
        let (mut q, v) = (DVector::from_column_slice(&self.near), DVector::zeros(self.near.len()));
        self.coordinates.iter().zip(z.iter().step_by(2)).for_each(|(of, zeta)| q[of.index()] = *zeta);
        let held = Held { coordinates: self.coordinates.clone(), velocities: self.coordinates.clone() };
        let inputs = Inputs { start: Start::Assembled { q, v, held }, ..inputs.clone() };
        let start = motion.solver.assemble(&inputs)?.start;
        self.retraction.place(z, start.q().as_slice(), &inputs).map_err(|error| error.started_at(node))
    }

    /// Makes the last point the current one.
    pub(super) fn settle(&mut self) {
        self.near.copy_from_slice(self.retraction.q());
        self.is_settled = true;
    }

    /// Replaces the coordinates of z, which are those of no state, by coordinates of a state near it, and seeks the start near that state; false if there
    /// is none.
    pub(super) fn approach(&mut self, z: &mut [f64]) -> bool {
        let places = self.coordinates.iter().map(Coordinate::index);
        let change: Vec<f64> = z.iter().step_by(2).zip(places.clone()).map(|(zeta, i)| zeta - self.near[i]).collect();
        let Some(q) = self.retraction.closest(&self.near, &change) else { return false };
        z.iter_mut().step_by(2).zip(places).for_each(|(zeta, i)| *zeta = q[i]);
        self.near.copy_from_slice(q);
        true
    }

    fn derive(&mut self, variables: &Variables, x: &[f64]) -> Result<&mut Derived, Error> {
        let known = self.derived.take();
        let derived = known.map_or_else(|| self.derivatives(variables, x), Ok)?;
        Ok(self.derived.insert(derived))
    }

    fn derivatives(&mut self, variables: &Variables, x: &[f64]) -> Result<Derived, Error> {
        let designs = variables.designs(x);
        let slopes: Vec<(usize, f64)> = designs.iter().map(|of| (of.design, of.slope)).collect();
        let columns = self.retraction.columns(&slopes)?;
        let designs = designs.into_iter().map(|of| of.variable).collect();
        Ok(Derived { columns, designs, through: Vec::new(), gradient: None, curvature: None })
    }

    /// From derivatives by (others, q, p*) to those by (others, z).
    pub(super) fn pull_back(
        &mut self,
        (variables, x): (&Variables, &[f64]),
        own: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), Error> {
        let others = gradient.len() - self.len();
        let Derived { columns, designs, .. } = self.derive(variables, x)?;
        gradient[..others].copy_from_slice(&own[..others]);
        let through = columns.pull_back(halves(&own[others..]).each_ref());
        let state = gradient.len() - others;
        gradient[others..].copy_from_slice(&through.as_slice()[..state]);
        designs.iter().zip(&through.as_slice()[state..]).for_each(|(&i, g)| gradient[i] += g);
        Ok(())
    }

    /// As [`pull_back`](Self::pull_back), for the function whose products are asked for next.
    pub(super) fn pull_back_and_keep(
        &mut self,
        (variables, x): (&Variables, &[f64]),
        own: &[f64],
        gradient: &mut [f64],
    ) -> Result<(), Error> {
        self.pull_back((variables, x), own, gradient)?;
        let others = gradient.len() - self.len();
        let derived = self.derive(variables, x)?;
        derived.through = gradient[..others].iter().zip(own).map(|(all, own)| all - own).collect();
        (derived.gradient, derived.curvature) = (Some(halves(&own[others..])), None);
        Ok(())
    }

    /// From a direction of (others, z) to that of (others, q, p*).
    pub(super) fn push_forward(
        &mut self,
        (variables, x): (&Variables, &[f64]),
        direction: &[f64],
    ) -> Result<Vec<f64>, Error> {
        let others = direction.len() - self.len();
        let Derived { columns, designs, .. } = self.derive(variables, x)?;
        let [q, p] = columns.push_forward(&along(direction, others, designs));
        Ok(direction[..others].iter().chain(q.iter()).chain(p.iter()).copied().collect())
    }

    /// Adds the second derivatives of the start along a direction to a product with the Hessian.
    pub(super) fn add_curvature(&mut self, variables: &Variables, direction: &[f64], product: &mut [f64]) {
        let others = direction.len() - self.len();
        let IndependentStart { retraction, derived: Some(derived), .. } = self else { return };
        let Derived { columns, designs, through, gradient: Some(gradient), curvature } = derived else { return };
        let curvature = curvature.get_or_insert_with(|| retraction.curvature(columns, gradient.each_ref()));
        let change = &*curvature * along(direction, others, designs);
        let state = direction.len() - others;
        product[others..].iter_mut().zip(change.iter()).for_each(|(sum, x)| *sum += x);
        designs.iter().zip(&change.as_slice()[state..]).for_each(|(&i, x)| product[i] += x);
        variables.add_curvature(&direction[..others], through, &mut product[..others]);
    }
}

/// Derivatives by q and by p*.
fn halves(of: &[f64]) -> [DVector<f64>; 2] {
    let (q, p) = of.split_at(of.len() / 2);
    [q, p].map(DVector::from_column_slice)
}

/// The direction of (z, design variables).
fn along(direction: &[f64], others: usize, designs: &[usize]) -> DVector<f64> {
    let all = direction[others..].iter().copied().chain(designs.iter().map(|&i| direction[i]));
    DVector::from_iterator(direction.len() - others + designs.len(), all)
}
