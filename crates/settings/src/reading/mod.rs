//! How a TOML file becomes values: fragments with their files and lines, durations, optional tables, and faults that name file, line and remedy.

pub(super) mod duration;
pub(super) mod folder_conflicts;
pub(super) mod fragment;
pub(super) mod notification_kind;
pub(super) mod option_group;
pub(super) mod optional;
pub(super) mod problem;
pub(super) mod problem_text;
pub(super) mod validator;
