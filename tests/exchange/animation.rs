//! Pages and pictures of motions: what is in them, and what happens in a browser.

use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{
    Animation, Error, Grid, Inputs, KineticEnergy, Scalar, Scene, Settings, Solver, Start, System, Trajectory,
};
use nalgebra::SVector;
use serde_json::Value;
use std::process::Command;

pub fn moved(system: &System, inputs: &Inputs) -> (Inputs, Trajectory) {
    let mut solver = Solver::new(system, Settings::default());
    let motion = solver.simulate(inputs).expect("a motion").clone();
    (solver.inputs().clone(), motion)
}

pub fn cart(steps: usize) -> (System, Inputs, Trajectory) {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(steps, 2.0 / steps as f64));
    inputs.controls.fill(10.0);
    let (inputs, motion) = moved(&system, &inputs);
    (system, inputs, motion)
}

/// One of every part that is drawn.
fn everything() -> Scene {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let boom = scene.body("boom", 30.0, 10.0, [1.0, 0.6, 0.3]);
    let arm = scene.body("arm", 15.0, 4.0, [2.6, 0.6, -0.7]);
    scene.revolute("foot", Body::GROUND.at(0.0, 0.0), boom.at(-1.1, 0.0));
    scene.revolute("elbow", boom.at(1.0, 0.1), arm.at(-0.9, 0.0));
    let [force, torque] = ["force", "torque"].map(|name| scene.control(name));
    scene.two_point_actuator("cylinder", Body::GROUND.at(0.6, -0.3), boom.at(0.2, 0.0), force);
    scene.actuator("pull", Body::GROUND.at(0.0, 0.0), 0.0, arm.at(0.9, 0.0), force);
    scene.spring_damper("spring", boom.at(0.0, 0.2), arm.at(-0.2, 0.1), 900.0, 1.2, 20.0);
    scene.torque_actuator("motor", boom, arm, torque);
    let law = [1e5.into(), 0.3.into(), 0.3.into(), 0.1.into()];
    scene.contact("floor", Body::GROUND.at(0.0, -0.8), std::f64::consts::FRAC_PI_2, arm.at(0.9, 0.0), law);
    let load = scene.particle("load", 5.0, [3.4, -0.2]);
    scene.distance("rope", arm.at(0.9, 0.0), load.point(), 0.6);
    let wheels = [("wheel", 0.0), ("second wheel", 0.5)].map(|(name, y)| {
        let wheel = scene.body(name, 1.0, 0.1, [-0.8, y, 0.0]);
        scene.revolute(&format!("axle of {name}"), Body::GROUND.at(-0.8, y), wheel.at(0.0, 0.0));
        wheel
    });
    scene.gear("gear", wheels[0], 0.3, wheels[1], 0.2);
    let plate = scene.body("plate", 1.0, 0.1, [-0.8, 0.9, 0.0]);
    scene.weld("glue", wheels[1].at(0.0, 0.1), plate.at(0.0, 0.0), 0.0);
    let law = [1e5, 0.3, 0.3, 0.1, 1e-3].map(Into::into);
    scene.circle_contact("round floor", Body::GROUND.at(0.0, -0.9), std::f64::consts::FRAC_PI_2, load.point(), 0.1, law);
    scene.circle_pair_contact("stone", Body::GROUND.at(3.0, -1.0), 0.2, load.point(), 0.1, law);
    let slide = scene.body("slide", 1.0, 0.1, [0.0, 1.5, 0.0]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 1.5), 0.0, slide.at(0.0, 0.0), 0.0);
    let (ground, law) = (Body::GROUND.at(0.0, 1.5), [1e4, 0.1, 0.0].map(Into::into));
    scene.sliding_end_stop("ends of the rail", ground, 0.0, slide.at(0.0, 0.0), [-0.3, 0.3].map(Into::into), law);
    scene
}

fn page_of_everything() -> String {
    let system = everything().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.005));
    inputs.start = Start::assembled(&system);
    inputs.controls.iter_mut().enumerate().for_each(|(i, u)| *u = 30.0 * (0.1 * i as f64).sin());
    let (inputs, motion) = moved(&system, &inputs);
    let animation = Animation::new(&system, &inputs, &motion).expect("an animation").title("All parts");
    assert_balanced(&animation.svg(0.2));
    assert_balanced(&animation.animated_svg());
    animation.html()
}

pub fn data(page: &str) -> Value {
    let begin = page.find("id=\"data\">").expect("data") + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").expect("an end");
    serde_json::from_str(&page[begin..end]).expect("JSON")
}

