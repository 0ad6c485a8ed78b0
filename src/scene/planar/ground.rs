//! Elements between two frames, of which one may be the ground or a particle: the same formulas with the missing coordinates fixed at zero.

use std::ops::Range;

use nalgebra::SVector;

use crate::model::element::ListCost;
use crate::model::{Control, Coordinate, Frame, Owner, Param};
use crate::system::AnyElement;
use crate::{Error, Scalar, Scene};

/// The coordinates of a pair of frames, and their numbers among the six coordinates of two bodies.
struct Pair {
    q: Vec<Coordinate>,
    there: &'static [usize],
}

impl Pair {
    fn of(frames: (Frame, Frame)) -> Option<Pair> {
        let (a, b) = (frames.0.0, frames.1.0);
        let there: &[usize] = match (a, b) {
            (Owner::Body(_), Owner::Body(_)) => &[0, 1, 2, 3, 4, 5],
            (Owner::Ground, Owner::Body(_)) => &[3, 4, 5],
            (Owner::Body(_), Owner::Ground) => &[0, 1, 2],
            (Owner::Body(_), Owner::Particle(_)) => &[0, 1, 2, 3, 4],
            (Owner::Particle(_), Owner::Body(_)) => &[0, 1, 3, 4, 5],
            (Owner::Particle(_), Owner::Particle(_)) => &[0, 1, 3, 4],
            (Owner::Ground, Owner::Particle(_)) => &[3, 4],
            (Owner::Particle(_), Owner::Ground) => &[0, 1],
            (Owner::Ground, Owner::Ground) => return None,
        };
        Some(Pair { q: [frames.0.own_coordinates(), frames.1.own_coordinates()].concat(), there })
    }
}

/// The six coordinates of two bodies, of which these are there and all others zero.
pub(super) fn of_both<S: Scalar>(there: &[usize], own: &[S]) -> SVector<S, 6> {
    let mut q = SVector::from([S::zero(); 6]);
    there.iter().zip(own).for_each(|(&i, &own)| q[i] = own);
    q
}

/// The kinds of frames that an element can connect.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ends {
    /// Bodies or the ground, because the element depends on angles.
    Bodies,
    /// Bodies, the ground or particles.
    Points,
}

impl Scene {
    /// Adds an element for two bodies between two frames. Returns false, and reports the error, if the element does not support these frames.
    pub(super) fn between<T: AnyElement + 'static>(
        &mut self,
        name: &str,
        formula: T,
        (frames, ends): ((Frame, Frame), Ends),
        (sigma, u): (Range<usize>, &[Control]),
        b: &[Param],
    ) -> bool {
        let pair = self.pair(name, frames, ends);
        if let Some(Pair { q, there }) = &pair {
            self.insert_on(name, formula, there, (q, sigma), u, b);
        }
        pair.is_some()
    }

    /// Adds an event between two frames, whose function is made from the numbers of the coordinates that are there.
    pub(super) fn between_event<C: ListCost>(
        &mut self,
        name: &str,
        function: impl FnOnce(&'static [usize]) -> C,
        (frames, ends): ((Frame, Frame), Ends),
        b: &[Param],
    ) {
        if let Some(Pair { q, there }) = self.pair(name, frames, ends) {
            self.list_event(name, function(there), &q, &[], &[], b);
        }
    }

    fn pair(&mut self, element: &str, frames: (Frame, Frame), ends: Ends) -> Option<Pair> {
        let has_particle = [frames.0, frames.1].into_iter().any(|frame| matches!(frame.0, Owner::Particle(_)));
        let element = element.to_string();
        if has_particle && ends == Ends::Bodies {
            self.report(Error::Particle { element });
            return None;
        }
        let pair = Pair::of(frames);
        if pair.is_none() {
            self.report(Error::NoBody { element });
        }
        pair
    }
}
