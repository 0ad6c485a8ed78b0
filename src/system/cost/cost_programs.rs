//! [`CostPrograms`]: the programs of all costs with the constants of a motion; like costs are evaluated side by side.

use std::sync::{Arc, OnceLock};

use super::placed_cost::PlacedCost;
use super::quadratic_form::{Forms, QuadraticForm};
use crate::program::Template;
use crate::system::formula::{
    Argument, Connections, ElementPrograms, LISTS, Labelled, Layout, NodeView, Place, Shape, Slot,
};

/// The program for value and gradient; each result with its order and the argument of a derivative.
pub type Gradient = Labelled<(usize, Option<Slot>)>;

/// A recorded cost and its programs, shared by all costs with this formula.
#[derive(Debug)]
pub struct CostFormula {
    template: Template,
    shape: Shape,
    /// The variables of the derivatives.
    variables: Vec<Slot>,
    gradient: Gradient,
    /// The program with changes along a direction, compiled when it is first needed; `None` if it is too long.
    changes: OnceLock<Option<Gradient>>,
    form: Option<Arc<QuadraticForm>>,
}

impl CostFormula {
    /// Compiles a recorded cost with derivatives with respect to these variables; `None` if the program is too long.
    pub fn new((shape, variables, template): (Shape, Vec<Slot>, Template)) -> Option<Self> {
        let gradient = Labelled::gradient(&template, shape, &variables, 1)?;
        let form = QuadraticForm::new(&template, shape, &gradient).map(Arc::new);
        Some(CostFormula { template, shape, variables, gradient, changes: OnceLock::new(), form })
    }

    fn with_changes(&self) -> Option<&Gradient> {
        let compile = || Labelled::gradient(&self.template, self.shape, &self.variables, 2);
        self.changes.get_or_init(compile).as_ref()
    }
}

/// The destination of a result: a value (order 0) or its change (order 1), or the derivative by an argument, with a factor.
type Target = (usize, Option<(Argument, f64)>);

/// The programs of costs for one run.
#[derive(Default)]
pub(crate) struct CostPrograms {
    /// The fingerprint of the costs and the parameters for which the programs are prepared.
    fingerprint: Option<u64>,
    design: Vec<f64>,
    /// The number of orders of the programs.
    orders: usize,
    /// Whether formulas have changed since they were compiled, so that they are recorded again.
    changed: bool,
    batches: Vec<Batch>,
    layout: Layout,
    /// The lists of arguments that any program reads.
    reads: [bool; LISTS],
    point: Vec<f64>,
}

/// Like costs, prepared when they are first evaluated.
#[derive(Default)]
struct Batch {
    is_known: bool,
    /// Whether the constants are set.
    is_fixed: bool,
    /// `None` if num-dual evaluates these costs.
    program: Option<LikeCosts>,
}

/// The program of like costs with their numbers.
pub(super) struct LikeCosts {
    programs: ElementPrograms<Target>,
    numbers: Vec<Vec<f64>>,
    forms: Option<Forms>,
}

impl CostPrograms {
    /// Begins a run with these parameters, for several batches of costs with a fingerprint that may have `changed` since they were compiled.
    pub(in crate::system) fn begin(
        &mut self,
        (layout, batches): (Layout, usize),
        (design, orders): (&[f64], usize),
        (fingerprint, changed): (u64, bool),
    ) {
        if self.fingerprint != Some(fingerprint) {
            let (point, fingerprint) = (vec![0.0; layout.len()], Some(fingerprint));
            *self = CostPrograms { fingerprint, orders, changed, layout, point, ..CostPrograms::default() };
            self.batches.resize_with(batches, Batch::default);
        }
        if self.design != design {
            self.design.clear();
            self.design.extend_from_slice(design);
            self.batches.iter_mut().for_each(|batch| batch.is_fixed = false);
        }
    }

