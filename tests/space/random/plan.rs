//! Random scenes in space as plain data.

use hamiltonian_adjoint::check::Random;

/// A factor, times a design variable if one is given.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    pub factor: f64,
    pub of: Option<usize>,
}

impl Number {
    pub fn value(self, designs: &[f64]) -> f64 {
        self.of.map_or(self.factor, |design| self.factor * designs[design])
    }
}

pub fn values<const N: usize>(numbers: [Number; N], designs: &[f64]) -> [f64; N] {
    numbers.map(|number| number.value(designs))
}

#[derive(Clone, Copy, Debug)]
pub enum Axes {
    OfBody,
    Along([Number; 3]),
    Toward([Number; 3], [Number; 3]),
    Turned([Number; 3]),
}

/// The body in the plane, as a body in space.
pub const FLAT: usize = usize::MAX;

/// A marker of a body, or of the ground.
#[derive(Clone, Copy, Debug)]
pub struct At {
    pub body: Option<usize>,
    pub at: [Number; 3],
    pub axes: Axes,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Revolute,
    Prismatic,
    Universal,
    Cylindrical,
    Planar,
    Ball,
    Free,
    Fixed,
    DependentRevolute,
    DependentPrismatic,
}

#[derive(Clone, Debug)]
pub struct Link {
    pub mass: Number,
    pub centre: [Number; 3],
    /// J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about the centre of mass.
    pub tensor: [Number; 6],
    pub kind: Kind,
    pub outer: At,
    pub inner: At,
    /// Which coordinate a dependent joint follows, counted round, and factor and offset.
    pub follows: (usize, [Number; 2]),
}

#[derive(Clone, Copy, Debug)]
pub enum Load {
    SpringDamper(At, At, [Number; 3]),
    InSpace(At, [Number; 6]),
    OnBody(At, [Number; 6]),
    Thrust(At),
    Torque(At, At),
    Actuator(At, At),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    Ball,
    Parallel,
    Revolute,
    Cylindrical,
    Prismatic,
    Fixed,
    Plane,
    Line,
    Distance,
}

/// A constraint between a marker and one of another body, where the first is at the start.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    pub kind: Closed,
    pub a: At,
    pub b: Option<usize>,
}

#[derive(Clone, Debug)]
pub struct Plan {
    pub designs: Vec<f64>,
    pub gravity: [Number; 3],
    /// Mass and moment of inertia of a body in the plane, if there is one.
    pub flat: Option<[f64; 2]>,
    pub links: Vec<Link>,
    pub loads: Vec<Load>,
    pub closings: Vec<Closing>,
    /// The links at whose bodies chains are cut.
    pub cuts: Vec<usize>,
    /// The marker of outputs and costs.
    pub tip: At,
}

/// What a plan may contain.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    pub loads: bool,
    pub conservative: bool,
    /// One free tree without gravity.
    pub afloat: bool,
    pub loops: bool,
}

struct Source<'a> {
    random: &'a mut Random,
    designs: Vec<f64>,
}

impl Source<'_> {
    fn chance(&mut self, share: f64) -> bool {
        self.random.uniform(0.0, 1.0) < share
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.random.below(of.len())]
    }

    /// A number with this value, sometimes of a design variable.
    fn number(&mut self, value: f64) -> Number {
        if !self.chance(0.15) {
            return Number { factor: value, of: None };
        }
        let design = self.random.below(self.designs.len());
        Number { factor: value / self.designs[design], of: Some(design) }
    }

    fn vector(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| self.random.uniform(-size, size))
    }

    fn direction(&mut self) -> [f64; 3] {
        let small = self.pick(&[0.0, 1e-12, 1e-7, 1e-3, 0.3]);
        match self.random.below(8) {
            0 => [0.0, 0.0, -1.0],
            1 => [small, -small, -1.0],
            2 => [small, 0.5 * small, 2.0],
            3 => self.pick(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [-3.0, 0.0, 0.0]]),
            _ => [0; 3].map(|_| self.random.away_from_zero(2.0)),
        }
    }

    fn numbers<const N: usize>(&mut self, values: [f64; N]) -> [Number; N] {
        values.map(|value| self.number(value))
    }

    fn axes(&mut self) -> Axes {
        match self.random.below(4) {
            0 => Axes::OfBody,
            1 => {
                let z = self.direction();
                Axes::Along(self.numbers(z))
            }
            2 => {
                let z = self.direction();
                let mut x = self.vector(1.0);
                // Not along z.
                let largest = (0..3).max_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs())).unwrap_or(0);
                x[(largest + 1) % 3] += 2.0;
                Axes::Toward(self.numbers(z), self.numbers(x))
            }
            _ => {
                let angles = self.vector(3.0);
                Axes::Turned(self.numbers(angles))
            }
        }
    }

    fn at(&mut self, body: Option<usize>) -> At {
        let at = self.vector(0.4);
        let axes = self.axes();
        At { body, at: self.numbers(at), axes }
    }

    /// The inertia of masses s² along three axes, turned.
    fn tensor(&mut self, mass: f64) -> [f64; 6] {
        let size = self.random.uniform(0.1, 0.4);
        let s = [0; 3].map(|_| mass * size * size * self.random.uniform(0.3, 1.0));
        let turn = super::chain::turned(self.vector(3.0));
        let entry = |i: usize, j: usize| {
            let along: f64 = (0..3).map(|k| turn[(i, k)] * s[k] * turn[(j, k)]).sum();
            if i == j { s.iter().sum::<f64>() - along } else { -along }
        };
        [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
    }

    fn link(&mut self, parent: Option<usize>, own: usize, kind: Kind, has_mass: bool) -> Link {
        let mass = if has_mass { self.random.uniform(0.3, 2.0) } else { 0.0 };
        // A mass that is fixed to another one may be a point.
        let is_point = !has_mass || (kind == Kind::Fixed && parent.is_some() && self.chance(0.5));
        let tensor = if is_point { [0.0; 6] } else { self.tensor(mass) };
        let centre = self.vector(0.3);
        let constant = |factor| Number { factor, of: None };
        let rule = [self.random.away_from_zero(2.0), self.random.uniform(-1.0, 1.0)];
        Link {
            mass: if has_mass { self.number(mass) } else { constant(0.0) },
            centre: self.numbers(centre),
            tensor: if is_point { tensor.map(constant) } else { self.numbers(tensor) },
            kind,
            outer: self.at(parent),
            inner: self.at(Some(own)),
            follows: (self.random.below(100), self.numbers(rule)),
        }
    }
}

