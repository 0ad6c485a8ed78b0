//! Comparison of solutions with dense LU; tests of the choice of condensed unknowns and of breakdowns.

use super::graph::VISITS;
use super::node::Shape;
use super::samples::{Random, blocks, bodies, fill, sizes, tree};
use super::{BlockLu, Branch, DenseLu, Factorization, Group, Matrix, Pattern, Symbolic};
use nalgebra::{DMatrix, DVector};

/// Sets the constant part: the entries of constant unknowns, and a third of the rest as two summands.
fn set_constant<F: Factorization>(lu: &mut Matrix<F>, s: &Symbolic, pattern: &Pattern, matrix: &DMatrix<f64>) {
    let mut triplets = vec![];
    for (i, j) in pattern.symmetric_entries() {
        if pattern.constant[i] || pattern.constant[j] {
            triplets.push((i, j, matrix[(i, j)]));
        } else {
            triplets.extend([(i, j, matrix[(i, j)] / 3.0 - 1.0), (i, j, 1.0)]);
        }
    }
    lu.set_constant(s, 0, placed(s, &triplets)).expect("regular pivots");
}

/// Entries (row, column, value) with their places.
fn placed(s: &Symbolic, triplets: &[(usize, usize, f64)]) -> impl Iterator<Item = (usize, f64)> {
    triplets.iter().map(|&(i, j, value)| (s.place(i, j).expect("in the pattern"), value))
}

fn assemble<F: Factorization>(lu: &mut Matrix<F>, s: &Symbolic, pattern: &Pattern, matrix: &DMatrix<f64>) {
    let values = lu.reset();
    for (i, j) in pattern.symmetric_entries() {
        if !(pattern.constant[i] || pattern.constant[j]) {
            let slot = s.slot(i, j).expect("varying entry");
            values[slot] += matrix[(i, j)] * 2.0 / 3.0;
        }
    }
}

fn permuted(s: &Symbolic, b: &DVector<f64>) -> Vec<f64> {
    let mut x = vec![0.0; s.size()];
    for (i, &value) in b.iter().enumerate() {
        x[s.position(i)] = value;
    }
    x
}

fn compare(s: &Symbolic, x: &[f64], matrix: &DMatrix<f64>, b: &DVector<f64>) {
    let reference = matrix.clone().lu().solve(b).expect("regular matrix");
    let x = DVector::from_fn(s.size(), |i, _| x[s.position(i)]);
    let error = (x - &reference).norm() / reference.norm();
    assert!(error < 1e-10, "relative error {error:e}");
}

/// Solves with K and Kᵀ in all ways, for three sets of values.
fn check(pattern: &Pattern, diagonal: f64, seed: u64) -> Symbolic {
    check_with(pattern, diagonal, seed, |_| ())
}

/// As `check`, with values modified by `change`.
fn check_with(pattern: &Pattern, diagonal: f64, seed: u64, change: impl Fn(&mut DMatrix<f64>)) -> Symbolic {
    let s = Symbolic::analyse(pattern);
    solve_in_all_ways::<BlockLu>(&s, pattern, diagonal, seed, &change);
    solve_in_all_ways::<DenseLu>(&s, pattern, diagonal, seed, &change);
    s
}

