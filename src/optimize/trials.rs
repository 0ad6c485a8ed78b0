//! [`Trials`]: several motions with the same variables.

mod problem;

use super::free::Quantity;
use super::motion_problem::MotionProblem;
use super::multiple_shooting::MultipleShooting;
use super::problem::Problem;
use super::sizes::Sizes;
use super::variables::{Meaning, Variables};
use crate::{Error, Inputs};

/// A problem made of several motions: the sum of their costs, and all their outputs in sequence. Use it for trials of one experiment with
/// different starts, forces or durations.
///
/// [`new`](Self::new) is for motions that have the same variables. [`sharing_designs`](Self::sharing_designs) is for records of experiments: the
/// parameters are common to all, and initial values, controls and durations belong to each motion. [`identify`](super::identify()) finds them. Bounds of a common variable are the intersection
/// of its bounds in all motions; its name is that in the first motion that has it.
#[derive(Debug)]
pub struct Trials<P = MotionProblem> {
    pub(super) parts: Vec<P>,
    sharing: Sharing,
    /// For each part, the variable of the whole problem for each of its variables.
    places: Vec<Vec<usize>>,
    names: Vec<String>,
}

/// The variables that are common to all parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sharing {
    /// All free quantities.
    All,
    /// Design variables with the same name.
    Designs,
}

/// A problem that can be one of several trials.
pub trait Part: Problem {
    /// The free quantities, which are the first variables.
    #[doc(hidden)]
    fn quantities(&self) -> &Variables;

    /// Evaluates a point that does not become the current one.
    ///
    /// # Errors
    /// A point without a value.
    #[doc(hidden)]
    fn attempt(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error>;

    /// Makes the point of the last attempt, which has a value, the current one.
    #[doc(hidden)]
    fn accept(&mut self);
}

impl Part for MotionProblem {
    fn quantities(&self) -> &Variables {
        self.free()
    }

    fn attempt(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.try_at(x, c)
    }

    fn accept(&mut self) {
        self.settle();
    }
}

impl Part for MultipleShooting {
    fn quantities(&self) -> &Variables {
        &self.whole
    }

    fn attempt(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.try_at(x, c)
    }

    fn accept(&mut self) {
        self.settle();
    }
}

impl Trials {
    /// A problem of motions that have the same variables.
    ///
    /// # Errors
    /// No motion; variables that differ from those of the first motion in number, quantity, scale or form; bounds with empty intersection.
    pub fn new(motions: Vec<MotionProblem>) -> Result<Self, Error> {
        if let Some(first) = motions.first() {
            for (trial, motion) in motions.iter().enumerate() {
                let (expected, found) = (first.variables(), motion.variables());
                if found != expected {
                    let what = "variables of a trial, which must be those of the first trial";
                    return Err(Error::Size { what, expected, found });
                }
                if let Some(i) = (0..found).find(|&i| motion.free().meaning(i) != first.free().meaning(i)) {
                    return Err(differs(trial, i, motion.free().meaning(i), 0));
                }
            }
        }
        Self::join(motions, Sharing::All)
    }

    /// A problem of motions that share parameters: free design variables of the same name are one variable, and all other free quantities,
    /// such as initial values, belong to their motion. A parameter may be missing in some motions.
    ///
    /// ```
    /// use hamiltonian_adjoint::optimize::{Free, MotionProblem, Options, Quantity, Trials, Variables, levenberg_marquardt, silent};
    /// use hamiltonian_adjoint::{Grid, Inputs, Scene, Settings, planar::Body};
    ///
    /// // A mass of 1 kg on a spring of 4 N/m, released twice from unknown positions, 1.2 m and 0.7 m: x = 1 m + c cos(2 t/s).
    /// let record = |amplitude: f64| {
    ///     let (mut scene, grid) = (Scene::new(), Grid::uniform(200, 0.01));
    ///     let stiffness = scene.design("stiffness", 3.0); // a guess, N/m
    ///     let cart = scene.body("cart", 1.0, 0.1, [1.0, 0.0, 0.0]);
    ///     scene.spring_damper("spring", Body::GROUND.at(-1.0, 0.0), cart.at(0.0, 0.0), stiffness, 2.0, 0.0);
    ///     for (node, t) in grid.times().into_iter().enumerate().skip(10).step_by(10) {
    ///         scene.reading(&format!("reading at node {node}"), cart.coordinates[0], node, 1.0 + amplitude * (2.0 * t).cos(), 1.0 / 2e-3);
    ///     }
    ///     let system = scene.compile()?;
    ///     let inputs = Inputs::at_rest(&system, grid);
    ///     let free = vec![Free::design(stiffness), Free::new(Quantity::Coordinate(cart.coordinates[0]))];
    ///     let variables = Variables::new(&system, &inputs, free)?;
    ///     MotionProblem::new(&system, Settings::default(), inputs, variables)
    /// };
    /// let mut trials = Trials::sharing_designs(vec![record(0.2)?, record(-0.3)?])?;
    /// let start = trials.start();
    /// let fit = levenberg_marquardt(&mut trials, &start, &Options::default(), &mut silent)?;
    /// assert_eq!(fit.outcome.x.len(), 3); // the stiffness and two starts
    /// assert!((fit.outcome.x[0] - 4.0).abs() < 1e-3);
    /// assert!((fit.outcome.x[1] - 1.2).abs() < 1e-3 && (fit.outcome.x[2] - 0.7).abs() < 1e-3);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// No motion; a parameter that has another scale or form in one of the motions; bounds with empty intersection.
    pub fn sharing_designs(motions: Vec<MotionProblem>) -> Result<Self, Error> {
        Self::join(motions, Sharing::Designs)
    }

