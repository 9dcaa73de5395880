//! Copies in a file's name: `bracket_x10.stl` is ten brackets.

/// The copies that a file name asks for by `_x10 _10x _qty10 _10pcs` right before the extension; `None` if it asks for
/// none, or ambiguously.
pub fn copies_in_name(_name: &str) -> Option<u32> {
    None
}