fn solve_in_all_ways<F: Factorization>(
    s: &Symbolic,
    pattern: &Pattern,
    diagonal: f64,
    seed: u64,
    change: &impl Fn(&mut DMatrix<f64>),
) {
    let random = &mut Random(seed);
    let mut lu = Matrix::<F>::new(s);
    for _ in 0..3 {
        let mut matrix = fill(pattern, diagonal, random);
        change(&mut matrix);
        let b = DVector::from_fn(pattern.size, |_, _| random.unit());
        set_constant(&mut lu, s, pattern, &matrix);
        assemble(&mut lu, s, pattern, &matrix);
        lu.factor(s).expect("regular");
        assert!(lu.worst_pivot() > 1e-13 && lu.worst_pivot() <= 1.0);
        let mut x = permuted(s, &b);
        lu.solve(s, &mut x);
        compare(s, &x, &matrix, &b);
        assemble(&mut lu, s, pattern, &matrix);
        let mut z = permuted(s, &b);
        lu.factor_and_solve_transposed(s, &mut z).expect("regular");
        compare(s, &z, &matrix.transpose(), &b);
        let mut again = permuted(s, &b);
        lu.solve_transposed(s, &mut again);
        compare(s, &again, &matrix.transpose(), &b);

        assemble(&mut lu, s, pattern, &matrix);
        let mut again = permuted(s, &b);
        lu.reduce(&mut again);
        lu.factor_and_solve_reduced(s, &mut again).expect("regular");
        lu.expand(&mut again);
        assert_eq!(x, again);
    }
}

#[test]
fn chains_have_no_fill() {
    for size in 1..=12 {
        let edges: Vec<_> = (1..9).map(|b| (b - 1, b)).collect();
        let s = check(&blocks(&[size; 9], &edges), 12.0, size as u64);
        assert_eq!(s.values_len(), size * size * (9 + 2 * 8));
    }
}

/// Without dominant diagonals, rows of every node are interchanged.
#[test]
fn rows_are_interchanged() {
    for size in 2..=10 {
        let edges: Vec<_> = (1..5).map(|b| (0, b)).collect();
        check(&blocks(&[size; 5], &edges), 0.0, size as u64);
    }
}

/// K in other units is C K C with a diagonal C; powers of two do not change any digit.
#[test]
fn interchanges_of_rows_do_not_depend_on_units() {
    for size in 2..=10 {
        let edges: Vec<_> = (1..5).map(|b| (0, b)).collect();
        let pattern = blocks(&[size; 5], &edges);
        let (s, random) = (Symbolic::analyse(&pattern), &mut Random(size as u64));
        let mut matrix = fill(&pattern, 0.0, random);
        (0..pattern.size).filter(|i| i % 3 != 1).for_each(|i| matrix[(i, i)] = 0.0);
        let units: Vec<f64> = (0..pattern.size).map(|_| 2f64.powi(random.below(41) as i32 - 20)).collect();
        let solution = |unit: &dyn Fn(usize) -> f64| {
            let mut lu = Matrix::<BlockLu>::new(&s);
            lu.set_constant(&s, 0, std::iter::empty()).expect("nothing is constant");
            let values = lu.reset();
            for (i, j) in pattern.symmetric_entries() {
                values[s.slot(i, j).expect("varying entry")] += unit(i) * matrix[(i, j)] * unit(j);
            }
            lu.factor(&s).expect("regular");
            let mut x = permuted(&s, &DVector::from_fn(pattern.size, |i, _| unit(i)));
            lu.solve(&s, &mut x);
            let x: Vec<f64> = (0..pattern.size).map(|i| unit(i) * x[s.position(i)]).collect();
            (lu.worst_pivot(), x)
        };
        let plain = solution(&|_| 1.0);
        assert_eq!(plain, solution(&|i| units[i]), "{size}");
        compare(&s, &permuted(&s, &DVector::from_vec(plain.1)), &matrix, &DVector::from_element(pattern.size, 1.0));
    }
}

