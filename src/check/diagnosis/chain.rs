//! Mistakes in a single step of the chain rule.
//!
//! A node z of the recorded formula f that is used in another node y contributes (∂f/∂y) (∂y/∂z) (∂z/∂x) to ∂f/∂x. A mistake in one step
//! of a derivation changes one of these three factors: half of a product rule is a missing contribution, a forgotten inner derivative is
//! ∂z/∂x = 1, degrees for radians are ∂y/∂z at another z. Each such change is compared with the user's values at all points.

use nalgebra::DMatrix;
use num_dual::Dual64;
use std::f64::consts::PI;

use super::arguments::{Confusion, confusions};
use super::evidence::{At, Evidence};
use super::factor::likely_name;
use super::mask::Mask;
use super::terms::describe;
use crate::check::report::{Diagnosis, Mistake};
use crate::program::{Expression, Function, Graph, Node};

/// Two numbers are the same coefficient if they differ by less than this.
const SAME: f64 = 1e-6;
/// A factor nearer to 1 than this counts as a lack of digits.
const FEW: f64 = 1e-3;
/// Maximum number of characters of a node's text.
const LONG: usize = 48;

/// The recorded formula of a block, and its derivatives at all points.
pub(super) struct Chain<'e> {
    evidence: &'e Evidence<'e>,
    graph: Graph,
    nodes: Vec<Node>,
    results: Vec<Node>,
    cuts: Vec<Vec<Link>>,
    sweeps: Vec<Sweep>,
}

/// The use of a node z in another one y, or all of its uses if both are the same.
#[derive(Clone, Copy, PartialEq)]
struct Link {
    y: Node,
    z: Node,
}

/// Values of all nodes z, ∂z/∂x, and ∂f/∂z at one point.
struct Sweep {
    values: Vec<f64>,
    forward: DMatrix<f64>,
    backward: Vec<Vec<f64>>,
}

