//! IPOPT through its C interface: callbacks that evaluate the problem.

#![expect(unsafe_code, reason = "a library in C++ is called")]

use std::cell::Cell;
use std::ffi::{c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice::{from_raw_parts, from_raw_parts_mut};
use std::sync::{Mutex, PoisonError};

use hamiltonian_adjoint::Error;
use hamiltonian_adjoint::optimize::{Interval, Iterate, Options, Outcome, Problem, Reason, Violation};
use nalgebra::DMatrix;

use crate::interface::{
    AddIpoptIntOption, AddIpoptNumOption, AddIpoptStrOption, CreateIpoptProblem, FreeIpoptProblem, IpoptSolve,
    SetIntermediateCallback,
};
use crate::{Failure, Hessian, finite};

/// IPOPT's linear solver stores data in static variables: only one call at a time in a process.
static ALONE: Mutex<()> = Mutex::new(());

thread_local! {
    /// True while this thread is in IPOPT: a problem that calls IPOPT again would wait for itself.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Resets the flag when a call ends, with or without a panic.
struct Mark;

impl Drop for Mark {
    fn drop(&mut self) {
        INSIDE.set(false);
    }
}

/// The problem, its last evaluation, and the progress of the run.
struct Asked<'p, P> {
    problem: &'p mut P,
    at: Option<Vec<f64>>,
    value: Option<f64>,
    c: Vec<f64>,
    gradient: Vec<f64>,
    /// The largest derivative of f at the start, by which f is scaled for IPOPT; 1 if all are zero.
    unit: f64,
    counts: [usize; 3],
    history: Vec<Iterate>,
    halved: usize,
    failures: usize,
    first_failure: Option<Error>,
    last_failure: Option<Error>,
    /// True if a callback stopped a simulation; then the problem is not evaluated any more.
    is_stopped: bool,
}

impl<P: Problem> Asked<'_, P> {
    /// The value at x, if it can be computed; x is then the point of the last evaluation.
    fn evaluate(&mut self, x: &[f64]) -> Option<f64> {
        if self.at.as_deref() != Some(x) {
            // If the evaluation panics, the point has no value.
            (self.at, self.value) = (Some(x.to_vec()), None);
            self.counts[0] += 1;
            let value = self.problem.evaluate(x, &mut self.c);
            let value = value.and_then(|value| {
                finite("the value of the cost or of a constraint", &[&[value], &self.c[..]].concat()).map(|()| value)
            });
            self.halved += usize::from(value.is_ok() && self.problem.is_halved());
            self.value = self.note(value);
        }
        self.value
    }

    /// The value of a result, if it is not an error; the first and the last error are stored.
    fn note<T>(&mut self, found: Result<T, Error>) -> Option<T> {
        let note = |error: Error| {
            self.failures += 1;
            self.is_stopped |= matches!(error, Error::Interrupted { .. });
            self.first_failure.get_or_insert(error.clone());
            self.last_failure = Some(error);
        };
        found.map_err(note).ok()
    }

    /// The gradient of σ f + λᵀ c.
    fn weigh(&mut self, x: &[f64], f: f64, c: &[f64]) -> Option<&[f64]> {
        self.evaluate(x)?;
        self.counts[1] += 1;
        let asked = self.problem.gradient(f, c, &mut self.gradient);
        let asked = asked.and_then(|()| finite("a derivative of the cost", &self.gradient));
        self.note(asked)?;
        Some(&self.gradient)
    }

    /// The Jacobian in row-major order.
    fn jacobian(&mut self, x: &[f64], values: &mut [f64]) -> Option<()> {
        self.evaluate(x)?;
        self.counts[1] += self.c.len();
        let rows: Vec<usize> = (0..self.c.len()).collect();
        let mut jacobian = DMatrix::zeros(rows.len(), x.len());
        let asked = self.problem.jacobian(&rows, &mut jacobian);
        let asked = asked.and_then(|()| finite("a derivative of a constraint", jacobian.as_slice()));
        self.note(asked)?;
        values.copy_from_slice(jacobian.transpose().as_slice());
        Some(())
    }

    /// The lower triangle of the Hessian of σ f + λᵀ c, row by row.
    fn hessian(&mut self, x: &[f64], (f, c): (f64, &[f64]), values: &mut [f64]) -> Option<()> {
        self.weigh(x, f, c)?;
        let (mut unit, mut row) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        for i in 0..x.len() {
            unit[i] = 1.0;
            self.counts[2] += 1;
            let asked = self.problem.product(&unit, &mut row);
            let asked = asked.and_then(|()| finite("a second derivative", &row));
            self.note(asked)?;
            unit[i] = 0.0;
            values[i * (i + 1) / 2..][..=i].copy_from_slice(&row[..=i]);
        }
        Some(())
    }

    /// Evaluates the start; its gradient with respect to the free variables determines the scale of f.
    fn begin(&mut self, x: &[f64], bounds: &[Interval]) -> Result<(), Failure> {
        let none = vec![0.0; self.c.len()];
        if self.weigh(x, 1.0, &none).is_none() {
            return Err(self.failure());
        }
        let free = self.gradient.iter().zip(bounds).filter(|(_, of)| of.least < of.most);
        let steepest = free.fold(0.0, |most: f64, (g, _)| most.max(g.abs()));
        self.unit = if steepest > 0.0 { steepest } else { 1.0 };
        Ok(())
    }

    fn failure(&mut self) -> Failure {
        self.last_failure.take().map_or(Failure::Refused(INVALID_NUMBER), Failure::Problem)
    }

    /// Callbacks failed for a reason that IPOPT does not know. After the start this is not an error, and the best point is kept.
    fn without_derivative(&mut self) -> Result<Reason, Failure> {
        if self.history.len() <= 1 {
            return Err(self.failure());
        }
        self.first_failure = self.last_failure.take();
        Ok(Reason::NoDerivative)
    }
}