/// From factors with and without interchanges, for single nodes, chains, stars and bodies with condensed coordinates.
#[test]
fn negative_eigenvalues_are_counted() {
    let star: Vec<_> = (1..5).map(|b| (0, b)).collect();
    let chain: Vec<_> = (1..6).map(|b| (b - 1, b)).collect();
    let (mut counts, mut interchanged) = (0, 0);
    for seed in 0..40 {
        let size = 1 + seed as usize % 9;
        let parents: Vec<usize> = (0..6_usize).map(|b| b.wrapping_sub(1)).collect();
        for pattern in [blocks(&[size; 5], &star), blocks(&[size; 6], &chain), bodies(&parents)] {
            let (s, random) = (Symbolic::analyse(&pattern), &mut Random(seed));
            let mut matrix = fill(&pattern, 0.0, random);
            matrix += matrix.transpose();
            (0..pattern.size).filter(|_| random.below(3) == 0).for_each(|i| matrix[(i, i)] *= 1e-6);
            let mut lu = Matrix::<BlockLu>::new(&s);
            set_constant(&mut lu, &s, &pattern, &matrix);
            assemble(&mut lu, &s, &pattern, &matrix);
            lu.factor(&s).expect("regular");
            let expected = matrix.symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count();
            assert_eq!(lu.negative_eigenvalues(&s), expected, "{seed}");
            counts += expected;
            interchanged += usize::from(lu.reciprocal_pivots(&s).filter(|x| *x < 0.0).count() != expected);
        }
    }
    assert!(counts > 500 && interchanged > 20, "{counts}, {interchanged}");
}

#[test]
fn trees_have_no_fill() {
    for seed in 0..20 {
        let random = &mut Random(seed);
        let sizes = sizes(12, if seed < 15 { 7 } else { 11 }, random);
        let pattern = tree(&sizes, random);
        let s = check(&pattern, 12.0, seed);
        assert_eq!(s.values_len(), pattern.symmetric_entries().len());
    }
}

#[test]
fn loops_fill() {
    for seed in 0..10 {
        let random = &mut Random(seed);
        let rungs = (0..8).map(|k| (k, k + 8));
        let sides = (0..7).flat_map(|k| [(k, k + 1), (k + 8, k + 9)]);
        let edges: Vec<_> = rungs.chain(sides).chain([(0, 7), (3, 12)]).collect();
        let pattern = blocks(&sizes(16, 9, random), &edges);
        let s = check(&pattern, 20.0, seed);
        assert!(s.values_len() > pattern.symmetric_entries().len());
        assert_eq!(s.nodes().map(|(size, _)| size).sum::<usize>(), pattern.size);
    }
}

#[test]
fn star_and_single_node() {
    let edges: Vec<_> = (1..10).map(|b| (0, b)).collect();
    check(&blocks(&[4; 10], &edges), 8.0, 1);
    for size in (1..12).chain([60]) {
        let s = check(&blocks(&[size], &[]), 0.0, size as u64);
        assert_eq!(s.nodes().count(), 1);
    }
}

fn single(group: usize) -> Branch {
    Branch { from: group, length: 1 }
}

/// Multipliers of three kinds wait for their coordinates; A and B are random with A dominant.
#[test]
fn saddle_points_with_after() {
    let edges: Vec<_> = (0..6).flat_map(|k| [(k, 6 + k), ((k + 1) % 6, 6 + k)]).collect();
    let mut pattern = blocks(&[3, 4, 5, 3, 4, 5, 2, 1, 2, 2, 1, 2], &edges);
    let multipliers = pattern.groups[6].unknowns[0]..pattern.size;
    (pattern.entries).retain(|(i, j)| !(multipliers.contains(i) && multipliers.contains(j)));
    for k in 0..6 {
        pattern.groups[6 + k].after = [k, (k + 1) % 6].map(single).into();
    }
    check(&pattern, 6.0, 3);
    // Contradictory conditions must not cause an endless loop.
    pattern.groups[0].after = vec![single(1)];
    pattern.groups[1].after = vec![single(0)];
    assert_eq!(Symbolic::analyse(&pattern).nodes().count(), 12);
}

