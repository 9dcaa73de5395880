//! People: who asks, where people sign in; the page on which they do; what each can change for himself, and an admin for all.

pub(super) mod account;
pub(super) mod people_page;
pub(super) mod sign_in;
pub(super) mod visitor;