/// Evaluates the problem behind a pointer; no panic may unwind into IPOPT.
///
/// # Safety
/// `data` and `x` are the pointers passed by [`minimise`] and IPOPT.
unsafe fn ask<P: Problem>(
    (n, x, data): (c_int, *const f64, *mut c_void),
    what: impl FnOnce(&mut Asked<P>, &[f64]) -> Option<()>,
) -> c_int {
    // SAFETY: IPOPT passes back the pointer that it was given, and arrays of the given sizes.
    let (asked, x) = unsafe { (&mut *data.cast::<Asked<P>>(), list(x, n)) };
    if asked.is_stopped {
        return 0;
    }
    catch_unwind(AssertUnwindSafe(|| what(asked, x))).ok().flatten().map_or(0, |()| 1)
}

/// # Safety
/// As `from_raw_parts`, except that IPOPT may pass a null pointer for an empty list.
unsafe fn list<'a>(x: *const f64, n: c_int) -> &'a [f64] {
    // SAFETY: as above.
    if n == 0 { &[] } else { unsafe { from_raw_parts(x, n as usize) } }
}

unsafe extern "C" fn value<P: Problem>(n: c_int, x: *const f64, _: c_int, f: *mut f64, data: *mut c_void) -> c_int {
    // SAFETY: as in `ask`.
    unsafe { ask::<P>((n, x, data), |asked, x| asked.evaluate(x).map(|value| *f = value)) }
}

unsafe extern "C" fn gradient<P: Problem>(n: c_int, x: *const f64, _: c_int, g: *mut f64, data: *mut c_void) -> c_int {
    // SAFETY: as in `ask`.
    unsafe {
        ask::<P>((n, x, data), |asked, x| {
            let none = vec![0.0; asked.c.len()];
            let gradient = asked.weigh(x, 1.0, &none)?;
            from_raw_parts_mut(g, x.len()).copy_from_slice(gradient);
            Some(())
        })
    }
}

unsafe extern "C" fn constraints<P: Problem>(
    n: c_int,
    x: *const f64,
    _: c_int,
    m: c_int,
    g: *mut f64,
    data: *mut c_void,
) -> c_int {
    // SAFETY: as in `ask`.
    unsafe {
        ask::<P>((n, x, data), |asked, x| {
            asked.evaluate(x)?;
            if m > 0 {
                from_raw_parts_mut(g, m as usize).copy_from_slice(&asked.c);
            }
            Some(())
        })
    }
}

