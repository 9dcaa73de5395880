//! Turns what the TOML reader complains of into words for an operator: (what is wrong, what to do).

/// About a text that is no TOML.
pub(super) fn of_syntax(message: &str) -> (String, String) {
    (
        format!("is not valid TOML: {}", message.replace('\n', ", ")),
        "correct the line; strings need quotes, as in root = \"/srv/nestd\"".into(),
    )
}

/// About the value at `key` that does not fit.
pub(super) fn of_value(key: &str, message: &str) -> (String, String) {
    let quoted = in_backticks(message);
    if message.starts_with("unknown field") {
        let (unknown, known) = quoted.split_first().unwrap_or((&"", &[]));
        return (format!("unknown option \"{key}\""), did_you_mean(unknown, known));
    }
    if message.starts_with("unknown variant") {
        let (value, known) = quoted.split_first().unwrap_or((&"", &[]));
        return (format!("{key} cannot be \"{value}\""), format!("use one of {}", listed(known)));
    }
    let (what, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    let remedy = match expected {
        "" => "correct the value".to_owned(),
        expected => format!("give {}", kind_in_words(expected)),
    };
    (format!("{key}: {what}"), remedy)
}

/// What a Rust type is called by people.
fn kind_in_words(expected: &str) -> &str {
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

fn did_you_mean(unknown: &str, known: &[&str]) -> String {
    let near = known.iter().map(|name| (edits(unknown, name), *name)).min();
    match near {
        Some((edits, name)) if edits <= 1 + unknown.chars().count() / 3 => format!("did you mean \"{name}\"?"),
        _ => format!("known here: {}", listed(known)),
    }
}

fn listed(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

fn in_backticks(message: &str) -> Vec<&str> {
    message.split('`').skip(1).step_by(2).collect()
}

/// Least number of letters to insert, delete or replace to turn `a` into `b` (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
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
        assert_eq!(edits("settle_sec", "settle_secs"), 1);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
    }

    #[test]
    fn an_unknown_option_is_told_with_the_nearest_known_one() {
        let (text, remedy) =
            of_value("trigger.copys", "unknown field `copys`, expected one of `copies`, `at`, `max_wait_secs`");
        assert_eq!(text, "unknown option \"trigger.copys\"");
        assert_eq!(remedy, "did you mean \"copies\"?");
    }

    #[test]
    fn an_option_like_no_other_is_told_with_all_known_ones() {
        let (_, remedy) = of_value("colour", "unknown field `colour`, expected `at` or `copies`");
        assert_eq!(remedy, "known here: \"at\", \"copies\"");
    }
}
