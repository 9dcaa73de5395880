//! What people say: how a print ended, what is printed again, taken back or broken out; and commands for the daemon.
//!
//! `said` is what can be said, `operator_word` judges it, and the others carry it out.

pub(super) mod close_order;
pub(super) mod command;
pub(super) mod finishing;
pub(super) mod operator_word;
pub(super) mod outcome;
pub(super) mod pick;
pub(super) mod put_back;
pub(super) mod requeue;
pub(super) mod said;
pub(super) mod withdrawal;
