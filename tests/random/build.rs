//! A description turned into a scene and inputs, with the public interface alone.

use hamiltonian_adjoint::planar::{Body, ConstantSpeed, Frame, Harmonic, Point};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{
    Control, Coordinate, Design, Error, Grid, Inputs, Multiplier, Param, Scene, Start, System, simulate,
};
use nalgebra::DVector;

use crate::bench::{Everything, number};
use crate::description::*;
use crate::elements::{Coupled, Effort, Geared, Mixed, Momentum, Polar, Reaction, TipMass, Wave};
use crate::parts::{AirDrag, Magnet, Parabola};

/// A scene and, for each coordinate, the size of the mass or moment of inertia that moves with it.
pub struct Built {
    pub scene: Scene,
    pub inertia: Vec<f64>,
    pub coordinates: Vec<Coordinate>,
    pub multipliers: Vec<Multiplier>,
    /// The ground and the bodies.
    pub parts: Vec<Part>,
}

/// The scene of a description.
pub fn scene(description: &Description) -> Built {
    let mut builder = Builder::new(description);
    for i in 0..description.bodies.len() {
        builder.bar(i);
    }
    description.groups.iter().for_each(|group| builder.group(group));
    description.loops.iter().for_each(|l| builder.closing(l));
    description.redundant.iter().for_each(|redundant| builder.redundant(*redundant));
    description.loads.iter().for_each(|load| builder.load(load));
    description.terms.iter().for_each(|term| builder.term(term));
    let Builder { scene, inertia, coordinates, multipliers, parts, .. } = builder;
    Built { scene, inertia, coordinates, multipliers, parts }
}

/// The inputs of a description for its compiled scene.
///
/// # Errors
/// Those of the start, if velocities are to be computed from momenta.
pub fn inputs(run: &Run, system: &System, inertia: &[f64]) -> Result<Inputs, Error> {
    let grid = match run.composition {
        None => Grid::new(run.start, run.steps.clone()),
        Some(composition) => Grid { start: run.start, ..Grid::composed(run.steps.len(), run.steps[0], composition) },
    };
    let mut inputs = Inputs::at_rest(system, grid);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = run.controls * number(i + run.seed + 7));
    let q = system.initial_coordinates();
    let v = DVector::from_fn(system.n(), |i, _| run.speed * number(i + run.seed + 3));
    let p_star = DVector::from_fn(system.n(), |i, _| v[i] * inertia[i]);
    inputs.start = match run.from {
        From::AnyVelocity => Start::Velocity { q, v },
        _ => Start::Momentum { q, p_star },
    };
    if let From::Velocity = run.from {
        let grid = Grid::new(run.start, Vec::new());
        let controls = inputs.controls.columns(0, 1).into_owned();
        let there = simulate(system, &Inputs { grid, controls, ..inputs.clone() }, run.settings)?;
        inputs.start = Start::Velocity { q: inputs.start.q().clone(), v: there.v.column(0).into_owned() };
    }
    run.faults.iter().for_each(|fault| fault.spoil(&mut inputs));
    Ok(inputs)
}

impl Fault {
    fn spoil(self, inputs: &mut Inputs) {
        match self {
            Fault::Value { of, index, value } => {
                let entries = match of {
                    Vector::Coordinates => inputs.start.q_mut().as_mut_slice(),
                    Vector::Rates => inputs.start.rate_mut().as_mut_slice(),
                    Vector::Controls => inputs.controls.as_mut_slice(),
                    Vector::Designs => inputs.design.as_mut_slice(),
                    Vector::Steps => &mut inputs.grid.steps,
                };
                let len = entries.len();
                if let Some(entry) = entries.get_mut(index % len.max(1)) {
                    *entry = value;
                }
            }
            Fault::Length { of, length } => match of {
                Vector::Coordinates => inputs.start.q_mut().resize_vertically_mut(length, 0.5),
                Vector::Rates => inputs.start.rate_mut().resize_vertically_mut(length, 0.5),
                Vector::Controls => inputs.controls.resize_mut(length % 4, length, 0.5),
                Vector::Designs => inputs.design.resize_vertically_mut(length, 0.5),
                Vector::Steps => inputs.grid.steps.resize(length, 0.01),
            },
        }
    }
}

/// The ground or a body, and its place at the start.
#[derive(Clone, Copy)]
pub struct Part {
    pub frame: Frame,
    pub place: [f64; 3],
}

const GROUND: Part = Part { frame: Body::GROUND, place: [0.0; 3] };

/// One thing of every kind that belongs to another scene.
struct Foreign {
    part: Part,
    control: Control,
    design: Design,
    multiplier: Multiplier,
}

