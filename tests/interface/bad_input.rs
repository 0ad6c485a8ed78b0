//! Bad scenes: each is refused with an error that names the culprit and says what to do.

use crate::common::assert_says;
use hamiltonian_adjoint::planar::{Body, ConstantSpeed, Revolute, RigidBody};
use hamiltonian_adjoint::scenes::AngleError;
use hamiltonian_adjoint::{Error, Force, ForcePoint, KineticEnergy, Param, Scalar, Scene, Sum};
use nalgebra::SVector;

const PLACE: [f64; 3] = [0.5, 0.0, 0.0];

fn with_rod() -> (Scene, Body) {
    let mut scene = Scene::new();
    let rod = scene.body("rod", 1.0, 0.1, PLACE);
    (scene, rod)
}

fn refused(scene: Scene) -> Error {
    scene.compile().expect_err("a bad scene")
}

fn duplicate(kind: &'static str, name: &str) -> Error {
    Error::DuplicateName { kind, name: name.into() }
}

#[test]
fn an_empty_scene_is_refused() {
    let error = refused(Scene::new());
    assert_eq!(error, Error::EmptyScene);
    assert_says(&error, &["no coordinates", "add a body"]);
}

#[test]
fn two_bodies_of_one_name_are_refused() {
    let (mut scene, _) = with_rod();
    scene.body("rod", 1.0, 0.1, PLACE);
    let error = refused(scene);
    assert_eq!(error, duplicate("body or coordinate group", "rod"));
    assert_says(&error, &["`rod`", "must be unique"]);
}

#[test]
fn two_coordinates_of_one_name_are_refused() {
    let mut scene = Scene::new();
    let q = scene.coordinates("crank", ["angle", "angle"]);
    scene.kinetic_energy("T", Mass, [q[0]], [1.0.into()]);
    assert_eq!(refused(scene), duplicate("coordinate", "crank.angle"));
}

#[test]
fn two_elements_of_one_name_are_refused() {
    let (mut scene, rod) = with_rod();
    scene.joint_friction("drag", Body::GROUND, rod, 0.1);
    scene.joint_friction("drag", Body::GROUND, rod, 0.2);
    let error = refused(scene);
    assert_eq!(error, duplicate("element", "drag"));
    assert_says(&error, &["more than one element", "`drag`"]);
}

#[test]
fn two_controls_of_one_name_are_refused() {
    let (mut scene, _) = with_rod();
    scene.control("torque");
    scene.control("torque");
    assert_eq!(refused(scene), duplicate("control", "torque"));
}

#[test]
fn two_design_variables_of_one_name_are_refused() {
    let (mut scene, _) = with_rod();
    scene.design("mass", 1.0);
    scene.design("mass", 2.0);
    assert_eq!(refused(scene), duplicate("design variable", "mass"));
}

#[test]
fn two_costs_of_one_name_are_refused() {
    let (mut scene, rod) = with_rod();
    let [_, _, angle] = rod.coordinates;
    for _ in 0..2 {
        scene.cost("aim", AngleError, Sum::Terminal, [angle], [], [], [0.0.into()]);
    }
    assert_eq!(refused(scene), duplicate("cost", "aim"));
}

/// ½ m v², b = [m].
struct Mass;
impl KineticEnergy<1, 1> for Mass {
    fn kinetic_energy<S: Scalar>(&self, _q: &SVector<S, 1>, v: &SVector<S, 1>, b: &SVector<S, 1>) -> S {
        b[0] * v[0] * v[0] * 0.5
    }
}

/// u.
struct Push;
impl Force<1, 1> for Push {
    fn force<S: Scalar>(&self, at: &ForcePoint<S, 1, 1>, _b: &SVector<S, 0>) -> SVector<S, 1> {
        SVector::from([at.u[0]])
    }
}

fn assert_foreign(scene: Scene, element: &str, kind: &'static str) {
    let error = refused(scene);
    assert_eq!(error, Error::Foreign { element: element.into(), kind });
    assert_says(&error, &[element, kind, "another scene"]);
}

#[test]
fn handles_of_another_scene_are_refused() {
    let (mut other, foreign) = with_rod();
    let foreign_angle = foreign.coordinates[2];
    let (foreign_control, foreign_design) = (other.control("u"), other.design("b", 1.0));
    let foreign_sigma = other.revolute("hinge", Body::GROUND.at(0.0, 0.0), foreign.at(-0.5, 0.0))[0];

    let (mut scene, rod) = with_rod();
    scene.revolute("hinge", rod.at(0.5, 0.0), foreign.at(0.0, 0.0));
    assert_foreign(scene, "hinge", "coordinate");

    let (mut scene, rod) = with_rod();
    scene.force("push", Push, [rod.coordinates[0]], [foreign_control], []);
    assert_foreign(scene, "push", "control");

    let (mut scene, rod) = with_rod();
    scene.joint_friction("drag", Body::GROUND, rod, foreign_design);
    assert_foreign(scene, "drag", "design variable");

    let mut scene = Scene::new();
    scene.body("disc", 1.0, foreign_design, PLACE);
    assert_foreign(scene, "disc", "design variable");

    let (mut scene, _) = with_rod();
    scene.gravity(0.0, foreign_design);
    assert_foreign(scene, "gravity", "design variable");

    let (mut scene, _) = with_rod();
    scene.place(foreign_angle, 1.0);
    assert_foreign(scene, "the initial coordinates", "coordinate");

    let (mut scene, _) = with_rod();
    scene.cost("aim", AngleError, Sum::Terminal, [foreign_angle], [], [], [0.0.into()]);
    assert_foreign(scene, "aim", "coordinate");

    let (mut scene, rod) = with_rod();
    let q = rod.coordinates;
    scene.cost("effort", crate::common::bench::Everything, Sum::Plain, q, [foreign_sigma], [foreign_control], [1.0.into()]);
    assert_foreign(scene, "effort", "multiplier");
}

