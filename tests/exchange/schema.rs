//! The JSON Schema of scene files: what the library writes satisfies it, and what it refuses does not.

use hamiltonian_adjoint::scenes::CartPendulum;
use hamiltonian_adjoint::{Scene, SceneFile};
use serde_json::{Value, json};

/// True if a value satisfies a schema, of which `root` contains the definitions.
fn satisfies(value: &Value, schema: &Value, root: &Value) -> bool {
    let holds = |(rule, of): (&String, &Value)| match (rule.as_str(), of) {
        ("$ref", of) => {
            let name = of.as_str().and_then(|path| path.strip_prefix("#/$defs/")).expect("a definition");
            satisfies(value, &root["$defs"][name], root)
        }
        ("const", of) => value == of,
        ("enum", of) => of.as_array().expect("values").contains(value),
        ("anyOf", of) => of.as_array().expect("schemas").iter().any(|schema| satisfies(value, schema, root)),
        ("oneOf", of) => of.as_array().expect("schemas").iter().filter(|schema| satisfies(value, schema, root)).count() == 1,
        ("type", of) => match of.as_str().expect("a type") {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "number" => value.is_number(),
            "integer" => value.is_u64(),
            "boolean" => value.is_boolean(),
            other => panic!("the type {other}"),
        },
        ("properties", of) => value.as_object().is_none_or(|value| {
            value.iter().all(|(name, value)| of.get(name).is_none_or(|schema| satisfies(value, schema, root)))
        }),
        ("required", of) => {
            of.as_array().expect("names").iter().all(|name| value.get(name.as_str().expect("a name")).is_some())
        }
        ("additionalProperties", _) => {
            value.as_object().is_none_or(|value| value.keys().all(|name| schema["properties"].get(name).is_some()))
        }
        ("items", of) => value.as_array().is_none_or(|values| values.iter().all(|value| satisfies(value, of, root))),
        ("minItems", of) => value.as_array().is_none_or(|values| values.len() as u64 >= of.as_u64().expect("a count")),
        ("maxItems", of) => value.as_array().is_none_or(|values| values.len() as u64 <= of.as_u64().expect("a count")),
        ("minimum" | "$schema" | "title" | "description" | "$defs", _) => true,
        (other, _) => panic!("the rule {other}"),
    };
    schema.as_object().expect("a schema").iter().all(holds)
}

fn schema() -> Value {
    serde_json::from_str(&SceneFile::schema()).expect("JSON")
}

fn scenes() -> Vec<Scene> {
    let mut scenes = super::space_files::all();
    scenes.extend([super::formulas::pendulum(), CartPendulum::with_links(2).scene()]);
    scenes
}

#[test]
fn every_file_satisfies_the_schema() {
    let schema = schema();
    for scene in scenes() {
        let file: Value = serde_json::from_str(&scene.to_json().expect("a file")).expect("JSON");
        for part in file["parts"].as_array().expect("parts") {
            let kinds = schema["properties"]["parts"]["items"]["oneOf"].as_array().expect("kinds");
            let of_kind = kinds.iter().find(|of| of["properties"]["kind"]["const"] == part["kind"]);
            assert!(satisfies(part, of_kind.expect("the kind"), &schema), "{part:#}\n{:#}", of_kind.expect("the kind"));
        }
        assert!(satisfies(&file, &schema, &schema));
    }
}

/// Entries that are missing, superfluous or of another type are refused by the schema and by the library.
#[test]
fn what_the_library_refuses_the_schema_refuses() {
    let (schema, mut tried) = (schema(), 0);
    for scene in scenes() {
        let file: Value = serde_json::from_str(&scene.to_json().expect("a file")).expect("JSON");
        for which in 0..file["parts"].as_array().expect("parts").len() {
            let names: Vec<String> = file["parts"][which].as_object().expect("a part").keys().cloned().collect();
            let mut refused = |change: &dyn Fn(&mut Value)| {
                let mut file = file.clone();
                change(&mut file["parts"][which]);
                let is_read = SceneFile::from_json(&file.to_string()).is_ok();
                let is_valid = satisfies(&file, &schema, &schema);
                assert!(is_valid || !is_read, "a file that is read must be valid: {:#}", file["parts"][which]);
                tried += usize::from(!is_valid);
            };
            for name in &names {
                refused(&|part| drop(part.as_object_mut().expect("a part").remove(name)));
                refused(&|part| part[name] = json!(null));
                refused(&|part| part[name] = json!({ "x": 1 }));
            }
            refused(&|part| part["more"] = json!(1));
        }
    }
    assert!(tried > 500, "{tried}");
}
