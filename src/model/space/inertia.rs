//! [`Inertia`]: mass, centre of mass and inertia tensor of a body in space.

use nalgebra::{Matrix3, SymmetricEigen, U3};

use super::components::Components;
use super::vectors::{self, Matrix, Vector};
use crate::model::Param;

/// Mass, centre of mass and inertia tensor of a body. Each of the ten numbers may be a design variable or an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    pub(crate) mass: Param,
    pub(crate) centre: Vector,
    /// J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass, in the axes of the body.
    pub(crate) tensor: [Param; 6],
    /// The edges of a cuboid or the radius of a sphere, which must not be negative; 0 otherwise.
    pub(crate) lengths: Vector,
    pub(crate) is_unchecked: bool,
}

/// Principal moments are compared up to this fraction of the largest one, since tensors are often given with a few digits.
const ROUNDING: f64 = 1e-6;
/// Largest number of iterations for eigenvalues.
const MOST_ITERATIONS: usize = 1000;

impl Inertia {
    /// From the mass, kg, and the entries J_xx, J_yy, J_zz, J_xy, J_xz, J_yz of the inertia tensor about the centre of mass, kg m², in the axes of the
    /// body, with J_xy = −∫ x y dm. The centre of mass is the origin of the body's frame ([`centred_at`](Self::centred_at)).
    pub fn new(mass: impl Into<Param>, tensor: impl Components<6>) -> Self {
        let [centre, lengths] = [vectors::zero(); 2];
        Inertia { mass: mass.into(), centre, tensor: tensor.params(), lengths, is_unchecked: false }
    }

    /// From the mass, kg, and the moments of inertia about the axes of the body through the centre of mass, kg m², which are principal axes.
    pub fn principal(mass: impl Into<Param>, moments: impl Components<3>) -> Self {
        let [xx, yy, zz] = moments.params();
        let zero = Param::from(0.0);
        Inertia::new(mass, [xx, yy, zz, zero, zero, zero])
    }

    /// A mass, kg, at the origin of the body's frame.
    pub fn point(mass: impl Into<Param>) -> Self {
        Inertia::new(mass, [0.0; 6])
    }

    /// A homogeneous cuboid with mass, kg, and lengths of its edges along x, y and z, m, about the origin of the body's frame.
    pub fn cuboid(mass: impl Into<Param>, edges: impl Components<3>) -> Self {
        let (mass, lengths) = (mass.into(), edges.params());
        let [xx, yy, zz] = lengths.map(|edge| vectors::times(edge, edge));
        let moment = |a, b| vectors::times(mass, vectors::plus(a, b)) * (1.0 / 12.0);
        Inertia { lengths, ..Inertia::principal(mass, [moment(yy, zz), moment(xx, zz), moment(xx, yy)]) }
    }

    /// A homogeneous sphere with mass, kg, and radius, m, about the origin of the body's frame.
    pub fn sphere(mass: impl Into<Param>, radius: impl Into<Param>) -> Self {
        let (mass, radius) = (mass.into(), radius.into());
        let moment = mass * radius * radius * 0.4;
        Inertia { lengths: [radius, 0.0.into(), 0.0.into()], ..Inertia::principal(mass, [moment; 3]) }
    }

    /// A body without mass.
    pub fn none() -> Self {
        Inertia::point(0.0)
    }

    /// This inertia with the centre of mass at a point of the body's frame, m.
    #[must_use]
    pub fn centred_at(self, centre: impl Components<3>) -> Self {
        Inertia { centre: centre.params(), ..self }
    }

    /// This inertia, accepted although no distribution of mass may have it, as in some files of robots.
    #[must_use]
    pub fn unchecked(self) -> Self {
        Inertia { is_unchecked: true, ..self }
    }

    /// The principal moments of a tensor J_xx, J_yy, J_zz, J_xy, J_xz, J_yz, kg m², in ascending order, if no distribution of mass has them: if one is
    /// negative, or larger than the sum of the other two; `None` otherwise.
    pub fn impossible_moments(tensor: [f64; 6]) -> Option<[f64; 3]> {
        if tensor == [0.0; 6] {
            return None;
        }
        let mut moments: [f64; 3] = principal(tensor).map_or([f64::NAN; 3], |principal| principal.eigenvalues.into());
        moments.sort_by(f64::total_cmp);
        let [least, middle, most] = moments;
        let rounding = ROUNDING * most.abs().max(least.abs());
        let is_possible = least >= -rounding && most <= least + middle + rounding;
        (!is_possible).then_some(moments)
    }

    /// Half of mass and tensor, with the same centre.
    pub(crate) fn halved(self) -> Self {
        Inertia { mass: self.mass * 0.5, tensor: self.tensor.map(|entry| entry * 0.5), ..self }
    }

    pub(crate) fn params(&self) -> Vec<Param> {
        [&[self.mass], &self.centre[..], &self.tensor, &self.lengths].concat()
    }
}

/// The principal moments and axes of a tensor J_xx, J_yy, J_zz, J_xy, J_xz, J_yz; `None` if it is zero or not finite.
pub(crate) fn principal([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Option<SymmetricEigen<f64, U3>> {
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    // The entries are scaled to 1, so that they can neither overflow nor be lost.
    let size = tensor.amax();
    if size == 0.0 || !tensor.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let mut found = SymmetricEigen::try_new(tensor / size, f64::EPSILON, MOST_ITERATIONS)?;
    found.eigenvalues *= size;
    Some(found)
}

/// m, m c and the tensor J about the origin of a frame: sums for bodies that do not move relative to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    pub(crate) mass: Param,
    pub(crate) first: Vector,
    /// J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    pub(crate) second: [Param; 6],
}

/// The entries of a symmetric matrix in the order of their storage.
const ENTRIES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

impl Moments {
    pub(crate) fn none() -> Self {
        Moments { mass: 0.0.into(), first: vectors::zero(), second: [0.0.into(); 6] }
    }

    /// Of a body whose frame has this rotation and origin.
    pub(crate) fn of(inertia: &Inertia, turn: Matrix, origin: Vector) -> Self {
        let [xx, yy, zz, xy, xz, yz] = inertia.tensor;
        let tensor = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let turned = turn.map(|row| vectors::apply(tensor, row));
        let centre = vectors::add(vectors::apply(turn, inertia.centre), origin);
        let square = vectors::dot(centre, centre);
        let second = ENTRIES.map(|[i, j]| {
            let own = vectors::dot(turned[i], turn[j]);
            let diagonal = if i == j { square } else { 0.0.into() };
            let steiner = vectors::plus(diagonal, -vectors::times(centre[i], centre[j]));
            vectors::plus(own, vectors::times(inertia.mass, steiner))
        });
        Moments { mass: inertia.mass, first: vectors::scaled(centre, inertia.mass), second }
    }

    pub(crate) fn are_none(&self) -> bool {
        let all = self.first.iter().chain(&self.second).chain([&self.mass]);
        all.into_iter().all(|param| param.constant() == Some(0.0))
    }

    pub(crate) fn add(&mut self, other: &Moments) {
        self.mass = vectors::plus(self.mass, other.mass);
        self.first = vectors::add(self.first, other.first);
        self.second = std::array::from_fn(|i| vectors::plus(self.second[i], other.second[i]));
    }

    pub(crate) fn subtract(&mut self, other: &Moments) {
        let Moments { mass, first, second } = *other;
        self.add(&Moments { mass: -mass, first: vectors::negated(first), second: second.map(|entry| -entry) });
    }
}
