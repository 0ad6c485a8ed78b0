//! Points and reference blocks as a file, and what other programs put beside them.

use super::pipe::{B, Polar, is_there};
use crate::common::assert_says;
use hamiltonian_adjoint::check::{self, Answers, Point, Report};
use hamiltonian_adjoint::paper_system::{Equation, PaperSystem, Variable};
use hamiltonian_adjoint::planar::Distance;
use hamiltonian_adjoint::{Constraint, Grid, Inputs, Scalar, Settings, scenes::CartPendulum, simulate};
use nalgebra::SVector;
use serde_json::Value;
use std::process::Command;

/// What a program does that knows all derivatives.
fn copied(sheet: &str) -> String {
    sheet.replace("\"reference\"", "\"value\"")
}

fn distance(hand: impl Fn(&Point<6, 1, 0, 5>) -> nalgebra::DMatrix<f64>) -> Report {
    check::constraint(&Distance, B).phi_q(hand).run()
}

fn sheet() -> String {
    check::constraint(&Distance, B).phi_q(|_| [[0.0; 6]]).worksheet().expect("a worksheet")
}

#[test]
fn a_filled_worksheet_is_compared() {
    let sheet = sheet();
    let answers = Answers::from_json(&copied(&sheet)).expect("answers");
    distance(|at| answers.ask("Φ_q", at)).assert_passed();
    answers.finish().expect("all were there");
    // A sign in one column; numbers with 12 digits, lists of one as numbers and no empty lists, as other programs write them.
    let mut theirs: Value = serde_json::from_str(&copied(&sheet)).expect("JSON");
    for point in theirs["blocks"][0]["points"].as_array_mut().expect("points") {
        let flipped = -point["value"][0][2].as_f64().expect("a number");
        point["value"][0][2] = flipped.into();
        let at = point["at"].as_object_mut().expect("arguments");
        at.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        for value in at.values_mut() {
            let short = |x: &Value| format!("{:.11e}", x.as_f64().expect("a number")).parse::<f64>().expect("a number");
            *value = match &*value {
                Value::Array(list) if list.len() == 1 => short(&list[0]).into(),
                Value::Array(list) => list.iter().map(short).collect(),
                x => short(x).into(),
            };
        }
    }
    let answers = Answers::from_json(&theirs.to_string()).expect("answers");
    let report = distance(|at| answers.ask("Φ_q", at));
    answers.finish().expect("all were there");
    assert!(!report.passed() && report.to_string().contains("sign flipped"), "{report}");
}

/// What is left of lists of one, of columns and of empty lists when Matlab or Octave has read and written them.
fn as_in_matlab(value: &Value) -> Value {
    match value {
        Value::Array(list) if list.len() == 1 && !list[0].is_array() => as_in_matlab(&list[0]),
        Value::Array(list) if list.len() == 1 && list[0].as_array().is_some_and(|row| row.len() > 1) => {
            as_in_matlab(&list[0])
        }
        Value::Array(list)
            if list.iter().all(|row| row.as_array().is_some_and(|row| row.len() == 1)) && !list.is_empty() =>
        {
            as_in_matlab(&list.iter().map(|row| row[0].clone()).collect())
        }
        Value::Array(list) => list.iter().map(as_in_matlab).collect(),
        Value::Object(entries) => entries.iter().map(|(name, value)| (name.clone(), as_in_matlab(value))).collect(),
        x => x.clone(),
    }
}

#[test]
fn a_worksheet_survives_matlab() {
    let through = |sheet: &str| as_in_matlab(&serde_json::from_str(&copied(sheet)).expect("JSON")).to_string();
    let text = through(&sheet());
    assert!(text.contains("\"blocks\":{"), "{text}");
    let answers = Answers::from_json(&text).expect("answers");
    distance(|at| answers.ask("Φ_q", at)).assert_passed();
    answers.finish().expect("all were there");
    // One point, and a column.
    let check = || check::function(&Polar, ["r", "φ"], ["x", "y"]).at(&[0.7, 0.4]);
    let value = |x: &[f64]| [[x[0] * x[1].cos()], [x[0] * x[1].sin()]];
    let answers = Answers::from_json(&through(&check().value(value).worksheet().expect("a worksheet"))).expect("answers");
    check().value(|x| answers.ask("f", x)).run().assert_passed();
    answers.finish().expect("all were there");
}

#[test]
fn a_worksheet_is_filled_in_python() {
    fill("python3", |given, filled| ["tests/languages/worksheet.py", given, filled].map(String::from).into());
}

#[test]
fn a_worksheet_is_filled_in_octave() {
    let call = |given: &str, filled: &str| format!("worksheet('{given}', '{filled}')");
    fill("octave-cli", |given, filled| {
        let (path, call) = ("tests/languages".to_string(), call(given, filled));
        vec!["--quiet".into(), "--path".into(), path, "--eval".into(), call]
    });
}

