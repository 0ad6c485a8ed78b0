//! [`CostFactors`]: the factors of a weighted sum of J, the outputs, the functions of events, and the state at the end.

use std::ops::Range;

use super::weights::Occurring;

/// The factor of J (0), followed by those of the outputs (from 1 on).
#[derive(Clone, Debug, Default)]
pub struct CostFactors {
    all: Vec<f64>,
    /// All factors outside this range are zero, so that costs of these outputs are skipped.
    some: Range<usize>,
    /// The factors of the functions of the events of a motion, in their order; those that are missing are zero.
    of_events: Vec<f64>,
    /// The factors of q, v and p* at the last node; empty if they are zero.
    of_end: Vec<f64>,
}

/// The numbers of functions of events follow this one, which is larger than that of any output.
pub const EVENTS: usize = usize::MAX / 2;

impl CostFactors {
    /// J alone, for a given number of outputs.
    pub fn of_cost(outputs: usize) -> Self {
        CostFactors::of_one(0, outputs)
    }

    /// Factors that select a single function, J (`which` = 0) or output number `which` (from 1 on), out of J and `outputs` outputs.
    pub fn of_one(which: usize, outputs: usize) -> Self {
        let mut factors = CostFactors { all: vec![0.0; 1 + outputs], some: 0..0, of_events: Vec::new(), of_end: Vec::new() };
        factors.choose(which);
        factors
    }

    /// The sum of all outputs, without J.
    pub fn of_outputs(outputs: usize) -> Self {
        let mut factors = CostFactors::of_cost(outputs);
        factors.weigh(0.0, &vec![1.0; outputs]);
        factors
    }

    /// Selects J (0) or an output (from 1 on) alone.
    pub fn choose(&mut self, which: usize) {
        self.all.fill(0.0);
        self.all[which] = 1.0;
        self.some = which..which + 1;
        self.of_events.clear();
        self.of_end.clear();
    }

    /// Adds the functions of events with these factors.
    pub fn weigh_events(&mut self, factors: &[f64]) {
        self.of_events.clear();
        self.of_events.extend_from_slice(factors);
    }

    /// Selects the function of one event alone.
    pub fn choose_event(&mut self, which: usize) {
        self.all.fill(0.0);
        self.some = 0..0;
        self.of_end.clear();
        self.of_events.clear();
        self.of_events.resize(which, 0.0);
        self.of_events.push(1.0);
    }

    /// Whether functions of events count.
    pub fn has_events(&self) -> bool {
        !self.of_events.is_empty()
    }

    /// The factor of J (0) or an output (from 1 on), or of a function with a number from [`EVENTS`] on at the node of this event.
    pub fn here(&self, which: usize, event: Option<Occurring>) -> f64 {
        let Some(function) = which.checked_sub(EVENTS) else { return self.all[which] };
        let of = event.filter(|event| event.function == function).and_then(|event| self.of_events.get(event.number));
        of.copied().unwrap_or(0.0)
    }

    /// Selects the sum w₀ J + Σ w_k r_k.
    pub fn weigh(&mut self, of_cost: f64, of_outputs: &[f64]) {
        self.all[0] = of_cost;
        self.all[1..].copy_from_slice(of_outputs);
        let first = self.all.iter().position(|factor| *factor != 0.0).unwrap_or(0);
        let end = self.all.iter().rposition(|factor| *factor != 0.0).map_or(first, |last| last + 1);
        self.some = first..end;
        self.of_events.clear();
        self.of_end.clear();
    }

    /// Selects one entry of (q, v, p*) at the last node alone, out of a number of entries.
    pub fn choose_end(&mut self, which: usize, entries: usize) {
        self.all.fill(0.0);
        self.some = 0..0;
        self.of_events.clear();
        self.of_end.clear();
        self.of_end.resize(entries, 0.0);
        self.of_end[which] = 1.0;
    }

    /// Adds (q, v, p*) at the last node with these factors.
    pub fn weigh_end(&mut self, factors: &[f64]) {
        self.of_end.clear();
        self.of_end.extend_from_slice(factors);
    }

    /// The factors of q, v and p* at the last node; empty if they are zero.
    pub fn of_end(&self) -> &[f64] {
        &self.of_end
    }

    /// Copies other factors without a new allocation.
    pub fn copy_from(&mut self, others: &CostFactors) {
        self.all.copy_from_slice(&others.all);
        self.some = others.some.clone();
        self.of_events.clone_from(&others.of_events);
        self.of_end.clone_from(&others.of_end);
    }

    /// The number of factors, including that of J.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// A range outside which all factors are zero.
    pub fn some(&self) -> Range<usize> {
        self.some.clone()
    }

    /// The indices of the nonzero factors.
    pub fn counting(&self) -> impl Iterator<Item = usize> + '_ {
        self.some().filter(|which| self.all[*which] != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::CostFactors;

    #[test]
    fn what_counts_is_between_the_first_and_the_last_factor_that_is_not_zero() {
        let mut factors = CostFactors::of_cost(4);
        assert_eq!((factors.some(), factors.len()), (0..1, 5));
        factors.weigh(0.0, &[0.0, 2.0, 0.0, -1.0]);
        assert_eq!((factors.some(), factors.counting().collect::<Vec<_>>()), (2..5, vec![2, 4]));
        factors.weigh(0.0, &[0.0; 4]);
        assert_eq!(factors.counting().count(), 0);
        factors.choose(3);
        assert_eq!((factors.some(), factors.here(2, None), factors.here(3, None)), (3..4, 0.0, 1.0));
        assert_eq!(CostFactors::of_outputs(4).some(), 1..5);
    }
}
