//! Motions in space beside references that were made without this library (`tests/data/space.json`).

mod loops;
mod tops;
mod trees;

use hamiltonian_adjoint::spatial::{Marker, MarkerFunction, MarkerPoint, Quantity, Spatial};
use hamiltonian_adjoint::{Coordinate, Error, Grid, Inputs, Scalar, Scene, Scheme, Settings, Solver, Start, Sum, System};
use nalgebra::Matrix3;
use serde_json::Value;

use crate::common::assert_order;

/// The references of one problem.
fn reference(problem: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("../data/space.json")).expect("a file of references");
    all[problem].clone()
}

/// All numbers in a value, row by row.
fn list(of: &Value) -> Vec<f64> {
    match of {
        Value::Array(rows) => rows.iter().flat_map(list).collect(),
        number => vec![number.as_f64().unwrap_or_else(|| panic!("{number} is not a number"))],
    }
}

fn array<const N: usize>(of: &Value) -> [f64; N] {
    list(of).try_into().expect("another length")
}

fn number(of: &Value) -> f64 {
    array::<1>(of)[0]
}

/// The numbers with these names, one list.
fn named(of: &Value, names: &[&str]) -> Vec<f64> {
    names.iter().flat_map(|name| list(&of[name])).collect()
}

/// The columns of a matrix, one after the other.
fn columns(of: &Value) -> Vec<f64> {
    Matrix3::from_row_slice(&list(of)).as_slice().to_vec()
}

/// The values at a time.
fn at(values: &Value, time: f64) -> &Value {
    let all = values.as_array().expect("values at some times");
    all.iter().find(|at| number(&at["t"]) == time).expect("values at this time")
}

/// Component k of the angular velocity along the axes of the marker.
struct OwnRate(usize);

impl MarkerFunction for OwnRate {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        let (axis, w) = (at.markers[0].axes[self.0], at.markers[0].angular_velocity);
        axis[0] * w[0] + axis[1] * w[1] + axis[2] * w[2]
    }
}

/// Adds outputs of the rotation matrix of a body, by columns, of its angular velocity in its own axes, and of the position of a marker of it.
fn attitude(scene: &mut Scene, marker: Marker) {
    for axis in [Quantity::XAxis, Quantity::YAxis, Quantity::ZAxis] {
        scene.spatial().outputs(&format!("{axis:?}"), axis, marker, Sum::Terminal);
    }
    for k in 0..3 {
        let output = scene.output(&format!("own rate {k}"));
        let mut space: Spatial = scene.spatial();
        space.term(output, &format!("own rate {k}"), OwnRate(k), Sum::Terminal, &[marker], &[], &[]);
    }
    scene.spatial().outputs("position", Quantity::Position, marker, Sum::Terminal);
}

/// Adds outputs of coordinates, and then of their rates.
fn ends(scene: &mut Scene, coordinates: &[Coordinate]) -> Vec<usize> {
    let ends: Vec<_> = coordinates.iter().map(|q| scene.end_state(*q)).collect();
    let all = ends.iter().map(|end| end.position).chain(ends.iter().map(|end| end.rate));
    all.map(|output| output.index()).collect()
}

/// Euler parameters of a rotation by less than a half turn.
fn euler(turn: &Matrix3<f64>) -> [f64; 4] {
    let e0 = 0.5 * (1.0 + turn.trace()).sqrt();
    let entry = |i: usize, j: usize| (turn[(i, j)] - turn[(j, i)]) / (4.0 * e0);
    [e0, entry(2, 1), entry(0, 2), entry(1, 0)]
}

/// Puts coordinates and rates of a start.
fn put(start: &mut Start, coordinates: &[Coordinate], values: &[f64], rates: &[f64]) {
    for (q, (value, rate)) in coordinates.iter().zip(values.iter().zip(rates)) {
        start.set_coordinate(*q, *value);
        start.set_rate(*q, *rate);
    }
}

