//! Second derivatives of an element computed column by column, for each coordinate and velocity. Computing all at once needs numbers with n² parts,
//! which would fill the stack if there are more than a few dozen coordinates.

use super::formula::Component;
use super::jet::ElementKind;
use super::shape::Shape;
use super::typed::{OnNumbers, Read, Slot};
use crate::number::{Slope, slope, with_slope};

/// Computes first derivatives, and writes second derivatives to `blocks`; see [`Jet::blocks`](super::jet::Jet::blocks).
pub fn by_columns(
    formula: &dyn OnNumbers<Slope>,
    (kind, Shape { n, m, .. }): (ElementKind, Shape),
    read: Read<f64>,
    put: &mut dyn FnMut(Component, f64),
    blocks: &mut [f64],
) {
    let (square, column) = (n * n, m * n);
    blocks.fill(0.0);
    for j in 0..n {
        let is_first = j == 0;
        along(formula, read, Slot::Q(j), &mut |of, x| {
            if is_first {
                put(of, x.re);
            }
            let at = match (kind, of) {
                (ElementKind::Kinetic, Component::Momentum(i)) => square + i * n,
                (ElementKind::Kinetic, Component::Force(i)) => 2 * square + i * n,
                (ElementKind::Potential, Component::Force(i)) => i * n,
                (ElementKind::Applied | ElementKind::Holonomic, Component::Force(i)) => square + i * n,
                (ElementKind::Holonomic, Component::Momentum(i)) => i * n,
                (ElementKind::Holonomic, Component::Equation(e)) => 2 * square + column + e * n,
                _ => return,
            };
            blocks[at + j] = slope(&x);
        });
        if kind == ElementKind::Potential {
            continue;
        }
        along(formula, read, Slot::V(j), &mut |of, x| {
            let at = match (kind, of) {
                (ElementKind::Kinetic, Component::Momentum(i)) | (ElementKind::Applied, Component::Force(i)) => i * n,
                (ElementKind::Holonomic, Component::Equation(e)) => 2 * square + e * n,
                _ => return,
            };
            blocks[at + j] = slope(&x);
        });
    }
}

fn along(formula: &dyn OnNumbers<Slope>, read: Read<f64>, moved: Slot, put: &mut dyn FnMut(Component, Slope)) {
    formula.first(&|slot| with_slope(read(slot), f64::from(slot == moved)), put);
}

#[cfg(test)]
mod tests {
    use super::super::applied::Applied;
    use super::super::energy::{Kinetic, Potential};
    use super::super::holonomic::Holonomic;
    use super::super::typed::{AnyElement, Typed};
    use super::*;
    use crate::{Constraint, Force, ForcePoint, KineticEnergy, PotentialEnergy, Scalar};
    use nalgebra::SVector;

    struct Sample;

    impl KineticEnergy<3, 1> for Sample {
        fn kinetic_energy<S: Scalar>(&self, q: &SVector<S, 3>, v: &SVector<S, 3>, b: &SVector<S, 1>) -> S {
            v[0] * v[1] * q[2].sin() + v[2] * v[2] * q[0] * q[1] * b[0] + v[0] * v[0]
        }
    }

    impl PotentialEnergy<3, 1> for Sample {
        fn potential_energy<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, t: S) -> S {
            q[0] * q[1] * q[2].cos() * t + b[0] * q[0] * q[0]
        }
    }

    impl Force<3, 1, 1> for Sample {
        fn force<S: Scalar>(&self, at: &ForcePoint<S, 3, 1>, b: &SVector<S, 1>) -> SVector<S, 3> {
            SVector::from([at.u[0] * at.q[1], at.v[0] * at.v[2] * at.q[0], b[0] * at.v[1] * at.t])
        }
    }

    impl Constraint<3, 2, 1> for Sample {
        fn phi<S: Scalar>(&self, q: &SVector<S, 3>, b: &SVector<S, 1>, t: S) -> SVector<S, 2> {
            SVector::from([q[0] * q[1].sin() * b[0], q[1] * q[2] * q[2] + t * q[0]])
        }
    }

    #[test]
    fn columns_are_those_of_all_at_once() {
        let elements: [Box<dyn AnyElement>; 4] = [
            Box::new(Typed::<_, 3, 0, 0, 1>(Kinetic(Sample))),
            Box::new(Typed::<_, 3, 0, 0, 1>(Potential(Sample))),
            Box::new(Typed::<_, 3, 0, 1, 1>(Applied(Sample))),
            Box::new(Typed::<_, 3, 2, 0, 1>(Holonomic(Sample))),
        ];
        let read = |slot: Slot| match slot {
            Slot::Q(i) => 0.3 + 0.5 * i as f64,
            Slot::V(i) => 1.1 - 0.7 * i as f64,
            Slot::Sigma(j) => 0.8 - 1.9 * j as f64,
            Slot::U(_) | Slot::T | Slot::B(_) => 1.7,
        };
        for element in &elements {
            let (kind, shape) = (element.kind(), element.shape());
            let blocks = || vec![f64::NAN; kind.length(shape.n, shape.m)];
            let (mut expected, mut found) = ((Vec::new(), blocks()), (Vec::new(), blocks()));
            element.blocks(&read, &mut |of, x| expected.0.push((of, x)), &mut expected.1);
            by_columns(&**element, (kind, shape), &read, &mut |of, x| found.0.push((of, x)), &mut found.1);
            assert!(expected.1.iter().any(|x| *x != 0.0));
            for (a, b) in expected.1.iter().zip(&found.1) {
                assert!((a - b).abs() < 1e-15, "{kind:?}: {expected:?} {found:?}");
            }
            for ((of, a), (same, b)) in expected.0.iter().zip(&found.0) {
                assert!(of == same && (a - b).abs() < 1e-15, "{kind:?}: {expected:?} {found:?}");
            }
        }
    }
}
