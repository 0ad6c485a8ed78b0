//! How far J and its gradient are from those of the continuous motion.
//!
//! J and its gradient are computed on the given grid, on every second and on every fourth of its nodes. With the order p of the scheme and the
//! difference Δ between the given grid and every second node, the error of a resolved motion is about Δ/(2ᵖ − 1). For the trapezoidal rule, the
//! adjoint variables weight the residuals of the steps, which is a second estimate of the error of J that needs no other motion
//! ([`residual`]). An estimate is withdrawn if the two disagree, if the differences do not decrease as they should, or if it is large.

mod levels;
mod outputs;
mod residual;

use std::fmt;

use crate::adjoint::Gradient;
use crate::error::seconds;
use crate::{Error, Inputs, Settings, Solver, System, Warning};

pub(crate) use outputs::{GridErrors, grid_errors};

use levels::{Levels, best, derivatives, every_second, has_quarters};
use residual::Residual;

/// Margin of the estimated error of J.
const MARGIN: f64 = 2.0;
/// Margin of the estimated error of the gradient.
const MARGIN_OF_GRADIENT: f64 = 3.0;
/// Two estimates of one error agree if their ratio is below this.
const AGREE: f64 = 3.0;
/// Relative differences below this are rounding.
const ROUNDING: f64 = 1e-11;
/// A relative error of the gradient above this is no estimate any more.
const LARGE: f64 = 0.3;

/// J and its gradient, with estimates of the errors that the grid causes.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// J on the given grid.
    pub value: f64,
    /// The gradient on the given grid. Where it has a gradient at frozen grid phase ([`Gradient::frozen`]), `gradient_uncertainty` is that of the
    /// latter.
    pub gradient: Gradient,
    /// Estimated bound of |J − J of the continuous motion|; `None` if there is none that can be trusted.
    pub uncertainty: Option<f64>,
    /// Estimated bound of the relative error of the gradient, in the norm of the effects of its variables: each derivative times the size of its
    /// variable. `None` if there is none that can be trusted.
    pub gradient_uncertainty: Option<f64>,
    /// The derivatives by the design variables and by the initial values, with estimated bounds of their errors; empty if there are none that can be
    /// trusted.
    pub derivatives: Vec<Derivative>,
    /// J and its gradient with their estimated errors added: J + (J − J₂)/(2ᵖ − 1), and dJ likewise, with J₂ on every second node. This is Richardson's
    /// extrapolation to the continuous motion, of order 4 for the trapezoidal rule and p + 1 for other schemes, if the number of steps is even.
    /// Derivatives by controls and step lengths have this order along changes that every second node can represent. `None` if the estimate is
    /// withdrawn, or if kinks, or knots of [`Inputs::controls_in_time`], lie between nodes.
    /// The values are those of no single motion: optimisers need [`gradient`](Self::gradient).
    pub corrected: Option<Gradient>,
    /// The error J of the continuous motion − J by the residuals of the steps. J plus this error has order 4, too, if controls are smooth. `None` for
    /// other schemes than the trapezoidal rule, and for motions with restarts or halved steps.
    pub residual: Option<f64>,
    /// The shortest interval of time, s, with more than half of the residuals, and its share of them.
    pub largest: Option<(f64, f64, f64)>,
    /// Why an estimate is missing.
    pub withdrawn: Option<Withdrawn>,
}

/// A derivative of J and an estimated bound of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative {
    /// The variable.
    pub of: String,
    /// The derivative, at frozen grid phase if a kink lies between nodes.
    pub value: f64,
    /// The estimated bound of its error.
    pub uncertainty: f64,
}

