//! Options, and what is told about a robot in a scene.

use std::f64::consts::FRAC_PI_2;

use hamiltonian_adjoint::{Grid, Inputs, Mechanics, Scene};
use urdf::{Base, Cause, Doubt, Fault, Kind, Limit, Locked, Options, Robot};

use crate::state::Failure;
use crate::text;

/// The accelerations of a robot at rest where all coordinates have the value 0.2.
fn accelerations(robot: &Robot, options: &Options) -> Result<Vec<f64>, Failure> {
    let mut scene = Scene::new();
    scene.spatial().gravity([0.0, 0.0, -9.81]);
    robot.add_to(&mut scene, options)?;
    let system = scene.compile()?;
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(1, 0.01));
    inputs.start.q_mut().fill(0.2);
    Ok(Mechanics::at_start(&system, &inputs)?.accelerations()?.0.as_slice().to_vec())
}

fn assert_close(own: &[f64], expected: &[f64]) {
    assert_eq!(own.len(), expected.len());
    let largest = expected.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    own.iter()
        .zip(expected)
        .for_each(|(own, expected)| assert!((own - expected).abs() < 1e-12 * largest, "{own} {expected}"));
}

#[test]
fn data_of_the_file_is_told() -> Result<(), Failure> {
    let added = Robot::from_text(text("linkage"))?.add_to(&mut Scene::new(), &Options::default())?;
    let names: Vec<&str> = added.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["shoulder", "elbow", "rail"]);
    let shoulder = added.joint("shoulder").ok_or("no shoulder")?;
    assert_eq!(shoulder.limit, Some(Limit { lower: -1.5, upper: 2.0, effort: Some(40.0), velocity: Some(3.0) }));
    assert_eq!((shoulder.damping, shoulder.friction, shoulder.kind), (0.7, 0.2, Kind::Revolute));
    assert_eq!(added.joint("elbow").ok_or("no elbow")?.limit, None);
    let of =
        |name: &str| added.followers.iter().find(|joint| joint.name == name).map(|f| (f.of.clone(), f.factor, f.offset));
    assert_eq!(of("belt"), Some(("elbow".into(), -2.5, 0.3)));
    assert_eq!(of("right"), Some(("rail".into(), 1.5, 0.03)), "a chain");
    let locked = |name: &str, value: f64| Locked { name: name.into(), value, cause: Cause::NoMass };
    assert_eq!(added.locked, [locked("dial", 0.0), locked("needle", 0.5)]);
    assert_eq!(added.links.len(), 11);
    assert!(added.link("left finger").is_some() && added.link("nothing").is_none() && added.doubts.is_empty());
    Ok(())
}

/// A locked joint equals a fixed one whose origin is turned or shifted by hand.
#[test]
fn locked_joints_keep_their_values() -> Result<(), Failure> {
    let robot = Robot::from_text(text("arm"))?;
    let options = Options { locked: vec![("joint3".into(), 0.7), ("joint1".into(), -0.4)], ..Options::default() };
    let own = accelerations(&robot, &options)?;
    let mut fixed = robot;
    // The axes are z, and R_x(π/2) R_z(value) = R_y(−value) R_x(π/2).
    for (which, rpy) in [(0, [0.0, 0.0, -0.4]), (2, [FRAC_PI_2, -0.7, 0.0])] {
        (fixed.joints[which].kind, fixed.joints[which].origin.rpy) = (Kind::Fixed, rpy);
    }
    assert_close(&own, &accelerations(&fixed, &Options::default())?);
    let mut robot = Robot::from_text(text("linkage"))?;
    let locked = Options { locked: vec![("rail".into(), 0.1), ("right".into(), 0.18)], ..Options::default() };
    let own = accelerations(&robot, &locked)?;
    let rail = robot.joints.iter().position(|joint| joint.name == "rail").ok_or("no rail")?;
    robot.joints.iter_mut().filter(|joint| joint.name == "left" || joint.name == "right").for_each(|joint| {
        if let Some(mimic) = &mut joint.mimic {
            (mimic.multiplier, mimic.offset) = (0.0, if joint.name == "left" { 0.06 } else { 0.18 });
        }
    });
    let pose = &mut robot.joints[rail].origin;
    let (sin, cos) = pose.rpy[2].sin_cos();
    pose.xyz = [pose.xyz[0] + 0.1 * cos, pose.xyz[1] + 0.1 * sin, pose.xyz[2]];
    robot.joints[rail].kind = Kind::Fixed;
    assert_close(&own, &accelerations(&robot, &Options::default())?);
    Ok(())
}

