//! Formats numbers, times and texts for pages.

use jiff::Timestamp;
use maud::{Markup, html};

use crate::ledger::UtcTimestamp;

/// Stands for a value that is not known.
pub(super) const DASH: &str = "\u{2013}";

/// '1 copy', '2 copies'.
pub(super) use build_file::format_count as count;

/// A text whose commands and options in backticks become `<code>` elements.
pub(super) fn prose_with_code(text: &str) -> Markup {
    let pieces: Vec<&str> = text.split('`').collect();
    // A backtick without a partner stays a character.
    if pieces.len().is_multiple_of(2) {
        return html! { (text) };
    }
    html! { @for (at, piece) in pieces.iter().enumerate() { @if at % 2 == 1 { code { (piece) } } @else { (piece) } } }
}

/// The time from `since` to `now` in two units, such as `2d 3h`.
pub(super) fn format_age(since: Timestamp, now: Timestamp) -> String {
    UtcTimestamp(since).age_text(now).unwrap_or_else(|| DASH.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_in_a_text_are_code_and_a_lone_tick_is_a_tick() {
        let shown = |text: &str| prose_with_code(text).into_string();
        assert_eq!(shown("run `nestd <check>`."), "run <code>nestd &lt;check&gt;</code>.");
        assert_eq!((shown("a`b.stl"), shown("plain")), ("a`b.stl".to_owned(), "plain".to_owned()));
    }
}
