//! Lists of coordinates that no element couples.

use std::collections::BTreeSet;

use std::sync::OnceLock;

use super::formula::ElementKind;
use crate::System;

/// The lists of a system, computed when they are needed first.
#[derive(Default)]
pub(super) struct Uncoupled {
    by_energies: OnceLock<Vec<Vec<usize>>>,
    by_energies_and_constraints: OnceLock<Vec<Vec<usize>>>,
}

impl System {
    /// Lists of coordinates that M does not couple.
    pub(crate) fn uncoupled_by_energies(&self) -> &[Vec<usize>] {
        self.0.uncoupled.by_energies.get_or_init(|| self.uncoupled_coordinates(&[ElementKind::Kinetic]))
    }

    /// Lists of coordinates that neither kinetic energies nor constraints couple.
    pub(crate) fn uncoupled_by_energies_and_constraints(&self) -> &[Vec<usize>] {
        let lists = || self.uncoupled_coordinates(&[ElementKind::Kinetic, ElementKind::Holonomic]);
        self.0.uncoupled.by_energies_and_constraints.get_or_init(lists)
    }

    /// Partitions the coordinates into a few lists such that no list contains two coordinates of one element of these kinds.
    fn uncoupled_coordinates(&self, kinds: &[ElementKind]) -> Vec<Vec<usize>> {
        let elements = self.formulas().elements.iter().filter(|element| kinds.contains(&element.kind()));
        let energies: Vec<&[usize]> = elements.map(|element| element.to.q.as_slice()).collect();
        let mut of_coordinate = vec![Vec::new(); self.n()];
        for (e, q) in energies.iter().enumerate() {
            q.iter().for_each(|&i| of_coordinate[i].push(e));
        }
        let (mut list_of, mut lists) = (vec![usize::MAX; self.n()], Vec::new());
        for i in 0..self.n() {
            let coupled = of_coordinate[i].iter().flat_map(|&e| energies[e]);
            let used: BTreeSet<usize> = coupled.map(|&j| list_of[j]).collect();
            list_of[i] = (0..).find(|list| !used.contains(list)).unwrap_or_default();
            if list_of[i] == lists.len() {
                lists.push(Vec::new());
            }
            lists[list_of[i]].push(i);
        }
        lists
    }
}

#[cfg(test)]
mod tests {
    use super::ElementKind;
    use crate::scene::scenes::CartPendulum;

    #[test]
    fn coordinates_of_a_long_chain_are_uncoupled_in_few_lists() {
        for links in [1, 300] {
            let system = CartPendulum::with_links(links).scene().compile().expect("a scene");
            let lists = system.uncoupled_by_energies();
            assert!(lists.len() <= 3, "{}", lists.len());
            let mut all = lists.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..system.n()));
            for energy in system.formulas().elements.iter().filter(|element| element.kind() == ElementKind::Kinetic) {
                let shared = |list: &Vec<usize>| list.iter().filter(|i| energy.to.q.contains(i)).count();
                assert!(lists.iter().all(|list| shared(list) <= 1));
            }
        }
    }
}
