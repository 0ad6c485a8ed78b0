//! Bodies that turn about a point: free top, heavy top, gimbals.

use hamiltonian_adjoint::spatial::{Body, Inertia};
use hamiltonian_adjoint::{Error, Mechanics, Scene, Scheme};

use super::{Case, array, at, at_rest, attitude, columns, ends, list, named, number, put, reference};

fn free_top(name: &str, time: f64) -> Case {
    let all = reference("1_free_top");
    let (of, given) = (&all["parameters"], &all[name]);
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    let body = space.body("top", Inertia::principal(number(&of["mass"]), array::<3>(&of["J_diag"])));
    let joint = space.free("flight", Body::GROUND.origin(), body.origin());
    attitude(&mut scene, body.origin());
    let system = scene.compile().expect("a scene");
    let mut start = at_rest(&system);
    put(&mut start, &joint.position, &[0.0; 3], &list(&given["start"]["velocity"]));
    start.set_angular_velocity(joint.orientation, array(&given["start"]["omega_body"])).expect("velocities");
    let end = at(&given["values"], time);
    let truth = [columns(&end["R"]), named(end, &["omega_body", "position"])].concat();
    Case::new(&format!("1 free top, {name}"), system, start, (time, truth))
}

#[test]
fn a_free_top() -> Result<(), Error> {
    free_top("general", 2.0).assert_orders([50, 20, 20])?;
    free_top("near_unstable", 2.0).assert_orders([100, 40, 40])?;
    free_top("general", 2.0).assert_close(Scheme::ESDIRK5, 1000, 1e-12)
}

fn heavy_top(name: &str, time: f64) -> Case {
    let all = reference("2_heavy_top");
    let (of, given) = (&all["parameters"], &all[name]);
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let inertia = Inertia::principal(number(&of["mass"]), array::<3>(&of["J_centre_body_diag"]));
    let centre = array::<3>(&of["centre_body"]);
    let body = space.body("top", inertia.centred_at(centre));
    let joint = space.ball("joint", Body::GROUND.origin(), body.origin());
    attitude(&mut scene, body.at(centre));
    let system = scene.compile().expect("a scene");
    let mut start = at_rest(&system);
    start.set_angular_velocity(joint.orientation, array(&given["omega0_body"])).expect("velocities");
    let end = at(&given["values"], time);
    let truth = [columns(&end["R"]), named(end, &["omega_body", "centre"])].concat();
    Case::new(&format!("2 heavy top, {name}"), system, start, (time, truth))
}

#[test]
fn a_heavy_top() -> Result<(), Error> {
    heavy_top("slow", 0.5).assert_orders([200, 50, 50])?;
    heavy_top("slow", 1.0).assert_close(Scheme::ESDIRK5, 2000, 1e-11)?;
    heavy_top("fast", 0.5).assert_orders([2000, 500, 250])?;
    let case = heavy_top("fast", 0.5);
    let here = Mechanics::new(&case.system, case.start.q().as_slice(), case.start.rate().as_slice())?;
    let energy = number(&reference("2_heavy_top")["fast"]["start"]["energy"]);
    assert!((here.energy() / energy - 1.0).abs() < 1e-15);
    Ok(())
}

#[test]
fn a_rotor_in_gimbals() -> Result<(), Error> {
    let all = reference("8_gimbals");
    let of = &all["parameters"];
    let mut scene = Scene::new();
    let mut space = scene.spatial();
    space.gravity(array::<3>(&of["g"]));
    let [outer, inner, rotor] = ["outer", "inner", "rotor"].map(|name| {
        let inertia = Inertia::principal(number(&of[name]["mass"]), array::<3>(&of[name]["J_diag"]));
        space.body(name, inertia)
    });
    let weight = space.body("weight", Inertia::point(number(&of["weight"]["mass"])));
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let a = space.revolute("a", Body::GROUND.origin(), outer.origin());
    let b = space.revolute("b", outer.origin().along(x), inner.origin().along(x));
    let c = space.revolute("c", inner.origin().along(y), rotor.origin().along(y));
    space.fixed("screw", inner.at(array::<3>(&of["weight"]["at_inner"])), weight.origin());
    let angles = [a, b, c].map(|joint| joint.angle);
    let outputs = ends(&mut scene, &angles);
    let system = scene.compile()?;
    let mut start = at_rest(&system);
    put(&mut start, &angles, &list(&all["start"]["angles"]), &list(&all["start"]["rates"]));
    let here = Mechanics::new(&system, start.q().as_slice(), start.rate().as_slice())?;
    let (accelerations, _) = here.accelerations()?;
    let error = crate::common::relative_error(accelerations.as_slice(), &list(&all["start"]["accelerations"]));
    println!("8 gimbals: accelerations {error:.1e}, energy {:e}", here.energy() - number(&all["start"]["energy"]));
    assert!(error < 1e-14 && (here.energy() - number(&all["start"]["energy"])).abs() < 1e-14);
    let truth = named(at(&all["values"], 0.5), &["angles", "rates"]);
    Case { outputs, ..Case::new("8 gimbals", system, start, (0.5, truth)) }.assert_orders([500, 200, 200])
}
