//! Mechanisms of any size: a chain, a binary tree, a ladder of closed loops, a string whose hinges are there several times.

use hamiltonian_adjoint::planar::{Body, Point};
use hamiltonian_adjoint::scenes::{AngleError, CartPendulum};
use hamiltonian_adjoint::{Scene, Sum};

/// The paper's cart with a chain of links.
pub fn chain(links: usize) -> Scene {
    CartPendulum::with_links(links).scene()
}

/// Bars with two more at the end of each: 2^levels − 1 bodies below the ground, a motor in the first hinge.
pub fn binary_tree(levels: u32) -> Scene {
    let mut bars = Bars::default();
    let root = bars.hang(Hook::ground(0.0), -1.3);
    let mut level = vec![root];
    for _ in 1..levels {
        let turns = |parent: &Bar| [0.3, -0.4].map(|turn| (parent.end(), parent.angle + turn));
        level = level.iter().flat_map(turns).map(|(hook, angle)| bars.hang(hook, angle)).collect();
    }
    bars.finish(root, level[0])
}

/// Two strings of bars side by side with a rung between their ends after every pair: closed loops with one degree of freedom each.
pub fn ladder(loops: usize) -> Scene {
    string_of_loops(loops, true)
}

/// A ladder whose rungs hang from the left string alone: no loop.
pub fn open_ladder(loops: usize) -> Scene {
    string_of_loops(loops, false)
}

/// A string of bars whose hinges are all there so many times: twice, and every other constraint depends on the one before.
pub fn string(length: usize, hinges: usize) -> Scene {
    let mut bars = Bars::default();
    let mut string: Vec<Bar> = Vec::new();
    for i in 0..length {
        let hook = string.last().map_or(Hook::ground(0.0), Bar::end);
        let bar = bars.hang(hook, -1.2);
        for again in 1..hinges {
            bars.scene.revolute(&format!("hinge {again} of bar {i}"), hook.point, bar.body.at(-0.5, 0.0));
        }
        string.push(bar);
    }
    bars.finish(string[0], string[length - 1])
}

fn string_of_loops(loops: usize, closed: bool) -> Scene {
    let mut bars = Bars::default();
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for i in 0..loops {
        let hook = |string: &[Bar], ground| string.last().map_or(Hook::ground(ground), Bar::end);
        left.push(bars.hang(hook(&left, 0.0), -1.2));
        right.push(bars.hang(hook(&right, 1.0), -1.2));
        let rung = bars.hang(left[i].end(), 0.0);
        if closed {
            bars.scene.revolute(&format!("end of rung {i}"), rung.end().point, right[i].end().point);
        }
    }
    bars.finish(left[0], left[loops - 1])
}

/// Bars of 1 m.
#[derive(Default)]
struct Bars {
    scene: Scene,
    count: usize,
}

/// A bar, the place of its outer end and its angle.
#[derive(Clone, Copy)]
struct Bar {
    body: Body,
    tip: [f64; 2],
    angle: f64,
}

/// Where a bar can be hung up.
#[derive(Clone, Copy)]
struct Hook {
    point: Point,
    at: [f64; 2],
}

impl Hook {
    fn ground(x: f64) -> Self {
        Hook { point: Body::GROUND.at(x, 0.0), at: [x, 0.0] }
    }
}

impl Bar {
    fn end(&self) -> Hook {
        Hook { point: self.body.at(0.5, 0.0), at: self.tip }
    }
}

impl Bars {
    fn hang(&mut self, hook: Hook, angle: f64) -> Bar {
        let ([x, y], (sin, cos)) = (hook.at, angle.sin_cos());
        let name = format!("bar {}", self.count);
        let body = self.scene.body(&name, 0.4, 0.083, [x + 0.5 * cos, y + 0.5 * sin, angle]);
        self.scene.revolute(&format!("hinge of {name}"), hook.point, body.at(-0.5, 0.0));
        self.count += 1;
        Bar { body, tip: [x + cos, y + sin], angle }
    }

    /// A motor in the hinge of `driven`, a terminal cost on the angle of `judged`, and gravity.
    fn finish(mut self, driven: Bar, judged: Bar) -> Scene {
        self.scene.gravity(0.0, -9.81);
        let torque = self.scene.control("torque");
        self.scene.torque_actuator("motor", Body::GROUND, driven.body, torque);
        let angle = judged.body.coordinates[2];
        self.scene.cost("angle", AngleError, Sum::Terminal, [angle], [], [], [(-1.0).into()]);
        self.scene
    }
}