/// Why an error estimate is missing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Withdrawn {
    /// A cost is read at a single node ([`Sum::Node`](crate::Sum::Node)) or summed over nodes without their steps ([`Sum::Plain`](crate::Sum::Plain),
    /// [`Sum::AllNodes`](crate::Sum::AllNodes)), the grid is composed or has fewer than eight steps, or the number of steps before an event or a step of
    /// length zero, since the last one, is not a multiple of four: every second node has no motion with the same J.
    NoCoarserGrid,
    /// The motion or its gradient has a warning which says that the steps do not resolve it.
    Warned(Warning),
    /// On every second or fourth node there is no motion.
    NoCoarserMotion(Box<Error>),
    /// The differences between the grids do not decrease as the order of the scheme says: the steps do not resolve the motion.
    Unresolved {
        /// The ratio of two successive differences of the gradient, or of J.
        ratio: f64,
        /// The least ratio that is accepted.
        least: f64,
    },
    /// The residuals of the steps and the difference between two grids estimate different errors of J.
    Disagree {
        /// The error of J by the residuals.
        residual: f64,
        /// The error of J by the difference.
        difference: f64,
    },
    /// The estimated relative error of the gradient is large.
    Large {
        /// The estimate.
        error: f64,
    },
}

/// Computes J and its gradient with estimates of their errors: a motion and a gradient on the given grid, on every second and on every fourth node,
/// which takes about twice as long as [`gradient`](crate::gradient).
///
/// ```
/// use hamiltonian_adjoint::{Grid, Inputs, Settings, estimate, scenes::CartPendulum};
///
/// let system = CartPendulum::default().scene().compile()?;
/// let mut inputs = Inputs::at_rest(&system, Grid::uniform(400, 0.005));
/// inputs.controls.fill(10.0);
/// let estimate = estimate(&system, &inputs, Settings::default())?;
/// println!("{estimate}"); // J = 15.1…; error of the grid: J ± …, gradient ± … of its size
/// assert!(estimate.uncertainty.is_some_and(|error| error < 0.01 * estimate.value));
/// # Ok::<(), hamiltonian_adjoint::Error>(())
/// ```
///
/// # Errors
/// As [`gradient`](crate::gradient), on the given grid.
pub fn estimate(system: &System, inputs: &Inputs, settings: Settings) -> Result<Estimate, Error> {
    Solver::new(system, settings).estimate(inputs)
}

impl Solver {
    /// J and its gradient with estimates of their errors, as [`estimate`](crate::estimate()) computes them. The last motion is discarded.
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate) and [`gradient`](Self::gradient).
    pub fn estimate(&mut self, inputs: &Inputs) -> Result<Estimate, Error> {
        let is_kept = self.keep_adjoint(true);
        let value = self.simulate(inputs).map(drop).and_then(|()| self.gradient().cloned());
        let value = value.and_then(|gradient| Estimate::of_value(self, gradient));
        self.keep_adjoint(is_kept);
        let estimate = value.and_then(|of| of.compared(self, inputs));
        self.drop_motion();
        estimate
    }
}

impl Estimate {
    /// J and its gradient without estimates of their errors, from a solver that stores the adjoint variables of this gradient of J.
    pub(crate) fn of_value(solver: &Solver, gradient: Gradient) -> Result<Self, Error> {
        let residual = Residual::new(solver)?;
        Ok(Estimate {
            value: gradient.value,
            uncertainty: None,
            gradient_uncertainty: None,
            derivatives: Vec::new(),
            corrected: None,
            residual: residual.as_ref().map(Residual::sum),
            largest: residual.as_ref().and_then(|residual| residual.largest(&solver.trajectory().times)),
            withdrawn: None,
            gradient,
        })
    }

