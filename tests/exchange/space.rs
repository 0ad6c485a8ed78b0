//! Pages and pictures of bodies in space.

use super::animation::{assert_balanced, data, moved};
use hamiltonian_adjoint::spatial::{Body, Inertia};
use hamiltonian_adjoint::{Animation, Grid, Inputs, Scene, planar};
use serde_json::Value;

/// The edges of the links of the arm.
const LINKS: [[f64; 3]; 7] = [
    [0.16, 0.16, 0.30],
    [0.13, 0.14, 0.34],
    [0.12, 0.12, 0.30],
    [0.11, 0.12, 0.30],
    [0.10, 0.10, 0.24],
    [0.09, 0.10, 0.18],
    [0.08, 0.09, 0.12],
];

/// An arm with seven hinges, each with a motor, in one second.
pub fn arm(steps: usize) -> Animation {
    let mut scene = Scene::new();
    let motors: Vec<_> = (1..=7).map(|k| scene.control(&format!("motor {k}"))).collect();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let mut outer = Body::GROUND.origin();
    let mut hinges = Vec::new();
    for (k, edges) in LINKS.into_iter().enumerate() {
        let axis = if k % 2 == 0 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let mass = 4.0 - 0.5 * k as f64;
        let link =
            space.body(&format!("link {}", k + 1), Inertia::cuboid(mass, edges).centred_at([0.0, 0.0, 0.5 * edges[2]]));
        let (a, b) = (outer.along(axis), link.origin().along(axis));
        hinges.push(space.revolute(&format!("joint {}", k + 1), a, b));
        space.torque(&format!("drive {}", k + 1), a, b, motors[k]);
        outer = link.at([0.0, 0.0, edges[2]]);
    }
    hinges.iter().enumerate().for_each(|(k, hinge)| scene.place(hinge.angle, [0.3, 0.4, -0.2, 0.8, 0.4, 0.5, 0.0][k]));
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 1.0 / steps as f64));
    for node in 0..inputs.controls.ncols() {
        let turning = (6.0 * node as f64 / steps as f64).sin();
        let torques = [9.0, -12.0, 2.0, -9.0, 0.3, -2.0, 0.05];
        torques
            .iter()
            .enumerate()
            .for_each(|(k, torque)| inputs.controls[(k, node)] = torque * if k % 2 == 0 { turning } else { 1.0 });
    }
    let (inputs, motion) = moved(&system, &inputs);
    Animation::new(&system, &inputs, &motion).expect("an animation")
}

/// A box that flies and tumbles.
pub fn top() -> Animation {
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let body = space.body("box", Inertia::cuboid(1.2, [0.9, 0.6, 0.2]));
    let free = space.free("flight", Body::GROUND.origin(), body.origin());
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(200, 0.01));
    inputs.start.set_rate(free.position[0], 0.6);
    inputs.start.set_rate(free.position[2], 9.81);
    inputs.start.set_angular_velocity(free.orientation, [0.3, 5.0, 0.2]).expect("velocities");
    let (inputs, motion) = moved(&system, &inputs);
    Animation::new(&system, &inputs, &motion).expect("an animation")
}

/// A cart in the plane that carries a rod on a universal joint, a slider with a point mass, and a wheel.
pub fn mixed() -> Animation {
    let mut scene = Scene::new();
    let force = scene.control("force");
    let cart = scene.body("cart", 2.0, 0.1, [0.0; 3]);
    let ground = planar::Body::GROUND.at(0.0, 0.0);
    scene.prismatic("rail", ground, 0.0, cart.at(0.0, 0.0), 0.0);
    scene.actuator("motor", ground, 0.0, cart.at(0.0, 0.0), force);
    let arm = scene.body("arm", 1.0, 0.1, [0.1, -0.4, -std::f64::consts::FRAC_PI_2]);
    scene.revolute("hinge", cart.at(0.1, -0.1), arm.at(-0.3, 0.0));
    scene.spring_damper("spring", planar::Body::GROUND.at(-1.0, 0.1), cart.at(-0.2, 0.1), 30.0, 0.8, 0.5);
    let mut space = scene.spatial();
    space.gravity([0.0, -9.81, 0.0]);
    let table = space.planar_body("table", cart);
    let rod = space.body("rod", Inertia::cuboid(0.5, [0.05, 0.6, 0.05]));
    let joint = space.universal("cross", table.at([0.1, 0.0, 0.0]), rod.at([0.0, 0.3, 0.0]));
    let bead = space.body("bead", Inertia::point(0.2));
    let slot = Body::GROUND.at([0.5, -0.2, 0.3]).along([0.0, 0.05, 1.0]);
    space.prismatic("slot", slot, bead.origin().along([0.0, 0.05, 1.0]));
    scene.place(joint.angles[0], 0.6);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(150, 0.01));
    inputs.start = hamiltonian_adjoint::Start::assembled(&system);
    inputs.controls.fill(4.0);
    let (inputs, motion) = moved(&system, &inputs);
    Animation::new(&system, &inputs, &motion).expect("an animation")
}

