//! A cost behind a trait that hides its type.

use std::any::TypeId;
use std::sync::Arc;

#[cfg(feature = "files")]
use super::graph_formula::GraphFormula;
use super::on_numbers::{List, Read, Recordable, Values, Wide, with_lists};
use super::shape::{Shape, Slot};
use crate::model::element::{ListCost, ListPoint};
use crate::number::Slope;
use crate::{Cx, Scalar};

/// A cost of lists with given lengths.
pub struct CostOfLists<C> {
    pub cost: C,
    pub shape: Shape,
}

impl<C: ListCost> CostOfLists<C> {
    /// The cost for any number of places in a scene.
    pub fn shared(cost: C, shape: Shape) -> Arc<dyn AnyCost> {
        Arc::new(CostOfLists { cost, shape })
    }
}

impl<C: ListCost, S: Scalar> Values<S> for CostOfLists<C> {
    fn values(&self, read: Read<S>, put: &mut dyn FnMut(S)) {
        let Shape { n, m, k, p } = self.shape;
        let lists: [List; 10] = [
            (Slot::Q, n),
            (Slot::V, n),
            (Slot::PStar, n),
            (Slot::PStarDot, n),
            (Slot::VDot, n),
            (Slot::Sigma, m),
            (Slot::Lambda, m),
            (Slot::U, k),
            (Slot::UDot, k),
            (Slot::B, p),
        ];
        with_lists(read, lists, &mut |[q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, b]| {
            let t = read(Slot::T);
            put(self.cost.cost(&ListPoint { q, v, p_star, p_star_dot, v_dot, sigma, lambda, u, u_dot, t, b }));
        });
    }
}

/// A cost whose type is hidden.
pub trait AnyCost: Values<Cx> + Values<Wide<f64>> + Values<Wide<Slope>> + Recordable {
    /// The type of the cost if its values are all equal, because they have no fields.
    fn only_value_of(&self) -> Option<TypeId> {
        None
    }
}

impl<C: ListCost> AnyCost for CostOfLists<C> {
    fn only_value_of(&self) -> Option<TypeId> {
        (size_of::<C>() == 0).then(TypeId::of::<C>)
    }
}

#[cfg(feature = "files")]
impl AnyCost for GraphFormula {}