/// Every tag is closed in its order, and nothing is open at the end.
pub fn assert_balanced(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (inside, _) = tag.split_once('>').expect("a closed tag");
        let name = inside.trim_start_matches('/').split([' ', '/']).next().unwrap_or_default();
        if inside.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "in {inside}");
        } else if !inside.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn the_page_holds_the_motion_of_every_body_and_is_small() {
    let (system, inputs, motion) = cart(100);
    let speeds: Vec<f64> = motion.v.row(0).iter().copied().collect();
    let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
    let page = animation.plot("speed", "m/s", &speeds).expect("a plot").html();
    assert!(page.len() < 60_000, "{} bytes", page.len());
    assert!(
        !page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org/2000/svg").count()
    );
    let data = data(&page);
    assert_eq!(data["times"].as_array().expect("times").len(), 101);
    let units: Vec<&str> =
        data["plots"].as_array().expect("plots").iter().filter_map(|plot| plot["unit"].as_str()).collect();
    assert_eq!(units, ["N", "J", "m/s"], "of the force on the cart, the energy and the speed");
    let bodies: Vec<bool> = data["bodies"].as_array().expect("flags").iter().map(|flag| flag == true).collect();
    assert_eq!(bodies.iter().filter(|is_body| **is_body).count(), 4);
    for node in [0, 37, 100] {
        for body in 0..4 {
            for k in 0..3 {
                let shown = data["poses"][body][k][node].as_f64().expect("a number");
                assert!((shown - motion.q[(3 * body + k, node)]).abs() < 1e-3, "body {body} at node {node}");
            }
        }
    }
    let names: Vec<&str> =
        data["plots"].as_array().expect("plots").iter().map(|plot| plot["name"].as_str().expect("a name")).collect();
    assert_eq!(names, ["force on the cart", "energy", "speed"]);
    assert_balanced(&Animation::new(&system, &inputs, &motion).expect("an animation").animated_svg());
}

#[test]
fn all_parts_are_drawn() {
    let page = page_of_everything();
    for name in [
        "boom",
        "foot",
        "cylinder",
        "pull",
        "spring",
        "motor",
        "floor",
        "load",
        "rope",
        "gear",
        "glue",
        "rail",
        "round floor",
        "stone",
        "ends of the rail",
    ] {
        assert!(page.contains(&format!("<title>{name}</title>")), "{name}");
    }
}

/// Two angles without bodies.
fn without_bodies() -> (System, Inputs, Trajectory) {
    struct Turning;
    impl KineticEnergy<2> for Turning {
        fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 2>, v: &SVector<S, 2>, _b: &SVector<S, 0>) -> S {
            v.dot(v) * 0.5
        }
    }
    let mut scene = Scene::new();
    let q = scene.coordinates("arm", ["φ", "ψ"]);
    scene.kinetic_energy("arm", Turning, q, []);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(20, 0.1));
    inputs.start.set_rate(q[0], 1.0);
    let (inputs, motion) = moved(&system, &inputs);
    (system, inputs, motion)
}

#[test]
fn a_scene_without_bodies_says_so_and_plots_its_coordinates() {
    let (system, inputs, motion) = without_bodies();
    let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
    for text in [animation.html(), animation.svg(1.0), animation.animated_svg()] {
        assert!(text.contains("No part of this scene can be drawn"));
    }
    let plots = data(&animation.html())["plots"].clone();
    let names: Vec<&str> = plots.as_array().expect("plots").iter().filter_map(|plot| plot["name"].as_str()).collect();
    assert_eq!(names, ["energy", "arm.φ", "arm.ψ"]);
    assert!((plots[1]["values"][20].as_f64().expect("an angle") - motion.q[(0, 20)]).abs() < 1e-4);
    assert_balanced(&animation.animated_svg());
    // Bodies have pictures instead of plots.
    let (system, inputs, motion) = cart(20);
    let page = Animation::new(&system, &inputs, &motion).expect("an animation").html();
    assert!(!page.contains("No part of this scene") && data(&page)["plots"].as_array().expect("plots").len() == 2);
}

