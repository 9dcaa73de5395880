//! The description of the JSON interface, `openapi.json`: derived from the list of its addresses, from the types of what is answered
//! and from those of what is asked.

use std::sync::LazyLock;

use access::Role;
use axum::{
    http::header,
    response::{IntoResponse, Response},
};
use schemars::{Schema, SchemaGenerator, generate::SchemaSettings};
use serde_json::{Map, Value, json};

use super::{
    api_route::{ApiRoute, RequestBody, schema_of},
    api_routes::all_routes,
};
use crate::web::base::error::ProblemDetails;

const ABOUT: &str = "What the pages of the dashboard show, and orders of programs. docs/integrator.md shows how to use it. Lengths end in _mm, volumes in _mm3, durations in _secs, sizes of files in \
    _bytes; density is a share, 0 to 1; rotations and directions have no unit; times are UTC, RFC 3339.";

/// Path of the schemas in the document.
const SCHEMAS: &str = "/components/schemas";

/// The document.
pub(crate) async fn document() -> Response {
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT.as_str()).into_response()
}

/// The document as text. It does not change while the program runs.
static DOCUMENT: LazyLock<String> = LazyLock::new(|| format!("{:#}", described()));

/// Creates the whole document.
pub(crate) fn described() -> Value {
    let maker = |mut settings: SchemaSettings| {
        settings.definitions_path = SCHEMAS.into();
        settings.meta_schema = None;
        settings.into_generator()
    };
    // What may be left out of a request is always in an answer.
    let mut asked = maker(SchemaSettings::draft2020_12().for_deserialize());
    let mut answered = maker(SchemaSettings::draft2020_12().for_serialize());
    let error = schema_of::<ProblemDetails>(&mut answered);
    let mut paths: Map<String, Value> = Map::new();
    for route in all_routes() {
        let of_path = paths.entry(route.path).or_insert_with(|| json!({}));
        of_path[route.method.to_lowercase()] = operation(route, &error, &mut asked, &mut answered);
    }
    let mut schemas = answered.take_definitions(true);
    schemas.extend(asked.take_definitions(true).into_iter().map(|(name, schema)| (name, without_defaults(schema))));
    let mut document = json!({
        "openapi": "3.1.0",
        "info": {
            "title": "nestd",
            "version": "1",
            "description": ABOUT,
            "license": { "name": env!("CARGO_PKG_LICENSE"), "identifier": env!("CARGO_PKG_LICENSE") },
        },
        "servers": [{ "url": "/" }],
        "paths": paths,
        "components": {
            "securitySchemes": {
                "token": { "type": "http", "scheme": "bearer", "description": "Only where web.token_file or web.tokens_file is set; each operation says which role it needs." },
            },
            "schemas": schemas,
        },
    });
    speak_json(&mut document);
    list_words(&mut document);
    document
}

fn operation(route: &ApiRoute, error: &Schema, asked: &mut SchemaGenerator, answered: &mut SchemaGenerator) -> Value {
    let mut parameters: Vec<Value> = route.path.split(['{', '}']).skip(1).step_by(2).map(path_parameter).collect();
    let names_something = !parameters.is_empty();
    if let Some(query) = route.query {
        let schema = query(asked);
        parameters.extend(query_parameters(&schema, route.without));
    }
    parameters.extend(route.headers.iter().map(|name| header_parameter(name)));
    let (status, answer) = route.answer;
    let mut responses = json!({ status: { "description": route.summary } });
    if let Some(answer) = answer {
        responses[status]["content"] = json!({ "application/json": { "schema": answer(answered) } });
        if status == "200" && route.role != Role::Read {
            responses["202"] = json!({ "description": "It is noted, and done when the daemon comes to it.",
                "content": responses[status]["content"] });
        }
    }
    let fails = |status: &str, why: &str| {
        responses[status] =
            json!({ "description": why, "content": { "application/problem+json": { "schema": error } } });
    };
    failures(route, names_something, !parameters.is_empty(), fails);
    let mut operation = json!({
        "summary": route.summary,
        "description": format!("Needs the role {}.", route.role.as_str()),
        "operationId": route.name,
        "responses": responses,
    });
    if !parameters.is_empty() {
        operation["parameters"] = parameters.into();
    }
    if let Some(content) = body_of(route.body, asked) {
        operation["requestBody"] = json!({ "required": true, "content": content });
    }
    operation
}

fn path_parameter(name: &str) -> Value {
    let schema = match name {
        "order" | "line" | "machine" | "upload" => json!({ "type": "string" }),
        "hash" => json!({ "type": "string", "pattern": "^[0-9a-f]{64}$" }),
        _ => json!({ "type": "integer", "format": "int64" }),
    };
    json!({ "name": name, "in": "path", "required": true, "schema": schema })
}

/// A header of a request.
fn header_parameter(name: &str) -> Value {
    let (about, schema) = match name {
        "Idempotency-Key" => (
            "A text that no other order of this client has, such as a UUID: the same request with the same key is one order",
            json!({ "type": "string", "minLength": 1, "maxLength": 255 }),
        ),
        "Tus-Resumable" => ("The version of the protocol.", json!({ "type": "string", "enum": ["1.0.0"] })),
        "Upload-Metadata" => {
            ("blake3 and the BLAKE3 of the file in base64; may be left out.", json!({ "type": "string" }))
        }
        _ => ("A number of bytes.", json!({ "type": "integer", "format": "int64" })),
    };
    let is_required = name != "Upload-Metadata";
    json!({ "name": name, "in": "header", "required": is_required, "description": about, "schema": schema })
}

