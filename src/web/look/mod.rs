//! How everything looks: the style sheet, and the components of pages, one function each. `/components` shows them all.

#[macro_use]
pub(super) mod phrase;

pub(super) mod chip;
pub(super) mod pieces;
pub(super) mod script_texts;
pub(super) mod style;
pub(super) mod times;