    /// Adds the estimates. The solver computes the motions on every second and every fourth node.
    ///
    /// # Errors
    /// If a progress callback stops the solver.
    pub(crate) fn compared(mut self, solver: &mut Solver, inputs: &Inputs) -> Result<Self, Error> {
        let (system, scheme) = (solver.system().clone(), solver.settings().scheme);
        let order = system.order_of_sums().unwrap_or(1).min(scheme.order);
        // Twice as many steps reduce the error by this factor.
        let decrease = 2f64.powi(order as i32);
        let levels = self
            .check_warnings()
            .and_then(|()| coarser(&system, inputs))
            .map(|coarse| Levels::new(solver, inputs, &self.gradient, &coarse, decrease));
        let levels = match levels {
            Ok(Err(stopped @ Error::Interrupted { .. })) => return Err(stopped),
            Ok(levels) => levels.map_err(|error| Withdrawn::NoCoarserMotion(Box::new(error))),
            Err(why) => Err(why),
        };
        let judged = levels.and_then(|mut levels| {
            let margin = if self.gradient.frozen.is_some() {
                self.judge_with_kinks(&levels, decrease)
            } else {
                self.judge(&levels, decrease)
            };
            margin.map(|margin| {
                self.derivatives = self.with_bounds(&system, &levels, margin);
                self.corrected = levels.extrapolated.take();
            })
        });
        self.withdrawn = judged.err();
        Ok(self)
    }
}

/// The inputs on every second and every fourth node.
fn coarser(system: &System, inputs: &Inputs) -> Result<[Inputs; 2], Withdrawn> {
    let moving = inputs.grid.steps.iter().filter(|dt| **dt != 0.0).count();
    if !has_quarters(inputs) || moving < 8 || inputs.grid.stages > 1 || system.order_of_sums().is_none() {
        return Err(Withdrawn::NoCoarserGrid);
    }
    let second = every_second(inputs);
    let fourth = every_second(&second);
    Ok([second, fourth])
}

impl Estimate {
    fn check_warnings(&self) -> Result<(), Withdrawn> {
        let is_coarse = |warning: &&Warning| {
            use Warning::{Braked, Drift, HalvedSteps, Rough, Unresolved, UnresolvedElement};
            matches!(
                warning,
                Braked { .. }
                    | Drift { .. }
                    | HalvedSteps { .. }
                    | Rough { .. }
                    | Unresolved { .. }
                    | UnresolvedElement { .. }
            )
        };
        self.gradient.warnings.iter().find(is_coarse).map_or(Ok(()), |warning| Err(Withdrawn::Warned(warning.clone())))
    }

    /// Sets the uncertainties of a motion with kinks between nodes: J zigzags, and differences fall irregularly, so they are not extrapolated. Returns
    /// the margin of a difference.
    fn judge_with_kinks(&mut self, levels: &Levels, decrease: f64) -> Result<f64, Withdrawn> {
        let [near, far] = levels.of_gradient;
        let error = MARGIN_OF_GRADIENT * near.max(far / decrease);
        if error >= LARGE {
            return Err(Withdrawn::Large { error });
        }
        let [near, far] = levels.of_value.map(f64::abs);
        self.uncertainty = Some(MARGIN * near.max(far / decrease).max(self.residual.map_or(0.0, f64::abs)));
        self.gradient_uncertainty = Some(error);
        Ok(MARGIN_OF_GRADIENT)
    }

    /// The single derivatives with the bounds of their errors.
    fn with_bounds(&self, system: &System, levels: &Levels, margin: f64) -> Vec<Derivative> {
        let rate = self.gradient.start.rate_symbol();
        let of_coordinates =
            |of: &str| (0..system.n()).map(|i| format!("{of} of `{}`", system.coordinate_name(i))).collect();
        let designs = (0..system.designs()).map(|p| format!("`{}`", system.design_name(p))).collect();
        let names: [Vec<String>; 3] = [designs, of_coordinates("q₀"), of_coordinates(rate)];
        let values = derivatives(best(&self.gradient)).into_iter().zip(&levels.of_derivatives);
        let all = names.into_iter().flatten().zip(values);
        all.map(|(of, (value, change))| Derivative { of, value, uncertainty: margin * change }).collect()
    }

