//! Scenes as people build them: a tree of joints, loops that leave every constraint independent, loads, costs, a motion of moderate speed.

use hamiltonian_adjoint::{Scheme, Settings, Sum};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use std::f64::consts::PI;

use crate::description::*;

/// A selector of one of several things.
fn any_of() -> impl Strategy<Value = usize> {
    0..60usize
}

fn binding() -> impl Strategy<Value = Binding> {
    (prop_oneof![Just(0u16), any::<u16>()], any_of()).prop_map(|(mask, first)| Binding { mask, first })
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [-1.2..1.2, -1.2..1.2]
}

/// A size away from zero, of either sign.
fn signed(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high, any::<bool>()).prop_map(|(size, negative)| if negative { -size } else { size })
}

fn joint_kind() -> impl Strategy<Value = JointKind> {
    prop_oneof![
        6 => Just(JointKind::Revolute),
        2 => (-PI..PI).prop_map(|axis| JointKind::Prismatic { axis }),
        1 => Just(JointKind::Free),
        1 => Just(JointKind::Weld),
        2 => (0.2..1.0, -PI..PI).prop_map(|(length, angle)| JointKind::Distance { length, angle }),
        1 => (-3.0..3.0).prop_map(|speed| JointKind::ConstantSpeed { speed }),
        1 => (-0.5..0.5, 1.0..6.0, -PI..PI)
            .prop_map(|(amplitude, frequency, phase)| JointKind::Harmonic { amplitude, frequency, phase }),
        1 => (-0.5..0.5).prop_map(|curvature| JointKind::Parabola { curvature }),
        1 => signed(0.5, 2.0).prop_map(|ratio| JointKind::Geared { ratio }),
    ]
}

fn joint() -> impl Strategy<Value = Joint> {
    (point(), joint_kind(), binding()).prop_map(|(at, kind, binding)| Joint { at, kind, binding })
}

fn bar() -> impl Strategy<Value = Bar> {
    let place = [-1.2..1.2, -1.2..1.2, -PI..PI];
    (0.3..3.0, 0.05..0.5, place, any_of(), joint(), binding())
        .prop_map(|(mass, inertia, place, parent, joint, binding)| Bar { mass, inertia, place, parent, joint, binding })
}

fn group() -> impl Strategy<Value = Group> {
    let kind = prop_oneof![
        (0.3..2.0, 0.3..1.0).prop_map(|(mass, radius)| GroupKind::Polar { mass, radius }),
        ([0.2..2.0, 0.2..2.0], -0.8..0.8).prop_map(|(masses, coupling)| GroupKind::Coupled { masses, coupling }),
    ];
    let geared = proptest::option::of((any_of(), signed(0.5, 2.0)));
    (kind, point(), binding(), geared).prop_map(|(kind, place, binding, geared)| Group { kind, place, binding, geared })
}

fn pair() -> impl Strategy<Value = Pair> {
    (any_of(), any_of()).prop_map(|(a, step)| Pair { a, step })
}

fn load_kind() -> impl Strategy<Value = LoadKind> {
    let damping = || prop_oneof![Just(0.0), 0.0..3.0];
    prop_oneof![
        (point(), 0.3..1.2, -PI..PI, 0.0..60.0, 0.5..1.2, damping()).prop_map(
            |(at, length, angle, stiffness, stretch, damping)| LoadKind::Strut {
                at,
                length,
                angle,
                stiffness,
                stretch,
                damping
            }
        ),
        (0.0..5.0, -0.5..0.5, damping()).prop_map(|(stiffness, angle, damping)| LoadKind::Torsion {
            stiffness,
            angle,
            damping
        }),
        (0.0..0.5).prop_map(|damping| LoadKind::Friction { damping }),
        (point(), -PI..PI, damping()).prop_map(|(at, axis, damping)| LoadKind::Sliding { at, axis, damping }),
        (point(), -PI..PI).prop_map(|(at, axis)| LoadKind::Actuator { at, axis }),
        Just(LoadKind::Torque),
        (0.0..1.0).prop_map(|coefficient| LoadKind::AirDrag { coefficient }),
        (-2.0..2.0, 0.7..2.0).prop_map(|(strength, distance)| LoadKind::Magnet { strength, distance }),
        (-2.0..2.0, -3.0..3.0).prop_map(|(strength, frequency)| LoadKind::Wave { strength, frequency }),
        [-0.5..0.5, -0.5..0.5, -0.2..0.2].prop_map(|constants| LoadKind::Mixed { constants }),
        (0.1..1.0, [-0.5..0.5, -0.5..0.5]).prop_map(|(mass, at)| LoadKind::TipMass { mass, at }),
        (point(), -PI..PI, proptest::option::of(signed(0.6, 1.0)), -0.1..0.2, [10.0..200.0, 0.0..0.5, 0.0..0.5], width())
            .prop_map(|(at, angle, radius, depth, [k, c, mu], width)| LoadKind::Contact {
                at,
                angle,
                radius,
                depth,
                law: [k, c, mu, width]
            }),
        (point(), proptest::option::of(-PI..PI), [-0.5..0.1, 0.2..0.5], 5.0..50.0, 0.0..0.5, width())
            .prop_map(|(at, axis, limits, k, c, width)| LoadKind::Stop { at, axis, limits, law: [k, c, width] }),
    ]
}

