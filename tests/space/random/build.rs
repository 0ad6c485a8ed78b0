//! Plans as calls of the public interface.

use hamiltonian_adjoint::check::Random;
use hamiltonian_adjoint::spatial::{Body, Inertia, Marker, MarkerFunction, Quantity};
use hamiltonian_adjoint::{Control, Coordinate, Design, Multiplier, Param, Scene, Sum};
use num_dual::Dual2_64;

use super::chain::Chain;
use super::plan::{At, Axes, Closed, FLAT, Kind, Load, Number, Plan};

/// A scene, with the numbers that belong to its plan.
pub struct Built {
    pub scene: Scene,
    pub of_links: Vec<Vec<usize>>,
    pub of_flat: Vec<usize>,
    pub others: Vec<(At, f64)>,
    /// The multipliers of the closings.
    pub multipliers: Vec<Multiplier>,
    /// Coordinates that are no quaternions.
    pub simple: Vec<Coordinate>,
    /// The coordinates of the body in the plane, and of the joint of every link.
    pub own: Vec<Coordinate>,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    tip: Marker,
    controls: Vec<Control>,
}

impl Built {
    /// Adds costs of the tip, along and at the end of a motion.
    pub fn cost<F: MarkerFunction>(&mut self, function: impl Fn() -> F) {
        for (name, sum) in [("along", Sum::Integral), ("end", Sum::Terminal)] {
            self.scene.spatial().cost(name, function(), sum, &[self.tip], &self.controls, &[]);
        }
    }
}

struct Builder<'a> {
    plan: &'a Plan,
    designs: Vec<Design>,
    bodies: Vec<Body>,
    flat: Option<Body>,
}

impl Builder<'_> {
    fn param(&self, number: Number) -> Param {
        number.of.map_or(number.factor.into(), |design| self.designs[design] * number.factor)
    }

    fn params<const N: usize>(&self, numbers: [Number; N]) -> [Param; N] {
        numbers.map(|number| self.param(number))
    }

    fn marker(&self, at: At) -> Marker {
        let flat = self.flat.unwrap_or(Body::GROUND);
        let body = at.body.map_or(Body::GROUND, |body| if body == FLAT { flat } else { self.bodies[body] });
        let marker = body.at(self.params(at.at));
        match at.axes {
            Axes::OfBody => marker,
            Axes::Along(z) => marker.along(self.params(z)),
            Axes::Toward(z, x) => marker.along_and_toward(self.params(z), self.params(x)),
            Axes::Turned(angles) => marker.turned(self.params(angles)),
        }
    }
}

pub const QUANTITIES: [Quantity; 8] = [
    Quantity::Position,
    Quantity::Velocity,
    Quantity::Acceleration,
    Quantity::XAxis,
    Quantity::YAxis,
    Quantity::ZAxis,
    Quantity::AngularVelocity,
    Quantity::AngularAcceleration,
];