#[test]
fn constant_unknowns_of_random_graphs() {
    let mut condensed = 0;
    for seed in 0..40 {
        let random = &mut Random(seed);
        let sizes = sizes(10, 7, random);
        let mut pattern = tree(&sizes, random);
        if seed % 2 == 0 {
            let (i, j) = (random.below(pattern.size), random.below(pattern.size));
            pattern.entries.push((i, j));
        }
        (pattern.entries).retain(|&(i, j)| i == j || random.below(3) > 0);
        pattern.constant = (0..pattern.size).map(|_| random.below(2) == 0).collect();
        condensed += check(&pattern, 9.0, seed).condensed();
    }
    assert!(condensed > 100, "{condensed}");
}

#[test]
fn coordinates_of_a_chain_are_condensed() {
    let parents: Vec<usize> = (0..20_usize).map(|b| b.wrapping_sub(1)).collect();
    let s = check(&bodies(&parents), 6.0, 5);
    assert_eq!((s.condensed(), s.nodes().count()), (40, 20));
    assert!(s.nodes().all(|(size, _)| size == 3));
    assert_eq!(s.values_len(), 9 * (20 + 2 * 19));
    assert_eq!(s.slot(0, 0), None);
    assert_eq!(s.slot(2, 12), None);
    assert!(s.slot(2, 8).is_some());
}

fn shapes(s: &Symbolic) -> Vec<Shape> {
    s.runs().flat_map(|(_, nodes)| nodes).map(|node| node.shape).collect()
}

/// An angle is coupled only to the hinges of its own body; if its pivot vanishes, rows are interchanged.
#[test]
fn angles_are_left_out_where_a_link_couples_to_the_next() {
    let pattern = bodies(&(0..9_usize).map(|b| b.wrapping_sub(1)).collect::<Vec<_>>());
    let massless = |every: usize, inertia: f64, slope: f64| {
        move |matrix: &mut DMatrix<f64>| {
            (0..9).step_by(every).for_each(|b| matrix[(5 * b + 2, 5 * b + 2)] = inertia);
            (0..9).for_each(|b| matrix[(5 * b + 2, 5 * b + 3)] *= slope);
        }
    };
    let little = [(1e-8, 1.0), (1e-8, 1e-7), (1e-8, 0.0), (-1e-15, 1.0), (-1e-15, 0.0)];
    let _ = little.map(|(inertia, slope)| check_with(&pattern, 6.0, 5, massless(1, inertia, slope)));
    for every in [1, 2, 3, 9] {
        let s = check_with(&pattern, 6.0, every as u64, massless(every, 0.0, 1.0));
        let count = |shape| shapes(&s).into_iter().filter(|&other| other == shape).count();
        assert_eq!([Shape::Outer, Shape::Inner, Shape::Linked].map(count), [4, 4, 1]);
    }
    // A spring between two angles couples them; an interchange in one link affects only its hinges.
    let mut sprung = pattern.clone();
    sprung.entries.extend([(2, 7), (32, 37)]);
    let s = check_with(&sprung, 6.0, 4, massless(2, 0.0, 1.0));
    assert_eq!(shapes(&s).into_iter().filter(|&shape| shape == Shape::Linked).count(), 3);
}

#[test]
fn coordinates_of_a_branching_body_stay() {
    let pattern = bodies(&[usize::MAX, 0, 1, 1, 1, 2, 3]);
    let s = check(&pattern, 6.0, 6);
    assert_eq!(s.condensed(), 12);
    assert!(s.slot(5, 5).is_some() && s.slot(6, 6).is_some());
    assert_eq!(s.nodes().filter(|&(size, _)| size == 5).count(), 1);
}

/// Constant multipliers are eliminated after all coordinates that they touch.
#[test]
fn constant_multipliers_are_condensed() {
    let mut pattern = bodies(&[usize::MAX, 0, 1, 2]);
    pattern.constant = vec![true; pattern.size];
    let s = check(&pattern, 6.0, 7);
    assert_eq!((s.condensed(), s.nodes().count(), s.values_len()), (20, 0, 0));
    pattern.constant[2] = false;
    let s = check(&pattern, 6.0, 8);
    assert_eq!(s.condensed(), 15);
}

