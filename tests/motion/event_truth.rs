//! Motions with located events beside references that were made without this library (`tests/data/events.json`).

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Cost, CostPoint, Design, Error, Force, ForcePoint, Gradient, Grid, Inputs, Param, Scalar, Scene, Scheme, Settings,
    Solver, Start, Sum, System,
};
use nalgebra::SVector;

use crate::common::numbers;

pub const TRUTH: &str = include_str!("../data/events.json");

/// q, or v.
pub struct Value {
    pub is_rate: bool,
}

impl Cost<1, 0, 0, 0> for Value {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, _b: &SVector<S, 0>) -> S {
        if self.is_rate { at.v[0] } else { at.q[0] }
    }
}

/// A motion and what the reference says of it.
pub struct Case {
    pub system: System,
    pub start: Start,
    /// The numbers of the design variables and, behind them, of the coordinates of the start, in the order of the derivatives.
    pub designs: Vec<usize>,
    pub coordinates: Vec<usize>,
    /// For each output, its value and its derivatives.
    pub truth: Vec<f64>,
    /// Lengths of the phases, and whether their steps are graded.
    pub phases: Vec<(f64, bool)>,
    /// The events at the ends of phases, and the numbers of steps of length zero that follow them.
    pub events: Vec<(usize, usize)>,
}

impl Case {
    /// Errors of values and of derivatives, relative to their norms over all outputs.
    pub fn errors(&self, scheme: Scheme, steps: &[usize]) -> Result<[f64; 2], Error> {
        let (mut grid, mut events) = (Grid::uniform(0, 0.0), Vec::new());
        for (k, (&(length, graded), &steps)) in self.phases.iter().zip(steps).enumerate() {
            let own = if graded { Grid::graded(steps, length) } else { Grid::uniform(steps, length / steps as f64) };
            grid = grid.then(&own);
            if let Some(&(event, zeros)) = self.events.get(k) {
                events.push(self.system.event(event).at(grid.steps.len()));
                grid = grid.then(&Grid::uniform(zeros, 0.0));
            }
        }
        let inputs = Inputs { start: self.start.clone(), events, ..Inputs::at_rest(&self.system, grid) };
        let mut solver = Solver::new(&self.system, Settings { scheme, ..Settings::default() });
        solver.simulate(&inputs)?;
        let values = solver.outputs()?;
        let rows = solver.jacobian()?;
        let derivatives = |row: &Gradient| -> Vec<f64> {
            let of_start = self.coordinates.iter().map(|&i| row.start.q()[i]);
            self.designs.iter().map(|&p| row.design[p]).chain(of_start).collect()
        };
        let each = 1 + self.designs.len() + self.coordinates.len();
        let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
        for (k, truth) in self.truth.chunks(each).enumerate() {
            let of_value = (values[k] - truth[0], truth[0]);
            // Derivatives by a stiffness are small: each counts with its own size.
            let of_rows = derivatives(&rows[k]).into_iter().zip(&truth[1..]).map(|(own, truth)| (own - truth, *truth));
            sums[0] += of_value.0.powi(2);
            sizes[0] += of_value.1.powi(2);
            for (error, truth) in of_rows {
                sums[1] += (error / truth.abs().max(1e-5)).powi(2);
                sizes[1] += 1.0;
            }
        }
        Ok([0, 1].map(|k| (sums[k] / sizes[k]).sqrt()))
    }

    pub fn assert_orders(&self, name: &str, scheme: Scheme, order: f64, steps: &[&[usize]]) -> Result<(), Error> {
        let errors = steps.iter().map(|steps| self.errors(scheme, steps)).collect::<Result<Vec<_>, _>>()?;
        for (which, of) in ["values", "derivatives"].into_iter().enumerate() {
            let errors: Vec<f64> = errors.iter().map(|errors| errors[which]).collect();
            let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
            println!("{name}, {}: {of}: {errors:?}, orders {orders:.2?}", scheme.name);
            // Small errors of opposite signs raise the order at first.
            assert!(orders[1..].iter().all(|found| *found > order - 0.35), "{name}, {}: {of}", scheme.name);
        }
        Ok(())
    }
}

/// The floor under the height q.
struct Floor(f64);

impl Force<1, 0, 1> for Floor {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 0>, b: &SVector<S, 1>) -> SVector<S, 1> {
        SVector::from([b[0] * (-at.q[0]).max(S::zero()).powf(self.0)])
    }
}

