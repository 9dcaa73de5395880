//! The dashboard: pages over the ledger's queries, rendered on the server and readable without JavaScript, plus a JSON
//! interface and metrics for programs. It decides nothing: its commands go through the ledger, like those of the CLI.
//!
//! All assets are embedded in the binary, and no page loads anything from another host.

mod api;
mod api_body;
mod api_route;
mod api_routes;
mod asset_route;
mod assets;
mod break_out;
mod break_out_card;
mod break_out_state;
mod build;
mod build_forms;
mod cache;
mod cached_render;
mod chart;
mod client;
mod client_limits;
mod command;
mod compressed;
mod connection_limits;
mod content;
mod device_name;
mod drop;
mod drop_form;
mod dto;
mod edit_door;
mod enum_words;
mod error;
mod farm;
mod flush;
mod footprint;
mod form_answer;
mod form_field;
mod form_keys;
mod format;
mod guard;
mod history;
mod labels;
mod listener;
mod listing;
mod live;
mod look_alike;
mod machine_card;
mod mesh_reduction;
mod metrics;
mod month;
mod needs;
mod openapi;
mod operate_door;
mod operate_form;
mod order;
mod order_cancel;
mod order_door;
mod order_forms;
mod order_keys;
mod order_request;
mod page;
mod part;
mod part_forms;
mod pick_map;
mod pick_page;
mod picture;
mod plan;
mod put_content;
mod query;
mod quote;
mod report;
mod request_stage;
mod request_user;
mod role_rules;
mod scene;
mod search;
mod search_report;
mod sent_form;
mod server;
mod state;
mod upload_door;
mod upload_turns;
mod view_section;

#[cfg(test)]
mod tests;

pub use report::{HtmlReport, ReportSource};
pub use server::serve_dashboard;
