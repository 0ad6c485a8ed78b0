//! [`Scatter`]: adds second derivatives of elements of one formula to the tangent matrix K of a step.
//!
//! Entries of neighbouring unknowns are often adjacent in K. Adjacent entries are added together, and at all places where they occur at once:
//! those of a cable between two points of a plane are four numbers, added twice and subtracted twice.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::number::by_fours;
use crate::system::formula::{Block, BlockEntry, RelativeEntry};

/// For fewer elements, the entries are processed one by one rather than together.
const FEW: usize = 4;

/// Adjacent numbers that are added together: one or more values per element.
#[derive(Clone, Debug)]
pub struct Scatter {
    block: Block,
    sign: f64,
    /// For each of these numbers, the index at which the values of all elements start.
    begins: Vec<usize>,
    /// The number of places per element at which values are added, and the number at which they are added or subtracted.
    plus: usize,
    places: usize,
    /// The slots of the first number, ordered by element and within an element by place.
    slots: Vec<u32>,
}

/// Slots to which the consecutive values from `begin` on are added, or from which they are subtracted.
struct Target {
    block: Block,
    begin: usize,
    is_negative: bool,
    slots: Vec<u32>,
}

impl Scatter {
    /// Covers all entries; their values start at `begin`, ordered by entry and within an entry by element. `slots` returns the slot of an entry of an
    /// element in K, and the slot of its mirrored entry.
    pub fn all(
        entries: &[RelativeEntry],
        elements: usize,
        mut begin: usize,
        slots: impl Fn(usize, &BlockEntry) -> [u32; 2],
    ) -> Vec<Scatter> {
        let mut targets = Vec::new();
        for like in entries.chunk_by(RelativeEntry::is_like) {
            for together in like.chunks(if elements < FEW { like.len() } else { 1 }) {
                if like[0].entry.block.is_in_tangent() {
                    targets.extend(Target::all(together, elements, begin, &slots));
                }
                begin += together.len() * elements;
            }
        }
        if elements < FEW {
            return Scatter::of_stacks(targets.into_iter().map(|target| vec![target]));
        }
        let of_range = |range: Range<usize>| {
            Scatter::of_stacks(stacks(targets.iter().map(|target| target.part(range.clone()))).into_iter())
        };
        alike(&targets, elements).into_iter().flat_map(of_range).collect()
    }

    /// Combines stacks of adjacent targets that have equal values.
    fn of_stacks(stacks: impl Iterator<Item = Vec<Target>>) -> Vec<Scatter> {
        let mut places = BTreeMap::<(Block, Vec<usize>), [Vec<Vec<u32>>; 2]>::new();
        for stack in stacks {
            let begins = stack.iter().map(|target| target.begin).collect();
            if let Some(first) = stack.into_iter().next() {
                places.entry((first.block, begins)).or_default()[usize::from(first.is_negative)].push(first.slots);
            }
        }
        places.into_iter().flat_map(|((block, begins), signed)| Scatter::at_places(block, &begins, signed)).collect()
    }

    /// Splits the places for addition and subtraction into groups: one or two of one kind, or one or two of each.
    fn at_places(block: Block, begins: &[usize], [mut plus, mut minus]: [Vec<Vec<u32>>; 2]) -> Vec<Scatter> {
        let (mut all, mut sign) = (Vec::new(), 1.0);
        while !plus.is_empty() || !minus.is_empty() {
            if plus.is_empty() {
                std::mem::swap(&mut plus, &mut minus);
                sign = -sign;
            }
            let count = if minus.is_empty() { plus.len().min(2) } else { plus.len().min(minus.len()).min(2) };
            let mut own: Vec<Vec<u32>> = plus.drain(..count).collect();
            own.extend(minus.drain(..count.min(minus.len())));
            let slots = (0..own[0].len()).flat_map(|k| own.iter().map(move |slots| slots[k])).collect();
            all.push(Scatter { block, sign, begins: begins.to_vec(), plus: count, places: own.len(), slots });
        }
        all
    }

    /// Adds the values in `blocks` to K(h).
    #[inline(always)]
    pub fn add(&self, blocks: &[f64], h: f64, values: &mut [f64]) {
        let factor = self.sign * self.block.in_tangent(h);
        // Skipped rather than multiplied by zero: at h = 0, derivatives of forces do not contribute to K even if they are not finite.
        if factor == 0.0 {
            return;
        }
        match self.begins.len() {
            1 => self.add_together::<1>(factor, blocks, values),
            2 => self.add_together::<2>(factor, blocks, values),
            _ => self.add_together::<4>(factor, blocks, values),
        }
    }

