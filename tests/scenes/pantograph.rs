//! A pantograph: a rhombus of two arms and two bars, with a bar across that follows from its sides or not, driven by its weight, a spring and a torque.
#![allow(dead_code)]

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Multiplier, Scene};

/// The parts that costs look at.
pub struct Pantograph {
    pub arms: [Body; 2],
    pub foot: [Multiplier; 2],
    pub stylus: [Multiplier; 2],
}

/// Several of them, which move alike, by one control.
pub fn pantographs(count: usize, across: bool, stiffness: f64) -> (Scene, Vec<Pantograph>) {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    scene.control("torque");
    let name = |which: usize| if which == 0 { String::new() } else { format!(" {which}") };
    let all = (0..count).map(|which| add(&mut scene, &name(which), across, stiffness)).collect();
    (scene, all)
}

fn add(scene: &mut Scene, which: &str, across: bool, stiffness: f64) -> Pantograph {
    let torque = scene.control_named("torque").expect("a control");
    let name = |name: &str| format!("{name}{which}");
    let (first, second) = (1.0f64, -0.6f64);
    let ahead = |[x, y]: [f64; 2], angle: f64, length: f64| [x + length * angle.cos(), y + length * angle.sin()];
    let mut rod = |what: &str, mass: f64, length: f64, foot: [f64; 2], angle: f64| {
        let [x, y] = ahead(foot, angle, 0.5 * length);
        scene.body(&name(what), mass, mass * length * length / 12.0, [x, y, angle])
    };
    let (elbow, middle) = (ahead([0.0; 2], first, 1.0), ahead([0.0; 2], first, 0.5));
    let arms = [rod("upper arm", 0.5, 1.0, [0.0; 2], first), rod("lower arm", 0.5, 1.0, elbow, second)];
    let stylus = ahead(middle, second, 0.5);
    let bars = [rod("bar", 0.2, 0.5, middle, second), rod("other bar", 0.2, 0.5, stylus, first)];
    let foot = scene.revolute(&name("foot"), Body::GROUND.at(0.0, 0.0), arms[0].at(-0.5, 0.0));
    scene.revolute(&name("elbow"), arms[0].at(0.5, 0.0), arms[1].at(-0.5, 0.0));
    scene.revolute(&name("middle"), arms[0].at(0.0, 0.0), bars[0].at(-0.25, 0.0));
    let stylus = scene.revolute(&name("stylus"), bars[0].at(0.25, 0.0), bars[1].at(-0.25, 0.0));
    scene.revolute(&name("corner"), bars[1].at(0.25, 0.0), arms[1].at(0.0, 0.0));
    if across {
        scene.distance(&name("across"), arms[0].at(0.25, 0.0), bars[1].at(0.0, 0.0), 0.5);
    }
    scene.torsional_spring_damper(&name("spring"), arms[0], arms[1], stiffness, -1.6, 0.1);
    scene.torque_actuator(&name("motor"), Body::GROUND, arms[0], torque);
    Pantograph { arms, foot, stylus }
}