#[test]
fn drawings_follow_the_state_and_fixed_ones_do_not_move() {
    let (system, inputs, motion) = without_bodies();
    let tip = |q: &[f64]| [q[0].cos(), q[0].sin()];
    let plain = || Animation::new(&system, &inputs, &motion).expect("an animation");
    let animation = (plain().line("arm", |q, _t| vec![[0.0; 2], tip(q)]).expect("a line"))
        .line("load", |q, t| vec![[tip(q)[0], tip(q)[1] - 0.1 * t]])
        .and_then(|drawn| drawn.wall("wall", &[[-1.0, -2.0], [3.0, -2.0]]))
        .and_then(|drawn| drawn.obstacle("post", [2.0, 0.5], 0.25))
        .and_then(|drawn| drawn.target("goal", [0.0, 1.0]))
        .expect("drawings");
    let page = animation.html();
    for name in ["arm", "load", "wall", "post", "goal"] {
        assert!(page.contains(&format!("<title>{name}</title>")), "{name}");
    }
    assert!(!page.contains("No part of this scene"));
    // The second point of the line is a group of its own, the third the load.
    for node in [0, 7, 20] {
        let [x, y] = tip(motion.q.column(node).as_slice());
        for (group, expected) in [(1, [x, y]), (2, [x, y - 0.1 * motion.times[node]])] {
            for (k, expected) in expected.into_iter().enumerate() {
                let shown = data(&page)["poses"][group][k][node].as_f64().expect("a number");
                assert!((shown - expected).abs() < 1e-3, "group {group} at node {node}: {shown} for {expected}");
            }
        }
    }
    assert_balanced(&animation.svg(1.0));
    assert_balanced(&animation.animated_svg());
    let nan = plain().line("arm", |q, _t| vec![[f64::NAN, q[0]]]).expect_err("no place");
    assert!(nan.to_string().contains("`arm`"), "{nan}");
    let more = plain().line("arm", |_q, t| vec![[0.0; 2]; 1 + (t > 1.0) as usize]).expect_err("another number of points");
    assert!(matches!(more, Error::Size { expected: 1, found: 2, .. }), "{more}");
    assert!(plain().obstacle("post", [0.0; 2], f64::INFINITY).is_err() && plain().target("goal", [f64::NAN; 2]).is_err());
}

#[test]
fn elements_of_ones_own_are_drawn_where_it_is_said() {
    let drawn = |springs: usize, foreign: bool| {
        let mut scene = Scene::new();
        let body = scene.body("body", 1.0, 0.1, [1.0, 0.0, 0.0]);
        let particle = scene.particle("particle", 1.0, [2.0, 0.0]);
        scene.draw_rod("rope", body.at(0.5, 0.0), particle.point());
        let mut other = Scene::new();
        let stranger = other.body("body", 1.0, 0.1, [1.0, 0.0, 0.0]);
        (0..springs).for_each(|_| scene.draw_spring("law", Body::GROUND.at(0.0, 1.0), body.at(-0.5, 0.0)));
        if foreign {
            scene.draw_spring("law", Body::GROUND.at(0.0, 1.0), stranger.at(-0.5, 0.0));
        }
        scene.compile()
    };
    let svg = |springs: usize| {
        let system = drawn(springs, false).expect("a scene");
        let (inputs, motion) = moved(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1)));
        let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
        assert_balanced(&animation.svg(0.1));
        animation.html()
    };
    let (with, without) = (svg(1), svg(0));
    assert!(with.contains("<title>law</title>") && with.contains("<title>rope</title>"));
    assert!(!without.contains("<title>law</title>"));
    assert!(matches!(drawn(1, true), Err(Error::Foreign { element, .. }) if element == "law"));
}

#[test]
fn names_of_strangers_stay_names() {
    let name = "{{picture}}{{data}}</script><script>alert('\"1\"')</script>";
    let mut scene = Scene::new();
    let body = scene.body(name, 1.0, 0.1, [0.0; 3]);
    let force = scene.control(&format!("{name}!"));
    scene.actuator(&format!("{name}?"), Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.3, 0.0), force);
    let system = scene.compile().expect("a scene");
    let (inputs, motion) = moved(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.1)));
    let animation = Animation::new(&system, &inputs, &motion).expect("an animation").title("{{data}} & <b>");
    let page = animation.html();
    assert_eq!(page.matches("<script").count(), 2, "those of the page");
    assert!(!page.contains("<script>alert"));
    assert_eq!(data(&page)["plots"][0]["name"], format!("{name}!"));
    for tag in ["title", "h1"] {
        assert!(page.contains(&format!("\n<{tag}>{{{{data}}}} &amp; &lt;b&gt;</{tag}>\n")), "{tag}");
    }
    assert_eq!(page.matches("id=\"picture\"").count(), 1);
    assert_balanced(&animation.svg(0.0));
}