    /// Prepares the program of a batch, which consists of some of all costs. Returns false if it was prepared before.
    #[inline]
    pub(super) fn prepare(&mut self, batch: (usize, &[usize]), all: &[PlacedCost], at: &NodeView<f64>) -> bool {
        self.batches.get(batch.0).is_some_and(|known| !known.is_fixed) && self.prepare_now(batch, all, at)
    }

    fn prepare_now(&mut self, (which, batch): (usize, &[usize]), all: &[PlacedCost], at: &NodeView<f64>) -> bool {
        let CostPrograms { orders, changed, batches, layout, reads, design, .. } = self;
        let Batch { is_known, is_fixed, program } = &mut batches[which];
        let items: Vec<&PlacedCost> = batch.iter().map(|&index| &all[index]).collect();
        if !*is_known {
            *program = LikeCosts::new(*layout, &items, *orders, changed.then_some(at), reads);
        }
        program.iter_mut().for_each(|program| program.fix(&items, design));
        (*is_known, *is_fixed) = (true, true);
        true
    }

    /// Loads a state, and a direction if the programs compute changes.
    pub(super) fn load(&mut self, at: &NodeView<f64>, along: Option<&NodeView<f64>>) {
        self.layout.load_lists(at, |list| self.reads[list], &mut self.point);
        along.into_iter().for_each(|along| self.layout.load_direction(along, &mut self.point));
    }

    /// The program of a batch, and the loaded point.
    pub(super) fn of(&mut self, batch: usize) -> Option<(&mut LikeCosts, &[f64])> {
        Some((self.batches.get_mut(batch)?.program.as_mut()?, &self.point))
    }
}

impl LikeCosts {
    /// The program of some costs, and the lists that it reads; `None` if their formulas are different now, at a state at which they are recorded again.
    fn new(
        layout: Layout,
        items: &[&PlacedCost],
        orders: usize,
        again: Option<&NodeView<f64>>,
        reads: &mut [bool; LISTS],
    ) -> Option<Self> {
        let formula = items[0].formula.as_deref()?;
        let program = if orders == 1 { &formula.gradient } else { formula.with_changes()? };
        let now = |item: &&PlacedCost| match again {
            None => Some(item.numbers.clone()),
            Some(at) => item.of.record(at).ok().filter(|(template, _)| *template == formula.template).map(|(_, now)| now),
        };
        let numbers = items.iter().map(now).collect::<Option<Vec<_>>>()?;
        let (shape, to) = (items[0].of.shape, Vec::from_iter(items.iter().map(|item| &item.of.to)));
        let target = |to: &Connections, (order, slot): (usize, Option<Slot>)| (order, slot.map(|slot| to.argument(slot)));
        let programs = ElementPrograms::of_costs(&layout, (shape, &to), program, target);
        let forms = formula.form.as_ref().filter(|_| orders == 1).map(|form| Forms::new(layout, &to, form.clone()));
        for &which in program.kernel.inputs() {
            if let Place::Of(slot) = shape.place(which) {
                reads[slot.place().0] = true;
            }
        }
        Some(LikeCosts { programs, numbers, forms })
    }

    /// Sets the constants of each cost.
    fn fix(&mut self, items: &[&PlacedCost], design: &[f64]) {
        let LikeCosts { programs, numbers, forms } = self;
        let parameters = |e: usize| items[e].of.to.with_factors(design, &numbers[e]);
        programs.fix(parameters);
        forms.iter_mut().for_each(|forms| forms.fix(parameters));
    }

    /// Passes all results at a point to `add`.
    pub(super) fn run(&mut self, point: &[f64], mut add: impl FnMut(&Target, f64)) {
        let LikeCosts { programs, forms, .. } = self;
        match forms.as_mut().and_then(|forms| forms.evaluate(point)) {
            Some(results) => results.for_each(|(e, k, x)| add(programs.target(e, k), x)),
            None => programs.run(point, add),
        }
    }
}