    /// The motions, each with the solver at the last evaluated point.
    pub fn motions(&self) -> &[MotionProblem] {
        &self.parts
    }

    /// The variables of the current inputs of all motions. A common variable has its value in the first motion that has it.
    pub fn start(&self) -> Vec<f64> {
        self.whole(self.parts.iter().map(MotionProblem::start))
    }

    /// The inputs of each motion at a point.
    ///
    /// # Panics
    /// If the point has fewer variables than the problem.
    pub fn inputs_at(&self, x: &[f64]) -> Vec<Inputs> {
        (0..self.parts.len()).map(|k| self.parts[k].inputs_at(&self.own(k, x))).collect()
    }
}

/// The error of a variable that differs from the one that it should be.
fn differs(trial: usize, i: usize, Meaning { name, scale: value, .. }: Meaning, first: usize) -> Error {
    let what = format!("the scale of variable {i} of trial {trial}, `{name}`,");
    let of = if first == 0 { "that of the same quantity as in trial 0, with the same scale and form" } else { SAME };
    Error::Parameter { what, value, must_be: of }
}

const SAME: &str = "that of the same quantity in an earlier trial, with the same scale and form";

impl<P: Part> Trials<P> {
    /// A problem of these parts.
    ///
    /// # Errors
    /// No part; a common variable that has another scale or form in one of the parts; bounds with empty intersection.
    pub(super) fn join(parts: Vec<P>, sharing: Sharing) -> Result<Self, Error> {
        if parts.is_empty() {
            return Err(Error::Parameter { what: "the number of trials".into(), value: 0.0, must_be: "at least 1" });
        }
        let mut names = Vec::new();
        // The common variables: the trial and the variable in which each appears first.
        let mut common: Vec<(usize, [usize; 2])> = Vec::new();
        let mut places = Vec::with_capacity(parts.len());
        for (trial, part) in parts.iter().enumerate() {
            let mut own = Vec::with_capacity(part.variables());
            for i in 0..part.variables() {
                let is_common = sharing.includes(part, i);
                let same = |(at, [first, k]): &(usize, [usize; 2])| {
                    parts[*first].variable_name(*k) == part.variable_name(i) && !own.contains(at)
                };
                let known = common.iter().find(|of| is_common && same(of)).copied();
                if let Some((at, [first, k])) = known {
                    let meaning = part.quantities().meaning(i);
                    if parts[first].quantities().meaning(k) != meaning {
                        return Err(differs(trial, i, meaning, first));
                    }
                    own.push(at);
                    continue;
                }
                if is_common {
                    common.push((names.len(), [trial, i]));
                }
                own.push(names.len());
                let name = part.variable_name(i);
                names.push(if is_common { name } else { format!("{name} of trial {trial}") });
            }
            places.push(own);
        }
        let trials = Trials { parts, sharing, places, names };
        let of_all = if sharing == Sharing::All { " in all trials" } else { "" };
        let name = |i: usize| format!("`{}`{of_all}", trials.names[i]);
        trials.bounds().iter().enumerate().try_for_each(|(i, of)| of.check(|| name(i)))?;
        Ok(trials)
    }

    pub(super) fn sharing(&self) -> Sharing {
        self.sharing
    }

    /// The variables of a part.
    pub(super) fn own(&self, part: usize, x: &[f64]) -> Vec<f64> {
        self.places[part].iter().map(|&at| x[at]).collect()
    }

    /// The variables of the whole problem for those of the parts; the first part that has a variable determines it.
    pub(super) fn whole(&self, parts: impl DoubleEndedIterator<Item = Vec<f64>> + ExactSizeIterator) -> Vec<f64> {
        let mut x = vec![0.0; self.names.len()];
        for (places, own) in self.places.iter().zip(parts).rev() {
            places.iter().zip(own).for_each(|(&at, value)| x[at] = value);
        }
        x
    }

    fn rows(part: &P) -> usize {
        part.constraints().len()
    }

    /// For each part: the places of its own rows in `rows`, and the constraints in these rows.
    fn own_rows(&self, rows: &[usize]) -> Vec<(Vec<usize>, Vec<usize>)> {
        let mut first = 0;
        let own = |part: &P| {
            let own = first..first + Self::rows(part);
            first = own.end;
            let places = (0..rows.len()).filter(|&k| own.contains(&rows[k]));
            places.map(|k| (k, rows[k] - own.start)).unzip()
        };
        self.parts.iter().map(own).collect()
    }

    /// The part that a constraint belongs to, and its number there.
    pub(super) fn part_of(&self, mut constraint: usize) -> Option<(usize, usize)> {
        for (k, part) in self.parts.iter().enumerate() {
            match constraint.checked_sub(Self::rows(part)) {
                None => return Some((k, constraint)),
                Some(rest) => constraint = rest,
            }
        }
        None
    }

    fn sizes(&self) -> Sizes {
        Sizes { variables: self.names.len(), constraints: self.parts.iter().map(Self::rows).sum() }
    }
}

impl Sharing {
    /// True if a variable of a part is common to all parts that have it.
    fn includes(self, part: &impl Part, variable: usize) -> bool {
        let quantities = part.quantities();
        variable < quantities.len() && (self == Sharing::All || matches!(quantities.quantity(variable), Quantity::Design(_)))
    }
}
