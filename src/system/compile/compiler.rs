//! Compilation of the parts of a scene into a [`System`], and detection of formulas that have changed when a motion begins.

use std::sync::Arc;

use super::names::Names;
use super::parameters::Parameters;
use super::scene_parts::{Parts, Required};
use super::structure;
use crate::model::space::Inertia;
use crate::model::{Action, Gap, Param, Sketch};
use crate::number::{Fingerprint, take_look};
use crate::system::compiled::{Compiled, System};
use crate::system::cost::{CostPrograms, Costs, Terms};
use crate::system::formula::{Batches, Element, ElementKind, Layout, NodeView, Positions, Recordings};
use crate::system::report::find_readers;
use crate::system::tangent::Formulas;
use crate::{Error, memory};

impl System {
    pub(crate) fn compile(mut scene: Parts, without_programs: bool) -> Result<Self, Error> {
        let (n, m, k) = (scene.coordinates.len(), scene.equations, scene.controls.len());
        if n == 0 {
            return Err(Error::EmptyScene);
        }
        let gravity = scene.gravity.map(|g| g.unwrap_or(0.0.into()));
        let mut parameters = Parameters::new(scene.designs.len(), scene.scene.expressions());
        let mut resolve = |param: Param| parameters.resolve(param, &gravity);
        scene.batches.0.iter_mut().for_each(|batch| batch.resolve(&mut resolve));
        scene.costs.resolve(&mut resolve);
        scene.positive.iter_mut().for_each(|required| required.param = resolve(required.param));
        scene.tensors.iter_mut().for_each(|(_, tensor)| *tensor = tensor.map(&mut resolve));
        scene.resolve_switches(&mut resolve);
        parameters.differentiate();
        let names = Names::new(&scene);
        let (mut batches, mut costs) = (scene.batches, scene.costs);
        let design: Vec<f64> = scene.designs.iter().map(|(_, value)| *value).collect();
        let values = parameters.values(&design);
        parameters.check(&values, &names.designs)?;
        check_positive(&scene.positive, &values)?;
        check_tensors(&scene.tensors, &values)?;
        let zeros = vec![0.0; n.max(m).max(k)];
        let (v, sigma, u) = (&zeros[..n], &zeros[..m], &zeros[..k]);
        let at = NodeView::of_equations([&scene.initial, v, sigma], (u, 0.0, &values));
        let mut recordings = Recordings::new(without_programs);
        batches.0.iter_mut().for_each(|batch| batch.prepare(&at, &mut recordings));
        let elements = recordings.elements;
        costs.prepare(&at, without_programs);
        costs.check_events()?;
        check_inertia(&elements, &names, n)?;
        let blocks: Vec<_> = scene.groups.into_iter().map(|(_, range)| range).collect();
        let partly_defined = elements.iter().filter(|element| element.formula.partly_defined);
        let partly_defined = partly_defined.map(|element| element.place).collect();
        let is_watched = |gap: &Gap| {
            let mut changes = scene.switches.iter().filter(|switch| switch.equation == gap.equation).peekable();
            changes.peek().is_some() && changes.all(|switch| switch.action != Action::Hold)
        };
        let gaps = scene.gaps.into_iter().filter(is_watched).collect();
        let may_open: Vec<usize> = scene.switches.iter().map(|switch| switch.equation).collect();
        let analysis = structure::analyse((&elements, &batches), (&blocks, &may_open), (n, m), &at);
        let structure::Analysis { symbolic, sines, loop_equations, has_still_loops } = analysis;
        let formulas = Formulas::new(elements, Layout { n, m, k, p: values.len() }, &symbolic);
        // The entries of K are numbered by `u32`.
        let entries = symbolic.values_len();
        let count = if u32::try_from(entries).is_ok() { entries } else { usize::MAX };
        memory::check("the tangent matrix K", count, size_of::<f64>())?;
        let place = |unknown| symbolic.position(unknown);
        let positions = Positions { v: (0..n).map(place).collect(), sigma: (n..n + m).map(place).collect() };
        let terms = Terms::new(&costs, names.outputs.len());
        let (initial, positive, tensors) = (scene.initial, scene.positive, scene.tensors);
        let (costs_compiled, fingerprint) = (fingerprint(None, &costs), fingerprint(Some(&batches), &costs));
        let reads_values = find_readers(&formulas, &costs);
        let compiled = Compiled {
            n,
            m,
            k,
            batches,
            formulas,
            costs,
            terms,
            symbolic,
            positions,
            sines,
            loop_equations,
            has_still_loops,
            switches: scene.switches,
            gaps,
            sides: scene.sides,
            partly_defined,
            names,
            initial,
            design,
            parameters,
            positive,
            tensors,
            sketch: Sketch { gravity: scene.gravity, ..scene.sketch },
            scene: scene.scene,
            fingerprint,
            costs_compiled,
            reads_values,
            uncoupled: Default::default(),
        };
        Ok(System(Arc::new(compiled)))
    }

