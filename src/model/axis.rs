//! [`Axis`]: a linear combination of coordinates, along which parts act.

use super::{Coordinate, Param};

/// A coordinate s = Σ a_k q_k along which parts act, m or rad; a [`Coordinate`] is an axis with the factor 1.
///
/// ```
/// use hamiltonian_adjoint::{Scene, axis::Axis};
///
/// let mut scene = Scene::new();
/// let [a, b] = scene.coordinates("wheels", ["a", "b"]);
/// scene.rotor("wheel a", a, 0.1, 1.0);
/// scene.rotor("wheel b", b, 0.2, 1.0);
/// scene.axis_spring_damper("shaft", Axis::difference(a, 1.0, b), 300.0, 0.0, 0.5); // s = b − a
/// scene.linear_relation("gear", [(a, 0.3), (b, 0.2)], 0.0); // 0.3 a + 0.2 b = 0
/// assert_eq!(scene.compile()?.m(), 1);
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Axis {
    pub(crate) q: Vec<Coordinate>,
    pub(crate) factors: Vec<Param>,
}

impl Axis {
    /// The coordinate s = q_b − factor q_a.
    pub fn difference(a: Coordinate, factor: impl Into<Param>, b: Coordinate) -> Self {
        [(a, -factor.into()), (b, 1.0.into())].into()
    }
}

impl From<Coordinate> for Axis {
    fn from(q: Coordinate) -> Self {
        [(q, 1.0)].into()
    }
}

/// From the coordinates q_k and their factors a_k.
impl<P: Into<Param>, const N: usize> From<[(Coordinate, P); N]> for Axis {
    fn from(terms: [(Coordinate, P); N]) -> Self {
        let (q, factors) = terms.into_iter().map(|(q, factor)| (q, factor.into())).unzip();
        Axis { q, factors }
    }
}
