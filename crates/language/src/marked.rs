//! The marked language: it shows, to tests and to who writes pages, what does not come from a catalog.

/// The words of a text in [`Language::Marked`](crate::Language::Marked) that no catalog said: what stands outside of all marks.
pub fn unsaid_words(text: &str) -> Vec<String> {
    let mut outside = String::new();
    let mut depth = 0_i32;
    for letter in text.chars() {
        depth += i32::from(letter == '⟦') - i32::from(letter == '⟧');
        outside.push(if depth == 0 && letter != '⟧' { letter } else { ' ' });
    }
    let words = outside.split(|letter: char| letter.is_whitespace() || ",;:()".contains(letter));
    words.filter(|word| word.chars().any(char::is_alphabetic)).map(|word| word.trim_matches('.').to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_outside_of_marks_is_not_said() {
        assert_eq!(unsaid_words("⟦Build ⟧7⟦ waits for ⟧ann@vm: an old word."), ["ann@vm", "an", "old", "word"]);
    }
}
