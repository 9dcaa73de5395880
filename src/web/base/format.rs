//! Formats numbers, times and texts for pages.

use std::collections::BTreeSet;

use jiff::Timestamp;
use language::say;
use maud::{Markup, html};

use ledger::UtcTimestamp;

/// Stands for a value that is not known.
pub(crate) const DASH: &str = "\u{2013}";

/// A text that may be stored in English, in the language of the reader; its commands and options in backticks become `<code>` elements.
pub(crate) fn prose_with_code(text: &str) -> Markup {
    let text = language::told(text);
    let pieces: Vec<&str> = text.split('`').collect();
    // A backtick without a partner stays a character.
    if pieces.len().is_multiple_of(2) {
        return html! { (text) };
    }
    html! { @for (at, piece) in pieces.iter().enumerate() { @if at % 2 == 1 { code { (piece) } } @else { (piece) } } }
}

/// Prose in which a command that a page can give as well is followed by a link to that page.
pub(crate) fn prose_with_pages(text: &str) -> Markup {
    let pages: BTreeSet<(String, String)> = text.split('`').skip(1).step_by(2).filter_map(page_of_command).collect();
    html! {
        (prose_with_code(text))
        @for (name, path) in pages { " " (phrase!("on-these-pages", link = html! { a href=(path) { (name) } })) }
    }
}

/// Name and path of the page that does what a command of the command line does: `nestd edit 7 --copies 9`, `nestd show b4`.
fn page_of_command(command: &str) -> Option<(String, String)> {
    let mut words = command.split_whitespace();
    let (Some("nestd"), Some(verb), Some(target)) = (words.next(), words.next(), words.next()) else { return None };
    let target = target.split('=').next().unwrap_or_default();
    let (kind, number) = match (verb, target.strip_prefix('b'), target.strip_prefix('p').unwrap_or(target)) {
        ("show" | "reprint" | "dismiss", Some(build), _) => ("build", build),
        ("outcome" | "requeue" | "dismiss", _, build) => ("build", build),
        ("show" | "reprint" | "retry" | "edit" | "cancel" | "confirm" | "move", None, part) => ("part", part),
        _ => return None,
    };
    let number: u64 = number.parse().ok()?;
    let name = match kind {
        "build" => say!("build-named", build = number.to_string()),
        _ => say!("part-named", part = number.to_string()),
    };
    Some((name, format!("/{kind}s/{number}")))
}

/// The time from `since` to `now` in two units, such as `2d 3h`.
pub(crate) fn format_age(since: Timestamp, now: Timestamp) -> String {
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

    #[test]
    fn a_command_that_a_page_can_give_is_followed_by_the_link_to_it() {
        let page = |command: &str| page_of_command(command).map(|(_, path)| path);
        for command in
            ["nestd show p7", "nestd edit 7 --copies 9", "nestd retry 7", "nestd reprint 7=N", "nestd cancel p7"]
        {
            assert_eq!(page(command).as_deref(), Some("/parts/7"), "{command}");
        }
        for command in ["nestd show b4", "nestd outcome 4 failed --correct", "nestd requeue 4", "nestd reprint b4"] {
            assert_eq!(page(command).as_deref(), Some("/builds/4"), "{command}");
        }
        for command in ["nestd show", "nestd edit PART --copies N", "nestd check", "cp 7 8", "order-1042"] {
            assert_eq!(page(command), None, "{command}");
        }
        let shown = prose_with_pages("`nestd show p7` says why, `nestd retry 7` takes it back.").into_string();
        assert!(shown.ends_with(r#" On these pages: <a href="/parts/7">part 7</a>."#), "{shown}");
    }
}