/// Kind of mistake, whether it concerns all uses of z, text, and the expression in place of (∂y/∂z) (∂z/∂x), computed from ∂y/∂z as a function
/// of z, and from z, y and ∂z/∂x.
type Wrong = (Mistake, bool, &'static str, fn(&dyn Fn(f64) -> f64, [f64; 3]) -> f64);

const WRONG: [Wrong; 9] = [
    (Mistake::TermMissing, true, "inner derivative missing: that of {z}", |f, [z, _, inner]| {
        f(z) * f64::from(u8::from(inner != 0.0))
    }),
    (Mistake::TermWrong, true, "inner derivative squared: that of {z}", |f, [z, _, inner]| f(z) * inner * inner),
    (Mistake::TermWrong, false, "the derivative of {y} by {z} is taken as 1", |_, [_, _, inner]| inner),
    (Mistake::OtherArgument, false, "{y} is used instead of its derivative with respect to {z}", |_, [_, y, inner]| {
        y * inner
    }),
    (Mistake::OtherArgument, false, "{z} has the wrong sign in the derivative of {y}", |f, [z, _, inner]| f(-z) * inner),
    (Mistake::OtherArgument, false, DEGREES, |f, [z, _, inner]| f(z * 180.0 / PI) * inner),
    (Mistake::OtherArgument, false, DEGREES, |f, [z, _, inner]| f(z * PI / 180.0) * inner),
    (Mistake::Factor, false, "superfluous factor {z} in the derivative of {y}", |f, [z, _, inner]| f(z) * z * inner),
    (Mistake::Factor, false, "factor {z} missing in the derivative of {y}", |f, [z, _, inner]| f(z) / z * inner),
];

/// Number of mistakes at the start of the list that are likelier than a wrong constant factor.
const INNER: usize = 2;
const DEGREES: &str = "looks like degrees instead of radians: {z} in the derivative of {y}";

impl<'e> Chain<'e> {
    /// Records the formula at the first point. `None` if that fails, or if the formula takes another branch at another point.
    pub(super) fn record(evidence: &'e Evidence) -> Option<Self> {
        let of = &evidence.block.truth;
        let first = evidence.at.first().filter(|at| of.by.end < at.x.len())?;
        let (graph, results) = of.function.derived_graph(&first.x)?;
        let nodes = graph.reachable(results.iter().copied());
        let mut chain = Chain { evidence, graph, nodes, results, cuts: Vec::new(), sweeps: Vec::new() };
        chain.sweeps = evidence.at.iter().map(|at| chain.sweep(&at.x)).collect();
        let value = |p: usize, (i, j): At| chain.sweeps[p].forward[(chain.results[i].index(), j)];
        if chain.results.len() != evidence.rows() || !Mask::all(evidence).are_true(value) {
            return None;
        }
        chain.cuts = chain.cuts();
        Some(chain)
    }

    /// Sets of links to test: single uses, all uses of a node, one factor of all products of a sum; the last steps of the formula first.
    fn cuts(&self) -> Vec<Vec<Link>> {
        let uses = |&y: &Node| self.graph.expression(y).distinct_arguments().map(move |z| Link { y, z });
        let links: Vec<Link> = self.nodes.iter().flat_map(uses).collect();
        let whole = self.nodes.iter().filter(|z| links.iter().filter(|link| link.z == **z).count() > 1);
        let whole = whole.map(|&z| vec![Link { y: z, z }]);
        let factors = |&y: &Node| {
            let products = terms(&self.graph, y);
            let factors = |y: &Node| match self.graph.expression(*y) {
                Expression::Multiply(a, b) => Some([a, b]),
                _ => None,
            };
            let of: Vec<[Node; 2]> = products.iter().map(factors).collect::<Option<_>>()?;
            let cut = |k: usize| products.iter().zip(&of).map(|(&y, z)| Link { y, z: z[k] }).collect::<Vec<_>>();
            (of.len() > 1).then(|| [cut(0), cut(1)])
        };
        let sums = self.nodes.iter().filter_map(factors).flatten();
        let moves = |link: &Link| self.sweeps.iter().any(|at| at.forward.row(link.z.index()).iter().any(|x| *x != 0.0));
        let single = links.iter().map(|link| vec![*link]);
        let mut cuts: Vec<Vec<Link>> = single.chain(whole).chain(sums).filter(|cut| cut.iter().any(moves)).collect();
        cuts.sort_by_key(|cut| std::cmp::Reverse(cut[0].y));
        cuts
    }

    fn sweep(&self, x: &[f64]) -> Sweep {
        let (graph, by, values) = (&self.graph, self.evidence.block.truth.by.clone(), self.graph.evaluate(&[], x));
        let mut forward = DMatrix::zeros(graph.len(), by.len());
        for (j, input) in by.enumerate() {
            let seed = |(k, &x): (usize, &f64)| Dual64::new(x, f64::from(u8::from(k == input)));
            let lifted = graph.evaluate(&[], &x.iter().enumerate().map(seed).collect::<Vec<_>>());
            lifted.iter().enumerate().for_each(|(z, value)| forward[(z, j)] = value.eps);
        }
        let backward = self.results.iter().map(|&y| graph.slopes(&self.nodes, None, &values, y)).collect();
        Sweep { values, forward, backward }
    }

    /// Σ (∂f/∂y) (∂y/∂z) (∂z/∂x) over a cut.
    fn term<'c>(&'c self, cut: &'c [Link], sweeps: &'c [Sweep]) -> impl Fn(usize, At) -> f64 + 'c {
        let slope = |at: &Sweep, link: &Link| slope(&self.graph, &at.values, *link, at.values[link.z.index()]);
        let slopes = |at: &Sweep| cut.iter().map(|link| slope(at, link)).collect::<Vec<f64>>();
        let slopes: Vec<Vec<f64>> = sweeps.iter().map(slopes).collect();
        move |p, (i, j)| {
            let one = |(link, slope): (&Link, &f64)| sweeps[p].outer(link, i) * slope * sweeps[p].inner(link, j);
            cut.iter().zip(&slopes[p]).map(one).sum()
        }
    }

    /// Diagnosis of a step that is missing, has a wrong sign or factor, is the only one present, or has wrong factors.
    pub(super) fn wrong_step(&self, mask: &Mask) -> Option<Diagnosis> {
        let scaled = |cut: &'_ Vec<Link>| mask.multiple(|p, e| mask.truth(p, e), self.term(cut, &self.sweeps));
        let scaled: Vec<(&Vec<Link>, f64)> = self.cuts.iter().filter_map(|cut| Some((cut, scaled(cut)?))).collect();
        let with = |wanted: f64| scaled.iter().find(move |(_, c)| (c - wanted).abs() < SAME);
        // The innermost steps come first, because their texts are the shortest.
        let steps = || self.cuts.iter().rev().filter(|cut| cut.len() == 1).map(|cut| &cut[0]);
        let replaced = |wrong: &Wrong| steps().find_map(|link| self.replaced(mask, link, wrong));
        let likely = || scaled.iter().find(|(_, c)| likely_name(mask.of, 1.0 + c).is_some());
        let describe = |(cut, c): &(&Vec<Link>, f64)| self.describe(mask, cut, *c);
        with(-1.0)
            .or_else(|| with(-2.0))
            .map(describe)
            .or_else(|| self.cuts.iter().find_map(|cut| self.alone(mask, cut)))
            .or_else(|| WRONG[..INNER].iter().find_map(replaced))
            .or_else(|| likely().map(describe))
            .or_else(|| WRONG[INNER..].iter().find_map(replaced))
    }

    /// Diagnosis of a step with any constant factor, or of an inner derivative that is wrong in one of several uses.
    pub(super) fn unlikely_step(&self, mask: &Mask) -> Option<Diagnosis> {
        let scaled = |cut: &Vec<Link>| {
            let term = self.term(cut, &self.sweeps);
            let c = mask.multiple(|p, e| mask.truth(p, e), &term).filter(|c| c.abs() > FEW && mask.varies(&term))?;
            Some(self.describe(mask, cut, c))
        };
        let uses = || self.cuts.iter().filter(|cut| cut.len() == 1 && cut[0].y != cut[0].z).map(|cut| &cut[0]);
        let in_one_use = |&(mistake, _, text, wrong): &Wrong| {
            uses().find_map(|link| self.replaced(mask, link, &(mistake, false, text, wrong)))
        };
        WRONG[..INNER].iter().find_map(in_one_use).or_else(|| self.cuts.iter().find_map(scaled))
    }

    fn describe(&self, mask: &Mask, cut: &[Link], c: f64) -> Diagnosis {
        let name = format!("the derivative of {}", self.name(cut));
        match self.rule(cut).filter(|_| (c + 1.0).abs() < SAME) {
            Some(rule) => mask.says(Mistake::TermMissing, format!("half of the {rule} rule is missing: {name},")),
            None => describe(mask, &name, c),
        }
    }

    /// Diagnosis if only this step is present.
    fn alone(&self, mask: &Mask, cut: &[Link]) -> Option<Diagnosis> {
        let half = self.rule(cut).map_or("terms are missing".into(), |rule| format!("half of the {rule} rule is missing"));
        let text = || format!("{half}: only the derivative of {} is present,", self.name(cut));
        mask.explains(self.term(cut, &self.sweeps)).then(|| mask.says(Mistake::TermMissing, text()))
    }

    fn rule(&self, cut: &[Link]) -> Option<&'static str> {
        match self.graph.expression(cut[0].y) {
            Expression::Multiply(..) => Some("product"),
            Expression::Divide(..) => Some("quotient"),
            _ => None,
        }
    }

    /// Name of a cut: "z in y", or z alone for all of its uses.
    fn name(&self, cut: &[Link]) -> String {
        let of = |link: &Link| match (self.text(link.z), self.text(link.y)) {
            (z, y) if z == y => z,
            (z, y) => format!("{z} in {y}"),
        };
        cut.iter().map(of).collect::<Vec<_>>().join(" and of ")
    }

    fn replaced(&self, mask: &Mask, link: &Link, (mistake, in_all, text, wrong): &Wrong) -> Option<Diagnosis> {
        let is_whole = |z: Node| self.cuts.contains(&vec![Link { y: z, z }]);
        let fits = if *in_all { link.y == link.z || !is_whole(link.z) } else { link.y != link.z };
        let cut = [*link];
        let term = self.term(&cut, &self.sweeps);
        let expected = |p: usize, (i, j): At| {
            let values = &self.sweeps[p].values;
            let slope = |z: f64| slope(&self.graph, values, *link, z);
            let here = [values[link.z.index()], values[link.y.index()], self.sweeps[p].inner(link, j)];
            mask.truth(p, (i, j)) - term(p, (i, j)) + self.sweeps[p].outer(link, i) * wrong(&slope, here)
        };
        let says = || text.replace("{z}", &self.text(link.z)).replace("{y}", &self.text(link.y)) + ",";
        (fits && mask.explains(expected)).then(|| mask.says(*mistake, says()))
    }

    /// Diagnosis of a step in which one argument is mistaken for another, while all other steps are right.
    pub(super) fn confused_step(&self, mask: &Mask) -> Option<Diagnosis> {
        let inputs: Vec<Expression> = self.nodes.iter().map(|&node| self.graph.expression(node)).collect();
        let used = |confusion: &Confusion| inputs.contains(&Expression::Input(confusion.argument as u32));
        confusions(mask.of).into_iter().filter(used).find_map(|Confusion { text, change, .. }| {
            let moved = |p: usize| {
                let mut x = mask.of.at[p].x.clone();
                change(&mut x);
                self.sweep(&x)
            };
            // Most confusions fail at the first point already.
            let (here, first, mut all) = (&self.sweeps, [moved(0)], Vec::new());
            self.cuts.iter().find_map(|cut| {
                let (old, new) = (self.term(cut, here), self.term(cut, &first));
                let fits = |sign: &f64| mask.holds_at(0, |e| mask.truth(0, e) - old(0, e) + sign * new(0, e));
                let sign = [1.0, -1.0].into_iter().find(fits)?;
                if all.is_empty() {
                    all = (0..here.len()).map(moved).collect();
                }
                let new = self.term(cut, &all);
                let says = || mask.says(Mistake::OtherArgument, format!("{text}, in the derivative of {},", self.name(cut)));
                mask.explains(|p, e| mask.truth(p, e) - old(p, e) + sign * new(p, e)).then(says)
            })
        })
    }

    /// Names of all nodes and their values at other points; the arguments come first.
    pub(super) fn quantities(&self, points: &[(Vec<f64>, bool)]) -> Vec<(String, Vec<f64>)> {
        let values: Vec<Vec<f64>> = points.iter().map(|(x, _)| self.graph.evaluate(&[], x)).collect();
        let at = |node: &Node| values.iter().map(|values| values[node.index()]).collect();
        self.nodes.iter().map(|node| (self.text(*node), at(node))).collect()
    }

    /// A node in mathematical notation, shortened if it is long.
    fn text(&self, node: Node) -> String {
        let texts = (1..8).rev().map(|depth| self.graph.text(node, &self.evidence.setting.arguments, depth));
        texts.into_iter().find(|text| text.chars().count() <= LONG).unwrap_or_else(|| "an intermediate result".into())
    }
}

impl Sweep {
    /// ∂f/∂y in a row.
    fn outer(&self, link: &Link, row: usize) -> f64 {
        self.backward[row][link.y.index()]
    }

    /// ∂z/∂x in a column.
    fn inner(&self, link: &Link, column: usize) -> f64 {
        self.forward[(link.z.index(), column)]
    }
}

/// The nodes of which a sum consists, without their signs.
fn terms(graph: &Graph, y: Node) -> Vec<Node> {
    match graph.expression(y) {
        Expression::Add(a, b) | Expression::Subtract(a, b) => [terms(graph, a), terms(graph, b)].concat(),
        Expression::Of(Function::Negative, x) => terms(graph, x),
        Expression::Multiply(a, b) if graph.is_fixed(a) => terms(graph, b),
        _ => vec![y],
    }
}

/// ∂y/∂z for a given value of z and the recorded values of all other nodes.
fn slope(graph: &Graph, values: &[f64], Link { y, z }: Link, value: f64) -> f64 {
    if y == z {
        return 1.0;
    }
    let at = |node: Node| if node == z { Dual64::new(value, 1.0) } else { Dual64::from_re(values[node.index()]) };
    graph.expression(y).value(at, &[], &[]).eps
}