pub fn page_of(animation: &Animation) -> String {
    animation.html()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// All parts of a page.
fn parts(data: &Value) -> Vec<&Value> {
    let groups = data["groups"].as_array().expect("groups").iter();
    groups.flat_map(|group| group["parts"].as_array().expect("parts")).collect()
}

fn part<'a>(data: &'a Value, name: &str, with: &str) -> &'a Value {
    let found = parts(data).into_iter().find(|part| part["name"] == name && !part[with].is_null());
    found.unwrap_or_else(|| panic!("{with} of {name}"))
}

/// The sorted lengths of the edges of a box.
fn edges(part: &Value) -> [f64; 3] {
    let faces = part["faces"].as_array().expect("faces");
    assert_eq!(faces.len(), 6);
    let mut all: Vec<f64> = Vec::new();
    for face in faces {
        let at = numbers(face);
        let corner = |k: usize| [at[3 * (k % 4)], at[3 * (k % 4) + 1], at[3 * (k % 4) + 2]];
        let length = |k: usize| corner(k).iter().zip(corner(k + 1)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        all.extend((0..4).map(length));
    }
    all.sort_by(f64::total_cmp);
    [all[0], all[12], all[23]]
}

#[test]
fn the_page_of_an_arm_is_small_and_complete() {
    let animation = arm(200);
    let page = page_of(&animation);
    assert!(page.len() < 300_000, "{} bytes", page.len());
    assert!(
        !page.contains("NaN") && !page.contains("http://")
            || page.matches("http").count() == page.matches("http://www.w3.org/2000/svg").count()
    );
    let data = data(&page);
    assert_eq!(data["times"].as_array().expect("times").len(), 201);
    for k in 0..7 {
        let columns = data["groups"][k]["poses"].as_array().expect("columns");
        assert_eq!(columns.len(), 7);
        for column in columns.iter().filter(|column| column.is_array()) {
            assert_eq!(numbers(column).len(), 201);
        }
        for frame in [0, 77, 200] {
            let e = columns[3..].iter().map(|column| column.as_f64().unwrap_or_else(|| numbers(column)[frame]));
            let length: f64 = e.map(|e| e * e).sum();
            assert!((length - 1.0).abs() < 1e-3, "{length}");
        }
        let mut expected = LINKS[k];
        expected.sort_by(f64::total_cmp);
        let found = edges(part(&data, &format!("link {}", k + 1), "trail"));
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-3), "{found:?} for {expected:?}");
        part(&data, &format!("joint {}", k + 1), "faces");
    }
    let names: Vec<&str> =
        data["plots"].as_array().expect("plots").iter().filter_map(|plot| plot["name"].as_str()).collect();
    assert!(names.contains(&"motor 7") && names.contains(&"energy") && names.contains(&"joint 7.angle"), "{names:?}");
    assert!(
        data["plots"].as_array().expect("plots").iter().any(|plot| plot["name"] == "joint 1.angle" && plot["unit"] == "rad")
    );
    assert_eq!(numbers(&data["up"]), [0.0, 0.0, 1.0]);
}

/// A point of a frame with x, y, z and the Euler parameters e: r + v + 2 e × (e₀ v + e × v).
fn place(pose: &[f64], v: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let e = [pose[4], pose[5], pose[6]];
    let inner = cross(e, v);
    let turned = cross(e, [0, 1, 2].map(|i| pose[3] * v[i] + inner[i]));
    [0, 1, 2].map(|i| pose[i] + v[i] + 2.0 * turned[i])
}