#[test]
fn singular_matrices_are_reported() {
    let random = &mut Random(9);
    let pattern = blocks(&[3, 4, 9], &[(0, 1), (1, 2)]);
    let s = Symbolic::analyse(&pattern);
    let mut lu = Matrix::<BlockLu>::new(&s);
    let mut matrix = fill(&pattern, 12.0, random);
    for (row, of) in [(1, 0), (5, 4), (12, 11)] {
        let kept = matrix.clone();
        matrix.set_row(row, &(kept.row(of) * 1.5));
        set_constant(&mut lu, &s, &pattern, &matrix);
        assemble(&mut lu, &s, &pattern, &matrix);
        let group = pattern.groups.iter().find(|g| g.unknowns.contains(&row)).unwrap();
        let breakdown = lu.factor(&s).expect_err("singular");
        assert!(group.unknowns.contains(&breakdown.unknown), "{breakdown:?}");
        assert!(breakdown.pivot.abs() < 1e-13 * breakdown.scale);
        matrix = kept;
    }
    lu.reset().fill(f64::NAN);
    assert!(lu.factor(&s).is_err());
}

/// A pivot of which a fraction δ of its terms remains, in one node or in the second of two, for kernels with and without interchanges.
#[test]
fn what_a_pivot_loses_is_told_by_every_kernel() {
    for (size, delta) in (1..=10).flat_map(|size| [1e-3, 1e-6].map(|delta| (size, delta))) {
        let pattern = blocks(&[size; 2], &[(0, 1)]);
        let s = Symbolic::analyse(&pattern);
        for (i, j) in [(size - 1, size), (0, size - 1)].into_iter().filter(|(i, j)| i < j) {
            let mut matrix = DMatrix::identity(2 * size, 2 * size);
            (matrix[(i, j)], matrix[(j, i)], matrix[(j, j)]) = (1.0, 1.0, 1.0 + delta);
            let mut lu = Matrix::<BlockLu>::new(&s);
            set_constant(&mut lu, &s, &pattern, &matrix);
            assemble(&mut lu, &s, &pattern, &matrix);
            lu.factor(&s).expect("regular");
            let told = lu.worst_pivot() / delta;
            println!("{size} unknowns, {i} and {j}: {told:.3} δ");
            assert!(told > 0.1 && told < 1.01, "{size} unknowns, {i} and {j}: {told} δ");
        }
    }
}

/// AᵀA with two columns at a small angle δ loses digits by 1/δ², also if rows are interchanged, after which pivots are of order δ.
#[test]
fn what_interchanged_pivots_lose_is_told() {
    for (size, delta) in (3..=10).flat_map(|size| [1e-3f64, 1e-5].map(|delta| (size, delta))) {
        let mut a = DMatrix::<f64>::identity(size, size);
        let tilted = [delta.cos(), 0.6 * delta.sin(), 0.8 * delta.sin()];
        tilted.into_iter().enumerate().for_each(|(i, x)| a[(i, 1)] = x);
        (0..2).for_each(|i| a[(i, 2)] = [0.0, 1.0][i]);
        a[(2, 2)] = 0.0;
        let (matrix, pattern) = (a.transpose() * &a, blocks(&[size], &[]));
        let (s, mut lu) = (Symbolic::analyse(&pattern), Matrix::<BlockLu>::new(&Symbolic::analyse(&pattern)));
        set_constant(&mut lu, &s, &pattern, &matrix);
        assemble(&mut lu, &s, &pattern, &matrix);
        lu.factor(&s).expect("regular");
        let told = lu.worst_pivot() / delta.powi(2);
        assert!(told > 0.1 && told < 1.01, "{size} unknowns, {delta}: {told} δ²");
    }
}