/// What a request brings, by media type.
fn body_of(body: RequestBody, generator: &mut SchemaGenerator) -> Option<Value> {
    match body {
        RequestBody::Nothing => None,
        RequestBody::Piece => {
            Some(json!({ "application/offset+octet-stream": { "schema": { "type": "string", "format": "binary" } } }))
        }
        RequestBody::Json(schema) => Some(json!({ "application/json": { "schema": schema(generator) } })),
        RequestBody::Bytes => {
            Some(json!({ "application/octet-stream": { "schema": { "type": "string", "format": "binary" } } }))
        }
        RequestBody::Form(field, schema) => {
            let order = schema(generator);
            let files = json!({ "type": "array", "items": { "type": "string", "format": "binary" } });
            let form = json!({ "type": "object", "required": [field], "properties": { field: order, "file": files } });
            Some(json!({ "application/json": { "schema": order }, "multipart/form-data": { "schema": form } }))
        }
    }
}

/// How an operation may fail.
fn failures(route: &ApiRoute, names_something: bool, has_parameters: bool, mut fails: impl FnMut(&str, &str)) {
    if has_parameters {
        fails("400", "A date, a state, a number or a key is none.");
    }
    fails("401", "The farm asks for a bearer token.");
    fails("403", "The token has another role, or the farm takes no orders from pages and programs.");
    if names_something {
        fails("404", "There is none of that number or name.");
    }
    if route.method != "GET" {
        fails(
            "409",
            "What is there does not allow it, or only in part (done, refused); or a request with this key is being carried out.",
        );
        fails("413", "It is larger than the farm takes.");
        fails("415", "It is of another media type.");
        fails("422", "What is asked cannot be done; the reason is that of a refused file.");
        fails("507", "The disk of the farm has no room.");
    }
    fails("421", "The farm does not answer to the name it was asked by.");
    fails("429", "The client asks too much; Retry-After says when to ask again.");
    fails("503", "The ledger does not answer.");
}

/// The fields of a query type as parameters of an address.
fn query_parameters(schema: &Schema, without: &[&str]) -> Vec<Value> {
    let fields = schema.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    let shown = fields.into_iter().filter(|(name, _)| !without.contains(&name.as_str()));
    let parameter = |(name, mut schema): (String, Value)| {
        let description = schema.as_object_mut().and_then(|schema| schema.remove("description"));
        json!({ "name": name, "in": "query", "description": description, "schema": without_defaults(schema) })
    };
    shown.map(parameter).collect()
}

/// What may be left out of a request, without what it is then: empty or null, which is no number and no date, and of which some
/// generators of clients conclude that the field is never left out.
fn without_defaults(mut schema: Value) -> Value {
    if let Some(fields) = schema.as_object_mut() {
        fields.remove("default");
        for value in fields.values_mut() {
            *value = without_defaults(value.take());
        }
    }
    schema
}

/// Lists the words of an enum as words. schemars describes each by itself where one has a meaning of its own, and few generators of
/// clients make one type of that; the meanings go into the description.
fn list_words(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(list_words),
        Value::Object(fields) => {
            fields.values_mut().for_each(list_words);
            let choices = fields.get("oneOf").and_then(Value::as_array).into_iter().flatten();
            let listed: Option<Vec<(Vec<Value>, String)>> = choices.map(words_and_meaning).collect();
            let Some(listed) = listed.filter(|listed| !listed.is_empty()) else { return };
            let meanings = listed.iter().filter(|(_, meaning)| !meaning.is_empty()).map(|(words, meaning)| {
                format!("- {}: {meaning}", words.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(", "))
            });
            let own = fields.get("description").and_then(Value::as_str).unwrap_or_default().to_owned();
            let described: Vec<String> = std::iter::once(own).chain(meanings).collect();
            let words: Vec<Value> = listed.iter().flat_map(|(words, _)| words.clone()).collect();
            fields.remove("oneOf");
            fields.insert("type".to_owned(), "string".into());
            fields.insert("enum".to_owned(), words.into());
            fields.insert("description".to_owned(), described.join("\n").into());
        }
        _ => {}
    }
}

/// The words of a choice between words, and what they mean.
fn words_and_meaning(choice: &Value) -> Option<(Vec<Value>, String)> {
    let words = match (choice.get("const"), choice.get("enum").and_then(Value::as_array)) {
        _ if choice["type"] != "string" => return None,
        (Some(word), _) => vec![word.clone()],
        (None, words) => words?.clone(),
    };
    Some((words, choice["description"].as_str().unwrap_or_default().to_owned()))
}

/// Replaces Rust terms in descriptions: `None` becomes null, and links become plain names.
fn speak_json(value: &mut Value) {
    match value {
        Value::String(text) => *text = text.replace("`None`", "null").replace("[`", "`").replace("`]", "`"),
        Value::Array(values) => values.iter_mut().for_each(speak_json),
        Value::Object(fields) => fields.values_mut().for_each(speak_json),
        _ => {}
    }
}
