//! What all readers and writers share: limits, errors, units, names, and the solid that a reader gives back.

pub(super) mod camspec;
pub(super) mod copies_question;
pub(super) mod decimal;
pub(super) mod error;
pub(super) mod file_name;
pub(super) mod limits;
pub(super) mod options;
pub(super) mod part_terms;
pub(super) mod plural;
pub(super) mod solid;
pub(super) mod unfinished;
pub(super) mod unit;
pub(super) mod uuid;
pub(super) mod visible_text;