    pub(crate) fn check_design(&self, design: &[f64]) -> Result<(), Error> {
        let values = self.0.parameters.values(design);
        self.0.parameters.check(&values, &self.0.names.designs)?;
        check_positive(&self.0.positive, &values)?;
        check_tensors(&self.0.tensors, &values)
    }

    /// Identifies the present formulas.
    pub(crate) fn fingerprint(&self) -> u64 {
        fingerprint(Some(&self.0.batches), &self.0.costs)
    }

    /// The formulas at an initial state if they differ from those that were compiled, otherwise `None`.
    ///
    /// # Errors
    /// A formula whose derivatives are constant, or zero, in other places than when it was compiled.
    pub(crate) fn formulas_now(&self, start: &NodeView<f64>, fingerprint: u64) -> Result<Option<Formulas>, Error> {
        if fingerprint == self.0.fingerprint {
            return Ok(None);
        }
        let mut recordings = Recordings::default();
        for element in &self.0.formulas.elements {
            recordings.add(self.item(element.place), element.place, start);
        }
        let changed = |element: &str| Error::Changed { element: element.to_string() };
        // Formulas that num-dual evaluates may change in any way.
        let mut pairs = recordings.elements.iter_mut().zip(&self.0.formulas.elements);
        let moved = pairs.find_map(|(now, then)| {
            if then.formula.kernels.is_none() {
                now.formula = then.formula.clone();
            }
            (!now.has_places_of(then)).then_some(&then.name)
        });
        if let Some(element) = moved {
            return Err(changed(element));
        }
        if let Some(cost) = self.0.costs.find_changed(start) {
            return Err(changed(cost));
        }
        Ok(Some(Formulas::new(recordings.elements, self.layout(), &self.0.symbolic)))
    }

    /// Identifies the present formulas of the costs.
    ///
    /// # Errors
    /// A cost depends on other arguments than when it was compiled; the motion does not provide these.
    pub(crate) fn costs_now(&self, at: &NodeView<f64>) -> Result<u64, Error> {
        let now = fingerprint(None, &self.0.costs);
        let changed = (now != self.0.costs_compiled).then(|| self.0.costs.find_changed(at)).flatten();
        changed.map_or(Ok(now), |cost| Err(Error::Changed { element: cost.to_string() }))
    }

    /// Prepares the programs of the costs for the design variables of a motion and for the present formulas, which may have changed since the motion
    /// was computed; with two `orders` for changes along a direction.
    ///
    /// # Errors
    /// As [`costs_now`](Self::costs_now).
    pub(crate) fn fix_costs(&self, at: &NodeView<f64>, orders: usize, programs: &mut CostPrograms) -> Result<(), Error> {
        let now = self.costs_now(at)?;
        programs.begin((self.layout(), self.0.costs.batches()), (at.design, orders), (now, now != self.0.costs_compiled));
        Ok(())
    }
}

fn fingerprint(batches: Option<&Batches>, costs: &Costs) -> u64 {
    let mut sum = Fingerprint::NONE;
    take_look();
    batches.into_iter().flat_map(Batches::items).for_each(|item| item.fingerprint(&mut sum));
    costs.fingerprint(&mut sum);
    sum.value(take_look())
}

pub(in crate::system) fn check_positive(positive: &[Required], design: &[f64]) -> Result<(), Error> {
    for Required { param, what, may_be_zero } in positive {
        let value: f64 = param.value(design);
        if !((value > 0.0 || *may_be_zero && value == 0.0) && value.is_finite()) {
            let must_be = if *may_be_zero { "finite and not negative" } else { "positive and finite" };
            return Err(Error::Parameter { what: what.clone(), value, must_be });
        }
    }
    Ok(())
}

/// Checks that no principal moment of inertia is negative or larger than the sum of the other two, as for every distribution of mass.
fn check_tensors(tensors: &[(String, [Param; 6])], design: &[f64]) -> Result<(), Error> {
    for (body, tensor) in tensors {
        let tensor = tensor.map(|entry| entry.value(design));
        if let Some(value) = tensor.into_iter().find(|entry: &f64| !entry.is_finite()) {
            return Err(Error::NotFinite { what: format!("a moment of inertia of `{body}`"), value });
        }
        if let Some(moments) = Inertia::impossible_moments(tensor) {
            return Err(Error::Inertia { body: body.clone(), moments });
        }
    }
    Ok(())
}

/// Checks that every coordinate appears in some kinetic energy or constraint.
fn check_inertia(elements: &[Element], names: &Names, n: usize) -> Result<(), Error> {
    let mut appears = vec![false; n];
    let moves = |element: &&Element| matches!(element.kind(), ElementKind::Kinetic | ElementKind::Holonomic);
    elements.iter().filter(moves).flat_map(|element| &element.to.q).for_each(|&i| appears[i] = true);
    match appears.iter().position(|appears| !appears) {
        Some(i) => Err(Error::MissingInertia { coordinate: names.coordinates[i].clone() }),
        None => Ok(()),
    }
}
