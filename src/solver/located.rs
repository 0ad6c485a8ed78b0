//! Derivatives of motions with located events.

use super::{Solver, workspace};
use crate::adjoint::{AdjointSweep, Gradient, Located, check_direction};
use crate::system::CostFactors;
use crate::{Error, Inputs, Settings};

impl Solver {
    /// True if the motion has located events.
    pub(crate) fn has_events(&self) -> bool {
        !self.forward.motion.inputs.events.is_empty()
    }

    /// The derivatives of the functions of the events, computed once for each motion.
    pub(super) fn located(&mut self) -> Result<&mut Located, Error> {
        let known = self.located.take();
        let located = known.map_or_else(|| self.differentiate_events(), Ok)?;
        Ok(self.located.insert(located))
    }

    fn differentiate_events(&mut self) -> Result<Located, Error> {
        let Solver { system, settings, forward, rows, phase, .. } = self;
        phase.examine_all(system, &forward.stepper.newton.linearisation.evaluation, &forward.motion);
        let unlocated = phase.unlocated(system, &forward.motion);
        let count = forward.motion.inputs.events.len();
        rows.resize_with(count.max(rows.len()), || AdjointSweep::new(system, settings.scheme));
        let settings = Settings { keep_adjoint: false, ..*settings };
        let choose = |k, factors: &mut CostFactors| factors.choose_event(k);
        AdjointSweep::run(&mut rows[..count], system, &mut forward.solved(), &settings, choose)?;
        let rows = rows[..count].iter().map(|row| row.gradient.clone()).collect();
        Located::new(system, &forward.motion, (rows, unlocated))
    }

    /// The gradient of a weighted sum of J and the outputs, as a function of the given steps.
    pub(super) fn differentiate_located(&mut self, choose: impl Fn(&mut CostFactors)) -> Result<(), Error> {
        self.located()?;
        let Solver { system, settings, forward, sweeps, located, .. } = self;
        let Some(located) = located else { return Ok(()) };
        AdjointSweep::run(&mut sweeps[..1], system, &mut forward.solved(), settings, |_, factors| choose(factors))?;
        let sweep = &mut sweeps[0];
        let value = sweep.gradient.value;
        let mu = located.complete_lagrangian(&mut sweep.gradient);
        sweep.cost.factors.weigh_events(&mu);
        // Stored adjoint variables are those of J so far.
        sweep.is_recorded = false;
        if settings.keep_adjoint {
            let factors = sweep.cost.factors.clone();
            let complete = sweep.gradient.clone();
            AdjointSweep::run(&mut sweeps[..1], system, &mut forward.solved(), settings, |_, own| own.copy_from(&factors))?;
            sweeps[0].gradient = complete;
        }
        sweeps[0].gradient.value = value;
        Ok(())
    }

    /// A product of a direction with the Hessian, as a function of the given steps.
    pub(super) fn product_located(&mut self, direction: &Inputs) -> Result<&Gradient, Error> {
        let taken = self.along_located(direction)?;
        if !self.located()?.has_lagrangian() {
            let factors = self.sweeps[0].cost.factors.clone();
            self.differentiate_located(|own| own.copy_from(&factors))?;
        }
        let Solver { system, settings, forward, sweeps, products, located, .. } = self;
        let products = workspace(products, system, settings.scheme);
        products.run(system, (forward.solved(), &mut sweeps[0]), settings, &taken)?;
        let product = products.product_mut();
        located.iter().for_each(|located| located.complete_product(product, direction, &taken));
        Ok(product)
    }

    /// The direction of the inputs with that of all steps.
    pub(super) fn along_located(&mut self, direction: &Inputs) -> Result<Inputs, Error> {
        check_direction(&self.forward.motion, direction)?;
        Ok(self.located()?.direction(direction))
    }
}
