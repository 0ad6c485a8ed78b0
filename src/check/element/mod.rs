//! Hand-derived derivatives of one element, without any scene.

/// A method for each block of an element's function: its name, and what is differentiated by what.
macro_rules! blocks {
    ($function:ident, $point:ty; $($(#[$doc:meta])* $method:ident: $derivative:expr;)*) => {
        $($(#[$doc])*
        pub fn $method<A: Matrix>(mut self, hand: impl Fn(&$point) -> A + 'a) -> Self {
            self.blocks.push($derivative.by_hand($function(self.element), hand));
            self
        })*
    };
}

mod constraint;
mod cost;
mod energy;
mod force;

pub use constraint::constraint;
pub use cost::cost;
pub use energy::{kinetic_energy, potential_energy};
pub use force::force;

use std::ops::Range;
use std::rc::Rc;

use super::compare::{Block, MatrixAt, Setting, check};
use super::draw::{Drawn, check_magnitudes, check_number, check_tolerance, draw};
use super::formula::{Derived, Differentiable, Function, Made, Values};
use super::matrix::Matrix;
use super::oracle::dual;
use super::point::{Part, Places, Point};
use super::random::Random;
use super::report::Report;
#[cfg(feature = "files")]
use super::worksheet;
use crate::Error;

/// Derivatives of an element to be checked; made by [`constraint`](constraint()), [`kinetic_energy`], [`potential_energy`], [`force`](force()) or [`cost`](cost()).
///
/// Hand in any number of derivatives, each as a closure of the [`Point`], then [`run`](ElementCheck::run).
pub struct ElementCheck<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> {
    element: &'a E,
    title: String,
    coordinates: Vec<String>,
    equations: Vec<String>,
    controls: Vec<String>,
    constants: Vec<String>,
    magnitudes: Point<N, M, K, P>,
    given: Vec<Point<N, M, K, P>>,
    count: usize,
    seed: u64,
    spread: f64,
    tolerance: f64,
    admissible: Box<dyn Fn(&Point<N, M, K, P>) -> bool + 'a>,
    blocks: Vec<Pending<'a>>,
}

/// What the rows of a block are.
#[derive(Clone, Copy)]
enum Rows {
    Equations(&'static str),
    Coordinates(&'static str),
    One(&'static str),
}

/// A block before the names and the points are known.
struct Pending<'a> {
    name: &'static str,
    rows: Rows,
    by: Range<usize>,
    function: Box<dyn Differentiable + 'a>,
    /// The element's own function, whose derivatives the block is made of.
    foundation: Option<(Box<dyn Differentiable + 'a>, Range<usize>)>,
    hand: MatrixAt<'a>,
    terms: Vec<(String, MatrixAt<'a>)>,
    others: Vec<(String, MatrixAt<'a>)>,
}

impl<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, M, K, P> {
    const PLACES: Places = Places { n: N, m: M, k: K, p: P };

    fn new(element: &'a E, kind: &str, b: [f64; P]) -> Self {
        let name = std::any::type_name::<E>().rsplit("::").next().unwrap_or_default().trim_end_matches('>');
        let numbered = |name: &str, count: usize| (0..count).map(|i| format!("{name}[{i}]")).collect();
        ElementCheck {
            element,
            title: format!("{kind} `{name}`"),
            coordinates: numbered("q", N),
            equations: (0..M).map(|j| format!("equation {j}")).collect(),
            controls: numbered("u", K),
            constants: numbered("b", P),
            magnitudes: Point::ones(b),
            given: Vec::new(),
            count: 12,
            seed: 1,
            spread: 0.0,
            tolerance: 1e-11,
            admissible: Box::new(|_| true),
            blocks: Vec::new(),
        }
    }

    /// Names the coordinates.
    pub fn coordinates(mut self, names: [&str; N]) -> Self {
        self.coordinates = names.map(|name| format!("`{name}`")).to_vec();
        self
    }

    /// Names the constraint equations.
    pub fn equations(mut self, names: [&str; M]) -> Self {
        self.equations = names.map(|name| format!("`{name}`")).to_vec();
        self
    }

    /// Names the controls.
    pub fn controls(mut self, names: [&str; K]) -> Self {
        self.controls = names.map(|name| format!("`{name}`")).to_vec();
        self
    }

    /// Names the physical constants b.
    pub fn constants(mut self, names: [&str; P]) -> Self {
        self.constants = names.map(|name| format!("`{name}`")).to_vec();
        self
    }

    /// Changes the sizes that the arguments have, all 1 at first: `|m| m.q[0] = 2000.0` for a length in mm.
    pub fn magnitudes(mut self, change: impl FnOnce(&mut Point<N, M, K, P>)) -> Self {
        change(&mut self.magnitudes);
        self
    }

    /// Compares at this point and where the formula bends near it, and at no random ones.
    pub fn at(mut self, point: Point<N, M, K, P>) -> Self {
        self.given.push(point);
        self
    }

    /// The number of random points (12 at first) and their seed.
    pub fn random_points(mut self, count: usize, seed: u64) -> Self {
        (self.count, self.seed) = (count, seed);
        self
    }

    /// Varies the constants too, by this fraction; the hand-derived formulas must then use the point's `b`.
    pub fn vary_constants(mut self, fraction: f64) -> Self {
        self.spread = fraction;
        self
    }

    /// Draws random points only where this holds.
    pub fn admissible(mut self, admissible: impl Fn(&Point<N, M, K, P>) -> bool + 'a) -> Self {
        self.admissible = Box::new(admissible);
        self
    }

    /// What an entry may be off by, relative to the size of its row and column (1e-11 at first).
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Compares everything that was handed in.
    ///
    /// What cannot be compared is refused in the report: a tolerance or magnitude that is no number, a formula that is finite at no
    /// random point.
    pub fn run(self) -> Report {
        let title = self.title.clone();
        Report::of(title, self.each_block(check))
    }

    /// The points and the true blocks there of everything that was handed in, as JSON, for a program in any language to put its own beside: see
    /// [`Answers`](super::Answers).
    ///
    /// # Errors
    /// What [`run`](Self::run) refuses.
    #[cfg(feature = "files")]
    pub fn worksheet(self) -> Result<String, Error> {
        let title = self.title.clone();
        let at = |x: &[f64]| Point::<N, M, K, P>::from_list(x);
        let (blocks, _) = self.each_block(|block, setting| worksheet::block(block, setting, at))?;
        Ok(worksheet::of(&title, blocks))
    }

    /// What is made of every block, and notes on the points.
    fn each_block<T>(mut self, mut make: impl FnMut(&Block, &Setting) -> T) -> Result<(Vec<T>, Vec<String>), Error> {
        let drawn = self.points()?;
        let notes = drawn.note(self.count).into_iter().collect();
        let blocks = std::mem::take(&mut self.blocks);
        let setting = self.setting(drawn);
        let blocks = blocks.into_iter().map(|pending| {
            let equations = |prefix: &str, names: &[String]| names.iter().map(|name| format!("{prefix}{name}")).collect();
            let rows = match pending.rows {
                Rows::Equations(prefix) => equations(prefix, &self.equations),
                Rows::Coordinates(prefix) => equations(prefix, &self.coordinates),
                Rows::One(name) => vec![name.to_string()],
            };
            let block = Block {
                name: pending.name.to_string(),
                function: pending.function,
                foundation: pending.foundation,
                columns: setting.arguments[pending.by.clone()].to_vec(),
                by: pending.by,
                rows,
                hand: pending.hand,
                terms: pending.terms,
                others: pending.others,
                elsewhere: Vec::new(),
            };
            make(&block, &setting)
        });
        Ok((blocks.collect(), notes))
    }

    fn points(&self) -> Result<Drawn, Error> {
        check_tolerance(self.tolerance)?;
        check_magnitudes(&self.arguments(), &self.magnitudes.list())?;
        check_number("the variation of the constants", self.spread, self.spread.is_finite(), "finite")?;
        let finite = |x: &[f64]| self.blocks.iter().all(|block| block.function.real(x).iter().all(|y| y.is_finite()));
        let usable = |x: &[f64]| (self.admissible)(&Point::from_list(x)) && finite(x);
        let fresh = |random: &mut Random| {
            let mut point = Point::random(&self.magnitudes, random);
            point.b.apply(|b| *b *= 1.0 + random.uniform(-self.spread, self.spread));
            point.list()
        };
        let signed: Vec<usize> = (0..Self::PLACES.of(Part::T).start).collect();
        draw(self.given.iter().map(Point::list).collect(), (self.count, self.seed), &signed, fresh, usable)
    }

    /// The names of all arguments, in the order of their list; the value of a function has none.
    fn arguments(&self) -> Vec<String> {
        let prefixed =
            |prefix: &str, names: &[String]| names.iter().map(|name| format!("{prefix}{name}")).collect::<Vec<_>>();
        let arguments = [
            self.coordinates.clone(),
            prefixed("v of ", &self.coordinates),
            prefixed("p* of ", &self.coordinates),
            prefixed("ṗ* of ", &self.coordinates),
            prefixed("v̇ of ", &self.coordinates),
            prefixed("σ of ", &self.equations),
            prefixed("λ of ", &self.equations),
            self.controls.clone(),
            prefixed("du/dt of ", &self.controls),
            vec!["t".to_string()],
            self.constants.clone(),
            vec![String::new()],
        ];
        arguments.concat()
    }

    fn setting(&self, drawn: Drawn) -> Setting<'_> {
        let places = Self::PLACES;
        let groups = [
            ("b", Part::B),
            ("v", Part::V),
            ("σ", Part::Sigma),
            ("u", Part::U),
            ("t", Part::T),
            ("p*", Part::PStar),
            ("ṗ*", Part::PStarDot),
            ("v̇", Part::VDot),
            ("λ", Part::Lambda),
            ("u̇", Part::UDot),
            ("q", Part::Q),
        ];
        let groups = groups.map(|(name, part)| (name.to_string(), places.of(part)));
        let size = |x: f64| if x == 0.0 { 1.0 } else { x.abs() };
        let varied = self.spread != 0.0;
        let constants = self.constants.iter().cloned().zip(self.magnitudes.b.iter().copied()).filter(|_| !varied);
        Setting {
            points: drawn.points,
            parents: drawn.parents,
            given: !self.given.is_empty(),
            free: (0..places.of(Part::T).end).collect(),
            kinds: groups[1..].iter().map(|(_, range)| range.clone().collect()).collect(),
            settle: Box::new(|_| ()),
            admissible: Box::new(|x| (self.admissible)(&Point::from_list(x))),
            seed: self.seed,
            magnitudes: self.magnitudes.list().into_iter().map(size).collect(),
            arguments: self.arguments(),
            groups: groups.to_vec(),
            factors: constants.collect(),
            tolerance: self.tolerance,
        }
    }
}

/// A row of an element's table of derivatives: its name, what is differentiated by what.
struct Derivative {
    name: &'static str,
    rows: Rows,
    derived: Derived,
    by: Part,
    /// Terms that it is the sum of, and blocks that it may be mistaken for.
    terms: &'static [Named],
    others: Vec<Named>,
}

/// A name, and what is differentiated by what.
type Named = (&'static str, Derived, Part);

impl Derivative {
    fn new(name: &'static str, rows: Rows, derived: Derived, by: Part) -> Self {
        Derivative { name, rows, derived, by, terms: &[], others: Vec::new() }
    }

    /// The function itself.
    fn value(name: &'static str, rows: Rows, derived: Derived) -> Self {
        Self::new(name, rows, derived, Part::One)
    }

    fn terms(self, terms: &'static [Named]) -> Self {
        Derivative { terms, ..self }
    }

    fn not(mut self, name: &'static str, derived: Derived, by: Part) -> Self {
        self.others.push((name, derived, by));
        self
    }

    /// With the user's version of it.
    fn by_hand<'a, F, A, const N: usize, const M: usize, const K: usize, const P: usize>(
        self,
        function: F,
        hand: impl Fn(&Point<N, M, K, P>) -> A + 'a,
    ) -> Pending<'a>
    where
        F: Function + 'a,
        A: Matrix,
    {
        let (function, places) = (Rc::new(function), Places { n: N, m: M, k: K, p: P });
        let made = |derived| Made { function: function.clone(), places, derived };
        let matrix = |&(name, derived, by): &Named| -> (String, MatrixAt<'a>) {
            let (of, by) = (made(derived), places.of(by));
            (name.to_string(), Box::new(move |x| dual(&of, x, &by)))
        };
        let of = made(self.derived);
        let is_value = self.by == Part::One;
        let below = self.derived.inner().filter(|_| !is_value);
        let boxed = |derived| -> Box<dyn Differentiable + 'a> { Box::new(made(derived)) };
        Pending {
            name: self.name,
            rows: self.rows,
            by: places.of(self.by),
            foundation: below.map(|by| (boxed(Derived::VALUE), places.of(by))),
            terms: self.terms.iter().map(matrix).collect(),
            others: self.others.iter().map(matrix).collect(),
            function: if is_value { Box::new(Values(of)) } else { Box::new(of) },
            hand: Box::new(move |x| hand(&Point::from_list(x)).dense()),
        }
    }
}