#[test]
fn the_links_of_an_arm_hang_together() {
    let data = data(&page_of(&arm(200)));
    let pose = |k: usize, frame: usize| -> Vec<f64> {
        let columns = data["groups"][k]["poses"].as_array().expect("columns");
        columns.iter().map(|column| column.as_f64().unwrap_or_else(|| numbers(column)[frame])).collect()
    };
    for (k, frame) in [(0, 0), (1, 0), (2, 40), (3, 100), (4, 160), (5, 200)] {
        // The next joint is twice as far from the joint as the centre of mass.
        let centre = numbers(&part(&data, &format!("link {}", k + 1), "trail")["trail"]);
        let (end, next) = (place(&pose(k, frame), [0, 1, 2].map(|i| 2.0 * centre[i])), pose(k + 1, frame));
        assert!((0..3).all(|i| (end[i] - next[i]).abs() < 1e-3), "link {} at {frame}: {end:?} {next:?}", k + 1);
    }
}

/// The position of a body's centre in a frame of the page.
fn centre(data: &Value, name: &str, frame: usize) -> [f64; 3] {
    let is_there = |group: &&Value| group["parts"].as_array().expect("parts").iter().any(|part| part["name"] == name);
    let group = data["groups"].as_array().expect("groups").iter().find(is_there).expect("a group");
    let at = |k: usize| group["poses"][k].as_f64().unwrap_or_else(|| numbers(&group["poses"][k])[frame]);
    [at(0), at(1), at(2)]
}

#[test]
fn a_thrown_box_flies_on_a_parabola() {
    let data = data(&page_of(&top()));
    for frame in [0, 50, 100, 200] {
        let t = 0.01 * frame as f64;
        let (found, expected) = (centre(&data, "box", frame), [0.6 * t, 0.0, 9.81 * t - 0.5 * 9.81 * t * t]);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 2e-3), "{found:?} for {expected:?}");
    }
    let found = edges(part(&data, "box", "trail"));
    assert!([0.2, 0.6, 0.9].iter().zip(found).all(|(a, b)| (a - b).abs() < 2e-3), "{found:?}");
}

#[test]
fn bodies_in_the_plane_are_drawn_in_space() {
    let animation = mixed();
    let data = data(&page_of(&animation));
    assert_eq!(numbers(&data["up"]), [0.0, 1.0, 0.0]);
    assert_eq!(part(&data, "cart", "faces")["flat"], true);
    part(&data, "arm", "lines");
    part(&data, "rod", "faces");
    part(&data, "bead", "balls");
    part(&data, "table", "lines");
    assert_eq!(parts(&data).iter().filter(|part| part["name"] == "cross").count(), 2, "the hinges of a universal joint");
    assert_eq!(data["links"][0]["name"], "spring");
    // The table moves with the cart.
    for frame in [0, 60, 150] {
        let [cart, table] = ["cart", "table"].map(|name| centre(&data, name, frame));
        assert!((0..3).all(|i| (cart[i] - table[i]).abs() < 1e-3), "{cart:?} {table:?}");
    }
}

