//! An address of the JSON interface: who may ask it, what it brings and what is answered.

use std::sync::Arc;

use access::Role;
use axum::routing::{MethodFilter, MethodRouter};
use schemars::{JsonSchema, Schema, SchemaGenerator};

use super::edit_door;
use crate::web::core::state::DashboardState;

/// Creates the schema of a type.
pub(crate) type SchemaMaker = fn(&mut SchemaGenerator) -> Schema;

/// Creates the handler of an address for the method that its description names.
pub(crate) type HandlerMaker = fn(MethodFilter) -> MethodRouter<Arc<DashboardState>>;

/// What a request brings.
#[derive(Clone, Copy)]
pub(crate) enum RequestBody {
    /// Nothing.
    Nothing,
    /// JSON.
    Json(SchemaMaker),
    /// JSON, or a form with that JSON in the field of this name and files.
    Form(&'static str, SchemaMaker),
    /// A file.
    Bytes,
    /// A piece of a file.
    Piece,
}

/// What may be done at an address.
pub(crate) struct ApiRoute {
    /// GET, PUT, POST, PATCH or DELETE.
    pub method: &'static str,
    pub path: &'static str,
    pub name: &'static str,
    pub summary: &'static str,
    /// Who may.
    pub role: Role,
    pub body: RequestBody,
    /// Status and content of the answer.
    pub answer: (&'static str, Option<SchemaMaker>),
    /// Schema of its query parameters; `None` = no query.
    pub query: Option<SchemaMaker>,
    /// Fields of that schema that do not apply to this address.
    pub without: &'static [&'static str],
    /// Headers that it needs.
    pub headers: &'static [&'static str],
    pub handler: HandlerMaker,
}

impl RequestBody {
    /// Whether a request of this type brings files, which its handler receives as they come. Such a body may be long.
    pub(crate) fn brings_files(self, content_type: &str) -> bool {
        match self {
            Self::Nothing | Self::Json(_) => false,
            Self::Form(..) => content_type.starts_with("multipart/"),
            Self::Bytes | Self::Piece => true,
        }
    }
}

pub(crate) fn schema_of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<T>()
}

/// Whether an address is one of a pattern: its steps are the same, or stand where the pattern has a name in braces.
pub(crate) fn is_path_of(pattern: &str, path: &str) -> bool {
    let (wanted, given) = (pattern.split('/'), path.split('/'));
    wanted.clone().count() == given.clone().count()
        && wanted.zip(given).all(|(wanted, given)| wanted.starts_with('{') || wanted == given)
}

/// A question.
pub(crate) const fn ask(
    path: &'static str,
    name: &'static str,
    summary: &'static str,
    answer: SchemaMaker,
    handler: HandlerMaker,
) -> ApiRoute {
    ApiRoute {
        method: "GET",
        path,
        name,
        summary,
        role: Role::Read,
        body: RequestBody::Nothing,
        answer: ("200", Some(answer)),
        query: None,
        without: &[],
        headers: &[],
        handler,
    }
}

/// Something that changes what the farm does.
pub(crate) const fn tell(
    (method, path): (&'static str, &'static str),
    name: &'static str,
    summary: &'static str,
    body: RequestBody,
    handler: HandlerMaker,
) -> ApiRoute {
    let answer: SchemaMaker = schema_of::<edit_door::CarriedOut>;
    ApiRoute { method, role: Role::Order, body, ..ask(path, name, summary, answer, handler) }
}

/// Something that operators do.
pub(crate) const fn operate(
    path: &'static str,
    name: &'static str,
    summary: &'static str,
    body: RequestBody,
    handler: HandlerMaker,
) -> ApiRoute {
    ApiRoute { role: Role::Operate, ..tell(("POST", path), name, summary, body, handler) }
}
