//! What people are shown, told and may do; and what printers do.

pub mod attention;
pub mod dashboard;
pub mod mails;
pub mod one_truth;
pub mod operations;
pub mod orders;
pub mod pictures;
pub mod printers;
pub mod privilege;
pub mod sign_in;
pub mod status_texts;
pub mod watchers;
