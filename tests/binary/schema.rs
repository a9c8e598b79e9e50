//! Does an answer in JSON follow `docs/explain.schema.json`?

use boon::{Compiler, Schemas};
use serde_json::Value;

/// Where an answer of `explain` departs from its schema.
pub fn violation(answer: &Value) -> Option<String> {
    let name = "explain.schema.json";
    let schema = serde_json::from_str(include_str!("../../docs/explain.schema.json")).unwrap();
    let mut schemas = Schemas::new();
    let mut compiler = Compiler::new();
    compiler.add_resource(name, schema).unwrap();
    let schema = compiler.compile(name, &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    schemas.validate(answer, schema).err().map(|error| format!("{error:#}\n{answer:#}"))
}

#[test]
fn what_is_not_in_the_schema_is_refused() {
    let errors = serde_json::json!({"heldout": null});
    let said = violation(&errors).expect("it lacks nearly everything");
    assert!(said.contains("missing properties"), "{said}");
}