/// A ball of 1 kg falls from 1 m on a floor with the force K δ^E.
fn ball(name: &str, stiffness: f64, exponent: f64) -> Case {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let stiffness = scene.design("stiffness", stiffness);
    let mass = scene.design("mass", 1.0);
    let z = [scene.particle("ball", mass, [0.0, 1.0]).coordinates[1]];
    scene.force("floor", Floor(exponent), z, [], [stiffness.into()]);
    scene.event("contact", Value { is_rate: false }, z, [], [], []);
    for k in 0..2 {
        scene.event_time(&format!("event {k}"), k);
    }
    for (name, is_rate) in [("z", false), ("v", true)] {
        let output = scene.output(name);
        scene.term(output, name, Value { is_rate }, Sum::Terminal, z, [], [], []);
    }
    let system = scene.compile().expect("a scene");
    // The reference has the derivatives by the height first.
    let given = numbers(TRUTH, name);
    let truth = given.chunks(4).flat_map(|row| [row[0], row[2], row[3], row[1]]).collect();
    let [touch, lift] = [given[0], given[4]];
    let start = Inputs::at_rest(&system, Grid::uniform(1, 1.0)).start;
    let phases = vec![(touch, false), (lift - touch, exponent != 1.0), (0.8 - lift, false)];
    Case { system, start, designs: vec![0, 1], coordinates: vec![1], truth, phases, events: vec![(0, 0); 2] }
}

#[test]
fn a_ball_on_an_elastic_floor() -> Result<(), Error> {
    // Free fall is exact, so that only the contact has errors.
    let steps = |all: [usize; 4]| all.map(|inside| [4, inside, 4]);
    let (coarse, fine) = (steps([12, 24, 48, 96]), steps([8, 16, 32, 64]));
    let list = |all: &'static [[usize; 3]]| all.iter().map(|steps| &steps[..]).collect::<Vec<_>>();
    let [coarse, fine] = [coarse, fine].map(|all| list(Box::leak(Box::new(all))));
    for (name, stiffness, exponent) in
        [("A1", 1e4, 1.0), ("A2", 1e6, 1.0), ("A3", 1e4, 1.5), ("A4", 1e6, 1.5), ("A5", 1e8, 1.5)]
    {
        let case = ball(name, stiffness, exponent);
        case.assert_orders(name, Scheme::TRAPEZOIDAL, 2.0, &coarse)?;
        case.assert_orders(name, Scheme::ESDIRK4, 4.0, &fine)?;
    }
    Ok(())
}

/// The distance of the tip of the outer rod from the wall at b, positive before the wall.
fn distance<S: Scalar>(q: [S; 2], b: S) -> S {
    q[0] + q[1].sin() * 0.4 - b
}

/// A spring between the tip and the wall, which only pushes.
struct Wall;

impl Force<2, 0, 2> for Wall {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 2, 0>, b: &SVector<S, 2>) -> SVector<S, 2> {
        let push = b[1] * (-distance(at.q.into(), b[0])).max(S::zero());
        SVector::from([push, push * at.q[1].cos() * 0.4])
    }
}

struct Distance;

impl Cost<2, 0, 0, 1> for Distance {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, b: &SVector<S, 1>) -> S {
        distance(at.q.into(), b[0])
    }
}

/// The place of the tip.
struct Tip(usize);

impl Cost<3, 0, 0, 0> for Tip {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 3, 0, 0>, _b: &SVector<S, 0>) -> S {
        if self.0 == 0 { at.q[0] + at.q[2].sin() * 0.4 } else { at.q[1] - at.q[2].cos() * 0.4 }
    }
}

/// Two rods in absolute coordinates, with angles from the lower vertical.
pub fn rods(scene: &mut Scene, mass: Design) -> [Body; 2] {
    let (a, b): (f64, f64) = (1.8, 0.1);
    let [elbow_x, elbow_y] = [a.sin(), -a.cos()];
    let inner = scene.body("inner", 1.0, 1.0 / 12.0, [0.5 * elbow_x, 0.5 * elbow_y, a]);
    let inertia = Param::from(mass) * (0.64 / 12.0);
    let outer = scene.body("outer", mass, inertia, [elbow_x + 0.4 * b.sin(), elbow_y - 0.4 * b.cos(), b]);
    scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), inner.at(0.0, 0.5));
    scene.revolute("elbow", inner.at(0.0, -0.5), outer.at(0.0, 0.4));
    [inner, outer]
}

