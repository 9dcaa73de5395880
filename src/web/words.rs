//! Numbers, times and names as pages show them.

use std::fmt::Display;

use jiff::Timestamp;
use maud::{Markup, html};

use crate::ledger::Utc;

/// What is not known.
pub(super) const DASH: &str = "\u{2013}";

/// A number with so many decimals.
pub(super) fn number(value: Option<f64>, decimals: usize) -> String {
    let text = value.map_or_else(|| DASH.to_owned(), |v| format!("{v:.decimals$}"));
    // What rounds to nothing has no sign.
    match text.strip_prefix('-') {
        Some(nothing) if nothing.bytes().all(|b| b == b'0' || b == b'.') => nothing.to_owned(),
        _ => text,
    }
}

/// A share 0..1 in percent.
pub(super) fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| DASH.to_owned(), |s| format!("{:.1} %", 100.0 * s))
}

/// Whatever prints.
pub(super) fn or_dash(value: Option<impl Display>) -> String {
    value.map_or_else(|| DASH.to_owned(), |v| v.to_string())
}

/// A text, a dash when it is empty.
pub(super) fn text(value: &str) -> &str {
    if value.is_empty() { DASH } else { value }
}

/// '1 copy', '2 copies'.
pub(super) use build_file::counted as count;
/// A time of the table, UTC.
pub(super) fn time(time: Option<Utc>) -> String {
    time.map_or_else(|| DASH.to_owned(), |t| t.0.strftime("%Y-%m-%d %H:%M").to_string())
}

/// A time with its zone.
pub(super) fn time_utc(moment: Utc) -> String {
    time(Some(moment)) + " UTC"
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

    #[test]
    fn what_rounds_to_nothing_has_no_sign() {
        assert_eq!((number(Some(-1e-9), 1), number(Some(-0.06), 1)), ("0.0".to_owned(), "-0.1".to_owned()));
        assert_eq!((number(Some(-0.2), 0), number(None, 1)), ("0".to_owned(), DASH.to_owned()));
    }
}
