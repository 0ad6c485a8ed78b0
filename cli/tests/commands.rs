//! The commands beside the library: results are equal to the last bit, and whatever is wrong is reported without a panic.

mod program;

use hamiltonian_adjoint::optimize::{Free, Interval, MotionProblem, Options, Variables, interior_point, silent};
use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Grid, Inputs, SceneFile, Scheme, Settings, Solver, System};
use program::{Folder, Run};
use serde_json::{Value, json};

const GUIDE: &str = include_str!("../../docs/command-line.md");

/// The first block of the guide in this language.
fn block(language: &str) -> &'static str {
    let after = GUIDE.split_once(&format!("```{language}\n")).expect("a block").1;
    after.split_once("```").expect("its end").0
}

/// An arm on a motorised hinge, with a cost and an output as formulas.
fn arm() -> &'static str {
    block("json")
}

/// A folder with a scene and inputs whose controls are all 2, and what the library makes of both.
fn known(name: &str, scene: &str, grid: Grid) -> (Folder, System, Inputs) {
    let folder = Folder::new(name);
    let system =
        SceneFile::from_json(scene).and_then(SceneFile::complete).and_then(|scene| scene.compile()).expect("a system");
    let mut inputs = Inputs::at_rest(&system, grid);
    inputs.controls.fill(2.0);
    folder.write("scene.json", scene);
    folder.write("inputs.json", &inputs.to_json(&system).expect("inputs"));
    (folder, system, inputs)
}

fn paper() -> String {
    CartPendulum::default().scene().to_json().expect("a scene")
}

#[test]
fn motions_and_derivatives_are_those_of_the_library_to_the_last_bit() {
    for (name, scene) in [("paper", paper()), ("arm", arm().to_string())] {
        let (folder, system, inputs) = known(name, &scene, Grid::uniform(20, 0.02));
        let results = |settings: Settings| {
            let mut solver = Solver::new(&system, settings);
            let motion = solver.simulate(&inputs).expect("a motion").clone();
            let gradient = solver.gradient().expect("a gradient").clone();
            let mut along = inputs.no_change();
            along.controls[(0, 3)] = 1.0;
            let product = solver.hessian_product(&along).expect("a product").to_json(&system).expect("a file");
            (along.controls, along.design) = (gradient.controls.clone(), gradient.design.clone());
            (along.start, along.grid.steps) = (gradient.start.clone(), gradient.steps.clone());
            let steepest = solver.hessian_product(&along).expect("a product").to_json(&system).expect("a file");
            let gradient = gradient.to_json(&system).expect("a file");
            let csv = motion.to_csv(&system, solver.inputs()).expect("a table");
            [motion.to_json(&system).expect("a file"), csv.trim_end().to_string(), gradient, product, steepest]
        };
        let mut push = vec![0.0; 21];
        push[3] = 1.0;
        let along = json!({
            "format": "hamiltonian-adjoint gradient", "version": 1, "controls": { system.control_name(0): push },
        });
        folder.write("along.json", &along.to_string());
        let options: [&[&str]; 2] = [&[], &["--scheme", "esdirk4", "--tolerance", "1e-12", "--drift-bound", "0"]];
        let settings = Settings { scheme: Scheme::ESDIRK4, tolerance: 1e-12, drift_bound: 0.0, ..Settings::default() };
        for (options, settings) in options.into_iter().zip([Settings::default(), settings]) {
            let run =
                |command: &[&str]| folder.run(&[command, &["scene.json", "inputs.json"], options].concat()).succeeded();
            run(&["simulate", "-o", "motion.csv"]);
            run(&["gradient", "-o", "gradient.json"]);
            let csv = folder.read("motion.csv").trim_end().to_string();
            let product = |along: &str| run(&["hessian-product", "--along", along]);
            let [part, steepest] = ["along.json", "gradient.json"].map(product);
            let found = [run(&["simulate"]), csv, folder.read("gradient.json").trim_end().into(), part, steepest];
            let expected = results(settings);
            assert!(found == expected, "{name} {options:?}\n{found:?}\n{expected:?}");
        }
        assert_ne!(results(settings), results(Settings::default()), "the options have an effect");
    }
}