    #[inline(always)]
    fn add_together<const N: usize>(&self, factor: f64, blocks: &[f64], values: &mut [f64]) {
        match (self.plus, self.places) {
            (1, 1) => self.add_at::<N, 1, 1>(factor, blocks, values),
            (2, 2) => self.add_at::<N, 2, 2>(factor, blocks, values),
            (1, 2) => self.add_at::<N, 1, 2>(factor, blocks, values),
            _ => self.add_at::<N, 2, 4>(factor, blocks, values),
        }
    }

    #[inline(always)]
    fn add_at<const N: usize, const PLUS: usize, const P: usize>(&self, factor: f64, blocks: &[f64], values: &mut [f64]) {
        let slots = self.slots.as_chunks::<P>().0;
        let x: [&[f64]; N] = std::array::from_fn(|i| &blocks[self.begins[i]..][..slots.len()]);
        let mut add = |x: [f64; N], slots: &[u32; P]| {
            let x = x.map(|x| factor * x);
            slots[..PLUS].iter().for_each(|slot| add_run(&x, *slot, values));
            slots[PLUS..].iter().for_each(|slot| add_run(&x.map(|x| -x), *slot, values));
        };
        if N == 1 && P <= 2 {
            by_fours(x[0], slots, |x, slots| add([*x; N], slots));
        } else {
            slots.iter().enumerate().for_each(|(e, slots)| add(x.map(|x| x[e]), slots));
        }
    }
}

/// Adds consecutive numbers; the last one first, so that the bounds are checked only once.
#[inline(always)]
fn add_run<const N: usize>(x: &[f64; N], slot: u32, values: &mut [f64]) {
    let first = slot as usize;
    values[first + N - 1] += x[N - 1];
    (0..N - 1).for_each(|i| values[first + i] += x[i]);
}

impl Target {
    /// The targets of like entries.
    fn all(
        entries: &[RelativeEntry],
        elements: usize,
        begin: usize,
        slots: &impl Fn(usize, &BlockEntry) -> [u32; 2],
    ) -> Vec<Target> {
        let (mut all, first) = (Vec::new(), &entries[0].entry);
        for (sign, parts) in RelativeEntry::parts_of(entries) {
            let of = |part: &BlockEntry| (0..elements).map(|e| slots(e, part)).collect::<Vec<_>>();
            let (here, there) = parts.iter().flat_map(of).map(|[here, there]| (here, there)).unzip();
            let target = |sign: f64, slots| Target { block: first.block, begin, is_negative: sign < 0.0, slots };
            all.push(target(sign, here));
            all.extend(first.sign_of_mirrored().map(|mirrored| target(sign * mirrored, there)));
        }
        all
    }

    /// The target restricted to a range of elements.
    fn part(&self, range: Range<usize>) -> Target {
        Target { begin: self.begin + range.start, slots: self.slots[range].to_vec(), ..*self }
    }

    /// Whether each slot follows the corresponding slot of another target with the same block and sign.
    fn is_behind(&self, other: &Target) -> bool {
        let is_next = |(own, other): (&u32, &u32)| *own == other + 1;
        (self.block, self.is_negative) == (other.block, other.is_negative)
            && self.slots.len() == other.slots.len()
            && self.slots.iter().zip(&other.slots).all(is_next)
    }
}

/// Ranges of elements whose slots are adjacent in the same way; all elements as one range if there would be too many ranges.
fn alike(targets: &[Target], elements: usize) -> Vec<Range<usize>> {
    let order = |e: usize| {
        let mut slots: Vec<(u32, usize)> = targets.iter().enumerate().map(|(k, target)| (target.slots[e], k)).collect();
        slots.sort_unstable();
        let is_next = slots.windows(2).map(|pair| pair[1].0 == pair[0].0 + 1).collect::<Vec<bool>>();
        (slots.into_iter().map(|(_, k)| k).collect::<Vec<usize>>(), is_next)
    };
    let orders: Vec<_> = (0..elements).map(order).collect();
    let mut end = 0;
    let ranges = orders.chunk_by(|a, b| a == b).map(|range| {
        end += range.len();
        end - range.len()..end
    });
    let ranges: Vec<Range<usize>> = ranges.collect();
    if ranges.len() <= 1 + elements / 8 { ranges } else { std::iter::once(0..elements).collect() }
}

