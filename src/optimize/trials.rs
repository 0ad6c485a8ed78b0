//! [`Trials`]: several motions with the same variables.

use nalgebra::DMatrix;

use super::motion_problem::MotionProblem;
use super::problem::{Interval, Problem};
use super::sizes::Sizes;
use super::variables::Meaning;
use crate::{Error, Report, Warning};

/// A problem made of several motions: the sum of their costs, and all their outputs in sequence. Use it for trials of one experiment with
/// different starts, forces or durations.
///
/// All motions must have the same variables. Bounds are the intersection of the bounds of all motions; names are those of the first.
#[derive(Debug)]
pub struct Trials {
    motions: Vec<MotionProblem>,
}

impl Trials {
    /// A problem of these motions.
    ///
    /// # Errors
    /// No motion; variables that differ from those of the first motion in number, quantity, scale or form; bounds with empty intersection.
    pub fn new(motions: Vec<MotionProblem>) -> Result<Self, Error> {
        let Some(first) = motions.first() else {
            return Err(Error::Parameter { what: "the number of trials".into(), value: 0.0, must_be: "at least 1" });
        };
        for (trial, motion) in motions.iter().enumerate() {
            let (expected, found) = (first.variables(), motion.variables());
            if found != expected {
                let what = "variables of a trial, which must be those of the first trial";
                return Err(Error::Size { what, expected, found });
            }
            if let Some(i) = (0..found).find(|&i| motion.free().meaning(i) != first.free().meaning(i)) {
                let Meaning { name, scale: value, .. } = motion.free().meaning(i);
                let what = format!("the scale of variable {i} of trial {trial}, `{name}`,");
                let must_be = "that of the same quantity as in trial 0, with the same scale and form";
                return Err(Error::Parameter { what, value, must_be });
            }
        }
        let trials = Trials { motions };
        let name = |i: usize| format!("`{}` in all trials", trials.variable_name(i));
        trials.bounds().iter().enumerate().try_for_each(|(i, of)| of.check(|| name(i)))?;
        Ok(trials)
    }

    /// The motions, each with the solver at the last evaluated point.
    pub fn motions(&self) -> &[MotionProblem] {
        &self.motions
    }

    /// For each motion: the places of its own rows in `rows`, and the outputs in these rows.
    fn own_rows(&self, rows: &[usize]) -> Vec<(Vec<usize>, Vec<usize>)> {
        let mut first = 0;
        let own = |motion: &MotionProblem| {
            let own = first..first + motion.outputs();
            first = own.end;
            let places = (0..rows.len()).filter(|&k| own.contains(&rows[k]));
            places.map(|k| (k, rows[k] - own.start)).unzip()
        };
        self.motions.iter().map(own).collect()
    }

    fn sizes(&self) -> Sizes {
        Sizes { variables: self.variables(), constraints: self.motions.iter().map(MotionProblem::outputs).sum() }
    }
}

impl Problem for Trials {
    fn variables(&self) -> usize {
        self.motions[0].variables()
    }

    fn bounds(&self) -> Vec<Interval> {
        let all = self.motions.iter().map(|motion| motion.bounds());
        let common = |a: Interval, b: Interval| Interval::new(a.least.max(b.least), a.most.min(b.most));
        all.reduce(|all, own| all.into_iter().zip(own).map(|(a, b)| common(a, b)).collect()).unwrap_or_default()
    }

    fn constraints(&self) -> Vec<Interval> {
        self.motions.iter().flat_map(Problem::constraints).collect()
    }

    fn variable_name(&self, i: usize) -> String {
        self.motions[0].variable_name(i)
    }

    fn constraint_name(&self, mut j: usize) -> String {
        for (trial, motion) in self.motions.iter().enumerate() {
            match j.checked_sub(motion.outputs()) {
                None => return format!("{} of trial {trial}", motion.constraint_name(j)),
                Some(rest) => j = rest,
            }
        }
        format!("constraint {j} of no trial")
    }

    fn warnings(&self) -> Vec<Warning> {
        Report::of_all(self.motions.iter().map(|motion| Report { warnings: motion.warnings(), ..Report::default() }))
            .warnings
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.sizes().values(x, c)?;
        let (mut sum, mut rest) = (0.0, c);
        for motion in &mut self.motions {
            let (own, others) = rest.split_at_mut(motion.outputs());
            sum += motion.try_at(x, own)?;
            rest = others;
        }
        self.motions.iter_mut().for_each(MotionProblem::settle);
        Ok(sum)
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.sizes().gradient(c_weights, gradient)?;
        let (mut part, mut rest) = (vec![0.0; gradient.len()], c_weights);
        gradient.fill(0.0);
        for motion in &mut self.motions {
            let (own, others) = rest.split_at(motion.outputs());
            rest = others;
            motion.gradient(f_weight, own, &mut part)?;
            gradient.iter_mut().zip(&part).for_each(|(sum, g)| *sum += g);
        }
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.sizes().jacobian(rows, jacobian)?;
        let own_rows = self.own_rows(rows);
        for (motion, (at, outputs)) in self.motions.iter_mut().zip(own_rows) {
            let mut part = DMatrix::zeros(at.len(), jacobian.ncols());
            motion.jacobian(&outputs, &mut part)?;
            at.iter().zip(part.row_iter()).for_each(|(&k, row)| jacobian.row_mut(k).copy_from(&row));
        }
        Ok(())
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        let work = self.motions.iter().zip(self.own_rows(rows)).map(|(motion, (_, outputs))| motion.jacobian_work(&outputs));
        work.fold([0; 2], |[by_rows, by_columns], [rows, columns]| [by_rows + rows, by_columns + columns])
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.sizes().push_forward(direction, change)?;
        let mut rest = change;
        for motion in &mut self.motions {
            let (own, others) = rest.split_at_mut(motion.outputs());
            motion.push_forward(direction, own)?;
            rest = others;
        }
        Ok(())
    }

    fn grid_errors(&self) -> Result<Option<Vec<f64>>, Error> {
        let all: Vec<_> = self.motions.iter().map(Problem::grid_errors).collect::<Result<_, Error>>()?;
        Ok(all.into_iter().collect::<Option<Vec<_>>>().map(|all| all.concat()))
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.sizes().product(direction, product)?;
        let mut part = vec![0.0; product.len()];
        product.fill(0.0);
        for motion in &mut self.motions {
            motion.product(direction, &mut part)?;
            product.iter_mut().zip(&part).for_each(|(sum, x)| *sum += x);
        }
        Ok(())
    }
}