/// The scene of a plan at a random state, with outputs of all quantities of its tip at the end.
pub fn build(plan: &Plan, random: &mut Random) -> Built {
    let mut scene = Scene::new();
    let designs = plan.designs.iter().enumerate().map(|(k, value)| scene.design(&format!("design {k}"), *value)).collect();
    let mut builder = Builder { plan, designs, bodies: Vec::new(), flat: None };
    let mut simple: Vec<Coordinate> = Vec::new();
    let flat = plan.flat.map(|[mass, moment]| scene.body("flat", mass, moment, [0.3, -0.2, 0.4]));
    let of_flat = flat.map_or(Vec::new(), |flat| flat.coordinates.iter().map(|q| q.index()).collect());
    simple.extend(flat.iter().flat_map(|flat| flat.coordinates));
    builder.flat = flat.map(|flat| scene.spatial().planar_body("flat in space", flat));
    let gravity = builder.params(plan.gravity);
    scene.spatial().gravity(gravity);
    let (mut of_links, mut all) = (Vec::new(), simple.clone());
    for k in 0..plan.links.len() {
        let own = join(&mut scene, &mut builder, k, &simple);
        let is_own = !matches!(plan.links[k].kind, Kind::DependentRevolute | Kind::DependentPrismatic);
        let count = if plan.links[k].kind == Kind::Ball { 0 } else { own.len().min(3) };
        simple.extend(own[..if is_own { count } else { 0 }].iter());
        all.extend(&own);
        of_links.push(own.iter().map(|q| q.index()).collect::<Vec<_>>());
    }
    let mut controls = Vec::new();
    for (k, load) in plan.loads.iter().enumerate() {
        apply(&mut scene, &builder, (&format!("load {k}"), load), &mut controls);
    }
    for quantity in QUANTITIES {
        let tip = builder.marker(plan.tip);
        scene.spatial().outputs(&format!("{quantity:?}"), quantity, tip, Sum::Terminal);
    }
    let n = of_links.iter().flatten().chain(&of_flat).max().map_or(0, |last| last + 1);
    let [mut q, mut v] = [0; 2].map(|_| (0..n).map(|_| random.uniform(-1.0, 1.0)).collect::<Vec<f64>>());
    let chain = |others| Chain { plan, designs: &plan.designs, of_links: &of_links, of_flat: &of_flat, others, u: &[] };
    for first in chain(&[]).quaternions() {
        let e = first..first + 4;
        let size = q[e.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
        q[e.clone()].iter_mut().for_each(|x| *x /= size);
        let along: f64 = e.clone().map(|i| q[i] * v[i]).sum();
        e.for_each(|i| v[i] -= along * q[i]);
    }
    let others = closing_markers(&chain(&[]), &q);
    let mut multipliers = Vec::new();
    for (k, (closing, (b, length))) in plan.closings.iter().zip(&others).enumerate() {
        let (a, b) = (builder.marker(closing.a), builder.marker(*b));
        multipliers.extend(close(&mut scene, &format!("closing {k}"), closing.kind, (a, b, *length)));
    }
    let tip = builder.marker(plan.tip);
    Built { tip, controls, scene, of_links, of_flat, others, multipliers, simple, own: all, q, v }
}

/// Adds a body, its joint and, if the plan says so, a cut, and returns the coordinates of the joint.
fn join(scene: &mut Scene, builder: &mut Builder, k: usize, simple: &[Coordinate]) -> Vec<Coordinate> {
    let own = carry(scene, builder, k, simple);
    if builder.plan.cuts.contains(&k) {
        scene.spatial().cut(&format!("cut {k}"), builder.bodies[k]);
    }
    own
}

fn carry(scene: &mut Scene, builder: &mut Builder, k: usize, simple: &[Coordinate]) -> Vec<Coordinate> {
    let link = &builder.plan.links[k];
    let inertia = Inertia::new(builder.param(link.mass), builder.params(link.tensor));
    let inertia = inertia.centred_at(builder.params(link.centre));
    let mut space = scene.spatial();
    let body = space.body(&format!("body {k}"), inertia);
    builder.bodies.push(body);
    let (a, b, name) = (builder.marker(link.outer), builder.marker(link.inner), &format!("joint {k}"));
    let followed = |k: usize| simple.get(k % simple.len().max(1)).copied();
    match (link.kind, followed(link.follows.0)) {
        (Kind::Revolute, _) => vec![space.revolute(name, a, b).angle],
        (Kind::Prismatic, _) => vec![space.prismatic(name, a, b).offset],
        (Kind::Universal, _) => space.universal(name, a, b).angles.to_vec(),
        (Kind::Cylindrical, _) => {
            let joint = space.cylindrical(name, a, b);
            vec![joint.offset, joint.angle]
        }
        (Kind::Planar, _) => {
            let joint = space.planar(name, a, b);
            vec![joint.offsets[0], joint.offsets[1], joint.angle]
        }
        (Kind::Ball, _) => space.ball(name, a, b).orientation.to_vec(),
        (Kind::Free, _) => {
            let joint = space.free(name, a, b);
            [&joint.position[..], &joint.orientation].concat()
        }
        (Kind::DependentRevolute, Some(of)) => {
            space.dependent_revolute(name, a, b, of, builder.params(link.follows.1));
            vec![of]
        }
        (Kind::DependentPrismatic, Some(of)) => {
            space.dependent_prismatic(name, a, b, of, builder.params(link.follows.1));
            vec![of]
        }
        (Kind::Fixed, _) | (_, None) => {
            space.fixed(name, a, b);
            Vec::new()
        }
    }
}

fn apply(scene: &mut Scene, builder: &Builder, (name, load): (&str, &Load), controls: &mut Vec<Control>) {
    let at = |at: &At| builder.marker(*at);
    let halves = |six: [Number; 6]| {
        let [a, b, c, d, e, f] = builder.params(six);
        ([a, b, c], [d, e, f])
    };
    let mut control = |scene: &mut Scene| {
        controls.push(scene.control(name));
        controls[controls.len() - 1]
    };
    match load {
        Load::SpringDamper(a, b, numbers) => {
            scene.spatial().spring_damper(name, at(a), at(b), builder.params(*numbers));
        }
        Load::InSpace(a, six) => {
            let (force, torque) = halves(*six);
            scene.spatial().applied_in_space(name, at(a), force, torque);
        }
        Load::OnBody(a, six) => {
            let (force, torque) = halves(*six);
            scene.spatial().applied_on_body(name, at(a), force, torque);
        }
        Load::Thrust(a) => {
            let u = control(scene);
            scene.spatial().thrust(name, at(a), u);
        }
        Load::Torque(a, b) => {
            let u = control(scene);
            scene.spatial().torque(name, at(a), at(b), u);
        }
        Load::Actuator(a, b) => {
            let u = control(scene);
            scene.spatial().two_point_actuator(name, at(a), at(b), u);
        }
    }
}

/// For each closing, the marker of its second body where the first one is, and for distances one elsewhere.
fn closing_markers(chain: &Chain, q: &[f64]) -> Vec<(At, f64)> {
    let poses = chain.poses(&|i| Dual2_64::from(q[i]));
    let constant = |x: [f64; 3]| x.map(|factor| Number { factor, of: None });
    let of = |closing: &super::plan::Closing| {
        let here = chain.marker(&poses, closing.a).motion();
        let length = 0.7;
        let away = if closing.kind == Closed::Distance { here.turn.column(0) * length } else { nalgebra::Vector3::zeros() };
        let ground = At { body: closing.b, at: constant([0.0; 3]), axes: Axes::OfBody };
        let base = chain.marker(&poses, ground).motion();
        let back = base.turn.transpose();
        let (at, turn) = (back * (here.place + away - base.place), back * here.turn);
        let column = |k: usize| constant(turn.column(k).into_owned().into());
        let axes = Axes::Toward(column(2), column(0));
        (At { body: closing.b, at: constant(at.into()), axes }, length)
    };
    chain.plan.closings.iter().map(of).collect()
}

fn close(scene: &mut Scene, name: &str, kind: Closed, (a, b, length): (Marker, Marker, f64)) -> Vec<Multiplier> {
    let mut space = scene.spatial();
    match kind {
        Closed::Ball => space.close_ball(name, a, b).to_vec(),
        Closed::Parallel => space.close_parallel(name, a, b).to_vec(),
        Closed::Revolute => space.close_revolute(name, a, b).to_vec(),
        Closed::Cylindrical => space.close_cylindrical(name, a, b).to_vec(),
        Closed::Prismatic => space.close_prismatic(name, a, b).to_vec(),
        Closed::Fixed => space.close_fixed(name, a, b).to_vec(),
        Closed::Plane => space.point_on_plane(name, a, b).to_vec(),
        Closed::Line => space.point_on_line(name, a, b).to_vec(),
        Closed::Distance => space.distance(name, a, b, length).to_vec(),
    }
}