impl Foreign {
    fn new() -> Self {
        let mut scene = Scene::new();
        let body = scene.body("foreign", 1.0, 0.1, [0.0; 3]);
        let [multiplier, _] = scene.revolute("foreign", Body::GROUND.at(0.0, 0.0), body.at(0.0, 0.0));
        let part = Part { frame: body.into(), place: [0.0; 3] };
        Foreign { part, control: scene.control("foreign"), design: scene.design("foreign", 1.0), multiplier }
    }
}

struct Builder<'d> {
    description: &'d Description,
    scene: Scene,
    inertia: Vec<f64>,
    foreign: Foreign,
    controls: Vec<Control>,
    designs: Vec<Design>,
    parts: Vec<Part>,
    coordinates: Vec<Coordinate>,
    /// x and y of every body and the coordinates of every group.
    doublets: Vec<[Coordinate; 2]>,
    multipliers: Vec<Multiplier>,
    names: usize,
}

/// The constants of one element, bound or not.
struct Constants<'b> {
    designs: Vec<Design>,
    values: &'b [f64],
    foreign: Design,
    binding: Binding,
    count: usize,
}

impl Constants<'_> {
    fn of(&mut self, value: f64) -> Param {
        let c = self.count;
        self.count += 1;
        if self.binding.mask >> (c % 16) & 1 == 0 {
            return value.into();
        }
        if self.binding.first == FOREIGN {
            return self.foreign.into();
        }
        match self.designs.len() {
            0 => value.into(),
            len => {
                let p = (self.binding.first + c) % len;
                self.designs[p] * (value / self.values[p])
            }
        }
    }

    /// A number of a law, whose width is no design variable if it is 0.
    fn of_law(&mut self, value: f64) -> Param {
        if value == 0.0 { value.into() } else { self.of(value) }
    }

    /// The point of a part that is here at the start.
    fn point(&mut self, part: Part, [x, y]: [f64; 2]) -> Point {
        let (dx, dy, (sin, cos)) = (x - part.place[0], y - part.place[1], part.place[2].sin_cos());
        let along = self.of(cos * dx + sin * dy);
        part.frame.at(along, self.of(cos * dy - sin * dx))
    }
}

fn beyond([x, y]: [f64; 2], length: f64, angle: f64) -> [f64; 2] {
    [x + length * angle.cos(), y + length * angle.sin()]
}

impl<'d> Builder<'d> {
    fn new(description: &'d Description) -> Self {
        let mut builder = Builder {
            description,
            scene: Scene::new(),
            inertia: Vec::new(),
            foreign: Foreign::new(),
            controls: Vec::new(),
            designs: Vec::new(),
            parts: vec![GROUND],
            coordinates: Vec::new(),
            doublets: Vec::new(),
            multipliers: Vec::new(),
            names: 0,
        };
        for value in &description.designs {
            let name = builder.name("design variable");
            builder.designs.push(builder.scene.design(&name, *value));
        }
        for _ in 0..description.controls {
            let name = builder.name("control");
            builder.controls.push(builder.scene.control(&name));
        }
        let mut constants = builder.constants(description.gravity_binding);
        let [x, y] = description.gravity.map(|g| constants.of(g));
        builder.scene.gravity(x, y);
        builder
    }

    fn name(&mut self, what: &str) -> String {
        self.names += 1;
        if self.description.same_names { what.to_string() } else { format!("{what} {}", self.names) }
    }

