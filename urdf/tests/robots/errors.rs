//! Every error, with its line, its column and the name of what is wrong.

use hamiltonian_adjoint::Scene;
use urdf::{Base, Error, Options, Robot};

/// The error of a text, from reading it or from adding it to a scene.
fn error(text: &str, options: &Options) -> Error {
    let added = Robot::from_text(text).and_then(|robot| robot.add_to(&mut Scene::new(), options));
    added.map(|_| ()).expect_err("a fault")
}

/// Asserts the place of the error and that its message contains these words.
fn assert_says(text: &str, place: (usize, usize), words: &[&str]) {
    let error = error(text, &Options::default());
    let message = error.to_string();
    assert_eq!((error.at.line, error.at.column), place, "{message}");
    assert_eq!(format!("{error:?}"), message);
    words.iter().for_each(|word| assert!(message.contains(word), "`{word}` is not in: {message}"));
}

/// A robot of two links and a hinge with a replaced part.
fn robot(old: &str, new: &str) -> String {
    const ROBOT: &str = r#"<robot name="r">
<link name="a"/>
<link name="b">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
</link>
<joint name="j" type="revolute">
  <parent link="a"/><child link="b"/>
  <axis xyz="0 0 1"/>
</joint>
</robot>"#;
    assert!(ROBOT.contains(old), "`{old}`");
    ROBOT.replace(old, new)
}

#[test]
fn texts_that_are_no_urdf() {
    assert_says("", (1, 1), &["not well-formed XML"]);
    assert_says("<robot name='r'>", (1, 1), &["not well-formed XML"]);
    assert_says("<robot name='r'>\n<link name='a'>\n</robot>", (3, 1), &["not well-formed XML", "link"]);
    assert_says("<sdf/>", (1, 1), &["`sdf` instead of `robot`"]);
    assert_says("<robot/>", (1, 1), &["the element `robot` of the robot has no attribute `name`"]);
    assert_says("<robot name='r'/>", (0, 0), &["no links"]);
    let xacro = robot("<link name=\"a\"/>", "<link name=\"a\"/>\n  <xacro:macro name=\"m\"/>");
    assert_says(
        &xacro.replace("<robot", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\""),
        (3, 3),
        &["`xacro:macro`", "run `xacro"],
    );
    assert_says("<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='r'/>", (1, 1), &["document type definitions"]);
    assert_says(&robot("name=\"r\"", "name=\"&a;\""), (1, 14), &["not well-formed XML"]);
}

#[test]
fn texts_that_are_too_large() {
    let long = format!("<robot name='r'><link name='{}'/></robot>", "a".repeat(17 << 20));
    assert_says(&long, (0, 0), &["bytes; at most 16777216"]);
    let links: String = (0..10_001).map(|i| format!("<link name='{i}'/>")).collect();
    assert_says(&format!("<robot name='r'>{links}</robot>"), (0, 0), &["10001 links", "at most 10000"]);
    let attributes: String = (0..300).map(|i| format!(" a{i}=''")).collect();
    assert_says(
        &format!("<robot name='r'>\n<link{attributes}/></robot>"),
        (2, 1),
        &["300 attributes in one element", "at most 256"],
    );
    let namespaces: String = (0..65).map(|i| format!("<a xmlns:n{i}='{i}'/>")).collect();
    assert_says(&format!("<robot name='r'>{namespaces}</robot>"), (1, 1216), &["65 namespaces"]);
    let nested = format!("<robot name='r'>{}{}</robot>", "<a>".repeat(500_000), "</a>".repeat(500_000));
    assert_says(&nested, (0, 0), &["no links"]);
    let nodes = format!("<robot name='r'>{}</robot>", "<a/>".repeat(1 << 20));
    assert!(error(&nodes, &Options::default()).to_string().contains("not well-formed XML: nodes limit"));
}

