//! Makes text from outside safe to show: it cannot move a cursor, change the reading direction, hide, or become a
//! formula in a spreadsheet.

/// Control characters, characters that hide text or change its direction, and those that XML forbids. The joiner of
/// emoji is allowed.
pub fn is_invisible(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200b}' | '\u{200c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{fffe}' | '\u{ffff}'
            | '\u{e0000}'..='\u{e007f}')
}

/// Returns the text on one line; invisible characters are escaped (`\n`, `\u{1b}`).
pub fn escape_invisible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' => shown.push_str("\\n"),
            '\r' => shown.push_str("\\r"),
            '\t' => shown.push_str("\\t"),
            c if is_invisible(c) => shown.push_str(&format!("\\u{{{:x}}}", c as u32)),
            c => shown.push(c),
        }
    }
    shown
}

/// The same for a text of several lines; line ends are kept.
pub fn escape_invisible_lines(text: &str) -> String {
    text.split('\n')
        .map(|line| escape_invisible(line.strip_suffix('\r').unwrap_or(line)))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Escapes a text for a CSV cell: spreadsheets treat text that begins like a formula as one, even in quotes.
pub fn csv_cell(text: &str) -> String {
    let begins_like_a_formula =
        |c: char| matches!(c, '=' | '+' | '-' | '@' | '＝' | '＋' | '－' | '＠') || c.is_control();
    let shown = escape_invisible(text);
    match text.trim_start().starts_with(begins_like_a_formula) || text.starts_with(begins_like_a_formula) {
        true => format!("'{shown}"),
        false => shown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_seen_is_escaped_and_names_of_people_stay_as_they_are() {
        assert_eq!(escape_invisible("a\u{1b}]0;x\u{7}\u{9b}31m\r\n\tb"), r"a\u{1b}]0;x\u{7}\u{9b}31m\r\n\tb");
        assert_eq!(escape_invisible("a\u{202e}lts.exe\u{feff}\u{ffff}"), r"a\u{202e}lts.exe\u{feff}\u{ffff}");
        for text in ["Größe \\ 3", "部品", "👩‍🔧"] {
            assert_eq!(escape_invisible(text), text);
        }
        assert_eq!(escape_invisible_lines("one\r\n\u{1b}two\n"), "one\n\\u{1b}two\n");
    }

    #[test]
    fn a_cell_is_never_a_formula() {
        for text in ["=HYPERLINK(\"x\")", "+1", "-1", "@SUM(A1)", "  =1", "\t=1", "\r=1", "＝1"] {
            assert!(csv_cell(text).starts_with('\''), "{text:?}");
        }
        for text in ["", "bracket.stl", "a=b", "3-4", "'", "5"] {
            assert_eq!(csv_cell(text), text);
        }
    }
}
