//! How a number of copies is asked for: what reads tickets and names writes it as a warning of the part, and what keeps the parts finds it
//! there until a number is told.

/// Start of a warning that asks for the number of copies.
pub const COPIES_QUESTION: &str = "How many copies?";

/// Whether a warning of a part asks for its number of copies: something was said about it, but was not understood.
pub fn is_copies_question(warning: &str) -> bool {
    warning.starts_with(COPIES_QUESTION)
}
