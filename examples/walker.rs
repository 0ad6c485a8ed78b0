//! A walker of two straight legs (the compass gait of Goswami, Thuilot and Espiau 1998) that walks down a slope without motors: its periodic gait, the
//! stability of the gait, and its derivative by the slope.
//!
//! One step begins after a heel strike. At the next one, an event, the rear foot is released and the front foot sticks where it lands, an impact that
//! takes energy away. A gait is a start with which, after the strike, each leg has the angle and the rate that the other had at the start.
//!
//! `cargo run --release --example walker`

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};

use hamiltonian_adjoint::optimize::{
    Free, MotionProblem, Options, Problem, Quantity, Variables, levenberg_marquardt, silent,
};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{
    Coordinate, Cost, CostPoint, Design, Event, Grid, Inputs, Output, Scalar, Scene, Scheme, Settings, Start, Sum, System,
};
use nalgebra::{DMatrix, DVector, SVector};

/// Mass of a leg and of the hip, kg; length of a leg, m. The mass of a leg is in its middle.
const LEG: f64 = 5.0;
const HIP: f64 = 10.0;
const LENGTH: f64 = 1.0;
/// Number of time steps, and the guess of their duration, s.
const STEPS: usize = 40;
const DURATION: f64 = 0.73;

/// The gait on a slope of 3° in minimal coordinates by SciPy, made without this library: angles from the vertical and rates.
const INDEPENDENT: [f64; 4] = [0.2186688, -0.3233886, -1.0923836, -0.3773740];

/// φ_a + φ_b − π + 2 γ, zero if both feet are on the slope γ = b₀; φ is the angle of a leg from its foot to the hip.
struct BothFeetDown;

impl Cost<2, 0, 0, 1> for BothFeetDown {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] + at.q[1] - PI + b[0] * 2.0
    }
}

/// φ_a − φ_b: the legs pass each other. Before this event, both feet are on the slope at the start.
struct Apart;

impl Cost<2> for Apart {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 2, 0, 0>, _b: &SVector<S, 0>) -> S {
        at.q[0] - at.q[1]
    }
}

/// b₀ φ.
struct Angle;

impl Cost<1, 0, 0, 1> for Angle {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.q[0] * b[0]
    }
}

/// b₀ φ̇.
struct Rate;

impl Cost<1, 0, 0, 1> for Rate {
    fn cost<S: Scalar>(&self, at: &CostPoint<S, 1, 0, 0>, b: &SVector<S, 1>) -> S {
        at.v[0] * b[0]
    }
}

struct Walker {
    system: System,
    /// Angles of the leg that stands first, and of the other one.
    angles: [Coordinate; 2],
    slope: Design,
    events: [Event; 2],
    /// The angle and the rate of each leg after the strike minus those of the other leg at the start.
    changes: Vec<Output>,
}

fn walker() -> Result<Walker, Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let slope = scene.design("slope", 0.0);
    // The hip is above the first foot at x = y = 0, for the assembly alone.
    let [first, second] = ["first leg", "second leg"].map(|name| scene.body(name, LEG, 0.0, [0.0, 0.5 * LENGTH, FRAC_PI_2]));
    let hip = scene.particle("hip", HIP, [0.0, LENGTH]);
    let ([foot, other_foot], half) = ([first, second].map(|leg| leg.at(-0.5 * LENGTH, 0.0)), 0.5 * LENGTH);
    let pin = scene.revolute("first foot", Body::GROUND.at(0.0, 0.0), foot);
    scene.revolute("first hip", hip.point(), first.at(half, 0.0));
    scene.revolute("second hip", hip.point(), second.at(half, 0.0));
    let angles = [first, second].map(|leg| leg.coordinates[2]);
    let passing = scene.event("passing", Apart, angles, [], [], []);
    let strike = scene.event("heel strike", BothFeetDown, angles, [], [], [slope.into()]);
    let sticks = [0.0, FRAC_PI_2].map(|direction| {
        let name = format!("second foot, {direction:.0}");
        scene.rigid_contact(&name, Body::GROUND.at(0.0, 0.0), direction, other_foot).equation
    });
    scene.open_at(strike, &pin);
    scene.hold_at(strike, &sticks);
    let mut changes = Vec::new();
    for (after, before) in [(1, 0), (0, 1)] {
        for is_rate in [false, true] {
            let name = format!("{} of leg {}", if is_rate { "rate" } else { "angle" }, after + 1);
            let output = scene.output(&name);
            for (sum, leg, factor) in [(Sum::AfterEvent(1), after, 1.0), (Sum::Node(0), before, -1.0)] {
                let (name, b) = (format!("{name}, leg {}", leg + 1), [factor.into()]);
                if is_rate {
                    scene.term(output, &name, Rate, sum, [angles[leg]], [], [], b);
                } else {
                    scene.term(output, &name, Angle, sum, [angles[leg]], [], [], b);
                }
            }
            changes.push(output);
        }
    }
    Ok(Walker { system: scene.compile()?, angles, slope, events: [passing, strike], changes })
}