#[test]
fn a_coordinate_of_another_scene_that_is_repeated_is_refused_too() {
    let (_other, foreign) = with_rod();
    let x = foreign.coordinates;
    let mut scene = Scene::new();
    scene.kinetic_energy("T", RigidBody, [x[2], x[2], x[2]], [1.0.into(), 1.0.into()]);
    assert_foreign(scene, "T", "coordinate");
}

#[test]
fn a_joint_from_the_ground_to_itself_is_refused() {
    let ground = Body::GROUND;
    type Adder = fn(&mut Scene);
    let adders: [(&str, Adder); 5] = [
        ("hinge", |scene| _ = scene.revolute("hinge", Body::GROUND.at(0.0, 0.0), Body::GROUND.at(0.0, 0.0))),
        ("motor", |scene| {
            _ = scene.driven_angle("motor", Body::GROUND, Body::GROUND, ConstantSpeed, [0.0.into(), 1.0.into()])
        }),
        ("strut (spring)", |scene| {
            scene.spring_damper("strut", Body::GROUND.at(0.0, 0.0), Body::GROUND.at(1.0, 0.0), 1.0, 1.0, 1.0)
        }),
        ("drag", |scene| scene.joint_friction("drag", Body::GROUND, Body::GROUND, 1.0)),
        ("drive", |scene| {
            let control = scene.control("u");
            scene.torque_actuator("drive", Body::GROUND, Body::GROUND, control);
        }),
    ];
    assert_eq!(ground.coordinates(), None);
    for (name, add) in adders {
        let (mut scene, _) = with_rod();
        add(&mut scene);
        let error = refused(scene);
        assert_eq!(error, Error::NoBody { element: name.into() });
        assert_says(&error, &[name, "ground", "must be a body"]);
    }
}

#[test]
fn a_joint_of_a_body_with_itself_is_refused() {
    let (mut scene, rod) = with_rod();
    scene.revolute("hinge", rod.at(0.5, 0.0), rod.at(0.5, 0.0));
    let error = refused(scene);
    assert_eq!(error, Error::RepeatedCoordinate { element: "hinge".into(), coordinate: "rod.x".into() });
    assert_says(&error, &["`hinge`", "`rod.x`", "twice", "two different bodies"]);
}

#[test]
fn a_coordinate_without_inertia_is_refused() {
    let (mut scene, _) = with_rod();
    scene.coordinates("valve", ["lift"]);
    let error = refused(scene);
    assert_eq!(error, Error::MissingInertia { coordinate: "valve.lift".into() });
    assert_says(&error, &["`valve.lift`", "kinetic energy", "add a mass"]);
}

#[test]
fn constants_that_must_be_positive_are_checked_when_the_scene_is_compiled() {
    for bad in [-1.0, -1e-300, f64::INFINITY] {
        let mut scene = Scene::new();
        let mass = scene.design("m", bad);
        scene.body("rod", mass, 0.1, PLACE);
        let error = refused(scene);
        let must_be = "finite and not negative";
        assert_eq!(error, Error::Parameter { what: "the mass of `rod`".into(), value: bad, must_be });
        assert_says(&error, &["the mass of `rod`", "must be finite and not negative"]);
    }
    let mut scene = Scene::new();
    scene.body("rod", 1.0, -0.1, PLACE);
    assert_says(&refused(scene), &["the moment of inertia of `rod` is -0.1"]);

    let (mut scene, rod) = with_rod();
    scene.distance("link", Body::GROUND.at(0.0, 0.0), rod.at(0.0, 0.0), 0.0);
    assert_says(&refused(scene), &["the length of `link` is 0"]);
}

#[test]
fn constants_that_are_not_finite_are_refused() {
    let (mut scene, rod) = with_rod();
    scene.joint_friction("drag", Body::GROUND, rod, f64::NAN);
    let error = refused(scene);
    assert!(
        matches!(&error, Error::NotFinite { what, value } if what == "`damping` of `drag`" && value.is_nan()),
        "{error:?}"
    );
    assert_says(&error, &["`damping` of `drag`", "NaN", "finite"]);

    let (mut scene, rod) = with_rod();
    scene.spring_damper("sp", Body::GROUND.at(0.0, 0.0), rod.at(0.0, f64::NAN), 1.0, 1.0, 0.0);
    assert_says(&refused(scene), &["point `b` of `sp` is NaN"]);

    let mut scene = Scene::new();
    scene.body("rod", f64::NAN, 1.0, [0.0; 3]);
    assert_says(&refused(scene), &["`mass` of `rod` is NaN"]);

    let (mut scene, rod) = with_rod();
    scene.kinetic_energy("own", RigidBody, rod.coordinates, [1.0.into(), f64::INFINITY.into()]);
    assert_says(&refused(scene), &["parameter 1 of `own` is inf"]);

    let (mut scene, _) = with_rod();
    scene.gravity(0.0, f64::NEG_INFINITY);
    assert_says(&refused(scene), &["gravity", "-inf"]);

    let (mut scene, rod) = with_rod();
    scene.constraint("own", Revolute, both(&mut Scene::new(), rod), [Param::from(f64::NAN); 4]);
    assert!(scene.compile().is_err());
}

/// Six coordinates of which three belong to another scene.
fn both(other: &mut Scene, body: Body) -> [hamiltonian_adjoint::Coordinate; 6] {
    let (a, b) = (body.coordinates, other.coordinates("other", ["x", "y", "φ"]));
    std::array::from_fn(|i| if i < 3 { a[i] } else { b[i - 3] })
}
