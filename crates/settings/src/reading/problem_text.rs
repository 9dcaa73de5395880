//! Converts errors of the TOML parser to messages for operators: (what is wrong, what to do).

/// Message about text that is not valid TOML.
pub(super) fn syntax_problem_text(message: &str) -> (String, String) {
    (
        format!("is not valid TOML: {}", message.replace('\n', ", ")),
        "correct the line; strings need quotes, as in root = \"/srv/nestd\"".into(),
    )
}

/// Message about an invalid value at `key`.
pub(super) fn value_problem_text(key: &str, message: &str) -> (String, String) {
    let quoted = words_in_backticks(message);
    if message.starts_with("unknown field") {
        let (unknown, known) = quoted.split_first().unwrap_or((&"", &[]));
        return (format!("unknown option \"{key}\""), suggest_option(unknown, known));
    }
    if message.starts_with("unknown variant") {
        let (value, known) = quoted.split_first().unwrap_or((&"", &[]));
        return (format!("{key} cannot be \"{value}\""), format!("use one of {}", quoted_list(known)));
    }
    let (what, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let remedy = match expected {
        "" => "correct the value".to_owned(),
        expected => format!("give {}", describe_kind(expected)),
    };
    (format!("{key}: {what}"), remedy)
}

/// Describes a Rust type in words for people.
fn describe_kind(expected: &str) -> &str {
    match expected {
        "f64" => "a number",
        "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "a boolean" => "true or false",
        "a string" | "path string" => "a text in quotes",
        "a sequence" => "a list, as in [\"09:00\", \"17:00\"]",
        "an array of length 3" => "three lengths, as in [200, 200, 200]",
        other if other.starts_with("struct ") => "a table, as in [trigger] on a line of its own",
        other => other,
    }
}

fn suggest_option(unknown: &str, known: &[&str]) -> String {
    if unknown == "instances" && known.contains(&"delivery") {
        return "say kind = \"shared\" or \"expanded\" in the section [delivery]".to_owned();
    }
    let near = known.iter().map(|name| (edit_distance(unknown, name), *name)).min();
    match near {
        Some((edits, name)) if edits <= 1 + unknown.chars().count() / 3 => format!("did you mean \"{name}\"?"),
        _ => format!("remove the line, or name one that is known here: {}", quoted_list(known)),
    }
}

fn quoted_list(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

fn words_in_backticks(message: &str) -> Vec<&str> {
    message.split('`').skip(1).step_by(2).collect()
}

/// Least number of letters to insert, delete or replace to turn `a` into `b` (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for j in 0..b.len() {
            let replaced = diagonal + usize::from(letter != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_count_letters() {
        assert_eq!(edit_distance("settle_sec", "settle_secs"), 1);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
    }

    #[test]
    fn an_unknown_option_is_reported_with_the_nearest_known_one() {
        let (text, remedy) = value_problem_text(
            "trigger.copys",
            "unknown field `copys`, expected one of `copies`, `at`, `max_wait_secs`",
        );
        assert_eq!(text, "unknown option \"trigger.copys\"");
        assert_eq!(remedy, "did you mean \"copies\"?");
    }

    #[test]
    fn an_option_like_no_other_is_reported_with_all_known_ones() {
        let (_, remedy) = value_problem_text("colour", "unknown field `colour`, expected `at` or `copies`");
        assert_eq!(remedy, "remove the line, or name one that is known here: \"at\", \"copies\"");
    }
}