unsafe extern "C" fn jacobian<P: Problem>(
    n: c_int,
    x: *const f64,
    _: c_int,
    m: c_int,
    count: c_int,
    rows: *mut c_int,
    cols: *mut c_int,
    values: *mut f64,
    data: *mut c_void,
) -> c_int {
    if count == 0 {
        return 1;
    }
    let (count, n_all) = (count as usize, n as usize);
    // SAFETY: as in `ask`; without values, IPOPT requests the positions, and the arrays have `count` entries.
    unsafe {
        if values.is_null() {
            let places = from_raw_parts_mut(rows, count).iter_mut().zip(from_raw_parts_mut(cols, count)).enumerate();
            places.for_each(|(k, (row, col))| (*row, *col) = ((k / n_all) as c_int, (k % n_all) as c_int));
            return c_int::from(m > 0);
        }
        ask::<P>((n, x, data), |asked, x| asked.jacobian(x, from_raw_parts_mut(values, count)))
    }
}

unsafe extern "C" fn hessian<P: Problem>(
    n: c_int,
    x: *const f64,
    _: c_int,
    f: f64,
    m: c_int,
    lambda: *const f64,
    _: c_int,
    count: c_int,
    rows: *mut c_int,
    cols: *mut c_int,
    values: *mut f64,
    data: *mut c_void,
) -> c_int {
    let count = count as usize;
    // SAFETY: as in `jacobian`.
    unsafe {
        if values.is_null() {
            let (rows, cols) = (from_raw_parts_mut(rows, count), from_raw_parts_mut(cols, count));
            let places = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
            places.zip(rows.iter_mut().zip(cols)).for_each(|((i, j), (row, col))| (*row, *col) = (i, j));
            return 1;
        }
        ask::<P>((n, x, data), |asked, x| asked.hessian(x, (f, list(lambda, m)), from_raw_parts_mut(values, count)))
    }
}

unsafe extern "C" fn iterate<P: Problem>(
    _: c_int,
    _: c_int,
    value: f64,
    violation: f64,
    stationarity: f64,
    _: f64,
    step: f64,
    _: f64,
    _: f64,
    _: f64,
    _: c_int,
    data: *mut c_void,
) -> c_int {
    // SAFETY: as in `ask`.
    let asked = unsafe { &mut *data.cast::<Asked<P>>() };
    let stationarity = stationarity * asked.unit;
    asked.history.push(Iterate { value, violation, stationarity, step, evaluations: asked.counts[0] });
    1
}

