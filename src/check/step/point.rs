//! Arguments of a step's blocks: y_i, y_{i−1}, u_i and b, by name and in one list.

use nalgebra::DVector;
use std::ops::Range;

use super::terms::Terms;
use crate::motion::column;
use crate::number::Random;
use crate::paper_system::{self, PaperSystem, Variable};
use crate::redundancy::mass_matrix;

/// The parts of the paper's y at one node.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Velocities v.
    pub v: DVector<f64>,
    /// Rates ṗ* of the augmented momenta.
    pub p_star_dot: DVector<f64>,
    /// Coordinates q.
    pub q: DVector<f64>,
    /// Augmented momenta p*.
    pub p_star: DVector<f64>,
    /// Multipliers σ.
    pub sigma: DVector<f64>,
}

/// The step that ends at node i: all arguments of f_i.
///
/// Eq. (2) holds between the two states, so `y.v` equals the paper's substitution γ q_i + q̂_{i−1}.
pub struct StepPoint<'a> {
    paper: &'a PaperSystem<'a>,
    /// The node i.
    pub node: usize,
    /// Time t_i, s.
    pub t: f64,
    /// Length Δt of the step, s.
    pub dt: f64,
    /// γ = 2/Δt.
    pub gamma: f64,
    /// y_i.
    pub y: State,
    /// y_{i−1}.
    pub previous: State,
    /// u_i.
    pub u: DVector<f64>,
    /// Design variables.
    pub b: DVector<f64>,
}

impl<'a> StepPoint<'a> {
    pub(super) fn new(paper: &'a PaperSystem<'a>, x: &[f64]) -> Self {
        let places = Places(paper);
        let list = |part: Part| DVector::from_column_slice(&x[places.of(part)]);
        let state = |of: fn(Variable) -> Part| {
            let [v, p_star_dot, q, p_star, sigma] = Variable::ALL.map(|variable| list(of(variable)));
            State { v, p_star_dot, q, p_star, sigma }
        };
        let node = x[places.of(Part::Node).start].round() as usize;
        let dt = paper.inputs.grid.steps[node - 1];
        StepPoint {
            paper,
            node,
            t: paper.trajectory.times[node],
            dt,
            gamma: 2.0 / dt,
            y: state(Part::Y),
            previous: state(Part::Previous),
            u: list(Part::Controls),
            b: list(Part::Design),
        }
    }

    /// The terms of Eq. (10) at q_i, v_i, σ_i, u_i.
    pub fn terms(&self) -> Terms {
        Terms::new(self.paper.system, &self.y, &self.u, &self.b, self.t)
    }

    /// The terms of Eq. (10) at q_{i−1}, v_{i−1}, σ_{i−1} and u_i.
    pub fn previous_terms(&self) -> Terms {
        Terms::new(self.paper.system, &self.previous, &self.u, &self.b, self.t - self.dt)
    }

    /// The terms of Eq. (10) at another state.
    ///
    /// # Panics
    /// If a part of the state has another length than in `y`.
    pub fn terms_at(&self, state: &State) -> Terms {
        Terms::new(self.paper.system, state, &self.u, &self.b, self.t)
    }
}

/// One kind of argument of f_i, in the order of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// A part of y_i.
    Y(Variable),
    /// A part of y_{i−1}.
    Previous(Variable),
    Controls,
    Design,
    /// The index i.
    Node,
    /// The factor 1 by which compared values are multiplied.
    One,
}

/// Positions of the arguments in the list.
#[derive(Clone, Copy)]
pub(super) struct Places<'a>(pub &'a PaperSystem<'a>);

