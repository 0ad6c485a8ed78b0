//! [`Report`] and [`Trajectory`] to JSON, and trajectories from JSON.

use std::collections::HashSet;
use std::ops::Range;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::inputs::{controls, coordinates};
use super::names::Named;
use crate::{Compliance, Error, Report, Scheme, States, System, Trajectory};

const FORMAT: &str = "hamiltonian-adjoint trajectory";
const VERSION: u32 = 2;
const KIND: &str = "trajectory";

impl Report {
    /// The report as JSON, with the warnings as text.
    pub fn to_json(&self) -> String {
        let warnings: Vec<String> = self.warnings.iter().map(ToString::to_string).collect();
        let report = json!({
            "format": "hamiltonian-adjoint report",
            "version": 1,
            "newton_iterations": self.newton_iterations,
            "most_iterations": self.most_iterations,
            "factorisations": self.factorisations,
            "reused_factors": self.reused_factors,
            "refined_solutions": self.refined_solutions,
            "element_evaluations": self.element_evaluations,
            "second_derivatives": self.second_derivatives,
            "sine_evaluations": self.sine_evaluations,
            "input_evaluations": self.input_evaluations,
            "chord_evaluations": self.chord_evaluations,
            "cost_evaluations": self.cost_evaluations,
            "worst_pivot": self.worst_pivot,
            "adjoint_growth": self.adjoint_growth,
            "restarts": self.restarts,
            "warnings": warnings,
        });
        format!("{report:#}")
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    scheme: String,
    nodes: Lists,
    /// The states between nodes, if the scheme has any.
    stages: Lists,
    /// Nodes from which compliances apply, and the equations with their compliances.
    compliance: Vec<(usize, Vec<(usize, f64)>)>,
    inserted: Vec<usize>,
    restarted: Vec<usize>,
}

/// Values of each quantity at all times.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Lists {
    /// Times, s.
    t: Vec<f64>,
    q: Named<Vec<f64>>,
    v: Named<Vec<f64>>,
    p_star: Named<Vec<f64>>,
    p_star_dot: Named<Vec<f64>>,
    sigma: Named<Vec<f64>>,
    /// Controls, only for stages.
    u: Named<Vec<f64>>,
}

fn equations(system: &System) -> impl Iterator<Item = &str> {
    (0..system.m()).map(|j| system.equation_name(j))
}

impl Trajectory {
    /// The motion as JSON: all numbers of the computed nodes, under their names and to the last bit.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Grid, Inputs, Settings, Trajectory, scenes::CartPendulum, simulate};
    ///
    /// let system = CartPendulum::default().scene().compile()?;
    /// let motion = simulate(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.01)), Settings::default())?;
    /// assert_eq!(Trajectory::from_json(&system, &motion.to_json(&system)?)?, motion);
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// For a user-defined scheme, only the name is written, and [`from_json`](Self::from_json) returns an error for it.
    ///
    /// # Errors
    /// A motion of another system.
    pub fn to_json(&self, system: &System) -> Result<String, Error> {
        let sizes = [("q: rows", system.n(), self.q.nrows()), ("σ: rows", system.m(), self.sigma.nrows())];
        if let Some((what, expected, found)) = sizes.into_iter().find(|(_, expected, found)| expected != found) {
            return Err(Error::Size { what, expected, found });
        }
        let computed = self.computed.min(self.times.len());
        let written = |nodes: &[usize]| nodes.iter().copied().filter(|node| *node < computed).collect();
        let known = self.compliance.iter().filter(|part| part.from < computed);
        let inner = (computed * self.scheme.inner()).min(self.stages.times.len());
        let lists = |states: &States, count: usize| {
            let rows = |part: &DMatrix<f64>| -> Vec<Vec<f64>> {
                part.row_iter().map(|row| row.iter().take(count).copied().collect()).collect()
            };
            let of = |part| Named::new(coordinates(system), rows(part).into_iter());
            Lists {
                t: states.times[..count].to_vec(),
                q: of(&states.q),
                v: of(&states.v),
                p_star: of(&states.p_star),
                p_star_dot: of(&states.p_star_dot),
                sigma: Named::new(equations(system), rows(&states.sigma).into_iter()),
                u: Named::new(controls(system), rows(&states.u).into_iter()),
            }
        };
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            scheme: self.scheme.name.into(),
            nodes: lists(&self.nodes, computed),
            stages: lists(&self.stages, inner),
            compliance: known.map(|part| (part.from, part.equations.clone())).collect(),
            inserted: written(&self.inserted),
            restarted: written(&self.restarted),
        };
        serde_json::to_string(&file).map_err(|error| wrong("the whole file", &error.to_string()))
    }

    /// Reads a motion from JSON as [`to_json`](Self::to_json) writes it.
    ///
    /// # Errors
    /// A malformed file (with line and column), missing or unknown names, lists of different lengths, a scheme that is not in
    /// [`Scheme::ALL`], or nodes and equations that do not exist or are out of order.
    pub fn from_json(system: &System, json: &str) -> Result<Self, Error> {
        let file: File = super::read_json(KIND, json)?;
        super::check_format(KIND, (&file.format, file.version), (FORMAT, VERSION))?;
        let scheme = Scheme::ALL.into_iter().find(|scheme| scheme.name == file.scheme);
        let scheme = scheme.ok_or_else(|| wrong("`scheme`", &format!("there is no scheme `{}`", file.scheme)))?;
        let (nodes, inner) = (file.nodes.t.len(), file.stages.t.len());
        if inner != nodes * scheme.inner() {
            let expected = nodes * scheme.inner();
            return Err(wrong("`stages`", &format!("{inner} times, but this scheme has {expected} for {nodes} nodes")));
        }
        let node_states = file.nodes.read("nodes", system, 0)?;
        let stages = match inner {
            0 => Trajectory::zeros(system, 0, scheme).stages,
            _ => file.stages.read("stages", system, system.k())?,
        };
        let from: Vec<usize> = file.compliance.iter().map(|(from, _)| *from).collect();
        check_nodes("`inserted`", &file.inserted, 1..nodes)?;
        check_nodes("`restarted`", &file.restarted, 1..nodes)?;
        check_nodes("`compliance`", &from, 0..nodes)?;
        file.compliance.iter().try_for_each(|(_, equations)| check_equations(equations, system.m()))?;
        let (inserted, restarted) = (file.inserted, file.restarted);
        let compliance = file.compliance.into_iter().map(|(from, equations)| Compliance { from, equations }).collect();
        Ok(Trajectory { computed: nodes, nodes: node_states, compliance, inserted, scheme, stages, restarted })
    }
}