#[test]
fn long_motions_are_thinned_and_short_ones_shown() {
    let (system, inputs, motion) = cart(4000);
    let page = Animation::new(&system, &inputs, &motion).expect("an animation").html();
    let shown = data(&page)["times"].as_array().expect("times").len();
    assert!((1000..=1501).contains(&shown), "{shown}");
    assert!(page.len() < 300_000, "{} bytes", page.len());
    assert_eq!(data(&page)["times"][shown - 1].as_f64().map(|t| (t - 2.0).abs() < 1e-3), Some(true));
    let (system, inputs, motion) = cart(1);
    assert_eq!(
        data(&Animation::new(&system, &inputs, &motion).expect("an animation").html())["times"]
            .as_array()
            .expect("times")
            .len(),
        2
    );
}

/// The cart in a hundred steps from a time on.
fn page_of_cart(start: f64, step: f64) -> String {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::new(start, vec![step; 100]));
    inputs.controls.fill(10.0);
    let (inputs, motion) = moved(&system, &inputs);
    Animation::new(&system, &inputs, &motion).expect("an animation").title("Cart").html()
}

#[test]
fn motions_that_start_late_or_far_away_are_shown_as_they_are() {
    let late = data(&page_of_cart(1e4, 0.01));
    let times: Vec<f64> = late["times"].as_array().expect("times").iter().filter_map(Value::as_f64).collect();
    assert!(times.windows(2).all(|of| (of[1] - of[0] - 0.01).abs() < 1e-6), "{times:?}");
    let mut scene = Scene::new();
    let body = scene.body("cart", 1.0, 0.1, [1e4, 0.0, 0.0]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, body.at(0.0, 0.0), force);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(100, 0.01));
    inputs.controls.fill(2.0);
    let (inputs, motion) = moved(&system, &inputs);
    let far = data(&Animation::new(&system, &inputs, &motion).expect("an animation").html());
    for node in [10, 100] {
        let shown = far["poses"][0][0][node].as_f64().expect("a number");
        assert!((shown - motion.q[(0, node)]).abs() < 1e-4, "{shown}");
    }
}