    /// Sets the uncertainties if they can be trusted, and returns the margin of a difference.
    fn judge(&mut self, levels: &Levels, decrease: f64) -> Result<f64, Withdrawn> {
        let least = decrease / AGREE;
        let [near, far] = levels.of_gradient;
        if far < least * near && near > ROUNDING {
            return Err(Withdrawn::Unresolved { ratio: far / near, least });
        }
        // A motion that is less smooth than the scheme assumes has errors that fall more slowly.
        let observed = |ratio: f64| if ratio.is_finite() { ratio.clamp(least, decrease) } else { decrease };
        let margin = MARGIN_OF_GRADIENT / (observed(far / near) - 1.0);
        let error = margin * near;
        if error >= LARGE {
            return Err(Withdrawn::Large { error });
        }
        let [near, far] = levels.of_value;
        // J of the continuous motion − J.
        let difference = near / (decrease - 1.0);
        let is_exact = difference.abs() <= ROUNDING * self.value.abs();
        match self.residual.filter(|_| !is_exact) {
            Some(residual) if !(residual / difference < AGREE && difference / residual < AGREE) => {
                return Err(Withdrawn::Disagree { residual, difference });
            }
            None if !is_exact && (far / near < least || far / near > decrease * AGREE) => {
                return Err(Withdrawn::Unresolved { ratio: far / near, least });
            }
            _ => {}
        }
        let slower = near.abs() / (observed((far / near).abs()) - 1.0);
        self.uncertainty = Some(MARGIN * self.residual.map_or(slower, |residual| residual.abs().max(difference.abs())));
        self.gradient_uncertainty = Some(error);
        Ok(margin)
    }
}

impl Estimate {
    /// The estimated errors of J and its gradient, in words.
    pub(crate) fn in_words(&self) -> String {
        match (&self.withdrawn, self.uncertainty, self.gradient_uncertainty) {
            (None, Some(of_value), Some(of_gradient)) => {
                let frozen = if self.gradient.frozen.is_some() { " at frozen grid phase" } else { "" };
                format!("J ± {of_value:.1e}, gradient{frozen} ± {} of its size", percent(of_gradient))
            }
            (Some(why), ..) => format!("not known: {why}"),
            _ => "not known".into(),
        }
    }
}

/// Two digits, as a percentage unless it is small.
fn percent(share: f64) -> String {
    if share < 1e-3 { format!("{share:.1e}") } else { format!("{:.1} %", 100.0 * share) }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "J = {}; error of the grid: {}", self.value, self.in_words())?;
        match self.largest.filter(|_| self.withdrawn.is_none()) {
            Some((from, to, share)) => {
                write!(f, " ({:.0} % of the error of J from {} to {} s)", 100.0 * share, seconds(from), seconds(to))
            }
            None => Ok(()),
        }
    }
}

impl fmt::Display for Withdrawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Withdrawn::NoCoarserGrid => write!(
                f,
                "a motion on every second node cannot be compared, because a cost is read at a single node or summed over nodes without their steps, the grid is composed or has fewer than eight steps, or the number of steps before an event or a step of length zero, since the last one, is not a multiple of four"
            ),
            Withdrawn::Warned(warning) => write!(f, "{warning}"),
            Withdrawn::NoCoarserMotion(error) => write!(f, "on every second or fourth node there is no motion ({error})"),
            Withdrawn::Unresolved { ratio, least } => write!(
                f,
                "with twice as many steps the change falls by a factor of {ratio:.2}, which should be at least {least:.2}: the steps do not resolve the motion"
            ),
            Withdrawn::Disagree { residual, difference } => write!(
                f,
                "J of the continuous motion minus J is {residual:.1e} by the residuals of the steps, but {difference:.1e} by the difference to every second node; if the steps resolved the motion, these would agree to a factor of {AGREE}"
            ),
            Withdrawn::Large { error } if *error < 1.0 => {
                write!(f, "the gradient may be wrong by {:.0} %: use shorter steps", 100.0 * error)
            }
            Withdrawn::Large { error } => write!(
                f,
                "the gradient may be wrong by {error:.2e} times its size: it almost vanishes, as at an optimum, or the steps are too long"
            ),
        }
    }
}