/// Groups adjacent targets into stacks of one, two or four.
fn stacks(targets: impl Iterator<Item = Target>) -> Vec<Vec<Target>> {
    let mut by_slot = BTreeMap::<u32, Vec<Target>>::new();
    targets.for_each(|target| by_slot.entry(target.slots[0]).or_default().push(target));
    let mut all = Vec::new();
    while let Some((slot, mut here)) = by_slot.pop_first() {
        let Some(first) = here.pop() else { continue };
        let mut stack = vec![first];
        by_slot.extend((!here.is_empty()).then_some((slot, here)));
        while stack.len() < 4 {
            let last = &stack[stack.len() - 1];
            let Some(next) = by_slot.get_mut(&(last.slots[0] + 1)) else { break };
            let Some(at) = next.iter().position(|target| target.is_behind(last)) else { break };
            stack.push(next.swap_remove(at));
        }
        // Three are split into two and one.
        let rest = if stack.len() == 3 { stack.split_off(2) } else { Vec::new() };
        all.push(stack);
        all.extend((!rest.is_empty()).then_some(rest));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::report::Draw;

    /// Entries of a block of two points of the plane, in a chain of elements, with K sorted by columns, by rows, by either, or unsorted.
    #[test]
    fn numbers_that_are_added_together_are_added_where_each_belongs() {
        let entry = |block, [row, col]: [usize; 2], reference: [Option<usize>; 2]| RelativeEntry {
            entry: BlockEntry { block, row, col, mirrored: block == Block::Qq && row != col },
            reference,
        };
        let pair = [2, 3].map(|b| [2, 3].map(|c| (b, c))).into_iter().flatten();
        let cable = |block| {
            pair.clone()
                .filter(move |(b, c)| block != Block::Qq || b >= c)
                .map(move |(b, c)| entry(block, [b, c], [Some(b - 2), Some(c - 2)]))
        };
        let contact = |block| [[0, 0], [1, 0], [1, 1]].map(|at| entry(block, at, [None; 2]));
        let constraint = |block| [[0, 2], [0, 3], [1, 2]].map(|[row, col]| entry(block, [row, col], [None, Some(col - 2)]));
        let mut lists: Vec<Vec<RelativeEntry>> = [Block::Qq, Block::ForceQ].map(|block| cable(block).collect()).into();
        lists.extend([Block::ForceV, Block::Vq, Block::PhiQq].map(|block| contact(block).into()));
        lists.extend([Block::PhiQ, Block::PhiDotQ].map(|block| constraint(block).into()));
        lists.push(lists.concat());
        let mut draw = Draw(3);
        for (entries, (count, order)) in lists.iter().flat_map(|list| {
            [1, 2, 3, 4, 5, 8, 29, 31].into_iter().flat_map(|n| (0..4).map(move |o| (n, o))).map(move |of| (list, of))
        }) {
            let size = 2 * count + 4;
            let slot = |row: usize, col: usize| {
                let [by_columns, by_rows] = [col * size + row, row * size + col];
                let by_either = if row.min(col) < size / 2 { by_columns } else { by_rows };
                [by_columns, by_rows, by_either, (row * 7 + col * 5) % (size * size)][order]
            };
            let unknown = |e: usize, entry: &BlockEntry| {
                let row = if entry.block.has_equations() { 2 + entry.row } else { entry.row };
                [2 * e + row, 2 * e + entry.col]
            };
            let slots = |e: usize, entry: &BlockEntry| {
                let [row, col] = unknown(e, entry);
                [slot(row, col) as u32, slot(col, row) as u32]
            };
            let (begin, h) = (3, 0.3);
            let blocks = draw.numbers(begin + entries.len() * count);
            let (mut values, mut expected) = (vec![0.0; size * size], vec![0.0; size * size]);
            Scatter::all(entries, count, begin, slots).iter().for_each(|scatter| scatter.add(&blocks, h, &mut values));
            for (k, entry) in entries.iter().enumerate() {
                for (e, (sign, part)) in (0..count).flat_map(|e| entry.signed_parts().map(move |part| (e, part))) {
                    let x = sign * entry.entry.block.in_tangent(h) * blocks[begin + k * count + e];
                    let [here, there] = slots(e, &part);
                    expected[here as usize] += x;
                    part.sign_of_mirrored().into_iter().for_each(|sign| expected[there as usize] += sign * x);
                }
            }
            let is_close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-14;
            assert!(values.iter().zip(&expected).all(is_close), "{count} elements in order {order}: {entries:?}");
        }
    }
}