/// The width of an onset, or none.
fn width() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 2 => 0.02..0.3]
}

/// Whether a load needs two parts.
fn between(kind: LoadKind) -> bool {
    use LoadKind::*;
    matches!(
        kind,
        Strut { .. }
            | Torsion { .. }
            | Friction { .. }
            | Sliding { .. }
            | Actuator { .. }
            | Torque
            | Contact { .. }
            | Stop { .. }
    )
}

fn load() -> impl Strategy<Value = Load> {
    (load_kind(), pair(), any_of(), binding()).prop_map(|(kind, pair, control, binding)| Load {
        kind,
        pair,
        control,
        binding,
    })
}

fn term() -> impl Strategy<Value = Term> {
    let kind = prop_oneof![
        Just(TermKind::Coordinate),
        Just(TermKind::Effort),
        Just(TermKind::Reaction),
        Just(TermKind::Momentum),
        Just(TermKind::Everything),
    ];
    let sum = select(vec![Sum::Terminal, Sum::Plain, Sum::AllNodes, Sum::Rectangle, Sum::Trapezoidal, Sum::Integral]);
    (kind, sum, any_of(), any_of(), any_of(), signed(0.2, 2.0), binding()).prop_map(
        |(kind, sum, body, multiplier, control, weight, binding)| Term {
            kind,
            sum,
            body,
            multiplier,
            control,
            weight,
            binding,
        },
    )
}

fn steps() -> impl Strategy<Value = Vec<f64>> {
    let uniform = (3..=12usize, 0.002..0.03).prop_map(|(count, dt)| vec![dt; count]);
    let varying = vec(0.002..0.03, 3..=12usize);
    let mixed = vec(signed(0.002, 0.03), 3..=12usize);
    let backward = vec(-0.03..-0.002, 3..=12usize);
    prop_oneof![3 => uniform, 3 => varying, 1 => backward, 1 => mixed]
}

fn run() -> impl Strategy<Value = Run> {
    let from = prop_oneof![Just(From::Momentum), Just(From::Velocity)];
    let scheme = prop_oneof![1 => Just(Scheme::TRAPEZOIDAL), 1 => select(Scheme::ALL.to_vec())];
    (prop_oneof![Just(0.0), -1.0..1.0], steps(), from, 0.0..2.0, 0.0..4.0, 0..1000usize, scheme).prop_map(
        |(start, steps, from, speed, controls, seed, scheme)| Run {
            start,
            steps,
            composition: None,
            tolerance: None,
            from,
            speed,
            controls,
            seed,
            settings: Settings { scheme, ..Settings::default() },
            faults: Vec::new(),
        },
    )
}