fn at_rest(system: &System) -> Start {
    Inputs::at_rest(system, Grid::uniform(1, 1.0)).start
}

/// A motion and what the reference says of its end.
struct Case {
    name: String,
    system: System,
    start: Start,
    time: f64,
    /// The numbers of outputs and their values.
    outputs: Vec<usize>,
    truth: Vec<f64>,
    /// The number of each design variable, and the derivatives of the outputs by it.
    derivatives: Vec<(usize, Vec<f64>)>,
    settings: Settings,
}

impl Case {
    fn new(name: &str, system: System, start: Start, (time, truth): (f64, Vec<f64>)) -> Self {
        let outputs = (0..truth.len()).collect();
        let (name, derivatives, settings) = (name.into(), Vec::new(), Settings::default());
        Case { name, system, start, time, outputs, truth, derivatives, settings }
    }

    /// The largest error of a value, relative where it is larger than 1, and of a derivative relative to the largest one by the same variable.
    fn errors(&self, scheme: Scheme, steps: usize) -> Result<[f64; 2], Error> {
        let grid = Grid::uniform(steps, self.time / steps as f64);
        let inputs = Inputs { start: self.start.clone(), ..Inputs::at_rest(&self.system, grid) };
        let mut solver = Solver::new(&self.system, Settings { scheme, ..self.settings });
        solver.simulate(&inputs)?;
        let values = solver.outputs()?;
        let own = self.outputs.iter().map(|k| values[*k]);
        let of_values = own.zip(&self.truth).map(|(own, truth)| (own - truth).abs() / truth.abs().max(1.0));
        let mut errors = [of_values.fold(0.0, f64::max), 0.0];
        if !self.derivatives.is_empty() {
            let rows = solver.jacobian()?;
            for (design, truth) in &self.derivatives {
                let own: Vec<f64> = self.outputs.iter().map(|k| rows[*k].design[*design]).collect();
                errors[1] = errors[1].max(crate::common::relative_error(&own, truth));
            }
        }
        Ok(errors)
    }

    /// Asserts that the errors fall with the order of the scheme when steps are halved, from the second halving on.
    fn assert_order(&self, scheme: Scheme, steps: usize, within: f64) -> Result<(), Error> {
        let order = match scheme.name {
            name if name == Scheme::ESDIRK4.name => 4.0,
            name if name == Scheme::ESDIRK5.name => 5.0,
            _ => 2.0,
        };
        let errors = [1, 2, 4, 8].map(|more| self.errors(scheme, steps * more));
        let errors = errors.into_iter().collect::<Result<Vec<_>, _>>()?;
        for (which, of) in ["values", "derivatives"].into_iter().enumerate().take(1 + self.derivatives.len().min(1)) {
            let errors: Vec<f64> = errors.iter().map(|errors| errors[which]).collect();
            assert_order(&format!("{}, {}, {steps} steps, {of}", self.name, scheme.name), &errors, order, within);
        }
        Ok(())
    }

    /// Asserts the orders of the trapezoidal rule and of two others, each with a first number of steps.
    fn assert_orders(&self, [two, four, five]: [usize; 3]) -> Result<(), Error> {
        self.assert_order(Scheme::TRAPEZOIDAL, two, 0.15)?;
        self.assert_order(Scheme::ESDIRK4, four, 0.4)?;
        self.assert_order(Scheme::ESDIRK5, five, 0.5)
    }

    /// Asserts that the errors are small.
    fn assert_close(&self, scheme: Scheme, steps: usize, bound: f64) -> Result<(), Error> {
        let [values, derivatives] = self.errors(scheme, steps)?;
        println!("{}, {}, {steps} steps: values {values:.1e}, derivatives {derivatives:.1e}", self.name, scheme.name);
        assert!(values.max(derivatives) <= bound, "{}: {values:e}, {derivatives:e}", self.name);
        Ok(())
    }
}
