//! The size of a node, which is known to the compiler if it is small.

use super::products::{subtract, subtract_products};
use std::fmt::Debug;

/// A number of unknowns or the index of one, as a constant of the type where possible.
///
/// The constant lets the compiler unroll every loop of a kernel and keep the node in registers.
pub(super) trait Size: Copy + Debug + Send + Sync + 'static {
    /// The number is a constant of the type.
    const FIXED: bool;

    /// The number as a value; `size` must equal the constant if there is one.
    fn new(size: usize) -> Self;

    fn get(self) -> usize;

    /// As `products::subtract_products`; the number of lines in `inner` equals the size.
    fn subtract_products(self, target: &mut [f64], outer: &[f64], inner: &[f64]);

    /// Works on a local copy of a vector of the size, or in place if the size is not fixed.
    fn on_vector(self, y: &mut [f64], work: impl FnOnce(&mut [f64]));

    /// Works on a local copy of a square matrix of the size, which is kept if that succeeds, or in place if the size is not fixed.
    fn on_square<R, E>(self, d: &mut [f64], work: impl FnOnce(&mut [f64]) -> Result<R, E>) -> Result<R, E>;
}

/// The constant S.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fixed<const S: usize>;

impl<const S: usize> Size for Fixed<S> {
    const FIXED: bool = true;

    #[inline(always)]
    fn new(_: usize) -> Self {
        Self
    }

    #[inline(always)]
    fn get(self) -> usize {
        S
    }

    #[inline(always)]
    fn subtract_products(self, target: &mut [f64], outer: &[f64], inner: &[f64]) {
        let mut columns = [[0.0; S]; S];
        for (i, line) in inner.as_chunks::<S>().0.iter().enumerate().take(S) {
            for k in 0..S {
                columns[k][i] = line[k];
            }
        }
        let targets = target.as_chunks_mut::<S>().0.iter_mut();
        for (target, line) in targets.zip(outer.as_chunks::<S>().0) {
            let mut sum = *target;
            for k in 0..S {
                subtract(line[k], &columns[k], &mut sum);
            }
            *target = sum;
        }
    }

    #[inline(always)]
    fn on_vector(self, y: &mut [f64], work: impl FnOnce(&mut [f64])) {
        let mut local = [0.0; S];
        local.copy_from_slice(y);
        work(&mut local);
        y.copy_from_slice(&local);
    }

    #[inline(always)]
    fn on_square<R, E>(self, d: &mut [f64], work: impl FnOnce(&mut [f64]) -> Result<R, E>) -> Result<R, E> {
        let mut local = [[0.0; S]; S];
        local.as_flattened_mut().copy_from_slice(d);
        let result = work(local.as_flattened_mut())?;
        d.copy_from_slice(local.as_flattened());
        Ok(result)
    }
}

/// A number known at run time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Free(usize);

impl Size for Free {
    const FIXED: bool = false;

    #[inline(always)]
    fn new(size: usize) -> Self {
        Self(size)
    }

    #[inline(always)]
    fn get(self) -> usize {
        self.0
    }

    #[inline(always)]
    fn subtract_products(self, target: &mut [f64], outer: &[f64], inner: &[f64]) {
        subtract_products(self.0, target, outer, inner);
    }

    #[inline(always)]
    fn on_vector(self, y: &mut [f64], work: impl FnOnce(&mut [f64])) {
        work(y);
    }

    #[inline(always)]
    fn on_square<R, E>(self, d: &mut [f64], work: impl FnOnce(&mut [f64]) -> Result<R, E>) -> Result<R, E> {
        work(d)
    }
}
