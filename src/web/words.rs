//! Numbers, times and names as pages show them.

use jiff::Timestamp;
use maud::{Markup, html};

use crate::{ledger::Utc, tables::fields};

/// What is not known.
pub(super) const DASH: &str = "\u{2013}";

/// '1 copy', '2 copies'.
pub(super) use build_file::counted as count;

/// A time with its zone.
pub(super) fn time_utc(moment: Utc) -> String {
    fields::TIME.with_unit(moment).unwrap_or_default()
}

/// A text in which commands and options stand between backticks.
pub(super) fn prose(text: &str) -> Markup {
    let pieces: Vec<&str> = text.split('`').collect();
    // A tick that nobody closes is a tick.
    if pieces.len().is_multiple_of(2) {
        return html! { (text) };
    }
    html! { @for (at, piece) in pieces.iter().enumerate() { @if at % 2 == 1 { code { (piece) } } @else { (piece) } } }
}

/// How long from `since` to `now`, to one unit below days.
pub(super) fn age(since: Timestamp, now: Timestamp) -> String {
    Utc(since).age(now).unwrap_or_else(|| DASH.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_in_a_text_are_code_and_a_lone_tick_is_a_tick() {
        let shown = |text: &str| prose(text).into_string();
        assert_eq!(shown("run `nestd <check>`."), "run <code>nestd &lt;check&gt;</code>.");
        assert_eq!((shown("a`b.stl"), shown("plain")), ("a`b.stl".to_owned(), "plain".to_owned()));
    }
}