#[cfg(unix)]
#[test]
fn the_session_of_the_guide_runs() {
    let folder = Folder::new("guide");
    folder.write("arm.json", arm());
    folder.write("session.sh", block("sh"));
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_hamiltonian-adjoint"));
    let path =
        [program.parent().expect("a folder"), "/usr/bin".as_ref(), "/bin".as_ref()].map(|part| part.display().to_string());
    let mut shell = std::process::Command::new("sh");
    shell.args(["-e", "session.sh"]).env("PATH", path.join(":")).current_dir(folder.path());
    let session = Run::of(&["session.sh"], shell.output().expect("a shell"));
    assert!(
        session.succeeded().lines().last().is_some_and(|last| last.starts_with("  \"value\": 0.00")),
        "{}",
        session.printed
    );
    assert!(
        session.errors.contains("best.json") || session.errors.contains("inputs.json: the gradient"),
        "{}",
        session.errors
    );
    for file in ["motion.csv", "gradient.json", "report.json", "best.html"] {
        assert!(folder.read(file).len() > 500, "{file}");
    }
}

#[test]
fn an_adaptive_grid_is_that_of_the_library() {
    let (folder, system, inputs) = known("adapt", arm(), Grid::uniform(4, 0.25));
    let options = ["--within", "1e-6", "--scheme", "esdirk4", "-o", "adapted.json"];
    folder.run(&[&["adapt", "scene.json", "inputs.json"], &options[..]].concat()).succeeded();
    let adapted = Inputs::from_json(&system, &folder.read("adapted.json")).expect("inputs");
    let settings = Settings { scheme: Scheme::ESDIRK4, ..Settings::default() };
    let expected = Solver::new(&system, settings).adapt(&inputs, 1e-6).expect("a grid");
    assert!(adapted == expected && adapted.grid.steps.len() > 8, "{adapted:?}");
    folder.run(&["simulate", "scene.json", "adapted.json", "--scheme", "esdirk4", "-o", "motion.csv"]).succeeded();
    assert_eq!(folder.read("motion.csv").lines().count(), 1 + adapted.grid.nodes());
    folder.run(&["adapt", "scene.json", "inputs.json", "--within", "-1"]).failed(2, &["--within"]);
    for within in ["--within=-1", "--within=NaN"] {
        folder.run(&["adapt", "scene.json", "inputs.json", within]).failed(2, &["inputs.json", "tolerance"]);
    }
    folder.run(&["adapt", "scene.json", "inputs.json"]).failed(2, &["--within"]);
}

#[test]
fn outputs_have_their_gradients_by_name() {
    let (folder, system, inputs) = known("outputs", arm(), Grid::uniform(9, 0.02));
    let found: Value =
        serde_json::from_str(&folder.run(&["jacobian", "scene.json", "inputs.json"]).succeeded()).expect("JSON");
    let mut solver = Solver::new(&system, Settings::default());
    solver.simulate(&inputs).expect("a motion");
    let expected = solver.jacobian().expect("gradients")[0].to_json(&system).expect("a file");
    assert_eq!(found["outputs"]["upright"], serde_json::from_str::<Value>(&expected).expect("JSON"));
    assert_eq!(found["outputs"].as_object().map(|all| all.len()), Some(1));
}

#[test]
fn the_help_states_the_defaults_of_the_library() {
    let folder = Folder::new("help");
    for command in ["adapt", "simulate", "gradient", "jacobian", "hessian-product", "check", "optimise", "animate"] {
        let help = folder.run(&[command, "--help"]).succeeded();
        let Settings { tolerance, max_iterations, position_tolerance, velocity_tolerance, max_halvings, .. } =
            Settings::default();
        let Settings { drift_bound, rebase_every, .. } = Settings::default();
        for (option, default) in [
            ("--tolerance", format!("{tolerance:e}")),
            ("--max-iterations", max_iterations.to_string()),
            ("--position-tolerance", format!("{position_tolerance:e}")),
            ("--velocity-tolerance", format!("{velocity_tolerance:e}")),
            ("--max-halvings", max_halvings.to_string()),
            ("--drift-bound", drift_bound.to_string()),
            ("--rebase-every", rebase_every.to_string()),
            ("--scheme", "trapezoidal".into()),
        ] {
            let after = help.split_once(&format!("{option} <")).unwrap_or_else(|| panic!("{command} {option}: {help}")).1;
            let shown = after.split_once("[default: ").expect("a default").1;
            assert!(shown.starts_with(&format!("{default}]")), "{command} {option} {default}: {help}");
        }
    }
    let names = ["trapezoidal", "tr-bdf2", "esdirk3", "esdirk4", "esdirk5"];
    for (name, scheme) in names.into_iter().zip(Scheme::ALL) {
        let (folder, ..) = known(&format!("scheme {name}"), arm(), Grid::uniform(2, 0.02));
        let motion = folder.run(&["simulate", "scene.json", "inputs.json", "--scheme", name]).succeeded();
        assert!(motion.contains(&format!("\"scheme\":\"{}\"", scheme.name)), "{motion}");
    }
}