pub fn minimise<P: Problem>(problem: &mut P, start: &[f64], options: &Options, second: Hessian) -> Result<Outcome, Failure> {
    options.fit(problem, start)?;
    let (bounds, intervals) = (problem.bounds(), problem.constraints());
    let (n, m) = (bounds.len(), intervals.len());
    let ends = |of: &[Interval]| -> [Vec<f64>; 2] {
        [of.iter().map(|of| of.least).collect(), of.iter().map(|of| of.most).collect()]
    };
    let ([x_least, x_most], [g_least, g_most]) = (ends(&bounds), ends(&intervals));
    let mut asked = Asked {
        problem,
        at: None,
        value: None,
        c: vec![0.0; m],
        gradient: vec![0.0; n],
        unit: 1.0,
        counts: [0; 3],
        history: Vec::new(),
        halved: 0,
        failures: 0,
        first_failure: None,
        last_failure: None,
        is_stopped: false,
    };
    let mut x: Vec<f64> = start.iter().zip(&bounds).map(|(x, of)| of.nearest(*x)).collect();
    asked.begin(&x, &bounds)?;
    let (mut c, mut multipliers, mut found) = (vec![0.0; m], vec![0.0; m], 0.0);
    let count = |k: usize| c_int::try_from(k).map_err(|_| Failure::Refused(-102));
    let (of_jacobian, of_hessian) = (count(m * n)?, count(n * (n + 1) / 2)?);
    if INSIDE.replace(true) {
        return Err(Failure::Nested);
    }
    let _mark = Mark;
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: the arrays have the given sizes; `asked` lives until the problem is freed and is not accessed elsewhere before; no other thread
    // is in IPOPT.
    let status = unsafe {
        let ipopt = CreateIpoptProblem(
            count(n)?,
            x_least.as_ptr(),
            x_most.as_ptr(),
            count(m)?,
            g_least.as_ptr(),
            g_most.as_ptr(),
            of_jacobian,
            of_hessian,
            0,
            value::<P>,
            constraints::<P>,
            gradient::<P>,
            jacobian::<P>,
            hessian::<P>,
        );
        if ipopt.is_null() {
            return Err(Failure::Refused(-11));
        }
        let approximation = if second == Hessian::Exact { c"exact" } else { c"limited-memory" };
        AddIpoptStrOption(ipopt, c"hessian_approximation".as_ptr(), approximation.as_ptr());
        AddIpoptStrOption(ipopt, c"sb".as_ptr(), c"yes".as_ptr());
        AddIpoptIntOption(ipopt, c"print_level".as_ptr(), 0);
        AddIpoptIntOption(ipopt, c"max_iter".as_ptr(), c_int::try_from(options.iterations).unwrap_or(c_int::MAX));
        // IPOPT does not accept tolerances of 0.
        AddIpoptNumOption(ipopt, c"tol".as_ptr(), options.stationarity.max(f64::MIN_POSITIVE));
        // Relative to the gradient at the start, for any unit of the cost; IPOPT's further limits assume gradients of size 1.
        AddIpoptNumOption(ipopt, c"nlp_scaling_obj_target_gradient".as_ptr(), 1.0);
        AddIpoptNumOption(ipopt, c"nlp_scaling_min_value".as_ptr(), 0.0);
        AddIpoptNumOption(ipopt, c"dual_inf_tol".as_ptr(), asked.unit);
        AddIpoptNumOption(ipopt, c"compl_inf_tol".as_ptr(), 1e-4 * asked.unit);
        // Accepts only the requested tolerance.
        AddIpoptIntOption(ipopt, c"acceptable_iter".as_ptr(), 0);
        // IPOPT relaxes bounds, here by a tenth of the permitted violation; constraints change when it moves variables back.
        AddIpoptNumOption(ipopt, c"constr_viol_tol".as_ptr(), (0.5 * options.violation).max(f64::MIN_POSITIVE));
        AddIpoptNumOption(ipopt, c"bound_relax_factor".as_ptr(), (0.1 * options.violation).min(1e-8));
        SetIntermediateCallback(ipopt, iterate::<P>);
        let data = (&raw mut asked).cast();
        let none = std::ptr::null_mut();
        let status =
            IpoptSolve(ipopt, x.as_mut_ptr(), c.as_mut_ptr(), &mut found, multipliers.as_mut_ptr(), none, none, data);
        FreeIpoptProblem(ipopt);
        status
    };
    // The problem keeps the motion of the result; IPOPT's values belong to a point that may have been moved into the bounds since.
    if let Some(value) = asked.evaluate(&x) {
        found = value;
        c.copy_from_slice(&asked.c);
    }
    let violation = intervals.iter().zip(&c).fold(0.0, |most: f64, (of, c)| most.max(of.violation(*c)));
    if asked.history.is_empty() {
        // All variables were fixed.
        let evaluations = asked.counts[0];
        asked.history.push(Iterate { value: found, violation, stationarity: 0.0, step: 0.0, evaluations });
    }
    let reason = match status {
        _ if asked.is_stopped => Reason::Interrupted,
        INVALID_NUMBER => asked.without_derivative()?,
        // The constraints hold, so the problem is not infeasible.
        2 | -2 if violation <= options.violation => Reason::NoLowerValue,
        _ => reason(status)?,
    };
    let violated = Violation::all(asked.problem, &c);
    let warnings = if asked.value.is_some() { asked.problem.warnings() } else { Vec::new() };
    let Asked { counts: [evaluations, gradients, products], history, halved, failures, first_failure, .. } = asked;
    Ok(Outcome {
        x,
        value: found,
        constraints: c,
        violation,
        violated,
        multipliers,
        reason,
        iterations: history.len() - 1,
        evaluations,
        gradients,
        products,
        history,
        warnings,
        halved,
        failures,
        first_failure,
    })
}

/// A value of IPOPT's `ApplicationReturnStatus`: callbacks failed.
const INVALID_NUMBER: c_int = -13;

/// The reason for a value of IPOPT's `ApplicationReturnStatus`.
fn reason(status: c_int) -> Result<Reason, Failure> {
    match status {
        0 => Ok(Reason::Stationary),
        2 | -2 => Ok(Reason::Infeasible),
        1 | 3 | 6 | -3 => Ok(Reason::NoLowerValue),
        4 => Ok(Reason::Unbounded),
        5 => Ok(Reason::Interrupted),
        -1 | -4 => Ok(Reason::Iterations),
        _ => Err(Failure::Refused(status)),
    }
}
