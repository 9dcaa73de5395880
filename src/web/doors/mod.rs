//! The door for programs: each address with its roles, what it takes and what it answers; `openapi.json` is made of the same rows.

pub(super) mod api;
pub(super) mod api_route;
pub(super) mod api_routes;
pub(super) mod dto;
pub(super) mod edit_door;
pub(super) mod enum_words;
pub(super) mod openapi;
pub(super) mod operate_door;
pub(super) mod order_door;
pub(super) mod order_request;
pub(super) mod put_content;
pub(super) mod quote;
pub(super) mod request_stage;
pub(super) mod upload_door;
