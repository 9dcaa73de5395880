//! What a name says: its bytes and code page, copies, sizes, dates, and whether two names mean the same file.
//!
//! Pure; it looks at no folder.

pub(super) mod code_page;
pub(super) mod copies;
pub(super) mod copies_doubts;
pub(super) mod copies_sizes;
pub(super) mod copies_words;
pub(super) mod copy_name;
pub(super) mod due_date;
pub(super) mod name;
pub(super) mod name_match;
pub(super) mod old_words;
pub(super) mod unordered_folder;