/// Two equal constraints whose coordinates are in an earlier node, in the same node, or condensed.
#[test]
fn redundant_constraints_are_reported() {
    let entries = vec![(0, 0), (1, 1), (2, 0), (2, 1), (3, 0), (3, 1)];
    let triplets = [(0, 0, 3.0), (1, 1, 7.0)].into_iter().chain(
        [(2, 0, 0.3), (2, 1, 1.1), (3, 0, 0.3), (3, 1, 1.1)]
            .into_iter()
            .flat_map(|(i, j, value)| [(i, j, value), (j, i, value)]),
    );
    let triplets: Vec<_> = triplets.collect();
    for ends in [&[2, 4][..], &[3, 4], &[2, 3, 4], &[4]] {
        for constants in [0, 2, 4] {
            let groups = ends.iter().enumerate().map(|(g, &end)| Group {
                unknowns: (if g == 0 { 0 } else { ends[g - 1] }..end).collect(),
                after: (0..g).map(single).collect(),
                ..Group::default()
            });
            let s = Symbolic::analyse(&Pattern {
                size: 4,
                coordinates: 2,
                entries: entries.clone(),
                constant: (0..4).map(|i| i < constants).collect(),
                groups: groups.collect(),
            });
            let mut lu = Matrix::<BlockLu>::new(&s);
            let result = lu.set_constant(&s, 0, placed(&s, &triplets)).and_then(|()| {
                lu.reset();
                lu.factor(&s)
            });
            assert!(result.expect_err("singular").unknown >= 2);
        }
    }
}

/// Strings of constant and of other bodies, stars of both, and loops that all wait for distant bodies: twice the size requires twice the work.
#[test]
fn the_analysis_takes_work_in_proportion_to_the_size() {
    let chain = |size: usize| bodies(&(0..size).map(|b| b.wrapping_sub(1)).collect::<Vec<_>>());
    let star = |size: usize| bodies(&(0..size).map(|b| if b == 0 { usize::MAX } else { 0 }).collect::<Vec<_>>());
    // A string of single constant unknowns that can be condensed only from its end, in descending order.
    let string = |size: usize, constant: bool| {
        let mut pattern = blocks(&vec![1; size], &(1..size).map(|b| (b - 1, b)).collect::<Vec<_>>());
        pattern.constant = (0..size).map(|b| constant && b > 0).collect();
        pattern
    };
    let hub = |size: usize| {
        let mut pattern = blocks(&vec![1; size], &(1..size).map(|b| (0, b)).collect::<Vec<_>>());
        pattern.constant = vec![true; size];
        pattern
    };
    // Rungs between two strings; each rung waits for both strings down to the ground.
    let ladder = |size: usize| {
        let sides = (2..2 * size).map(|b| (b - 2, b));
        let rungs = (0..size).flat_map(|k| [2 * k, 2 * k + 1].map(|b| (b, 2 * size + k)));
        let mut pattern = blocks(&vec![2; 3 * size], &sides.chain(rungs).collect::<Vec<_>>());
        for b in 2..2 * size {
            pattern.groups[b].parent = Some(b - 2);
        }
        for k in 0..size {
            pattern.groups[2 * size + k].after = [2 * k, 2 * k + 1].map(|from| Branch { from, length: k + 1 }).into();
        }
        pattern
    };
    let patterns: [(&str, &dyn Fn(usize) -> Pattern); 6] = [
        ("chain", &chain),
        ("star", &star),
        ("string", &|size| string(size, false)),
        ("constant string", &|size| string(size, true)),
        ("constant star", &hub),
        ("ladder", &ladder),
    ];
    for (name, pattern) in patterns {
        let [small, large] = [500, 4000].map(|size| {
            let pattern = pattern(size);
            let before = VISITS.get();
            Symbolic::analyse(&pattern);
            VISITS.get() - before
        });
        println!("{name}: {small} visits for 500 bodies, {large} for 4000");
        assert!(large < 9 * small, "{name}: {small} and {large}");
    }
}