#[test]
fn a_scene_is_described_and_has_inputs_at_rest() {
    let (folder, system, _) = known("describe", arm(), Grid::uniform(4, 0.1));
    let description: Value = serde_json::from_str(&folder.run(&["describe", "scene.json"]).succeeded()).expect("JSON");
    assert_eq!(description["sizes"]["coordinates"], 3);
    assert_eq!(description["names"]["controls"], json!(["torque"]));
    assert_eq!(description["names"]["constraints"].as_array().map(Vec::len), Some(2));
    assert_eq!([&description["has_cost"], &description["warnings"]], [&json!(true), &json!([])]);
    let left_out = arm().replace("\"left_out\": []", "\"left_out\": [\"a spring\"]").replace("[0.5, 0, 0]", "[0.6, 0, 0]");
    folder.write("broken.json", &left_out);
    assert_eq!(folder.run(&["schema"]).succeeded().trim_end(), SceneFile::schema());
    let description: Value = serde_json::from_str(&folder.run(&["describe", "broken.json"]).succeeded()).expect("JSON");
    assert_eq!(description["left_out"], json!(["a spring"]));
    assert!(description["warnings"][0].as_str().is_some_and(|text| text.contains("shoulder")), "{description}");
    folder.run(&["inputs", "broken.json", "--steps", "2", "--dt", "0.1"]).failed(2, &["broken.json", "a spring"]);

    folder.write("table.csv", "t [s],x,torque [N m]\n0,1,2\n0.4,1,4\n");
    let table = ["--controls", "table.csv", "-o", "rest.json"];
    folder
        .run(&[&["inputs", "-", "--steps", "4", "--dt", "0.1"], &table[..]].concat())
        .failed(2, &["standard input", "scene"]);
    folder.run_with(&[&["inputs", "-", "--steps", "4", "--dt", "0.1"], &table[..]].concat(), arm()).succeeded();
    let mut expected = Inputs::at_rest(&system, Grid::uniform(4, 0.1));
    expected.set_control(system.control(0), |t| 2.0 * (1.0 - t / 0.4) + 4.0 * (t / 0.4));
    assert_eq!(Inputs::from_json(&system, &folder.read("rest.json")).expect("inputs"), expected);
}

#[test]
fn checks_pass_and_fail() {
    let (folder, ..) = known("check", &paper(), Grid::uniform(20, 0.02));
    let run =
        |options: &[&str]| folder.run(&[&["check", "scene.json", "inputs.json", "-o", "report.json"], options].concat());
    let passed = run(&["--complete"]);
    passed.succeeded();
    let report: Value = serde_json::from_str(&folder.read("report.json")).expect("JSON");
    assert_eq!([&report["passed"], &report["gradients"][0]["singles"]], [&json!(true), &json!(21 + 20 + 24)]);
    assert_eq!(report["gradients"][0]["own"][0]["name"], "without programs (own gradient, controls)");
    // No computation is as exact as that.
    run(&["--within", "1e-25"]).failed(1, &["references disagree", "inputs.json: a derivative is wrong"]);
    let report: Value = serde_json::from_str(&folder.read("report.json")).expect("JSON");
    assert_eq!(report["passed"], false);
    run(&["--within", "NaN"]).failed(2, &["NaN"]);
    let (folder, ..) = known("check nothing", &arm().replace("upright", "up"), Grid::uniform(5, 0.02));
    folder.run(&["check", "scene.json", "inputs.json"]).succeeded();
    let neither = paper().replace("\"cost\"", "\"term\"").replace("\"sum\"", "\"output\": \"o\", \"sum\"");
    let with_output = neither.replacen("\"parts\": [", "\"parts\": [{\"kind\": \"output\", \"name\": \"o\"},", 1);
    let (folder, ..) = known("check output", &with_output, Grid::uniform(5, 0.02));
    folder.run(&["check", "scene.json", "inputs.json"]).succeeded();
}