#[test]
fn missing_and_malformed_parts() {
    assert_says(&robot(r#"<link name="a"/>"#, "<link/>"), (2, 1), &["the element `link` of a link has no attribute `name`"]);
    assert_says(&robot(r#"<mass value="1"/>"#, ""), (4, 3), &["link 'b' has no element `mass`"]);
    assert_says(&robot(r#"<mass value="1"/>"#, "<mass/>"), (4, 13), &["`mass` of link 'b' has no attribute `value`"]);
    assert_says(&robot(r#" izz="1""#, ""), (4, 30), &["`inertia` of link 'b' has no attribute `izz`"]);
    assert_says(
        &robot(r#"value="1""#, r#"value="1,5""#),
        (4, 13),
        &["`value` of link 'b' is '1,5' instead of a finite number"],
    );
    assert_says(&robot(r#"value="1""#, r#"value="NaN""#), (4, 13), &["'NaN'"]);
    assert_says(&robot(r#"ixy="0""#, r#"ixy="1e999""#), (4, 30), &["`ixy` of link 'b' is '1e999'"]);
    assert_says(
        &robot(r#"xyz="0 0 1""#, r#"xyz="0 1""#),
        (8, 3),
        &["`xyz` of joint 'j' is '0 1' instead of 3 finite numbers"],
    );
    assert_says(&robot(r#"xyz="0 0 1""#, r#"xyz="0 0 ${pi}""#), (8, 3), &["'0 0 ${pi}'"]);
    assert_says(&robot(r#" type="revolute""#, ""), (6, 1), &["`joint` of joint 'j' has no attribute `type`"]);
    assert_says(&robot("revolute", "screw"), (6, 1), &["joint 'j' has the type 'screw'"]);
    assert_says(&robot(r#"<parent link="a"/>"#, ""), (6, 1), &["joint 'j' has no element `parent`"]);
    assert_says(&robot(r#"<axis xyz="0 0 1"/>"#, r#"<axis/>"#), (8, 3), &["`axis` of joint 'j' has no attribute `xyz`"]);
    let twice = robot(r#"<child link="b"/>"#, "<child link=\"b\"/>\n<child link=\"a\"/>");
    assert_says(&twice, (8, 1), &["joint 'j' has two elements `child`"]);
    assert_says(&robot("<axis", "<mimic/><axis"), (8, 3), &["`mimic` of joint 'j' has no attribute `joint`"]);
}

#[test]
fn robots_that_are_no_trees() {
    assert_says(
        &robot(r#"<link name="a"/>"#, "<link name=\"a\"/>\n<link name=\"a\"/>"),
        (3, 1),
        &["two links have the name 'a'"],
    );
    let joint = r#"<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>"#;
    assert_says(&robot("</robot>", &format!("{joint}</robot>")), (10, 1), &["two joints have the name 'j'"]);
    let second = joint.replace("\"j\"", "\"k\"");
    let second = robot("</robot>", &format!("{second}</robot>"));
    assert_says(&second, (10, 1), &["joint 'k' carries the link 'b', which joint 'j' carries already"]);
    assert_says(&robot(r#"<child link="b"/>"#, r#"<child link="c"/>"#), (6, 1), &["the child of joint 'j' is the link 'c'"]);
    assert_says(
        &robot(r#"<parent link="a"/>"#, r#"<parent link=""/>"#),
        (6, 1),
        &["the parent of joint 'j' is the link ''"],
    );
    assert_says(&robot(r#"<parent link="a"/>"#, r#"<parent link="b"/>"#), (3, 1), &["carry the link 'b' in a loop"]);
    let back = joint
        .replace("\"j\"", "\"k\"")
        .replace("link=\"b\"", "link=\"c\"")
        .replace("\"a\"", "\"b\"")
        .replace("\"c\"", "\"a\"");
    assert_says(&robot("</robot>", &format!("{back}</robot>")), (2, 1), &["carry the link 'a' in a loop"]);
    assert_says(&robot("</robot>", "<link name=\"c\"/></robot>"), (10, 1), &["no joint carries the links 'a' and 'c'"]);
}

#[test]
fn values_out_of_range() {
    assert_says(&robot(r#"value="1""#, r#"value="-1""#), (3, 1), &["the mass of link 'b' is -1", "positive or zero"]);
    assert_says(
        &robot(r#"value="1""#, r#"value="0""#),
        (3, 1),
        &["link 'b' has moments of inertia but no mass", "accept_impossible"],
    );
    assert_says(&robot(r#"ixx="1""#, r#"ixx="3""#), (3, 1), &["link 'b' are 1.0000e0, 1.0000e0 and 3.0000e0"]);
    assert_says(&robot(r#"ixy="0""#, r#"ixy="2""#), (3, 1), &["link 'b' are -1.0000e0", "accept_impossible_inertias"]);
    assert_says(&robot(r#"xyz="0 0 1""#, r#"xyz="0 0 0""#), (6, 1), &["the axis [0.0, 0.0, 0.0] of joint 'j'"]);
    assert_says(&robot("<axis", "<dynamics damping=\"-2\"/><axis"), (6, 1), &["the damping of joint 'j' is -2"]);
    assert_says(
        &robot("<axis", "<mimic joint=\"k\"/><axis"),
        (6, 1),
        &["joint 'j' follows joint 'k', which does not exist"],
    );
    assert_says(
        &robot("<axis", "<mimic joint=\"j\"/><axis"),
        (6, 1),
        &["joint 'j' follows joint 'j', which follows it in turn"],
    );
    let planar = robot("<axis", "<mimic joint=\"j\"/><axis").replace("revolute", "planar");
    assert_says(&planar, (6, 1), &["one of them has several coordinates"]);
}

#[test]
fn options_that_do_not_fit() {
    let locked = |name: &str, value| Options { locked: vec![(name.into(), value)], ..Options::default() };
    let message = |text: &str, options| error(text, &options).to_string();
    assert_eq!(message(&robot("", ""), locked("k", 0.0)), "joint 'k' should be locked but does not exist");
    let planar = robot("revolute", "planar");
    assert!(
        message(&planar, locked("j", 0.1))
            .contains("joint 'j' has several coordinates and can be locked at 0 only, not at 0.1")
    );
    assert!(message(&robot("", ""), locked("j", f64::NAN)).contains("not at NaN"));
    let floating = Options { base: Base::Floating, ..Options::default() };
    assert!(message(&robot("\"j\"", "\"base\""), floating).contains("two joints have the name 'base'"));
    let error = Robot::read("no/such/file.urdf").expect_err("no file").to_string();
    assert!(error.contains("`no/such/file.urdf` cannot be read"), "{error}");
}
