//! Checks of hand-derived derivatives of one element, without a scene.

mod blocks;

pub use blocks::{constraint, cost, force, kinetic_energy, potential_energy};

use std::rc::Rc;

use super::block::{Block, MatrixAt};
use super::draw::{Drawn, check_magnitudes, check_number, check_tolerance, draw};
use super::formula::{Derived, Function, Made};
use super::matrix::Matrix;
use super::plan::Plan;
use super::point::{Part, Places, Point};
use super::reference::Jacobian;
use super::report::Report;
use super::setting::Setting;
use crate::Error;
use crate::number::Random;

/// A check of hand-derived derivatives of an element, created by [`constraint`](constraint()), [`kinetic_energy`], [`potential_energy`],
/// [`force`](force()) or [`cost`](cost()).
///
/// Add any number of derivatives, each as a closure of the [`Point`], then call [`run`](ElementCheck::run).
#[must_use = "a check does nothing until it is run"]
pub struct ElementCheck<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> {
    element: &'a E,
    title: String,
    coordinates: Vec<String>,
    equations: Vec<String>,
    controls: Vec<String>,
    constants: Vec<String>,
    magnitudes: Point<N, M, K, P>,
    given: Vec<Point<N, M, K, P>>,
    /// Number of random points, if it was set.
    count: Option<usize>,
    seed: u64,
    spread: f64,
    tolerance: f64,
    admissible: Box<dyn Fn(&Point<N, M, K, P>) -> bool + 'a>,
    /// The blocks, each with the kind of its rows.
    blocks: Vec<(Rows, Block<'a>)>,
}

/// Kind of the rows of a block, with the prefix of their names.
enum Rows {
    Equations(&'static str),
    Coordinates(&'static str),
    One(&'static str),
}

impl<'a, E, const N: usize, const M: usize, const K: usize, const P: usize> ElementCheck<'a, E, N, M, K, P> {
    const PLACES: Places = Point::<N, M, K, P>::PLACES;

    fn new(element: &'a E, kind: &str, b: [f64; P]) -> Self {
        // Without the path of the module and the generic parameters.
        let name =
            std::any::type_name::<E>().split('<').next().and_then(|path| path.rsplit("::").next()).unwrap_or_default();
        let numbered = |name: &str, count: usize| (0..count).map(|i| format!("{name}[{i}]")).collect();
        ElementCheck {
            element,
            title: format!("{kind} `{name}`"),
            coordinates: numbered("q", N),
            equations: (0..M).map(|j| format!("equation {j}")).collect(),
            controls: numbered("u", K),
            constants: numbered("b", P),
            magnitudes: Point::same(1.0, b),
            given: Vec::new(),
            count: None,
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

    /// Changes the typical sizes of the arguments, 1 by default: `|m| m.q[0] = 2000.0` for a length in mm.
    pub fn magnitudes(mut self, change: impl FnOnce(&mut Point<N, M, K, P>)) -> Self {
        change(&mut self.magnitudes);
        self
    }

    /// Adds a point. Random points are then used only after a call of [`random_points`](Self::random_points).
    pub fn at(mut self, point: Point<N, M, K, P>) -> Self {
        self.given.push(point);
        self
    }

    /// Sets the number of random points (12 by default, none if points are given) and their seed.
    pub fn random_points(mut self, count: usize, seed: u64) -> Self {
        (self.count, self.seed) = (Some(count), seed);
        self
    }

    /// Varies the constants too, by this fraction; the hand-derived formulas must then use `b` of the point.
    pub fn vary_constants(mut self, fraction: f64) -> Self {
        self.spread = fraction;
        self
    }

    /// Restricts the comparison to points for which the condition holds; given points are always used.
    pub fn admissible(mut self, admissible: impl Fn(&Point<N, M, K, P>) -> bool + 'a) -> Self {
        self.admissible = Box::new(admissible);
        self
    }

    /// Sets the tolerance of an entry, relative to the size of its row and column (1e-11 by default).
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Adds a block with the user's version of it.
    fn block<A: Matrix>(
        mut self,
        f: impl Function + 'a,
        of: Derivative,
        hand: impl Fn(&Point<N, M, K, P>) -> A + 'a,
    ) -> Self {
        let (function, places) = (Rc::new(f), Self::PLACES);
        let made = |derived| Made { function: function.clone(), places, derived };
        let matrix = |&(name, derived, by): &Named| -> (String, MatrixAt<'a>) {
            let of = Jacobian::new(made(derived), places.of(by));
            (name.to_string(), Box::new(move |x| of.dual(x)))
        };
        let hand = Box::new(move |x: &[f64]| hand(&Point::from_list(x)).dense());
        // The arguments by which the function itself is differentiated.
        let below = of.derived.gradient.or(of.derived.rate.first().copied()).filter(|_| of.by != Part::One);
        let block = Block {
            foundation: below.map(|by| Jacobian::new(made(Derived::default()), places.of(by))),
            terms: of.terms.iter().map(matrix).collect(),
            others: of.others.iter().map(matrix).collect(),
            ..Block::new(of.name, Jacobian::new(made(of.derived), places.of(of.by)), hand)
        };
        self.blocks.push((of.rows, block));
        self
    }

    /// Compares all given blocks.
    ///
    /// If nothing can be compared, the report's `refused` gives the reason: an invalid tolerance or size, or a formula that is not finite
    /// at any random point.
    pub fn run(self) -> Report {
        let title = self.title.clone();
        Plan::run(self.plan(), title)
    }

    /// The points and the true values of all given blocks as JSON, for a program in another language that adds its own values: see
    /// [`Answers`](super::Answers).
    ///
    /// # Errors
    /// The reasons for which [`run`](Self::run) compares nothing.
    #[cfg(feature = "files")]
    pub fn worksheet(self) -> Result<String, Error> {
        let title = self.title.clone();
        Ok(self.plan()?.worksheet(&title, Point::<N, M, K, P>::from_list))
    }

    fn plan(mut self) -> Result<Plan<'a>, Error> {
        let drawn = self.points()?;
        let blocks = std::mem::take(&mut self.blocks).into_iter();
        let blocks: Vec<_> = blocks.map(|(rows, block)| Block { rows: self.names(rows), ..block }).collect();
        Ok(Plan::new(self.setting(drawn), blocks.into_iter()))
    }

    fn names(&self, of: Rows) -> Vec<String> {
        match of {
            Rows::Equations(prefix) => prefixed([prefix], &self.equations),
            Rows::Coordinates(prefix) => prefixed([prefix], &self.coordinates),
            Rows::One(name) => vec![name.to_string()],
        }
    }

    fn points(&self) -> Result<Drawn, Error> {
        check_tolerance(self.tolerance)?;
        check_magnitudes(&self.arguments(), &self.magnitudes.list())?;
        check_number("the variation of the constants", self.spread, self.spread.is_finite(), "finite")?;
        let finite =
            |x: &[f64]| self.blocks.iter().all(|(_, block)| block.truth.function.real(x).iter().all(|y| y.is_finite()));
        let usable = |x: &[f64]| (self.admissible)(&Point::from_list(x)) && finite(x);
        let fresh = |random: &mut Random| {
            let mut point = Point::random(&self.magnitudes, random);
            point.b.apply(|b| *b *= 1.0 + random.uniform(-self.spread, self.spread));
            point.list()
        };
        let signed: Vec<usize> = (0..Self::PLACES.of(Part::T).start).collect();
        draw(self.given.iter().map(Point::list).collect(), (self.count, self.seed), &signed, fresh, usable)
    }

    /// Names of all arguments, in the order of their list; the last one, the factor 1, has an empty name.
    fn arguments(&self) -> Vec<String> {
        let states = prefixed(["", "v of ", "p* of ", "ṗ* of ", "v̇ of "], &self.coordinates);
        let multipliers = prefixed(["σ of ", "λ of "], &self.equations);
        let controls = prefixed(["", "du/dt of "], &self.controls);
        [states, multipliers, controls, vec!["t".to_string()], self.constants.clone(), vec![String::new()]].concat()
    }

    fn setting(self, drawn: Drawn) -> Setting<'a> {
        let places = Self::PLACES;
        let groups = Part::GROUPS.map(|(part, _, name)| (name.to_string(), places.of(part)));
        let arguments = self.arguments();
        let constants = self.constants.into_iter().zip(self.magnitudes.b.iter().copied());
        let free = if self.spread == 0.0 { places.of(Part::T).end } else { places.of(Part::B).end };
        let mut setting = Setting::new(drawn, self.seed, self.tolerance, arguments, self.magnitudes.list());
        for (k, b) in places.of(Part::B).zip(self.magnitudes.b.iter()) {
            let within = (self.spread * b).abs();
            setting.bounds[k] = [b - within, b + within];
        }
        Setting {
            free: (0..free).collect(),
            groups: groups.to_vec(),
            admissible: Box::new(move |x| (self.admissible)(&Point::from_list(x))),
            factors: constants.filter(|_| self.spread == 0.0).collect(),
            ..setting
        }
    }
}

/// All names with each prefix.
fn prefixed<const L: usize>(prefixes: [&str; L], names: &[String]) -> Vec<String> {
    prefixes.iter().flat_map(|prefix| names.iter().map(move |name| format!("{prefix}{name}"))).collect()
}

/// A row of an element's table of derivatives: its name, the differentiated quantity and the variable.
struct Derivative {
    name: &'static str,
    rows: Rows,
    derived: Derived,
    by: Part,
    /// Terms of which the derivative is the sum, and blocks for which it may be mistaken.
    terms: &'static [Named],
    others: Vec<Named>,
}

/// A name, the differentiated quantity and the variable.
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
}