#[test]
fn pictures_of_motions_that_go_back_in_time_or_are_short_move() {
    let system = CartPendulum::default().scene().compile().expect("a scene");
    for (start, step, duration) in [(0.5, -0.05, "0.5"), (0.0, 1e-5, "0.0001")] {
        let mut inputs = Inputs::at_rest(&system, Grid::new(start, vec![step; 10]));
        inputs.controls.fill(10.0);
        let (inputs, motion) = moved(&system, &inputs);
        let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
        let svg = animation.animated_svg();
        assert!(svg.contains(&format!("dur=\"{duration}s\"")) && !svg.contains("dur=\"0s\""));
        assert!(svg.contains("keyTimes=\"0;0.1;0.2;0.3;0.4;0.5;0.6;0.7;0.8;0.9;1\""));
        let stills = [0, 5, 10].map(|node| animation.svg(motion.times[node]));
        assert!(step > 0.0 || stills[0] != stills[1] && stills[1] != stills[2]);
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let (system, inputs, motion) = cart(10);
    let animation = Animation::new(&system, &inputs, &motion).expect("an animation");
    assert!(matches!(animation.plot("short", "m", &[0.0; 3]), Err(Error::Size { expected: 11, found: 3, .. })));
    let (_, other, _) = cart(5);
    assert!(Animation::new(&system, &other, &motion).is_err());
    let none = Trajectory { computed: 0, ..motion };
    assert!(matches!(Animation::new(&system, &inputs, &none), Err(Error::Incomplete { .. })));
}

/// Run it with `cargo test --test exchange -- --ignored` where a program `chromium` is.
#[test]
#[ignore = "needs Chromium"]
fn a_browser_plays_the_page_without_errors() {
    let pages = [
        (page_of_everything(), "All parts", "t = 0.250 s"),
        (page_of_cart(1e4, 0.01), "Cart", "t = 10000.500 s"),
        (page_of_cart(2.0, -0.01), "Cart", "t = 1.500 s"),
        (super::extremes::page(1e150, 1.0), "Motion", "t = 0.500 s"),
        (super::extremes::page(1e-14, 5e-13), "Motion", "t = 2.500e-13 s"),
        (super::space::page_of(&super::space::arm(200)), "Motion", "t = 0.500 s"),
        (super::space::page_of(&super::space::top()), "Motion", "t = 1.000 s"),
        (super::space::page_of(&super::space::mixed()), "Motion", "t = 0.750 s"),
    ];
    for (page, title, middle) in pages {
        let told = played(&page);
        assert_eq!(told["problems"], Value::Array(Vec::new()), "{told}");
        assert_eq!((&told["moved"], &told["bad"]), (&Value::Bool(true), &Value::Bool(false)), "{told}");
        assert_eq!((told["time"].as_str(), told["playing"].as_str()), (Some(middle), Some("Pause")), "{told}");
        assert_eq!((told["title"].as_str(), told["went"].as_bool()), (Some(title), Some(true)), "{told}");
    }
}

/// What a browser tells of a page that is moved to its middle and played.
fn played(page: &str) -> Value {
    // Without a window no frames are asked for.
    let watch = "<head><script>
        window.problems = []; window.onerror = text => { window.problems.push(text); };
        window.requestAnimationFrame = tick => setTimeout(() => tick(performance.now()), 16);
        </script>";
    let act = "<script>
        const canvas = document.querySelector('canvas');
        const seen = () => canvas ? canvas.toDataURL() : [...document.querySelectorAll('g.moving')].map(g => g.getAttribute('transform')).join();
        const before = seen(), slider = document.getElementById('slider'), title = document.title;
        slider.value = 500; slider.dispatchEvent(new Event('input'));
        const middle = seen(), time = document.getElementById('time').textContent;
        document.getElementById('play').click();
        const playing = document.getElementById('play').textContent;
        setTimeout(() => {
            const told = { problems: window.problems, moved: before !== middle, bad: middle.includes('NaN'), went: seen() !== middle };
            document.title = JSON.stringify({ ...told, time, playing, title });
        }, 200);
        </script></body>";
    let page = page.replacen("<head>", watch, 1).replacen("</body>", act, 1);
    let folder = std::env::temp_dir().join(format!("browser-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("page.html");
    std::fs::write(&file, page).expect("a file");
    let quiet = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--no-first-run",
        "--disable-background-networking",
        "--virtual-time-budget=1000",
        "--dump-dom",
    ];
    let browser = Command::new("chromium")
        .args(quiet)
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("Chromium");
    std::fs::remove_dir_all(&folder).ok();
    let dom = String::from_utf8_lossy(&browser.stdout).into_owned();
    let title = dom.split("<title>").nth(1).and_then(|rest| rest.split("</title>").next()).expect("a title");
    serde_json::from_str(&title.replace("&quot;", "\"")).expect("JSON")
}

#[test]
fn rounding_is_not_drawn_as_motion() {
    let mut scene = Scene::new();
    scene.gravity(0.0, -9.81);
    let cart = scene.body("cart", 1.5, 0.01, [0.0; 3]);
    scene.prismatic("rail", Body::GROUND.at(0.0, 0.0), 0.0, cart.at(0.0, 0.0), 0.0);
    let system = scene.compile().expect("a scene");
    let (inputs, motion) = moved(&system, &Inputs::at_rest(&system, Grid::uniform(100, 0.01)));
    let svg = Animation::new(&system, &inputs, &motion).expect("an animation").svg(0.0);
    let view = svg.split("viewBox=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a view");
    let numbers: Vec<f64> = view.split(' ').map(|x| x.parse().expect("a number")).collect();
    assert!(numbers[2] <= 1.2 && numbers[3] <= 1.2, "{view}");
}

#[test]
fn walls_have_two_points_and_radii_are_not_negative() {
    let (system, inputs, motion) = cart(10);
    let animation = || Animation::new(&system, &inputs, &motion).expect("an animation");
    let errors = [animation().wall("stop", &[[0.0; 2]]), animation().obstacle("pillar", [0.0; 2], -0.1)].map(Result::err);
    let texts = errors.map(|error| error.expect("an error").to_string());
    assert!(texts[0].contains("the number of points of `stop`") && texts[1].contains("the radius of `pillar`"), "{texts:?}");
}

#[test]
fn a_point_mass_is_drawn_at_the_end_of_its_rod() {
    let width = |inertia: f64| {
        let mut scene = Scene::new();
        let bob = scene.body("bob", 0.4, inertia, [0.6, 0.0, 0.0]);
        scene.revolute("pivot", Body::GROUND.at(0.0, 0.0), bob.at(-0.6, 0.0));
        let system = scene.compile().expect("a scene");
        let (inputs, motion) = moved(&system, &Inputs::at_rest(&system, Grid::uniform(3, 0.01)));
        let svg = Animation::new(&system, &inputs, &motion).expect("an animation").svg(0.0);
        let view = svg.split("viewBox=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a view");
        view.split(' ').nth(2).and_then(|x| x.parse::<f64>().ok()).expect("a width")
    };
    assert!(width(0.0) < 0.75 && width(0.1) > 1.2, "{} {}", width(0.0), width(0.1));
}
