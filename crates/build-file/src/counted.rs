//! How many of something: '1 copy', '2 copies'.

use std::fmt::Display;

/// A number with the word for one or for several.
pub fn counted<N: Display + PartialEq + From<u8>>(number: N, one: &str, several: &str) -> String {
    let word = if number == N::from(1) { one } else { several };
    format!("{number} {word}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one_and_nothing_is_several() {
        let told = [0_u32, 1, 2].map(|n| counted(n, "copy", "copies"));
        assert_eq!(told, ["0 copies", "1 copy", "2 copies"]);
    }
}