    fn constants(&self, binding: Binding) -> Constants<'d> {
        // The handles are copied so that the scene can be written to meanwhile.
        let designs = self.designs.clone();
        Constants { designs, values: &self.description.designs, foreign: self.foreign.design, binding, count: 0 }
    }

    fn part(&self, index: usize) -> Part {
        if index == FOREIGN { self.foreign.part } else { self.parts[index % self.parts.len()] }
    }

    /// A body, if there is any.
    fn body(&self, index: usize) -> Option<[Coordinate; 3]> {
        match self.parts.len() {
            _ if index == FOREIGN => self.foreign.part.frame.coordinates(),
            1 => None,
            parts => self.parts[1 + index % (parts - 1)].frame.coordinates(),
        }
    }

    /// Two coordinates of a body or a group, if there is any.
    fn doublet(&self, index: usize) -> Option<[Coordinate; 2]> {
        match self.doublets.len() {
            _ if index == FOREIGN => self.body(FOREIGN).map(|[x, y, _]| [x, y]),
            0 => None,
            count => Some(self.doublets[index % count]),
        }
    }

    fn pair(&self, pair: Pair) -> [Part; 2] {
        let (count, a) = (self.parts.len(), self.part(pair.a));
        match pair.step {
            FOREIGN => [a, a],
            _ if pair.a == FOREIGN => [a, self.part(pair.step)],
            step => [a, self.parts[(pair.a % count + 1 + step % count.saturating_sub(1).max(1)) % count]],
        }
    }

    fn control(&self, index: usize) -> Option<Control> {
        match self.controls.len() {
            _ if index == FOREIGN => Some(self.foreign.control),
            0 => None,
            count => Some(self.controls[index % count]),
        }
    }

    fn multiplier(&self, index: usize) -> Option<Multiplier> {
        match self.multipliers.len() {
            _ if index == FOREIGN => Some(self.foreign.multiplier),
            0 => None,
            count => Some(self.multipliers[index % count]),
        }
    }

    fn add_body(&mut self, mass: f64, inertia: f64, place: [f64; 3], binding: Binding) -> Part {
        let name = self.name("body");
        let mut constants = self.constants(binding);
        let body = self.scene.body(&name, constants.of(mass), constants.of(inertia), place);
        self.inertia.extend([mass, mass, inertia]);
        let part = Part { frame: body.into(), place };
        self.parts.push(part);
        self.coordinates.extend(body.coordinates);
        self.doublets.push([body.coordinates[0], body.coordinates[1]]);
        part
    }

    fn bar(&mut self, i: usize) {
        let bar = &self.description.bodies[i];
        let parent = self.part(bar.parent);
        let part = self.add_body(bar.mass, bar.inertia, bar.place, bar.binding);
        self.joint(parent, part, &bar.joint);
    }

    fn closing(&mut self, l: &Loop) {
        let [a, b] = self.pair(l.pair);
        self.joint(a, b, &l.joint);
    }

    fn joint(&mut self, a: Part, b: Part, joint: &Joint) {
        let at = joint.at;
        let mut c = self.constants(joint.binding);
        let name = self.name("joint");
        let turn = b.place[2] - a.place[2];
        match joint.kind {
            JointKind::Free => {}
            JointKind::Revolute => self.hinge(&name, a, b, at, &mut c),
            JointKind::Prismatic { axis } => {
                let (from, along) = (c.point(a, at), c.of(axis - a.place[2]));
                let sigma = self.scene.prismatic(&name, from, along, c.point(b, at), c.of(turn));
                self.multipliers.extend(sigma);
            }
            JointKind::Weld => {
                let sigma = self.scene.weld(&name, c.point(a, at), c.point(b, at), c.of(turn));
                self.multipliers.extend(sigma);
            }
            JointKind::Distance { length, angle } => {
                let (from, to) = (c.point(a, at), c.point(b, beyond(at, length, angle)));
                let sigma = self.scene.distance(&name, from, to, c.of(length));
                self.multipliers.extend(sigma);
            }
            JointKind::ConstantSpeed { speed } => {
                self.hinge(&name, a, b, at, &mut c);
                let motion = [c.of(turn - speed * self.description.run.start), c.of(speed)];
                let motor = self.name("motor");
                let sigma = self.scene.driven_angle(&motor, a.frame, b.frame, ConstantSpeed, motion);
                self.multipliers.extend(sigma);
            }
            JointKind::Harmonic { amplitude, frequency, phase } => {
                self.hinge(&name, a, b, at, &mut c);
                let there = amplitude * (frequency * self.description.run.start + phase).sin();
                let motion = [turn - there, amplitude, frequency, phase].map(|x| c.of(x));
                let motor = self.name("motor");
                let sigma = self.scene.driven_angle(&motor, a.frame, b.frame, Harmonic, motion);
                self.multipliers.extend(sigma);
            }
            JointKind::Parabola { curvature } => {
                let Some([x, y, _]) = b.frame.coordinates() else { return };
                let height = b.place[1] - curvature * b.place[0] * b.place[0];
                let sigma = self.scene.constraint(&name, Parabola, [x, y], [c.of(curvature), c.of(height)]);
                self.multipliers.extend(sigma);
            }
            JointKind::Geared { ratio } => {
                if let (Some(a_q), Some(b_q)) = (a.frame.coordinates(), b.frame.coordinates()) {
                    self.gear(&name, [a_q[2], b_q[2]], [a.place[2], b.place[2]], ratio, &mut c);
                }
            }
        }
    }

    fn hinge(&mut self, name: &str, a: Part, b: Part, at: [f64; 2], c: &mut Constants) {
        let sigma = self.scene.revolute(name, c.point(a, at), c.point(b, at));
        self.multipliers.extend(sigma);
    }

    fn gear(&mut self, name: &str, q: [Coordinate; 2], at: [f64; 2], ratio: f64, c: &mut Constants) {
        let shift = at[1] - ratio * at[0] - Geared::WOBBLE * at[0].sin();
        let sigma = self.scene.constraint(name, Geared, q, [c.of(ratio), c.of(shift)]);
        self.multipliers.extend(sigma);
    }

    fn group(&mut self, group: &Group) {
        let name = self.name("group");
        let q = self.scene.coordinates(&name, ["first", "second"]);
        self.doublets.push(q);
        self.coordinates.extend(q);
        self.scene.place(q[0], group.place[0]);
        self.scene.place(q[1], group.place[1]);
        let mut c = self.constants(group.binding);
        match group.kind {
            GroupKind::Polar { mass, radius } => {
                self.scene.kinetic_energy(&name, Polar, q, [c.of(mass), c.of(radius)]);
                self.inertia.extend([mass, mass * (radius * radius + group.place[0] * group.place[0])]);
            }
            GroupKind::Coupled { masses, coupling } => {
                self.scene.kinetic_energy(&name, Coupled, q, [c.of(masses[0]), c.of(masses[1]), c.of(coupling)]);
                self.inertia.extend(masses);
            }
        }
        let Some((body, ratio)) = group.geared else { return };
        let place = self.part(1 + body % self.parts.len().saturating_sub(1).max(1)).place;
        if let Some([_, _, angle]) = self.body(body) {
            let gear = self.name("gear");
            self.gear(&gear, [angle, q[1]], [place[2], group.place[1]], ratio, &mut c);
        }
    }

    fn redundant(&mut self, redundant: Redundant) {
        const NUMBERS: Binding = Binding { mask: 0, first: 0 };
        match redundant {
            Redundant::DoubledHinge { body } => {
                let bodies = &self.description.bodies;
                let Some(bar) = bodies.get(body % bodies.len().max(1)) else { return };
                let i = body % bodies.len();
                // The parent as it was counted when only the bodies before this one were there.
                let parent = if bar.parent == FOREIGN { FOREIGN } else { bar.parent % (i + 1) };
                let (parent, part) = (self.part(parent), self.part(1 + i));
                let hinge = Joint { kind: JointKind::Revolute, binding: NUMBERS, ..bar.joint };
                self.joint(parent, part, &hinge);
                if !matches!(bar.joint.kind, JointKind::Revolute) {
                    self.joint(parent, part, &hinge);
                }
            }
            Redundant::ThirdCrank { length, angle } => {
                let feet = [[3.0, 0.0], [3.4, 0.0], [4.0, 0.0]];
                let [x, y] = beyond([3.5, 0.0], length, angle);
                let coupler = self.add_body(0.7, 0.06, [x, y, 0.0], NUMBERS);
                for foot in feet {
                    let [x, y] = beyond(foot, 0.5 * length, angle);
                    let crank = self.add_body(0.5, 0.04, [x, y, angle], NUMBERS);
                    let hinge = |at| Joint { at, kind: JointKind::Revolute, binding: NUMBERS };
                    self.joint(GROUND, crank, &hinge(foot));
                    self.joint(crank, coupler, &hinge(beyond(foot, length, angle)));
                }
            }
        }
    }

    fn load(&mut self, load: &Load) {
        let [a, b] = self.pair(load.pair);
        let name = self.name("load");
        let mut c = self.constants(load.binding);
        let body = self.body(load.pair.a);
        match load.kind {
            LoadKind::Strut { at, length, angle, stiffness, stretch, damping } => {
                let (from, to) = (c.point(a, at), c.point(b, beyond(at, length, angle)));
                let constants = [stiffness, length * stretch, damping].map(|x| c.of(x));
                self.scene.spring_damper(&name, from, to, constants[0], constants[1], constants[2]);
            }
            LoadKind::Torsion { stiffness, angle, damping } => {
                let rest = b.place[2] - a.place[2] + angle;
                let constants = [stiffness, rest, damping].map(|x| c.of(x));
                self.scene.torsional_spring_damper(&name, a.frame, b.frame, constants[0], constants[1], constants[2]);
            }
            LoadKind::Friction { damping } => self.scene.joint_friction(&name, a.frame, b.frame, c.of(damping)),
            LoadKind::Sliding { at, axis, damping } => {
                let (from, to, axis) =
                    (c.point(a, at), c.point(b, b.place.first_chunk().copied().unwrap_or(at)), c.of(axis));
                self.scene.sliding_friction(&name, from, axis, to, c.of(damping));
            }
            LoadKind::Actuator { at, axis } => {
                let Some(control) = self.control(load.control) else { return };
                let (from, to) = (c.point(a, at), c.point(b, b.place.first_chunk().copied().unwrap_or(at)));
                self.scene.actuator(&name, from, c.of(axis), to, control);
            }
            LoadKind::Torque => {
                let Some(control) = self.control(load.control) else { return };
                self.scene.torque_actuator(&name, a.frame, b.frame, control);
            }
            LoadKind::AirDrag { coefficient } => {
                let Some(q) = self.doublet(load.pair.a) else { return };
                self.scene.force(&name, AirDrag, q, [], [c.of(coefficient)]);
            }
            LoadKind::Magnet { strength, distance } => {
                let Some(q) = self.doublet(load.pair.a) else { return };
                self.scene.potential_energy(&name, Magnet, q, [c.of(strength), c.of(distance)]);
            }
            LoadKind::Wave { strength, frequency } => {
                let Some(q) = self.doublet(load.pair.a) else { return };
                self.scene.potential_energy(&name, Wave, q, [c.of(strength), c.of(frequency)]);
            }
            LoadKind::Mixed { constants } => {
                let (Some(q), Some(control)) = (body, self.control(load.control)) else { return };
                self.scene.force(&name, Mixed, q, [control], constants.map(|x| c.of(x)));
            }
            LoadKind::Contact { at, angle, radius, depth, law } => {
                self.contact(&name, [a, b], (at, angle, radius, depth), law, &mut c)
            }
            LoadKind::Stop { at, axis, limits, law } => {
                let law = law.map(|x| c.of_law(x));
                match axis {
                    None => {
                        let turn = b.place[2] - a.place[2];
                        self.scene.end_stop(&name, a.frame, b.frame, limits.map(|x| c.of(turn + x)), law);
                    }
                    Some(axis) => {
                        let (from, to) = (c.point(a, at), c.point(b, at));
                        let axis = c.of(axis - a.place[2]);
                        self.scene.sliding_end_stop(&name, from, axis, to, limits.map(|x| c.of(x)), law);
                    }
                }
            }
            LoadKind::TipMass { mass, at } => {
                let Some(q) = body else { return };
                self.scene.kinetic_energy(&name, TipMass, q, [c.of(mass), c.of(at[0]), c.of(at[1])]);
            }
        }
    }

    /// A circle of radius 0.3 at the given point of b that begins at the given depth in a half-plane or a circle of a.
    fn contact(
        &mut self,
        name: &str,
        [a, b]: [Part; 2],
        (at, angle, radius, depth): ([f64; 2], f64, Option<f64>, f64),
        law: [f64; 4],
        c: &mut Constants,
    ) {
        const RADIUS: f64 = 0.3;
        let [k, damping, mu, width] = law.map(|x| c.of_law(x));
        let (law, to) = ([k, damping, mu, c.of(0.2), width], c.point(b, at));
        match radius {
            None => {
                let from = c.point(a, beyond(at, depth - RADIUS, angle));
                self.scene.circle_contact(name, from, c.of(angle - a.place[2]), to, c.of(RADIUS), law);
            }
            Some(radius) => {
                // Outside: |d| = r_a + r_b − δ; inside: |d| = |r_a| − r_b + δ.
                let distance = if radius < 0.0 { -radius - RADIUS + depth } else { radius + RADIUS - depth };
                let from = c.point(a, beyond(at, -distance, angle));
                self.scene.circle_pair_contact(name, from, c.of(radius), to, c.of(RADIUS), law);
            }
        }
    }

    fn term(&mut self, term: &Term) {
        let name = self.name("cost");
        let weight = self.constants(term.binding).of(term.weight);
        let (sum, body) = (term.sum, self.body(term.body));
        let (control, sigma) = (self.control(term.control), self.multiplier(term.multiplier));
        let doublet = self.doublet(term.body);
        match (term.kind, body, sigma, control) {
            (TermKind::Everything, Some(q), Some(sigma), Some(control)) => {
                self.scene.cost(&name, Everything, sum, q, [sigma], [control], [weight]);
            }
            (TermKind::Effort, _, _, Some(control)) => self.scene.cost(&name, Effort, sum, [], [], [control], [weight]),
            (TermKind::Reaction, _, Some(sigma), _) => self.scene.cost(&name, Reaction, sum, [], [sigma], [], [weight]),
            (TermKind::Everything | TermKind::Momentum, Some(q), _, _) => {
                self.scene.cost(&name, Momentum, sum, q, [], [], [weight]);
            }
            _ => {
                let Some([_, second]) = doublet else { return };
                self.scene.cost(&name, AngleError, sum, [second], [], [], [weight]);
            }
        }
    }
}