/// A crank, a rod and a rocker that a ball joint closes, with a spring and a ram, driven by a motor and a jet.
pub fn linkage() -> Animation {
    let mut scene = Scene::new();
    let [torque, push, jet, both] = ["torque", "push", "jet", "both"].map(|name| scene.control(name));
    let mut space = scene.spatial();
    space.gravity([0.0, 0.0, -9.81]);
    let [crank, rod, rocker] = [("crank", 0.2), ("rod", 0.6), ("rocker", 0.5)].map(|(name, length)| {
        space.body(name, Inertia::cuboid(length, [length, 0.03, 0.03]).centred_at([0.5 * length, 0.0, 0.0]))
    });
    let drive = space.revolute("drive", Body::GROUND.origin(), crank.origin());
    let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    space.universal("elbow", crank.at([0.2, 0.0, 0.0]).along_and_toward(x, y), rod.origin().along_and_toward(x, y));
    space.revolute("pivot", Body::GROUND.at([0.5, 0.1, 0.3]).along(y), rocker.origin().along(y));
    space.close_ball("end", rod.at([0.6, 0.0, 0.0]), rocker.at([0.5, 0.0, 0.0]));
    space.spring_damper("spring", Body::GROUND.at([0.0, 0.0, 0.5]), rod.at([0.3, 0.0, 0.0]), [20.0, 0.4, 0.1]);
    space.two_point_actuator("ram", Body::GROUND.at([0.9, 0.0, 0.0]), rocker.at([0.25, 0.0, 0.0]), push);
    space.thrust("nozzle", rocker.origin(), jet);
    space.thrust("other nozzle", rocker.origin(), both);
    space.torque("wheel", Body::GROUND.origin(), rocker.origin(), both);
    scene.motor("motor", drive.angle, torque);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(50, 0.01));
    inputs.start = hamiltonian_adjoint::Start::assembled(&system).hold(&[drive.angle]);
    let (inputs, motion) = moved(&system, &inputs);
    #[cfg(feature = "files")]
    assert!(motion.to_csv(&system, &inputs).expect("a table").contains("drive.angle [rad]"));
    Animation::new(&system, &inputs, &motion).expect("an animation")
}

#[test]
fn springs_rams_and_closing_joints_are_drawn_and_controls_have_units() {
    let data = data(&page_of(&linkage()));
    let names: Vec<&str> =
        data["links"].as_array().expect("links").iter().filter_map(|link| link["name"].as_str()).collect();
    assert_eq!(names, ["spring", "ram"]);
    part(&data, "end", "balls");
    let unit = |name: &str| {
        data["plots"].as_array().expect("plots").iter().find(|plot| plot["name"] == name).map(|plot| plot["unit"].clone())
    };
    let units = ["torque", "push", "jet", "both", "drive.angle"].map(|name| unit(name).expect("a plot"));
    assert_eq!(units, ["N m", "N", "N", "", "rad"]);
}

#[test]
fn pictures_of_space_are_balanced_and_move() {
    for (animation, names) in [(arm(200), ["link 1", "joint 7"]), (top(), ["box", "box"]), (mixed(), ["cart", "slot"])] {
        let (still, moving) = (animation.svg(0.3), animation.animated_svg());
        for picture in [&still, &moving] {
            assert_balanced(picture);
            assert!(names.iter().all(|name| picture.contains(&format!("<title>{name}</title>"))));
            assert!(picture.len() < 300_000, "{} bytes", picture.len());
        }
        assert!(moving.contains("<animate attributeName=\"d\"") && !still.contains("<animate"));
        assert_ne!(still, animation.svg(0.6));
    }
}

/// The faces of a picture show their outside only, so that three of six are seen.
#[test]
fn a_box_shows_three_faces_and_rises() {
    let picture = top().svg(0.33);
    assert_eq!(picture.matches("<title>box</title>").count(), 3);
    // In the group of the picture y points up.
    let height = |time: f64| -> f64 {
        let picture = top().svg(time);
        let face = picture.split("<title>box").next().and_then(|before| before.rsplit_once(" d=\"M")).expect("a face").1;
        face.split_once('L').and_then(|(first, _)| first.split_once(' ')).expect("a corner").1.parse().expect("a number")
    };
    assert!(height(1.0) > height(0.0) + 100.0 && height(1.0) > height(2.0) + 100.0);
}

#[test]
fn the_size_of_a_scene_does_not_matter() {
    for length in [1e-9, 1.0, 1e9, 1e80] {
        let mut scene = Scene::new();
        let mut space = scene.spatial();
        let body = space.body("box", Inertia::cuboid(1.0, [length, 0.5 * length, 0.25 * length]));
        space.prismatic("rail", Body::GROUND.origin(), body.origin());
        let system = scene.compile().expect("a scene");
        let (inputs, motion) = moved(&system, &Inputs::at_rest(&system, Grid::uniform(4, 0.1)));
        let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
        let data = data(&page_of(&animation));
        let found = edges(part(&data, "box", "trail"));
        assert!((found[2] / found[0] - 4.0).abs() < 1e-2 && found[2] < 1e6 && found[2] > 1e-3, "{found:?}");
        assert_balanced(&animation.svg(0.0));
        assert_balanced(&animation.animated_svg());
    }
}
