//! Formats a number with its noun: '1 copy', '2 copies'.

use std::fmt::Display;

/// Formats a number with the singular or plural noun.
pub fn format_count<N: Display + PartialEq + From<u8>>(number: N, one: &str, several: &str) -> String {
    let word = if number == N::from(1) { one } else { several };
    format!("{number} {word}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one_and_nothing_is_several() {
        let texts = [0_u32, 1, 2].map(|n| format_count(n, "copy", "copies"));
        assert_eq!(texts, ["0 copies", "1 copy", "2 copies"]);
    }
}