/// Has a program fill a worksheet with what is right, if it is there.
fn fill(program: &str, arguments: impl Fn(&str, &str) -> Vec<String>) {
    if !is_there(program) {
        return;
    }
    let folder = std::env::temp_dir().join(format!("worksheet-{program}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let (given, filled) = (folder.join("sheet.json"), folder.join("filled.json"));
    std::fs::write(&given, sheet()).expect("written");
    let [from, to] = [&given, &filled].map(|path| path.to_str().expect("a path"));
    assert!(Command::new(program).args(arguments(from, to)).status().expect(program).success());
    let answers = Answers::from_json(&std::fs::read_to_string(&filled).expect("a file")).expect("answers");
    distance(|at| answers.ask("Φ_q", at)).assert_passed();
    answers.finish().expect("all were there");
    std::fs::remove_dir_all(folder).ok();
}

/// |q| on one side, q² on the other: places where it bends are searched for.
struct Bent;

impl Constraint<1, 1, 0> for Bent {
    fn phi<S: Scalar>(&self, q: &SVector<S, 1>, _: &SVector<S, 0>, t: S) -> SVector<S, 1> {
        let x = q[0] - 0.31;
        SVector::from([if x.re() > 0.0 { x * x } else { x * 0.0 } + t])
    }
}

#[test]
fn functions_steps_and_places_where_formulas_bend_are_in_worksheets() {
    let polar = |x: &[f64]| [[x[1].cos(), -x[0] * x[1].sin()], [x[1].sin(), x[0] * x[1].cos()]];
    let check = || check::function(&Polar, ["r", "φ"], ["x", "y"]);
    let text = check().jacobian(polar).value(|x: &[f64]| [[x[0] * x[1].cos()], [x[0] * x[1].sin()]]).worksheet();
    let answers = Answers::from_json(&copied(&text.expect("a worksheet"))).expect("answers");
    check().jacobian(|x| answers.ask("f_x", x)).value(|x| answers.ask("f", x)).run().assert_passed();
    answers.finish().expect("all were there");

    let text = check::constraint(&Bent, []).phi_q(|_| [[0.0]]).worksheet().expect("a worksheet");
    let answers = Answers::from_json(&copied(&text)).expect("answers");
    let report = check::constraint(&Bent, []).phi_q(|at| answers.ask("Φ_q", at)).run();
    answers.finish().expect("all were there");
    assert!(report.passed() && report.blocks[0].bends > 0, "{report}");

    let system = CartPendulum::with_links(1).scene().compile().expect("a scene");
    let mut inputs = Inputs::at_rest(&system, Grid::uniform(10, 0.02));
    inputs.controls.fill(3.0);
    let motion = simulate(&system, &inputs, Settings::default()).expect("a motion");
    let paper = PaperSystem::new(&system, &inputs, &motion).expect("fits");
    let (f, by) = (Equation::F5, Variable::V);
    let text = check::step(&paper).f_y_previous(f, by, |at| -at.terms().phi_q).worksheet().expect("a worksheet");
    assert!(["\"q_previous\"", "\"dt\": 0.02", "\"node\""].iter().all(|words| text.contains(words)));
    let answers = Answers::from_json(&copied(&text)).expect("answers");
    check::step(&paper).f_y_previous(f, by, |at| answers.ask("∂f5_i/∂v_(i−1)", at)).run().assert_passed();
    answers.finish().expect("all were there");
}

#[test]
fn worksheets_that_are_none_are_told_of() {
    let sheet = sheet();
    let error = |text: &str| Answers::from_json(text).err().expect("no answers");
    assert_says(&error(&sheet), &["worksheet", "block `Φ_q`, point 0", "no \"value\""]);
    assert_says(&error("{\n \"format\": 3}"), &["line 2"]);
    assert_says(&error(&copied(&sheet).replace("worksheet\"", "scene\"")), &["format", "scene", "expected"]);
    let mut ragged: Value = serde_json::from_str(&copied(&sheet)).expect("JSON");
    ragged["blocks"][0]["points"][3]["value"] = serde_json::json!([[1.0, 2.0], [3.0]]);
    assert_says(&error(&ragged.to_string()), &["point 3", "rows of different lengths"]);
    // A point whose numbers are none is no point of the check.
    let mut blank: Value = serde_json::from_str(&copied(&sheet)).expect("JSON");
    for point in blank["blocks"][0]["points"].as_array_mut().expect("points") {
        point["at"]["q"][0] = Value::Null;
    }
    let answers = Answers::from_json(&blank.to_string()).expect("answers");
    assert!(!distance(|at| answers.ask("Φ_q", at)).passed());
    assert_says(&answers.finish().expect_err("no numbers"), &["is not a point of"]);
    // Another seed, another name.
    let answers = Answers::from_json(&copied(&sheet)).expect("answers");
    let report = check::constraint(&Distance, B).random_points(12, 99).phi_q(|at| answers.ask("Φ_q", at)).run();
    assert!(!report.passed());
    assert_says(&answers.finish().expect_err("other points"), &["is not a point of", "was the check changed?"]);
    let answers = Answers::from_json(&copied(&sheet)).expect("answers");
    assert!(!distance(|at| answers.ask("phi_q", at)).passed());
    assert_says(&answers.finish().expect_err("another name"), &["no block `phi_q`"]);
    // Whatever is cut off or changed is an error or other answers, and no panic.
    let whole: Vec<char> = copied(&sheet).trim_end().chars().collect();
    for k in (0..whole.len()).step_by(211) {
        let cut: String = whole[..k].iter().collect();
        assert!(Answers::from_json(&cut).is_err());
    }
}

#[test]
fn an_error_without_a_name_is_reported_and_no_question_of_the_diagnosis_is_missed() {
    let mut sheet: Value = serde_json::from_str(&copied(&sheet())).expect("JSON");
    let mut random = check::Random::new(4);
    for point in sheet["blocks"][0]["points"].as_array_mut().expect("points") {
        for entry in point["value"][0].as_array_mut().expect("a row") {
            *entry = (entry.as_f64().expect("a number") + random.uniform(0.0, 1.0)).into();
        }
    }
    let answers = Answers::from_json(&sheet.to_string()).expect("answers");
    let report = distance(|at| answers.ask("Φ_q", at));
    println!("{report}");
    assert_eq!(report.blocks[0].diagnoses[0].mistake, check::Mistake::Unexplained);
    answers.finish().expect("all were there");
}
