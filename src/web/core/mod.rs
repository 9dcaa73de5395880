//! The state that all handlers share, and what several of them use: commands to the daemon, answers to forms, pictures and scenes, and which copies
//! are on screens.

pub(super) mod cached_render;
pub(super) mod command;
pub(super) mod content;
pub(super) mod device_name;
pub(super) mod form_answer;
pub(super) mod form_keys;
pub(super) mod order_keys;
pub(super) mod picture;
pub(super) mod request_user;
pub(super) mod scene;
pub(super) mod shown_copies;
pub(super) mod state;
pub(super) mod upload_turns;
pub(super) mod view_section;
