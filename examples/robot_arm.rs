//! A robot arm with seven hinges in space, driven by a torque at each: prints cost, gradient and run times as one JSON object.
//!
//! `cargo run --release --example robot_arm -- --steps 100 --repeat 200`, with `--design` if all ten numbers of every inertia are design variables.

use std::time::Instant;

use hamiltonian_adjoint::spatial::{Body, Inertia, MarkerFunction, MarkerPoint};
use hamiltonian_adjoint::{Design, Error, Grid, Inputs, Scalar, Scene, Settings, Solver, Sum, System};

/// The hinges: origin in the frame of the link before, m, and roll of the axes, rad, about x.
const HINGES: [([f64; 3], f64); 7] = [
    ([0.0, 0.0, 0.33], 0.0),
    ([0.0, 0.0, 0.0], -90.0),
    ([0.0, -0.31, 0.0], 90.0),
    ([0.08, 0.0, 0.0], 90.0),
    ([-0.08, 0.38, 0.0], -90.0),
    ([0.0, 0.0, 0.0], 90.0),
    ([0.09, 0.0, 0.0], 90.0),
];
/// Masses of the links, kg, and centres of mass in their frames, m.
const LINKS: [(f64, [f64; 3]); 7] = [
    (4.9, [0.004, 0.002, -0.05]),
    (0.7, [-0.003, -0.03, 0.004]),
    (3.2, [0.03, 0.04, -0.07]),
    (3.6, [-0.05, 0.1, 0.03]),
    (1.2, [-0.01, 0.04, -0.04]),
    (1.7, [0.06, -0.01, -0.01]),
    (0.7, [0.01, 0.005, 0.06]),
];
const START: [f64; 7] = [0.1, -0.4, 0.2, -1.8, 0.1, 1.5, 0.6];

/// ½ |p − b|² of a marker.
struct Miss;

impl MarkerFunction for Miss {
    fn value<S: Scalar>(&self, at: &MarkerPoint<S>) -> S {
        (0..3).map(|i| (at.markers[0].position[i] - at.b[i]).powi(2) * 0.5).sum()
    }
}

fn arm(with_design: bool) -> Result<System, Error> {
    let mut scene = Scene::new();
    let designs: Vec<Vec<Design>> = (0..LINKS.len() * usize::from(with_design)).map(|k| inertia_of(&mut scene, k)).collect();
    let torques: Vec<_> = (1..=HINGES.len()).map(|k| scene.control(&format!("torque {k}"))).collect();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let mut outer = Body::GROUND;
    let mut angles = Vec::new();
    for (k, (origin, roll)) in HINGES.into_iter().enumerate() {
        let numbers = numbers_of(k);
        let inertia = match designs.get(k) {
            Some(d) => Inertia::new(d[0], [d[4], d[5], d[6], d[7], d[8], d[9]]).centred_at([d[1], d[2], d[3]]),
            None => {
                Inertia::new(numbers[0], [4, 5, 6, 7, 8, 9].map(|i| numbers[i])).centred_at([1, 2, 3].map(|i| numbers[i]))
            }
        };
        let link = space.body(&format!("link {}", k + 1), inertia);
        let socket = outer.at(origin).turned([roll.to_radians(), 0.0, 0.0]);
        angles.push(space.revolute(&format!("hinge {}", k + 1), socket, link.origin()).angle);
        outer = link;
    }
    let tip = outer.at([0.0, 0.0, 0.2]);
    space.cost("miss", Miss, Sum::Terminal, &[tip], &[], &[0.4.into(), 0.3.into(), 0.5.into()]);
    for (k, angle) in angles.into_iter().enumerate() {
        scene.place(angle, START[k]);
        scene.motor(&format!("motor {}", k + 1), angle, torques[k]);
    }
    scene.compile()
}

/// Mass, centre of mass, and J_xx, J_yy, J_zz, J_xy, J_xz, J_yz about it.
fn numbers_of(link: usize) -> [f64; 10] {
    let (mass, [x, y, z]) = LINKS[link];
    let size = 0.004 * mass;
    [mass, x, y, z, 1.1 * size, 0.9 * size, 0.7 * size, 0.03 * size, -0.05 * size, 0.04 * size]
}

fn inertia_of(scene: &mut Scene, link: usize) -> Vec<Design> {
    let names = ["m", "x", "y", "z", "J_xx", "J_yy", "J_zz", "J_xy", "J_xz", "J_yz"];
    names.iter().zip(numbers_of(link)).map(|(name, value)| scene.design(&format!("{name} {}", link + 1), value)).collect()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The number after a name among the arguments of the program.
fn argument(name: &str, default: usize) -> Result<usize, String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != name).skip(1);
    let Some(text) = arguments.next() else { return Ok(default) };
    text.parse().ok().filter(|number| *number > 0).ok_or_else(|| format!("{name}: `{text}` is not a positive whole number"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (steps, repeat) = (argument("--steps", 100)?, argument("--repeat", 1)?);
    let begin = Instant::now();
    let system = arm(std::env::args().any(|argument| argument == "--design"))?;
    let compiled = begin.elapsed().as_secs_f64();
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 0.002));
    inputs.controls.row_iter_mut().enumerate().for_each(|(k, mut row)| row.fill(2.0 - 0.5 * k as f64));
    let mut solver = Solver::new(&system, Settings::default());
    let (mut forward, mut both) = (Vec::new(), Vec::new());
    for _ in 0..repeat {
        let begin = Instant::now();
        solver.simulate(&inputs)?;
        forward.push(begin.elapsed().as_secs_f64());
        solver.gradient()?;
        both.push(begin.elapsed().as_secs_f64());
    }
    let gradient = solver.gradient()?;
    println!(
        "{}",
        serde_json::json!({
            "cost": gradient.value,
            "by_torques": gradient.controls.column_sum().as_slice(),
            "by_inertias": gradient.design.as_slice(),
            "compiled_s": compiled,
            "forward_s": median(forward),
            "value_and_gradient_s": median(both),
        })
    );
    Ok(())
}
