//! Signs between words, as each language writes them.

use crate::say;

/// What stands between two names of a list: `, `.
pub fn comma() -> String {
    say!("sign-comma")
}

/// What stands between a name and what is said of it: `: `.
pub fn colon() -> String {
    say!("sign-colon")
}

/// Names after each other: `a, b, c`.
pub fn join_names(names: impl IntoIterator<Item = impl Into<String>>) -> String {
    names.into_iter().map(Into::into).collect::<Vec<String>>().join(&comma())
}

/// Sentences or parts of sentences after each other: `a; b`.
pub fn join_sentences(sentences: impl IntoIterator<Item = impl Into<String>>) -> String {
    let sentences = sentences.into_iter().map(|one| one.into().trim_end_matches('。').to_owned());
    sentences.collect::<Vec<String>>().join(&say!("sign-semicolon"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Language;

    #[test]
    fn lists_have_the_signs_of_their_language() {
        let lists = || (join_names(["a", "b"]), join_sentences(["a。", "b"]), colon());
        assert_eq!(lists(), ("a, b".to_owned(), "a; b".to_owned(), ": ".to_owned()));
        assert_eq!(Language::Japanese.within(lists), ("a、b".to_owned(), "a。b".to_owned(), ": ".to_owned()));
        assert_eq!(Language::French.within(colon), "\u{202f}: ");
    }
}