impl Lists {
    /// The states of nodes or stages that have `k` controls.
    fn read(self, part: &str, system: &System, k: usize) -> Result<States, Error> {
        let t = self.t;
        let matrix = |name: &str, rows: Vec<Vec<f64>>| {
            let place = format!("`{part}.{name}`");
            match rows.iter().find(|row| row.len() != t.len()) {
                Some(row) => Err(wrong(&place, &format!("{} numbers for {} times", row.len(), t.len()))),
                None => Ok(DMatrix::from_fn(rows.len(), t.len(), |i, column| rows[i][column])),
            }
        };
        let of = |name: &str, list: Named<Vec<f64>>| matrix(name, list.in_order(KIND, name, coordinates(system))?);
        let matrices = [
            of("q", self.q)?,
            of("v", self.v)?,
            of("p_star", self.p_star)?,
            of("p_star_dot", self.p_star_dot)?,
            matrix("sigma", self.sigma.in_order(KIND, "sigma", equations(system))?)?,
            matrix("u", self.u.in_order(KIND, "u", controls(system).take(k))?)?,
        ];
        Ok(States::new(t, matrices))
    }
}

/// Returns an error unless the nodes ascend and lie within a range.
fn check_nodes(place: &str, nodes: &[usize], range: Range<usize>) -> Result<(), Error> {
    if let Some(node) = nodes.iter().find(|node| !range.contains(node)) {
        let which = if *node < range.start { "the first one, which is not allowed here" } else { "beyond the last one" };
        return Err(wrong(place, &format!("node {node} is {which}")));
    }
    match nodes.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(wrong(place, &format!("node {} follows node {}; nodes must ascend", pair[1], pair[0]))),
        None => Ok(()),
    }
}

/// Returns an error for compliances that are negative (they would feed energy to a motion), or of missing or repeated equations.
fn check_equations(equations: &[(usize, f64)], m: usize) -> Result<(), Error> {
    let mut seen = HashSet::new();
    for &(j, mu) in equations {
        let problem = if j >= m {
            "is beyond the last one".to_string()
        } else if !seen.insert(j) {
            "occurs twice".to_string()
        } else if mu < 0.0 {
            format!("has the compliance {mu}, which must not be negative")
        } else {
            continue;
        };
        return Err(wrong("`compliance`", &format!("equation {j} {problem}")));
    }
    Ok(())
}

fn wrong(place: &str, problem: &str) -> Error {
    Error::File { kind: KIND, place: place.to_string(), problem: problem.to_string() }
}
