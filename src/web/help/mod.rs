//! The book below `/help`: its chapters are files of the repository that are embedded in the binary, so that they can be read and searched
//! without a network and without scripts. This folder decides how Markdown becomes a page, where its links lead, and what a search finds;
//! it owns no words of its own and asks neither ledger nor farm.

/// The chapter of settings, Markdown.
pub const SETTINGS_CHAPTER: &str = include_str!("../../../docs/settings.md");

mod book;
mod markdown;
pub(super) mod pages;
mod search;
#[cfg(test)]
mod tests;
