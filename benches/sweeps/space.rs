//! Chains of hinges in space: whole, and cut at every sixth body.

use criterion::{Criterion, Throughput};

use crate::{group, hinges, mark};
use benches::Row;

/// Time per joint and step: the throughput counts joints times steps.
pub fn chains(criterion: &mut Criterion) {
    const STEPS: usize = 100;
    let mut group = group(criterion, "chains in space, 100 steps");
    let whole = [3, 7, 14, 28, 56].map(|joints| (joints, 0));
    let cut = [14, 28, 56, 98].map(|joints| (joints, 6));
    for (joints, piece) in whole.into_iter().chain(cut) {
        let row = Row::new(hinges::chain(joints, piece, false), STEPS, 0.001, 0.02);
        group.throughput(Throughput::Elements((joints * STEPS) as u64));
        let what = if piece > 0 { "cut every 6" } else { "whole" };
        row.both(&mut group, what, &mark(format!("{joints} joints"), joints == 14));
    }
    group.finish();
}

/// Compiling these chains.
pub fn compile(criterion: &mut Criterion) {
    let mut group = group(criterion, "compile a chain in space");
    group.sample_size(10);
    for (joints, piece) in [(7, 0), (28, 0), (28, 6), (98, 6)] {
        let what = if piece > 0 { "cut every 6" } else { "whole" };
        group.bench_function(mark(format!("{joints} joints, {what}"), joints == 7), |bencher| {
            bencher.iter_with_large_drop(|| hinges::chain(joints, piece, false).compile())
        });
    }
    group.finish();
}