/// A scene that simulates, but for accidents.
pub fn description() -> impl Strategy<Value = Description> {
    let closing = (pair(), joint()).prop_map(|(pair, joint)| Loop { pair, joint });
    let inputs = (vec(signed(0.5, 2.0), 0..=4), 0..=2usize, [-1.0..1.0, -9.81..0.0], binding());
    let mechanism = (vec(bar(), 0..=6), vec(group(), 0..=2), vec(closing, 0..=3));
    let rest = (vec(load(), 0..=4), vec(term(), 1..=4), run());
    (inputs, mechanism, rest).prop_map(
        |((designs, controls, gravity, gravity_binding), (bodies, mut groups, loops), (loads, terms, run))| {
            if bodies.is_empty() && groups.is_empty() {
                let kind = GroupKind::Polar { mass: 1.0, radius: 0.5 };
                groups.push(Group { kind, place: [0.4, 0.3], binding: Binding { mask: 0, first: 0 }, geared: None });
            }
            let mut loads = loads;
            loads.retain(|load| !bodies.is_empty() || !between(load.kind));
            let loops = independent(&bodies, loops);
            Description {
                gravity,
                gravity_binding,
                designs,
                controls,
                bodies,
                groups,
                loops,
                redundant: Vec::new(),
                loads,
                terms,
                same_names: false,
                run,
            }
        },
    )
}

/// The same with constraints that follow from others. Their multipliers, and so p*, are not determined, and no
/// cost looks at them.
pub fn redundant() -> impl Strategy<Value = Description> {
    let third_crank = (0.3..0.8, 0.4..2.6).prop_map(|(length, angle)| Redundant::ThirdCrank { length, angle });
    let redundant = prop_oneof![any_of().prop_map(|body| Redundant::DoubledHinge { body }), third_crank];
    (description(), redundant).prop_map(|(mut description, redundant)| {
        if let Redundant::DoubledHinge { body } = redundant
            && !description.bodies.is_empty()
        {
            let count = description.bodies.len();
            description.bodies[body % count].joint.kind = JointKind::Revolute;
        }
        description.redundant.push(redundant);
        // With a compliance the velocities of a start with momenta are consistent to 1e-8 only.
        description.run.from = From::Momentum;
        for term in &mut description.terms {
            match term.kind {
                TermKind::Coordinate | TermKind::Effort => {}
                _ => term.kind = TermKind::Coordinate,
            }
        }
        description
    })
}

/// The freedom of one side of a joint against the other: to slide, to turn.
fn freedom(kind: JointKind) -> [usize; 2] {
    match kind {
        JointKind::Free => [2, 1],
        JointKind::Revolute => [0, 1],
        JointKind::Prismatic { .. } => [1, 0],
        JointKind::Weld | JointKind::ConstantSpeed { .. } | JointKind::Harmonic { .. } => [0, 0],
        JointKind::Distance { .. } | JointKind::Parabola { .. } => [1, 1],
        JointKind::Geared { .. } => [2, 0],
    }
}

/// The loops that take freedom which the tree and the loops before them leave.
fn independent(bodies: &[Bar], loops: Vec<Loop>) -> Vec<Loop> {
    let parts = bodies.len() + 1;
    let parent = |i: usize| match bodies[i - 1].joint.kind {
        JointKind::Parabola { .. } => 0,
        _ => bodies[i - 1].parent % i,
    };
    let mut free: Vec<[usize; 2]> = bodies.iter().map(|bar| freedom(bar.joint.kind)).collect();
    let keep = |l: &Loop| {
        if parts == 1 {
            return false;
        }
        let a = l.pair.a % parts;
        let b = (a + 1 + l.pair.step % (parts - 1)) % parts;
        let (mut ends, mut path) = (if let JointKind::Parabola { .. } = l.joint.kind { [0, b] } else { [a, b] }, Vec::new());
        while ends[0] != ends[1] {
            let later = if ends[0] > ends[1] { 0 } else { 1 };
            path.push(ends[later] - 1);
            ends[later] = parent(ends[later]);
        }
        let [slide, turn] = path.iter().fold([0, 0], |sum, &i| [sum[0] + free[i][0], sum[1] + free[i][1]]);
        let [takes_slide, takes_turn] = freedom(l.joint.kind);
        let possible = slide + turn >= 3 - takes_slide - takes_turn && turn + takes_turn >= 1;
        if possible {
            path.iter().for_each(|&i| free[i] = [0, 0]);
        }
        possible
    };
    loops.into_iter().filter(keep).collect()
}
