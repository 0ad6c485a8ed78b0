//! [`Trials`] as a [`Problem`]: values and derivatives assembled from all parts.

use nalgebra::DMatrix;

use super::super::problem::{Interval, Problem};
use super::{Part, Trials};
use crate::{Error, Report, Warning};

impl<P: Part> Problem for Trials<P> {
    fn variables(&self) -> usize {
        self.names.len()
    }

    fn bounds(&self) -> Vec<Interval> {
        let mut all = vec![Interval::FREE; self.names.len()];
        for (part, places) in self.parts.iter().zip(&self.places) {
            for (&at, own) in places.iter().zip(part.bounds()) {
                all[at] = Interval::new(all[at].least.max(own.least), all[at].most.min(own.most));
            }
        }
        all
    }

    fn constraints(&self) -> Vec<Interval> {
        self.parts.iter().flat_map(Problem::constraints).collect()
    }

    fn variable_name(&self, i: usize) -> String {
        self.names[i].clone()
    }

    fn constraint_name(&self, j: usize) -> String {
        match self.part_of(j) {
            Some((trial, own)) => format!("{} of trial {trial}", self.parts[trial].constraint_name(own)),
            None => format!("constraint {j} of no trial"),
        }
    }

    fn is_reading(&self, j: usize) -> bool {
        self.part_of(j).is_some_and(|(part, own)| self.parts[part].is_reading(own))
    }

    fn warnings(&self) -> Vec<Warning> {
        Report::of_all(self.parts.iter().map(|part| Report { warnings: part.warnings(), ..Report::default() })).warnings
    }

    fn evaluate(&mut self, x: &[f64], c: &mut [f64]) -> Result<f64, Error> {
        self.sizes().values(x, c)?;
        let (mut sum, mut rest) = (0.0, c);
        for (part, places) in self.parts.iter_mut().zip(&self.places) {
            let (own, others) = rest.split_at_mut(Self::rows(part));
            sum += part.attempt(&of(places, x), own)?;
            rest = others;
        }
        // After all parts succeeded, so that none keeps a point at which another one has no value.
        self.parts.iter_mut().for_each(P::accept);
        Ok(sum)
    }

    fn gradient(&mut self, f_weight: f64, c_weights: &[f64], gradient: &mut [f64]) -> Result<(), Error> {
        self.sizes().gradient(c_weights, gradient)?;
        let mut rest = c_weights;
        gradient.fill(0.0);
        for (part, places) in self.parts.iter_mut().zip(&self.places) {
            let (own, others) = rest.split_at(Self::rows(part));
            rest = others;
            let mut of_part = vec![0.0; places.len()];
            part.gradient(f_weight, own, &mut of_part)?;
            places.iter().zip(&of_part).for_each(|(&at, g)| gradient[at] += g);
        }
        Ok(())
    }

    fn jacobian(&mut self, rows: &[usize], jacobian: &mut DMatrix<f64>) -> Result<(), Error> {
        self.sizes().jacobian(rows, jacobian)?;
        jacobian.fill(0.0);
        let own_rows = self.own_rows(rows);
        for ((part, places), (at, own)) in self.parts.iter_mut().zip(&self.places).zip(own_rows) {
            let mut of_part = DMatrix::zeros(at.len(), places.len());
            part.jacobian(&own, &mut of_part)?;
            for (&k, row) in at.iter().zip(of_part.row_iter()) {
                places.iter().zip(row.iter()).for_each(|(&variable, x)| jacobian[(k, variable)] = *x);
            }
        }
        Ok(())
    }

    fn jacobian_work(&self, rows: &[usize]) -> [usize; 2] {
        let work = self.parts.iter().zip(self.own_rows(rows)).map(|(part, (_, own))| part.jacobian_work(&own));
        work.fold([0; 2], |[by_rows, by_columns], [rows, columns]| [by_rows + rows, by_columns + columns])
    }

    fn push_forward(&mut self, direction: &[f64], change: &mut [f64]) -> Result<(), Error> {
        self.sizes().push_forward(direction, change)?;
        let mut rest = change;
        for (part, places) in self.parts.iter_mut().zip(&self.places) {
            let (own, others) = rest.split_at_mut(Self::rows(part));
            part.push_forward(&of(places, direction), own)?;
            rest = others;
        }
        Ok(())
    }

    fn grid_errors(&self) -> Result<Option<Vec<f64>>, Error> {
        let all: Vec<_> = self.parts.iter().map(Problem::grid_errors).collect::<Result<_, Error>>()?;
        Ok(all.into_iter().collect::<Option<Vec<_>>>().map(|all| all.concat()))
    }

    fn product(&mut self, direction: &[f64], product: &mut [f64]) -> Result<(), Error> {
        self.sizes().product(direction, product)?;
        product.fill(0.0);
        for (part, places) in self.parts.iter_mut().zip(&self.places) {
            let mut of_part = vec![0.0; places.len()];
            part.product(&of(places, direction), &mut of_part)?;
            places.iter().zip(&of_part).for_each(|(&at, x)| product[at] += x);
        }
        Ok(())
    }
}

/// The entries at these places.
fn of(places: &[usize], x: &[f64]) -> Vec<f64> {
    places.iter().map(|&at| x[at]).collect()
}
