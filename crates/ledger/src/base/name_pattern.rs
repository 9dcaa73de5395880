//! What the databases leave out of a search for part of a name.

/// What names must resemble: a pattern for `LIKE` with the escape character `!`, in lower case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamePattern(String);

impl NamePattern {
    /// The pattern of all names that can contain a text, without regard to case. Anything may stand for a letter beyond ASCII:
    /// its other case, or the same letter in two characters.
    pub fn containing(text: &str) -> Self {
        let mut pattern = "%".to_owned();
        for letter in text.chars() {
            match letter {
                '%' | '_' | '!' => pattern.extend(['!', letter]),
                letter if letter.is_ascii() => pattern.push(letter.to_ascii_lowercase()),
                _ if pattern.ends_with('%') && !pattern.ends_with("!%") => {}
                _ => pattern.push('%'),
            }
        }
        pattern.push('%');
        Self(pattern)
    }

    /// The pattern, for `LIKE .. ESCAPE '!'`.
    pub(crate) fn text(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_lets_anything_stand_for_letters_beyond_ascii_and_takes_signs_as_they_are() {
        let pattern = |text: &str| NamePattern::containing(text).0;
        assert_eq!(pattern("Hinge_50%!"), "%hinge!_50!%!!%");
        assert_eq!(
            (pattern("mÜÜller"), pattern("ä"), pattern("")),
            ("%m%ller%".to_owned(), "%%".to_owned(), "%%".to_owned())
        );
        assert_eq!(pattern("%ß"), "%!%%%");
    }
}