#[test]
fn an_optimum_is_that_of_the_library() {
    let (folder, system, inputs) = known("optimise", arm(), Grid::uniform(30, 0.02));
    let bounds = ["--bounds", "controls.torque=-14..14", "--bounds", "outputs.upright=-0.1..0.1"];
    let command = ["optimise", "scene.json", "inputs.json", "--free", "controls", "-o", "best.json"];
    let run = folder.run(&[&command[..], &bounds, &["--scale", "controls=5", "--stationarity", "1e-6"]].concat());
    run.succeeded();
    assert!(run.errors.contains("inputs.json: the gradient is below the tolerance"), "{}", run.errors);

    let scene = SceneFile::from_json(arm()).expect("a scene").scene;
    let (torque, upright) = (scene.control_named("torque").expect("it"), scene.output_named("upright").expect("it"));
    let system_of_handles = scene.compile().expect("a system");
    let free = vec![Free::control(torque).within(-14.0, 14.0).scaled(5.0)];
    let variables = Variables::new(&system_of_handles, &inputs, free).expect("variables");
    let problem = MotionProblem::new(&system_of_handles, Settings::default(), inputs.clone(), variables);
    let mut problem = problem.expect("a problem");
    problem.constrain(upright, Interval::new(-0.1, 0.1));
    let (start, options) = (problem.start(), Options { stationarity: 1e-6, ..Options::default() });
    let outcome = interior_point(&mut problem, &start, &options, &mut silent).expect("an outcome");
    let best = Inputs::from_json(&system, &folder.read("best.json")).expect("inputs");
    assert_eq!(best, problem.inputs_at(&outcome.x));
    assert!(best.controls.amax() <= 14.0 && outcome.violation < 1e-9, "{outcome}");

    let few = folder.run(&[&command[..], &["--iterations", "1"]].concat());
    few.failed(1, &["the iteration limit was reached"]);
    assert_ne!(Inputs::from_json(&system, &folder.read("best.json")).expect("inputs"), best);
    for method in ["lbfgs", "augmented-lagrangian", "levenberg-marquardt"] {
        let free = ["--method", method, "--bounds", "outputs.upright=.."];
        let run = folder.run(&[&command[..], if method == "lbfgs" { &free } else { &free[..2] }].concat());
        run.succeeded();
    }
    let several = ["--free", "design.mass,duration", "--free", "rate0.arm.φ", "--iterations", "1"];
    let run: Run = folder.run(&[&command[..3], &several].concat());
    run.failed(2, &["inputs.json", "arm.φ"]);
    for (option, value, expected) in [
        ("--free", "colour", "colour: this is none of controls"),
        ("--free", "controls.colour", "none of them with its name"),
        ("--bounds", "controls", "controls: this does not have the form"),
        ("--bounds", "controls=1", "controls=1: this does not have the form"),
        ("--bounds", "controls=2..1", "at least the lower bound"),
        ("--bounds", "controls=nan..1", "NaN"),
        ("--bounds", "outputs.colour=0..1", "no such output"),
        ("--bounds", "design.mass=0..1", "design.mass: this is not free"),
        ("--scale", "controls=0", "positive"),
        ("--method", "luck", "interior-point"),
        ("--target", "NaN", "NaN"),
    ] {
        folder.run(&["optimise", "scene.json", "inputs.json", option, value]).failed(2, &[expected]);
    }
}

#[test]
fn a_page_shows_the_motion() {
    let (folder, ..) = known("page", arm(), Grid::uniform(5, 0.02));
    folder.run(&["animate", "scene.json", "inputs.json", "-o", "motion.html"]).succeeded();
    let page = folder.read("motion.html");
    assert!(page.contains("<svg") && page.contains("torque"), "{page}");
}

#[test]
fn what_was_computed_before_a_failed_step_is_written() {
    let (folder, system, mut inputs) = known("partial", arm(), Grid::uniform(20, 0.02));
    inputs.controls[(0, 12)] = 1e300;
    folder.write("wild.json", &inputs.to_json(&system).expect("inputs"));
    for file in ["motion.json", "motion.csv", "motion.html"] {
        let command = if file.ends_with("html") { "animate" } else { "simulate" };
        folder.run(&[command, "scene.json", "wild.json", "-o", file]).failed(1, &["error: wild.json: "]);
        assert!(folder.read(file).len() > 100);
    }
    let lines = folder.read("motion.csv").lines().count();
    assert!((5..=13).contains(&lines), "{lines}");
    folder.write("gradient.json", "old");
    folder.run(&["gradient", "scene.json", "wild.json", "-o", "gradient.json"]).failed(1, &["wild.json"]);
    assert_eq!(folder.read("gradient.json"), "old");
}
