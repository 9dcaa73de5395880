//! The addresses of the JSON interface, in one list. The server serves them, and `openapi.json` is derived from the
//! list, from the response types and from the query types.

use std::sync::{Arc, LazyLock};

use axum::{
    Router,
    http::header,
    response::{IntoResponse, Response},
    routing::{MethodRouter, get},
};
use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde_json::{Map, Value, json};

use super::{
    api,
    dto::{BuildResponse, PartResource, PartResponse},
    error::ApiError,
    history, month, order, part, pick_page,
    state::DashboardState,
};
use crate::{
    ledger::{HeightSummary, HistoryRow, OrderSummary},
    tables::PickList,
};

const ABOUT: &str = "What the pages of the dashboard show. Lengths end in _mm, volumes in _mm3, durations in _secs, sizes of files in \
    _bytes; density is a share, 0 to 1; rotations and directions have no unit; times are UTC, RFC 3339.";

/// Path of the schemas in the document.
const SCHEMAS: &str = "/components/schemas";

/// Creates the schema of a type.
type SchemaMaker = fn(&mut SchemaGenerator) -> Schema;

/// Creates the handler of an address.
type HandlerMaker = fn() -> MethodRouter<Arc<DashboardState>>;

/// An address of the interface.
struct ApiRoute {
    path: &'static str,
    name: &'static str,
    summary: &'static str,
    answer: SchemaMaker,
    /// Schema of its query parameters; `None` = no query.
    query: Option<SchemaMaker>,
    /// Fields of that schema that do not apply to this address.
    without: &'static [&'static str],
    handler: HandlerMaker,
}

const ROUTES: [ApiRoute; 10] = [
    ApiRoute {
        path: "/api/v1/farm",
        name: "farm",
        summary: "The farm as it stands",
        answer: schema_of::<api::FarmResponse>,
        query: None,
        without: &[],
        handler: || get(api::get_farm),
    },
    ApiRoute {
        path: "/api/v1/builds",
        name: "builds",
        summary: "Builds past nesting, newest first unless sorted otherwise, 500 at a time",
        answer: schema_of::<Vec<HistoryRow>>,
        query: Some(schema_of::<history::HistoryFilter>),
        without: &[],
        handler: || get(api::list_builds),
    },
    ApiRoute {
        path: "/api/v1/heights",
        name: "heights",
        summary: "What the published builds come to, by machine; filtered as the builds are",
        answer: schema_of::<Vec<HeightSummary>>,
        query: Some(schema_of::<history::HistoryFilter>),
        without: &["sort", "after"],
        handler: || get(api::list_height_sums),
    },
    ApiRoute {
        path: "/api/v1/builds/{build}",
        name: "build",
        summary: "A build with its parts and placements",
        answer: schema_of::<BuildResponse>,
        query: None,
        without: &[],
        handler: || get(api::get_build),
    },
    ApiRoute {
        path: "/api/v1/builds/{build}/pick",
        name: "pick",
        summary: "The copies of a build in the order in which they come out of the cake",
        answer: schema_of::<PickList>,
        query: None,
        without: &[],
        handler: || get(pick_page::get_pick_list),
    },
    ApiRoute {
        path: "/api/v1/parts",
        name: "parts",
        summary: "Parts, newest first, 500 at a time; without a state or a name those that are not built yet, of the refused ones \
            those of the last 30 days",
        answer: schema_of::<Vec<PartResource>>,
        query: Some(schema_of::<part::PartFilter>),
        without: &[],
        handler: || get(api::list_parts),
    },
    ApiRoute {
        path: "/api/v1/parts/{part}",
        name: "part",
        summary: "A part, where its copies are and what happened to it",
        answer: schema_of::<PartResponse>,
        query: None,
        without: &[],
        handler: || get(api::get_part),
    },
    ApiRoute {
        path: "/api/v1/orders",
        name: "orders",
        summary: "Orders with what became of their copies, open ones first, newest first",
        answer: schema_of::<Vec<OrderSummary>>,
        query: Some(schema_of::<order::OrderFilter>),
        without: &[],
        handler: || get(order::get_orders),
    },
    ApiRoute {
        path: "/api/v1/month",
        name: "month",
        summary: "What each machine made in a month and in the one before, what came late and what failed",
        answer: schema_of::<month::MonthResponse>,
        query: Some(schema_of::<month::MonthQuestion>),
        without: &[],
        handler: || get(month::get_month),
    },
    ApiRoute {
        path: "/api/v1/orders/{order}",
        name: "order",
        summary: "An order with its lines: what became of their copies, and the builds that hold them",
        answer: schema_of::<order::OrderResponse>,
        query: None,
        without: &[],
        handler: || get(order::get_order),
    },
];