#[test]
fn joints_may_be_free_of_those_that_they_mimic() -> Result<(), Failure> {
    let text = text("linkage").replace(r#"<mimic joint="elbow""#, r#"<mimic joint="nothing""#);
    let robot = Robot::from_text(&text)?;
    let error = robot.add_to(&mut Scene::new(), &Options::default()).expect_err("an unknown joint");
    assert!(error.to_string().contains("joint 'belt' follows joint 'nothing', which does not exist"), "{error}");
    let added = robot.add_to(&mut Scene::new(), &Options { ignore_mimic: true, ..Options::default() })?;
    assert_eq!((added.joints.len(), added.followers.len()), (6, 0));
    Ok(())
}

#[test]
fn several_robots_have_prefixes() -> Result<(), Failure> {
    let (mut scene, robot) = (Scene::new(), Robot::from_text(text("arm"))?);
    for prefix in ["left ", "right "] {
        let options = Options { prefix: prefix.into(), base: Base::Floating, ..Options::default() };
        let added = robot.add_to(&mut scene, &options)?;
        assert_eq!(added.drive(&mut scene).len(), 7);
    }
    assert!(scene.coordinate_named("left joint3.angle").is_some());
    assert_eq!(scene.compile()?.n(), 28);
    Ok(())
}

#[test]
fn a_root_may_have_the_name_of_its_joint() -> Result<(), Failure> {
    let robot = Robot::from_text(&text("arm").replace("link0", "base"))?;
    let mut scene = Scene::new();
    robot.add_to(&mut scene, &Options { base: Base::Floating, ..Options::default() })?;
    scene.compile()?;
    Ok(())
}

/// A joint without mass moves if one that follows it carries mass.
#[test]
fn followers_move_their_leaders() -> Result<(), Failure> {
    let inertial = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    let text = text("linkage").replace(r#"<link name="needle"/>"#, &format!(r#"<link name="needle">{inertial}</link>"#));
    let robot = Robot::from_text(&text.replace(r#"<parent link="dial"/>"#, r#"<parent link="stand"/>"#))?;
    let added = robot.add_to(&mut Scene::new(), &Options::default())?;
    assert!(added.joint("dial").is_some() && added.locked.is_empty());
    Ok(())
}

/// A floating base without any mass cannot move.
#[test]
fn bases_without_mass_are_locked() -> Result<(), Failure> {
    let robot = Robot::from_text(r#"<robot name="frame"><link name="frame"/></robot>"#)?;
    let added = robot.add_to(&mut Scene::new(), &Options { base: Base::Floating, ..Options::default() })?;
    assert!(added.base.is_none());
    assert_eq!(added.locked[0].name, "base");
    Ok(())
}

#[test]
fn impossible_inertias_are_accepted_on_request() -> Result<(), Failure> {
    for (inertia, is_massless) in [(r#"ixx="0.5""#, false), (r#"ixx="-0.01""#, false), (r#"ixx="0.03""#, true)] {
        let text = text("linkage").replace(r#"ixx="0.03""#, inertia);
        let text = if is_massless { text.replace(r#"mass value="1.2""#, r#"mass value="0""#) } else { text };
        let robot = Robot::from_text(&text)?;
        let error = robot.add_to(&mut Scene::new(), &Options::default()).expect_err("an impossible inertia");
        assert!(matches!(error.fault, Fault::Inertia { .. }) && error.at.line == 30, "{error}");
        let (mut scene, options) = (Scene::new(), Options { accept_impossible_inertias: true, ..Options::default() });
        let added = robot.add_to(&mut scene, &options)?;
        assert_eq!(added.doubts.len(), 1);
        assert_eq!((&*added.doubts[0].0, added.doubts[0].1 == Doubt::NoMass), ("lower", is_massless));
        scene.compile()?;
    }
    Ok(())
}
