//! Pages and pictures of motions that are very small, large, short or long.

use super::animation::{assert_balanced, cart, data, moved};
use hamiltonian_adjoint::planar::Body;
use hamiltonian_adjoint::{Animation, Grid, Inputs, Scene, Trajectory};
use serde_json::Value;

/// A rod that is pushed by its own length in a time, with the inputs and the motion.
fn pushed(length: f64, duration: f64) -> (Animation, Inputs, Trajectory) {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, length * length, [0.0; 3]);
    let force = scene.control("force");
    scene.actuator("motor", Body::GROUND.at(0.0, 0.0), 0.0, rod.at(0.0, 0.0), force);
    scene.actuator("other end", Body::GROUND.at(0.0, 0.0), 0.0, rod.at(0.0, length), force);
    let system = scene.compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.1 * duration));
    inputs.controls.fill(length / duration / duration);
    let (inputs, motion) = moved(&system, &inputs);
    (Animation::new(&system, &inputs, &motion).expect("an animation"), inputs, motion)
}

pub fn page(length: f64, duration: f64) -> String {
    pushed(length, duration).0.html()
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
}

/// The numbers between two marks.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    text.split_once(begin).and_then(|(_, rest)| rest.split_once(end)).expect("both marks").0
}

fn assert_close(found: &[f64], expected: &[f64]) {
    let size = expected.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    assert!(found.len() == expected.len() && size > 0.0);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-3 * size, "{found} in the place of {expected}");
    }
}

#[test]
fn quantities_and_places_of_any_size_are_shown() {
    for (length, duration) in [(1e-14, 1.0), (1e-6, 1e-3), (1.0, 1.0), (1e9, 1.0), (1e150, 1.0)] {
        let (animation, inputs, motion) = pushed(length, duration);
        let page = animation.html();
        let data = data(&page);
        assert_close(&numbers(&data["plots"][0]["values"]), inputs.controls.as_slice());
        // Drawn lengths are in parts of what is seen.
        let picture = animation.animated_svg();
        assert_balanced(&picture);
        let view: Vec<f64> =
            between(&picture, "viewBox=\"", "\"").split(' ').map(|x| x.parse().expect("a number")).collect();
        assert!(view.iter().all(|x| x.abs() < 1e6) && view[2].max(view[3]) > 1e-3, "{view:?}");
        let places = numbers(&data["poses"][0][0]);
        let moved: Vec<f64> = motion.q.row(0).iter().map(|x| x / motion.q[(0, 10)]).collect();
        assert!(places[10] > 0.1 * view[2].max(view[3]) && places[10] < view[2]);
        assert_close(&places.iter().map(|x| x / places[10]).collect::<Vec<f64>>(), &moved);
        for text in [&picture, &animation.svg(0.0), &page] {
            let longest = text.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
            assert!(longest <= Some(17), "numbers of {longest:?} digits");
        }
    }
}

#[test]
fn what_is_too_short_or_too_long_to_be_watched_takes_ten_seconds() {
    for (duration, shown) in [(5e-13, "10s"), (2e-5, "0.00002s"), (2.0, "2s"), (1e9, "10s"), (1e100, "10s")] {
        let (animation, _, motion) = pushed(1.0, duration);
        let picture = animation.animated_svg();
        assert_eq!(between(&picture, "dur=\"", "\""), shown);
        assert!(picture.contains("keyTimes=\"0;0.1;0.2;0.3;0.4;0.5;0.6;0.7;0.8;0.9;1\""));
        assert_close(&numbers(&data(&animation.html())["times"]), &motion.times);
    }
}

#[test]
fn pictures_that_move_show_the_whole_of_long_motions() {
    for steps in [1, 149, 150, 151, 4000] {
        let (system, inputs, motion) = cart(steps);
        let picture = Animation::new(&system, &inputs, &motion).expect("an animation").animated_svg();
        assert_eq!(between(&picture, "dur=\"", "\""), "2s", "{steps} steps");
        let keys: Vec<&str> = between(&picture, "keyTimes=\"", "\"").split(';').collect();
        assert_eq!((keys.len(), keys[0], keys[keys.len() - 1]), ((steps + 1).min(150), "0", "1"));
        let places: Vec<&str> = between(&picture, "values=\"", "\"").split(';').collect();
        let last: f64 = places[places.len() - 1].split_once(' ').expect("two numbers").0.parse().expect("a number");
        assert!((last - motion.q[(0, steps)]).abs() < 1e-3 && places.len() == keys.len(), "{steps} steps: {last}");
    }
}