impl Walker {
    /// The problem of one step on a slope from a start (φ_1, φ_2, φ̇_1, φ̇_2), with the start and the slope as variables.
    fn problem(&self, slope: f64, start: [f64; 4]) -> Result<MotionProblem, Box<dyn Error>> {
        let grid = Grid::uniform(STEPS, DURATION / STEPS as f64).then(&Grid::new(0.0, vec![0.0]));
        let mut inputs = Inputs::at_rest(&self.system, grid);
        inputs.design[self.slope.index()] = slope;
        inputs.start = Start::assembled(&self.system).hold(&self.angles);
        for (k, angle) in self.angles.into_iter().enumerate() {
            inputs.start.set_coordinate(angle, start[k]);
            inputs.start.set_rate(angle, start[2 + k]);
        }
        inputs.events = vec![self.events[0].at(STEPS / 2), self.events[1].at(STEPS)];
        let of_start = self.angles.map(|angle| Free::new(Quantity::Coordinate(angle)));
        let rates = self.angles.map(|angle| Free::new(Quantity::Rate(angle)));
        let free: Vec<Free> =
            of_start.into_iter().chain(rates).chain([Free::design(self.slope).within(slope, slope)]).collect();
        let variables = Variables::new(&self.system, &inputs, free)?;
        let settings = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
        Ok(MotionProblem::new(&self.system, settings, inputs, variables)?)
    }

    /// The gait near a start on a slope.
    fn gait(&self, slope: f64, near: [f64; 4]) -> Result<(MotionProblem, [f64; 4]), Box<dyn Error>> {
        let mut problem = self.problem(slope, near)?;
        let start = problem.start();
        let options = Options { target: Some(1e-22), ..Options::default() };
        let found = levenberg_marquardt(&mut problem, &start, &options, &mut silent)?.outcome;
        if !found.reason.is_converged() || found.value > 1e-18 {
            return Err(format!("no gait on a slope of {slope}: {found}").into());
        }
        Ok((problem, std::array::from_fn(|k| found.x[k])))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let walker = walker()?;
    let slope = 3f64.to_radians();
    // A guess: the stance leg leans back and turns forward.
    let near = [FRAC_PI_2 + 0.22, FRAC_PI_2 - 0.32, -1.1, -0.4];
    let (mut problem, gait) = walker.gait(slope, near)?;
    let [stance, swing, stance_rate, swing_rate] = gait;
    let duration: f64 = problem.solver.trajectory().times[STEPS];
    println!("gait on a slope of 3°: legs at {:.4} and {:.4} rad from the vertical,", stance - FRAC_PI_2, swing - FRAC_PI_2);
    let from_vertical = [stance - FRAC_PI_2, swing - FRAC_PI_2, stance_rate, swing_rate];
    assert!(from_vertical.iter().zip(INDEPENDENT).all(|(ours, independent)| (ours - independent).abs() < 1e-5));
    println!("  rates {stance_rate:.4} and {swing_rate:.4} rad/s, one step takes {duration:.4} s");

    // r(x, γ) = P(x, γ) − x: the derivatives of the map P from step to step, and dx/dγ = −r_x⁻¹ r_γ.
    let rows: Vec<usize> = walker.changes.iter().map(|output| output.index()).collect();
    let mut jacobian = DMatrix::zeros(4, 5);
    problem.jacobian(&rows, &mut jacobian)?;
    // Rows are angle and rate of the second, then of the first leg; after the step, the second leg is the first.
    let rows = [0, 2, 1, 3].map(|row| jacobian.row(row).into_owned());
    let r = DMatrix::from_rows(&rows);
    let map = r.columns(0, 4) + DMatrix::identity(4, 4);
    let factors: Vec<f64> = map.complex_eigenvalues().iter().map(|z| z.norm()).collect();
    println!("deviations are multiplied by {factors:.3?} with each step");
    let by_slope: DVector<f64> = -r.columns(0, 4).into_owned().lu().solve(&r.column(4)).ok_or("no isolated gait")?;
    let [more, less] = [1e-4, -1e-4].map(|by| walker.gait(slope + by, gait).map(|(_, gait)| gait));
    let (more, less) = (more?, less?);
    println!("{:>12} {:>14} {:>14}", "d/d slope", "exact", "difference");
    for (k, name) in ["φ_1", "φ_2", "rate of φ_1", "rate of φ_2"].into_iter().enumerate() {
        let difference = (more[k] - less[k]) / 2e-4;
        println!("{name:>12} {:>14.7} {difference:>14.7}", by_slope[k]);
        assert!((by_slope[k] - difference).abs() < 1e-4 * difference.abs().max(1.0));
    }
    assert!(factors.iter().all(|factor| *factor < 1.0));
    Ok(())
}
