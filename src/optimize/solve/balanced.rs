//! The state at the end in which forces balance in the motions that the constraints there leave free: a load then hangs below its trolley, although
//! nothing is asked of its position.

use nalgebra::{DMatrix, DVector};

use super::super::problem::Interval;
use super::pose::{End, FOUND, Pose};
use super::reach::Reach;
use crate::solver::Asked;
use crate::{Coordinate, Mechanics};

/// Rates below this are zero, m/s or rad/s, and derivatives below this fraction of the largest one.
const ZERO: f64 = 1e-9;
/// Values that are asked for change by at most this in a part of the way, m or rad, with at most so many parts.
const SHORT: f64 = 0.25;
const MOST_PARTS: f64 = 40.0;

impl Pose {
    /// The state z at rest with the same coordinates of which outputs are functions, in a stable equilibrium without controls; `None` if z is not at rest,
    /// if an output depends on several coordinates, or if there is no such equilibrium.
    pub(super) fn balanced(&mut self, z: &[f64], time: f64, asked: &[(usize, Interval)]) -> Option<Vec<f64>> {
        let is_resting = z.iter().skip(1).step_by(2).all(|rate| rate.abs() <= ZERO);
        if !is_resting || !self.inputs.open.is_empty() {
            return None;
        }
        let [q, _] = self.at(z, time).ok()?;
        let held = self.determined(asked)?;
        if held.len() == self.states.len() {
            return None;
        }
        let (none, design) = (DVector::zeros(q.len()), self.inputs.design.clone());
        let system = self.segment.motion.solver.system();
        let here = Mechanics::new(system, q.as_slice(), none.as_slice()).ok()?.at_time(time).ok()?;
        let balanced = here.with_design(design.as_slice()).ok()?.settled(&held);
        let found = balanced.and_then(|state| {
            let mut z = DVector::from_vec(self.guess(&DVector::from_column_slice(state.q()), &none));
            let left = self.residuals(&mut z, time, asked)?;
            (left.amax() < FOUND).then(|| z.as_slice().to_vec())
        });
        if found.is_none() {
            self.guess(&q, &none);
        }
        found
    }

    /// The state in which outputs have given values that is reached from a start at rest if these values change slowly, and what is free stays in equilibrium;
    /// `None` if there is none.
    pub(super) fn carried(&mut self, start: [&DVector<f64>; 2], time: f64, asked: &[(usize, Interval)]) -> Option<End> {
        let mut at = self.guess(start[0], start[1]);
        let left = self.residuals(&mut DVector::from_column_slice(&at), time, asked)?;
        let parts = (left.amax() / SHORT).ceil().min(MOST_PARTS);
        let mut end = None;
        for part in 1..=parts as usize {
            let remaining = 1.0 - part as f64 / parts;
            let shifted = |to: Interval, by: f64| Interval::new(to.least + by, to.most + by);
            let part = asked.iter().zip(&left).map(|(&(output, to), left)| (output, shifted(to, remaining * left)));
            let part: Vec<(usize, Interval)> = part.collect();
            let here = self.newton(&at, time, &part);
            if here.reach != Reach::Found {
                return None;
            }
            at = self.balanced(&here.z, time, &part)?;
            end = Some(End { z: at.clone(), ..here });
        }
        end
    }

    /// The independent coordinates that outputs with given values determine at the current point; `None` if such an output depends on several ones.
    fn determined(&mut self, asked: &[(usize, Interval)]) -> Option<Vec<Coordinate>> {
        let given = asked.iter().filter(|(_, to)| to.is_equality());
        let outputs: Vec<Asked> = given.map(|(output, _)| Asked::Output(*output)).collect();
        let mut jacobian = DMatrix::zeros(outputs.len(), 2 * self.states.len());
        self.segment.jacobian(&outputs, &mut jacobian).ok()?;
        let mut held = Vec::new();
        for row in jacobian.row_iter() {
            let of_coordinates = |i: &usize| row[2 * i].abs() > ZERO * row.amax();
            let known: Vec<usize> = (0..self.states.len()).filter(of_coordinates).collect();
            match known[..] {
                [] => {}
                [i] if held.contains(&self.states[i]) => {}
                [i] => held.push(self.states[i]),
                _ => return None,
            }
        }
        Some(held)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Guess;
    use super::super::guess::Line;
    use super::super::reach::Reach;
    use crate::optimize::{Free, Interval, MotionProblem, Variables};
    use crate::planar::Body;
    use crate::{Grid, Inputs, Scene, Settings};

    /// The rope is shorter than the way of the trolley: no state has the trolley at its place and the load where it was.
    #[test]
    fn the_load_of_a_crane_hangs_below_the_trolley_at_the_end() {
        let mut scene = Scene::new();
        scene.gravity(0.0, -9.81);
        let (trolley, load) = (scene.body("trolley", 1.0, 0.1, [0.0; 3]), scene.particle("load", 0.3, [0.0, -0.5]));
        scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), 0.0);
        scene.distance("rope", trolley.at(0.0, 0.0), load.point(), 0.5);
        let force = scene.control("force");
        scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, trolley.at(0.0, 0.0), force);
        let place = scene.end_state(trolley.coordinates[0]);
        let system = scene.compile().expect("a scene");
        let inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1));
        let variables = Variables::new(&system, &inputs, vec![Free::control(force)]).expect("it fits");
        let mut problem = MotionProblem::new(&system, Settings::default(), inputs, variables).expect("they fit");
        problem.constrain(place.position, Interval::equal(3.0));
        problem.constrain(place.rate, Interval::ZERO);
        let line = Line::new(&problem, &Guess::Straight, 0).expect("a consistent start");
        assert_eq!(line.reach, Reach::Found);
        let [x, y] = load.coordinates.map(|of| line.q[(of.index(), 10)]);
        assert!((x - 3.0).abs() < 1e-6 && (y + 0.5).abs() < 1e-6, "{x} {y}");
    }
}
