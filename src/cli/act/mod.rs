//! Commands by which a person changes something: words about builds and parts, and what a machine is to do.

pub(super) mod adopt;
pub(super) mod command;
pub(super) mod dismiss;
pub(super) mod edit;
pub(super) mod machine;
pub(super) mod notify;
pub(super) mod operate;
pub(super) mod outcome;
pub(super) mod person;
pub(super) mod printer;
pub(super) mod release;
mod secret_input;
pub(super) mod token;
pub(super) mod withdraw;