/// The addresses of the interface, and of the document that describes them.
pub(super) fn routes() -> Router<Arc<DashboardState>> {
    let router = Router::new().route("/api/v1/openapi.json", get(document));
    ROUTES.iter().fold(router, |router, route| router.route(route.path, (route.handler)()))
}

async fn document() -> Response {
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT.as_str()).into_response()
}

/// The document as text. It does not change while the program runs.
static DOCUMENT: LazyLock<String> = LazyLock::new(|| format!("{:#}", described()));

fn schema_of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<T>()
}

/// Creates the whole document.
pub(super) fn described() -> Value {
    let mut settings = SchemaSettings::draft2020_12().for_serialize();
    settings.definitions_path = SCHEMAS.into();
    settings.meta_schema = None;
    let mut generator = settings.into_generator();
    let error = schema_of::<ApiError>(&mut generator);
    let paths: Map<String, Value> = (ROUTES.iter())
        .map(|route| (route.path.to_owned(), json!({ "get": operation(route, &error, &mut generator) })))
        .collect();
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
                "token": { "type": "http", "scheme": "bearer", "description": "Only where web.token_file is set." },
            },
            "schemas": generator.take_definitions(true),
        },
    });
    speak_json(&mut document);
    document
}

fn operation(route: &ApiRoute, error: &Schema, generator: &mut SchemaGenerator) -> Value {
    let mut parameters = Vec::new();
    let subject = route.path.split(['{', '}']).nth(1);
    parameters.extend(subject.map(|name| {
        let schema = match name {
            "order" => json!({ "type": "string" }),
            _ => json!({ "type": "integer", "format": "int64" }),
        };
        json!({ "name": name, "in": "path", "required": true, "schema": schema })
    }));
    if let Some(query) = route.query {
        let schema = query(generator);
        parameters.extend(query_parameters(&schema, route.without));
    }
    let content = |schema: &Schema| json!({ "application/json": { "schema": schema } });
    let mut responses = json!({
        "200": { "description": route.summary, "content": content(&(route.answer)(generator)) },
    });
    let mut fails = |status: &str, why: &str| {
        responses[status] = json!({ "description": why, "content": content(error) });
    };
    if !parameters.is_empty() {
        fails("400", "A date, a state or a number is none.");
    }
    fails("401", "The farm asks for a bearer token.");
    if subject.is_some() {
        fails("404", "There is none of that number or name.");
    }
    fails("421", "The farm does not answer to the name it was asked by.");
    fails("503", "The ledger does not answer.");
    let mut operation = json!({ "summary": route.summary, "operationId": route.name, "responses": responses });
    if !parameters.is_empty() {
        operation["parameters"] = parameters.into();
    }
    operation
}

/// The fields of a query type as parameters of an address.
fn query_parameters(schema: &Schema, without: &[&str]) -> Vec<Value> {
    let fields = schema.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    let shown = fields.into_iter().filter(|(name, _)| !without.contains(&name.as_str()));
    let parameter = |(name, mut schema): (String, Value)| {
        let description = schema.as_object_mut().and_then(|schema| schema.remove("description"));
        json!({ "name": name, "in": "query", "description": description, "schema": schema })
    };
    shown.map(parameter).collect()
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