const SMALL: [Kind; 4] = [Kind::Revolute, Kind::Prismatic, Kind::Universal, Kind::Cylindrical];
const ALL: [Kind; 12] = [
    Kind::Revolute,
    Kind::Revolute,
    Kind::Prismatic,
    Kind::Universal,
    Kind::Cylindrical,
    Kind::Planar,
    Kind::Ball,
    Kind::Ball,
    Kind::Free,
    Kind::Fixed,
    Kind::DependentRevolute,
    Kind::DependentPrismatic,
];

fn can_be_followed(links: &[Link], has_flat: bool) -> bool {
    has_flat || links.iter().any(|link| !matches!(link.kind, Kind::Ball | Kind::Fixed))
}

/// The body to which a body is fixed.
fn base(links: &[Link], body: Option<usize>) -> Option<usize> {
    match body.and_then(|body| links.get(body)) {
        Some(link) if link.kind == Kind::Fixed => base(links, link.outer.body),
        _ => body,
    }
}

/// A random plan.
pub fn plan(random: &mut Random, scope: Scope) -> Plan {
    let designs = [0; 4].map(|_| random.uniform(0.5, 1.5)).to_vec();
    let mut source = Source { random, designs };
    let flat = (!scope.afloat && source.chance(0.3)).then(|| [0; 2].map(|_| source.random.uniform(0.3, 1.0)));
    let (mut links, count) = (Vec::new(), 1 + source.random.below(6));
    while links.len() < count {
        let is_first = links.is_empty();
        let parent =
            if is_first || (!scope.afloat && source.chance(0.25)) { None } else { Some(source.random.below(links.len())) };
        // A dependent joint of the first link has nothing to follow.
        // One that follows a place in space would hold it.
        let kinds = if is_first { &ALL[..9] } else { &ALL[..if scope.afloat { 10 } else { 12 }] };
        let kind = match source.pick(kinds) {
            _ if is_first && scope.afloat => Kind::Free,
            Kind::DependentRevolute | Kind::DependentPrismatic if !can_be_followed(&links, flat.is_some()) => Kind::Revolute,
            kind => kind,
        };
        let link = if kind != Kind::Free && !is_first && source.chance(0.2) {
            // A body without mass, and one that it carries.
            let (first, second) = (source.pick(&SMALL), source.pick(&SMALL));
            links.push(source.link(parent, links.len(), first, false));
            source.link(Some(links.len() - 1), links.len(), second, true)
        } else {
            source.link(parent, links.len(), kind, true)
        };
        links.push(link);
    }
    let gravity = if scope.afloat { [0.0; 3] } else { source.vector(9.81) };
    let any = |source: &mut Source, count: usize| (count > 0).then(|| source.random.below(count));
    let tip = any(&mut source, links.len());
    let tip = source.at(tip);
    let mut loads = Vec::new();
    for _ in 0..if scope.loads { source.random.below(4) } else { 0 } {
        let first = any(&mut source, links.len());
        let second = if source.chance(0.5) && !scope.afloat { None } else { any(&mut source, links.len()) };
        if base(&links, first) == base(&links, second) || base(&links, first).is_none() {
            continue;
        }
        let (a, b) = (source.at(first), source.at(second));
        let six = [0; 6].map(|_| source.random.uniform(-1.0, 1.0));
        let damping = if scope.conservative { 0.0 } else { 0.4 };
        loads.push(match source.random.below(if scope.conservative { 1 } else { 6 }) {
            0 => Load::SpringDamper(a, b, source.numbers([8.0, 0.2, damping])),
            1 => Load::InSpace(a, source.numbers(six)),
            2 => Load::OnBody(a, source.numbers(six)),
            3 => Load::Thrust(a),
            4 => Load::Torque(b, a),
            _ => Load::Actuator(b, a),
        });
    }
    let mut closings = Vec::new();
    for _ in 0..if scope.loops { 1 + source.random.below(2) } else { 0 } {
        const KINDS: [Closed; 9] = [
            Closed::Ball,
            Closed::Parallel,
            Closed::Revolute,
            Closed::Cylindrical,
            Closed::Prismatic,
            Closed::Fixed,
            Closed::Plane,
            Closed::Line,
            Closed::Distance,
        ];
        let a = any(&mut source, links.len());
        let b = if source.chance(0.4) || links.len() == 1 { None } else { Some((a.unwrap_or(0) + 1) % links.len()) };
        if base(&links, a) == base(&links, b) {
            continue;
        }
        closings.push(Closing { kind: source.pick(&KINDS), a: source.at(a), b });
    }
    let gravity = source.numbers(gravity);
    Plan { designs: source.designs, gravity, flat, links, loads, closings, cuts: Vec::new(), tip }
}
