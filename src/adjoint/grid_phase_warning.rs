//! The comparison of the gradient with the one at frozen grid phase.

use crate::adjoint::Gradient;
use crate::motion::Motion;
use crate::{System, Warning};

/// A derivative counts if the value of its variable changes J by this fraction of what the most important variable does.
const COUNTS: f64 = 1e-3;

/// A derivative, or the norm of those with respect to all values of a control.
struct Pair {
    of: String,
    plain: f64,
    frozen: f64,
    /// |plain − frozen|.
    difference: f64,
    /// The size of the variable.
    size: f64,
}

impl Pair {
    fn of_one(of: String, [plain, frozen]: [f64; 2], value: f64) -> Self {
        Pair { of, plain, frozen, difference: (plain - frozen).abs(), size: value.abs() }
    }

    fn share(&self) -> f64 {
        self.difference / self.frozen.abs().max(f64::MIN_POSITIVE)
    }
}

/// The derivative that differs most, if any differs by more than [`Warning::GRID_PHASE`]: its name, its value, and that at frozen grid phase.
pub(super) fn worst(system: &System, motion: &Motion, plain: &Gradient, frozen: &Gradient) -> Option<(String, f64, f64)> {
    let pairs = pairs(system, motion, plain, frozen);
    let effect = |pair: &Pair| pair.difference.max(pair.frozen.abs()) * if pair.size > 0.0 { pair.size } else { 1.0 };
    let most = pairs.iter().map(effect).fold(0.0, f64::max);
    let counts = pairs.into_iter().filter(|pair| effect(pair) > COUNTS * most && pair.share() > Warning::GRID_PHASE);
    counts.max_by(|x, y| x.share().total_cmp(&y.share())).map(|pair| (pair.of, pair.plain, pair.frozen))
}

fn pairs(system: &System, motion: &Motion, plain: &Gradient, frozen: &Gradient) -> Vec<Pair> {
    let inputs = &motion.inputs;
    let design = (0..system.designs()).map(|p| {
        let derivatives = [plain, frozen].map(|gradient| gradient.design[p]);
        Pair::of_one(format!("dJ/db of `{}`", system.design_name(p)), derivatives, inputs.design[p])
    });
    let rate = format!("dJ/d{}", plain.start.rate_symbol());
    let start = (0..system.n()).flat_map(|i| {
        let name = system.coordinate_name(i);
        let q = [plain, frozen].map(|gradient| gradient.start.q()[i]);
        let of_rate = [plain, frozen].map(|gradient| gradient.start.rate()[i]);
        let (place, motion) = (inputs.start.q()[i], inputs.start.rate()[i]);
        [Pair::of_one(format!("dJ/dq₀ of `{name}`"), q, place), Pair::of_one(format!("{rate} of `{name}`"), of_rate, motion)]
    });
    let controls = (0..system.k()).map(|k| {
        let [own, other] = [plain, frozen].map(|gradient| gradient.controls.row(k));
        let (of, difference) = (format!("dJ/du of `{}`", system.control_name(k)), (own - other).norm());
        Pair { of, plain: own.norm(), frozen: other.norm(), difference, size: inputs.controls.row(k).amax() }
    });
    design.chain(start).chain(controls).collect()
}