impl Places<'_> {
    pub(super) fn len_of_y(&self) -> usize {
        4 * self.0.system.n() + self.0.system.m()
    }

    pub(super) fn of(&self, part: Part) -> Range<usize> {
        let system = self.0.system;
        let of_y = |variable: Variable, first: usize| {
            let Range { start, end } = paper_system::part(variable as usize, system.n(), system.m());
            first + start..first + end
        };
        let u = 2 * self.len_of_y();
        let (b, node) = (u + system.k(), u + system.k() + system.designs());
        match part {
            Part::Y(variable) => of_y(variable, 0),
            Part::Previous(variable) => of_y(variable, self.len_of_y()),
            Part::Controls => u..b,
            Part::Design => b..node,
            Part::Node => node..node + 1,
            Part::One => node + 1..node + 2,
        }
    }

    /// Arguments that may be moved; q_{i−1} and p*_{i−1} follow from Eq. (2).
    pub(super) fn free(&self) -> Vec<usize> {
        let y = [Variable::Q, Variable::V, Variable::Sigma].map(Part::Y);
        y.into_iter().chain([Part::Previous(Variable::V), Part::Controls]).flat_map(|part| self.of(part)).collect()
    }

    /// Satisfies Eq. (2) by changing q_{i−1} and p*_{i−1}.
    pub(super) fn settle(&self, x: &mut [f64]) {
        let h = 0.5 * self.0.inputs.grid.steps[x[self.of(Part::Node).start].round() as usize - 1];
        for (value, rate) in [(Variable::Q, Variable::V), (Variable::PStar, Variable::PStarDot)] {
            let at = |variable| [Part::Y(variable), Part::Previous(variable)].map(|part| self.of(part).start);
            let ([value, previous], [rate, previous_rate]) = (at(value), at(rate));
            for i in 0..self.0.system.n() {
                let sum = x[rate + i] + x[previous_rate + i];
                x[previous + i] = x[value + i] - h * sum;
            }
        }
    }

    /// Replaces some parts of y_i by those of y_{i−1}, and restores Eq. (2).
    pub(super) fn take_previous(&self, x: &mut [f64], which: &[Variable]) {
        for &variable in which {
            x.copy_within(self.of(Part::Previous(variable)), self.of(Part::Y(variable)).start);
        }
        self.settle(x);
    }

    /// A random state near that of the motion at a node, for which Eq. (2) holds.
    pub(super) fn near(&self, node: usize, magnitudes: &[f64], spread: f64, random: &mut Random) -> Vec<f64> {
        let paper = self.0;
        let (y, previous) = (paper.y(node), paper.y(node - 1));
        let u = column(&paper.inputs.controls, node);
        let lists = [y.as_slice(), previous.as_slice(), u, paper.inputs.design.as_slice(), &[node as f64, 1.0]];
        let mut x = lists.concat();
        for k in 0..self.of(Part::Design).start {
            x[k] += if spread == 0.0 { 0.0 } else { random.away_from_zero(spread * magnitudes[k]) };
        }
        self.settle(&mut x);
        x
    }
}

/// Size of each argument along the motion. If an argument is always zero, its size is that of its kind (made comparable by the masses if units
/// differ), or 1.
pub(super) fn magnitudes(paper: &PaperSystem) -> Vec<f64> {
    let nodes = paper.inputs.grid.nodes();
    let (motion, design) = (paper.trajectory, paper.system.parameters().values(paper.inputs.design.as_slice()));
    let start = motion.at((paper.inputs, &design), 0);
    let root = |x: f64| if x > 0.0 { x.sqrt() } else { 1.0 };
    let roots = mass_matrix(paper.system, &start).diagonal().map(root);
    let mut flexibilities = vec![0.0; paper.system.m()];
    paper.system.phi_q(&start).iter().for_each(|e| flexibilities[e.row] += (e.value / roots[e.col]).powi(2));
    let sized = |matrix: &nalgebra::DMatrix<f64>, unit: &dyn Fn(usize) -> f64| {
        let along = |row: usize| matrix.row(row).iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let largest = (0..matrix.nrows()).fold(0.0f64, |m, row| m.max(along(row) * unit(row)));
        let floor = |row: usize| if largest == 0.0 { 1.0 } else { 0.1 * largest / unit(row) };
        (0..matrix.nrows()).map(|row| along(row).max(floor(row))).collect::<Vec<f64>>()
    };
    let velocities = |matrix| sized(matrix, &|i| roots[i]);
    let momenta = |matrix| sized(matrix, &|i| 1.0 / roots[i]);
    let [v, q] = [&motion.v, &motion.q].map(velocities);
    let [p_star_dot, p_star] = [&motion.p_star_dot, &motion.p_star].map(momenta);
    let y = [v, p_star_dot, q, p_star, sized(&motion.sigma, &|j| root(flexibilities[j]))].concat();
    let design = paper.inputs.design.iter().map(|b| if *b == 0.0 { 1.0 } else { b.abs() }).collect();
    [y.clone(), y, sized(&paper.inputs.controls, &|_| 1.0), design, vec![nodes as f64, 1.0]].concat()
}

/// The name of each argument.
pub(super) fn names(paper: &PaperSystem, equations: &[String]) -> Vec<String> {
    let system = paper.system;
    let of = |variable: Variable, node: &str| -> Vec<String> {
        let symbol = format!("{}_{node}", variable.name());
        match variable {
            Variable::Sigma => equations.iter().map(|name| format!("{symbol} of {name}")).collect(),
            _ => (0..system.n()).map(|i| format!("{symbol} of `{}`", system.coordinate_name(i))).collect(),
        }
    };
    let y = |node: &str| Variable::ALL.map(|variable| of(variable, node)).concat();
    let controls = (0..system.k()).map(|k| format!("`{}`", system.control_name(k))).collect();
    let design = (0..system.designs()).map(|p| format!("`{}`", system.design_name(p))).collect();
    [y("i"), y("(i−1)"), controls, design, vec!["node".to_string(), String::new()]].concat()
}
