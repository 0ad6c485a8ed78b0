//! Random formulas of differences of coordinates, in either order, compared with num-dual.

use nalgebra::SVector;

use super::verify::Draw;
use super::verify_tests::{Random, bound, hold};
use crate::model::Param;
use crate::system::formula::{Applied, Fixed, Holonomic, Kinetic, Potential};
use crate::{Constraint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar};

/// A formula of two differences of four coordinates, and of the fifth if there is one; `reversed` swaps the terms of each difference.
struct OfDifferences {
    formula: Random,
    reversed: [bool; 2],
}

impl OfDifferences {
    fn new(draw: &mut Draw, inputs: usize, len: usize) -> Self {
        let reversed = [draw.number() > 0.0, draw.number() > 0.0];
        OfDifferences { formula: Random::new(draw, inputs, len), reversed }
    }

    fn of<S: Scalar, const N: usize>(&self, x: &SVector<S, N>) -> [S; 2] {
        [0, 1].map(|i| if self.reversed[i] { x[i] - x[2 + i] } else { x[2 + i] - x[i] })
    }
}

impl KineticEnergy<4, 2> for OfDifferences {
    fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 4>, v: &SVector<S, 4>, b: &SVector<S, 2>) -> S {
        let ([x, y], [u, v]) = (self.of(q), self.of(v));
        self.formula.last::<S, 1>(&[x, y, u, v, b[0], b[1]])[0]
    }
}

impl PotentialEnergy<5, 2> for OfDifferences {
    fn potential_energy<S: Scalar>(&self, q: &SVector<S, 5>, b: &SVector<S, 2>, t: S) -> S {
        let [x, y] = self.of(q);
        self.formula.last::<S, 1>(&[x, y, q[4], b[0], b[1], t])[0]
    }
}

impl Force<4, 1, 2> for OfDifferences {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 4, 1>, b: &SVector<S, 2>) -> SVector<S, 4> {
        let ([x, y], [u, v]) = (self.of(&at.q), self.of(&at.v));
        let pull: SVector<S, 2> = self.formula.last(&[x, y, u, v, at.u[0], at.t, b[0], b[1]]);
        // Components 0 and 2 are opposite; components 1 and 3 are not.
        SVector::from([pull[0], pull[1], -pull[0], pull[1] * 2.0])
    }
}

impl Constraint<5, 2, 2> for OfDifferences {
    fn phi<S: Scalar>(&self, q: &SVector<S, 5>, b: &SVector<S, 2>, t: S) -> SVector<S, 2> {
        let [x, y] = self.of(q);
        self.formula.last(&[x, y, q[4], b[0], b[1], t])
    }
}

#[test]
fn programs_of_differences_are_what_num_dual_makes_of_them() {
    let (mut draw, mut said, mut relative) = (Draw(11), 0, [0; 4]);
    let formulas = 800;
    for k in 0..formulas {
        let mut random = |inputs: usize| OfDifferences::new(&mut draw, inputs, 3 + k % 12);
        let (kinetic, potential, applied, holonomic) = (random(6), random(6), random(8), random(6));
        let name = |of: &OfDifferences| format!("formula {k}: {:?} {:?}", of.formula, of.reversed);
        let names = [name(&kinetic), name(&potential), name(&applied), name(&holonomic)];
        let design = [0.7 * draw.number()];
        let with = ([bound(), Param::from(draw.number())], design.as_slice());
        let held = [
            hold((Kinetic::<Fixed<_, 4, 0, 0, 2>, 4>::fixed(kinetic), &[]), &mut draw, &names[0], with),
            hold((Potential::<Fixed<_, 5, 0, 0, 2>, 5>::fixed(potential), &[]), &mut draw, &names[1], with),
            hold((Applied::<Fixed<_, 4, 0, 1, 2>, 4>::fixed(applied), &[]), &mut draw, &names[2], with),
            hold((Holonomic::<Fixed<_, 5, 2, 0, 2>, 5>::fixed(holonomic), &[]), &mut draw, &names[3], with),
        ];
        for (kind, held) in held.into_iter().enumerate() {
            said += held.points;
            relative[kind] += usize::from(held.is_relative);
        }
    }
    assert!(said > 12 * formulas, "{said} of {} points are conclusive", 16 * formulas);
    assert!(relative.iter().all(|&relative| relative > formulas / 5), "{relative:?} depend on differences");
}
