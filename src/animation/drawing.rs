//! User-defined shapes of an animation: lines through moving points, and fixed walls, obstacles and targets.

use super::Animation;
use super::figure::MarkKind;
use crate::Error;

impl Animation {
    /// Draws a line through points (x, y), m, that are a function of the coordinates q and the time t, s; a single point is drawn as a disc.
    ///
    /// ```
    /// use hamiltonian_adjoint::{Animation, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver};
    /// use nalgebra::SVector;
    ///
    /// /// T = ½ φ̇².
    /// struct Turning;
    /// impl KineticEnergy<1> for Turning {
    ///     fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, _b: &SVector<S, 0>) -> S {
    ///         v[0] * v[0] * 0.5
    ///     }
    /// }
    ///
    /// let mut scene = Scene::new();
    /// let [angle] = scene.coordinates("arm", ["φ"]);
    /// scene.kinetic_energy("arm", Turning, [angle], []);
    /// let system = scene.compile()?;
    /// let mut solver = Solver::new(&system, Settings::default());
    /// let motion = solver.simulate(&Inputs::at_rest(&system, Grid::uniform(10, 0.1)))?.clone();
    /// let animation = Animation::new(&system, solver.inputs(), &motion)?
    ///     .line("arm", |q, _t| vec![[0.0, 0.0], [q[0].cos(), q[0].sin()]])?
    ///     .obstacle("post", [2.0, 0.0], 0.2)?;
    /// assert!(animation.html().contains("<title>arm</title>"));
    /// # Ok::<(), hamiltonian_adjoint::Error>(())
    /// ```
    ///
    /// # Errors
    /// A coordinate that is not finite, or a number of points that changes during the motion.
    pub fn line(mut self, name: &str, points: impl Fn(&[f64], f64) -> Vec<[f64; 2]>) -> Result<Self, Error> {
        let frames: Vec<_> = self.q.iter().zip(&self.times).map(|(q, &t)| points(q, t)).collect();
        let expected = frames.first().map_or(0, Vec::len);
        if let Some(other) = frames.iter().find(|points| points.len() != expected) {
            return Err(Error::Size { what: "points of a line (as many at every node)", expected, found: other.len() });
        }
        frames.iter().flatten().try_for_each(|point| check(name, point))?;
        self.figure.add_line(name, &frames);
        Ok(self)
    }

    /// Draws a fixed wall along a line through points (x, y), m.
    ///
    /// # Errors
    /// A coordinate that is not finite, or fewer than two points.
    pub fn wall(mut self, name: &str, points: &[[f64; 2]]) -> Result<Self, Error> {
        at_least(2.0, &format!("the number of points of `{name}`"), points.len() as f64)?;
        points.iter().try_for_each(|point| check(name, point))?;
        points.windows(2).for_each(|ends| self.figure.add_fixed(name, MarkKind::Wall(ends[1]), ends[0]));
        Ok(self)
    }

    /// Draws a fixed circular obstacle with its centre (x, y) and radius, m.
    ///
    /// # Errors
    /// A number that is not finite, or a negative radius.
    pub fn obstacle(mut self, name: &str, centre: [f64; 2], radius: f64) -> Result<Self, Error> {
        at_least(0.0, &format!("the radius of `{name}`"), radius)?;
        check(name, &[centre[0], centre[1], radius])?;
        self.figure.add_fixed(name, MarkKind::Obstacle(radius.abs()), centre);
        Ok(self)
    }

    /// Draws a fixed target at the point (x, y), m.
    ///
    /// # Errors
    /// A coordinate that is not finite.
    pub fn target(mut self, name: &str, point: [f64; 2]) -> Result<Self, Error> {
        check(name, &point)?;
        self.figure.add_fixed(name, MarkKind::Target, point);
        Ok(self)
    }
}

fn at_least(least: f64, what: &str, value: f64) -> Result<(), Error> {
    // Numbers that are not finite are refused with the others.
    if value >= least || !value.is_finite() {
        return Ok(());
    }
    let must_be = if least == 0.0 { "positive or zero" } else { "at least 2" };
    Err(Error::Parameter { what: what.into(), value, must_be })
}

fn check(name: &str, numbers: &[f64]) -> Result<(), Error> {
    match numbers.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(Error::NotFinite { what: format!("a coordinate of the drawing `{name}`"), value }),
        None => Ok(()),
    }
}
