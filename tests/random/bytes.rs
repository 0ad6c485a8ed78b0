//! Any bytes as a description, sane or absurd: what a fuzzer drives.

use hamiltonian_adjoint::{Scheme, Settings, Sum};

use crate::description::*;

/// Numbers that break formulas.
const ABSURD: [f64; 24] = [
    0.0,
    -0.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    1e300,
    -1e300,
    1e-300,
    -1e-300,
    1e154,
    1e-154,
    1e100,
    1e-100,
    1e16,
    1e-16,
    1e8,
    1e-8,
    f64::EPSILON,
    std::f64::consts::FRAC_PI_2,
];

/// Bytes that are read one after the other; zeros follow the last.
pub struct Bytes<'b>(pub &'b [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((&first, rest)) => {
                self.0 = rest;
                first
            }
            None => 0,
        }
    }

    /// A whole number below `count`.
    fn below(&mut self, count: u8) -> usize {
        (self.byte() % count) as usize
    }

    fn flag(&mut self) -> bool {
        self.byte() >= 128
    }

    /// An index, of something foreign in one case of 256.
    fn index(&mut self) -> usize {
        match self.byte() {
            255 => FOREIGN,
            byte => byte as usize,
        }
    }

    /// Mostly a number of moderate size; `lean` is its size without its sign.
    fn number(&mut self, lean: f64) -> f64 {
        match self.byte() {
            byte @ 0..=199 => lean * (0.01 * (byte as f64) + 0.3),
            byte @ 200..=239 => -lean * (0.05 * (byte - 199) as f64),
            240..=253 => ABSURD[self.below(ABSURD.len() as u8)],
            _ => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte()))),
        }
    }

    /// The same, seldom negative.
    fn positive(&mut self, lean: f64) -> f64 {
        let number = self.number(lean);
        if self.byte() < 240 { number.abs() } else { number }
    }

    fn point(&mut self) -> [f64; 2] {
        [self.number(0.5), self.number(0.5)]
    }

    fn many<T>(&mut self, most: u8, one: impl Fn(&mut Self) -> T) -> Vec<T> {
        let count = self.below(most + 1);
        (0..count).map(|_| one(self)).collect()
    }

    /// The scene and the motion that the bytes stand for.
    pub fn description(&mut self) -> Description {
        Description {
            gravity: self.point(),
            gravity_binding: self.binding(),
            designs: self.many(4, |bytes| bytes.number(1.0)),
            controls: self.below(3),
            bodies: self.many(5, Bytes::bar),
            groups: self.many(2, Bytes::group),
            loops: self.many(3, |bytes| Loop { pair: bytes.pair(), joint: bytes.joint() }),
            redundant: self.many(1, Bytes::redundant),
            loads: self.many(4, Bytes::load),
            terms: self.many(4, Bytes::term),
            same_names: self.byte() > 250,
            run: self.run(),
        }
    }

    fn binding(&mut self) -> Binding {
        let mask = if self.flag() { u16::from_le_bytes([self.byte(), self.byte()]) } else { 0 };
        Binding { mask, first: self.index() }
    }

    fn bar(&mut self) -> Bar {
        Bar {
            mass: self.positive(1.0),
            inertia: self.positive(0.1),
            place: [self.number(0.5), self.number(0.5), self.number(2.0)],
            parent: self.index(),
            joint: self.joint(),
            binding: self.binding(),
        }
    }

    fn joint(&mut self) -> Joint {
        let kind = match self.below(12) {
            1 => JointKind::Free,
            2 => JointKind::Prismatic { axis: self.number(1.0) },
            3 => JointKind::Weld,
            4 => JointKind::Distance { length: self.positive(0.5), angle: self.number(1.0) },
            5 => JointKind::ConstantSpeed { speed: self.number(1.0) },
            6 => JointKind::Harmonic { amplitude: self.number(0.2), frequency: self.number(3.0), phase: self.number(1.0) },
            7 => JointKind::Parabola { curvature: self.number(0.4) },
            8 => JointKind::Geared { ratio: self.number(1.0) },
            _ => JointKind::Revolute,
        };
        Joint { at: self.point(), kind, binding: self.binding() }
    }

    fn pair(&mut self) -> Pair {
        Pair { a: self.index(), step: self.index() }
    }

    fn group(&mut self) -> Group {
        let kind = if self.flag() {
            GroupKind::Polar { mass: self.positive(1.0), radius: self.number(0.5) }
        } else {
            GroupKind::Coupled { masses: [self.positive(0.5), self.positive(0.5)], coupling: self.number(0.4) }
        };
        let geared = if self.flag() { Some((self.index(), self.number(1.0))) } else { None };
        Group { kind, place: self.point(), binding: self.binding(), geared }
    }

    fn redundant(&mut self) -> Redundant {
        if self.flag() {
            Redundant::ThirdCrank { length: self.number(0.5), angle: self.number(1.0) }
        } else {
            Redundant::DoubledHinge { body: self.byte() as usize }
        }
    }

    fn load(&mut self) -> Load {
        let kind = match self.below(13) {
            0 => LoadKind::Strut {
                at: self.point(),
                length: self.number(0.5),
                angle: self.number(1.0),
                stiffness: self.number(20.0),
                stretch: self.number(1.0),
                damping: self.number(1.0),
            },
            1 => LoadKind::Torsion { stiffness: self.number(2.0), angle: self.number(0.3), damping: self.number(0.3) },
            2 => LoadKind::Friction { damping: self.number(0.3) },
            3 => LoadKind::Sliding { at: self.point(), axis: self.number(1.0), damping: self.number(0.3) },
            4 => LoadKind::Actuator { at: self.point(), axis: self.number(1.0) },
            5 => LoadKind::Torque,
            6 => LoadKind::AirDrag { coefficient: self.number(0.3) },
            7 => LoadKind::Magnet { strength: self.number(1.0), distance: self.number(1.0) },
            8 => LoadKind::Wave { strength: self.number(1.0), frequency: self.number(2.0) },
            9 => LoadKind::Mixed { constants: std::array::from_fn(|_| self.number(0.3)) },
            10 => LoadKind::Contact {
                at: self.point(),
                angle: self.number(1.0),
                radius: if self.flag() { Some(self.number(0.5)) } else { None },
                depth: self.number(0.1),
                law: [self.number(100.0), self.number(0.3), self.number(0.3), self.number(0.1)],
            },
            11 => LoadKind::Stop {
                at: self.point(),
                axis: if self.flag() { Some(self.number(1.0)) } else { None },
                limits: [-self.number(0.3), self.number(0.3)],
                law: [self.number(20.0), self.number(0.3), self.number(0.1)],
            },
            _ => LoadKind::TipMass { mass: self.positive(0.5), at: self.point() },
        };
        Load { kind, pair: self.pair(), control: self.index(), binding: self.binding() }
    }

    fn term(&mut self) -> Term {
        use TermKind::*;
        Term {
            kind: [Everything, Coordinate, Effort, Reaction, Momentum][self.below(5)],
            sum: [Sum::Terminal, Sum::Plain, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral, Sum::AllNodes][self.below(6)],
            body: self.index(),
            multiplier: self.index(),
            control: self.index(),
            weight: self.number(1.0),
            binding: self.binding(),
        }
    }

    fn run(&mut self) -> Run {
        Run {
            start: self.number(1.0),
            steps: self.many(6, |bytes| bytes.number(0.02)),
            composition: None,
            tolerance: None,
            from: [From::Momentum, From::Velocity, From::AnyVelocity][self.below(3)],
            speed: self.number(1.0),
            controls: self.number(1.0),
            seed: self.byte() as usize,
            settings: self.settings(),
            faults: self.many(1, Bytes::fault),
        }
    }

    /// Mostly the default; tolerances that let everything pass find what breaks later.
    fn settings(&mut self) -> Settings {
        let usual = Settings { scheme: Scheme::ALL[self.below(10).saturating_sub(5)], ..Settings::default() };
        match self.byte() {
            0..=127 => usual,
            128..=191 => Settings { position_tolerance: f64::INFINITY, velocity_tolerance: f64::INFINITY, ..usual },
            _ => Settings {
                scheme: usual.scheme,
                tolerance: self.number(1e-10),
                max_iterations: self.below(30),
                position_tolerance: self.number(1.0),
                velocity_tolerance: self.number(1.0),
                max_halvings: self.below(5),
                drift_bound: self.number(1e-3),
                rebase_every: self.below(4),
                keep_adjoint: self.flag(),
            },
        }
    }

    fn fault(&mut self) -> Fault {
        use Vector::*;
        let of = [Coordinates, Rates, Controls, Designs, Steps][self.below(5)];
        if self.flag() {
            Fault::Length { of, length: self.below(20) }
        } else {
            Fault::Value { of, index: self.byte() as usize, value: self.number(1.0) }
        }
    }
}