/// Outputs of both angles, their rates and the place of the tip at the end.
pub fn ends(scene: &mut Scene, [inner, outer]: [Body; 2]) {
    let [x, y, angle] = outer.coordinates;
    for (name, q, is_rate) in
        [("a1", inner.coordinates[2], false), ("a2", angle, false), ("w1", inner.coordinates[2], true), ("w2", angle, true)]
    {
        let output = scene.output(name);
        scene.term(output, name, Value { is_rate }, Sum::Terminal, [q], [], [], []);
    }
    for (k, name) in ["tip x", "tip y"].into_iter().enumerate() {
        let output = scene.output(name);
        scene.term(output, name, Tip(k), Sum::Terminal, [x, y, angle], [], [], []);
    }
}

/// Two rods in absolute coordinates, with angles from the lower vertical; the tip hits an elastic wall and leaves it.
fn double_pendulum() -> Case {
    let mut scene = Scene::new();
    let mass = scene.design("mass", 0.7);
    let wall = scene.design("wall", -0.85);
    let gravity = scene.design("gravity", 9.81);
    let stiffness = scene.design("stiffness", 2e5);
    scene.gravity(0.0, -Param::from(gravity));
    let [inner, outer] = rods(&mut scene, mass);
    let [x, _, angle] = outer.coordinates;
    scene.force("wall", Wall, [x, angle], [], [wall.into(), stiffness.into()]);
    scene.event("contact", Distance, [x, angle], [], [], [wall.into()]);
    for k in 0..2 {
        scene.event_time(&format!("event {k}"), k);
    }
    ends(&mut scene, [inner, outer]);
    let system = scene.compile().expect("a scene");
    let start = Start::assembled(&system).hold(&[inner.coordinates[2], angle]);
    // The reference has the derivatives by the mass, the wall, gravity, both angles and the stiffness.
    let given = numbers(TRUTH, "C2");
    let order = [0, 1, 2, 3, 6, 4, 5];
    let truth = given.chunks(7).flat_map(|row| order.map(|k| row[k])).collect();
    let [touch, lift] = [given[0], given[7]];
    let phases = vec![(touch, false), (lift - touch, false), (1.08 - lift, false)];
    let coordinates = vec![inner.coordinates[2].index(), angle.index()];
    Case { system, start, designs: vec![0, 1, 2, 3], coordinates, truth, phases, events: vec![(0, 0); 2] }
}

#[test]
fn a_double_pendulum_whose_tip_hits_an_elastic_wall() -> Result<(), Error> {
    let case = double_pendulum();
    let coarse: [&[usize]; 3] = [&[400, 40, 200], &[800, 80, 400], &[1600, 160, 800]];
    let fine: [&[usize]; 3] = [&[50, 8, 25], &[100, 16, 50], &[200, 32, 100]];
    case.assert_orders("C2", Scheme::TRAPEZOIDAL, 2.0, &coarse)?;
    case.assert_orders("C2", Scheme::ESDIRK4, 4.0, &fine)
}

#[test]
fn events_are_located_in_a_few_passes() -> Result<(), Error> {
    let case = double_pendulum();
    let steps = [300, 30, 120];
    // Guesses that are off by a tenth, and those that were found.
    let lengths = [0.85, 0.003, 0.227];
    let grids = steps.iter().zip(lengths).map(|(&steps, length)| Grid::uniform(steps, length / steps as f64));
    let grid = grids.reduce(|all, next| all.then(&next)).expect("a phase");
    let mut inputs = Inputs { start: case.start.clone(), ..Inputs::at_rest(&case.system, grid) };
    inputs.events = vec![case.system.event(0).at(300), case.system.event(0).at(330)];
    let mut solver = Solver::new(&case.system, Settings::default());
    let mut work = |inputs: &Inputs| -> Result<(usize, Inputs), Error> {
        solver.simulate(inputs)?;
        Ok((solver.report().newton_iterations, solver.inputs().clone()))
    };
    let (located, found) = work(&inputs)?;
    let (again, _) = work(&found)?;
    let scene_without = Inputs { events: Vec::new(), ..found };
    // Outputs at events are read from motions with events only.
    assert!(work(&scene_without).is_err());
    println!("Newton iterations: {located} from a guess, {again} from what was found");
    assert!(located <= 8 * again, "{located} and {again}");
    Ok(())
}
