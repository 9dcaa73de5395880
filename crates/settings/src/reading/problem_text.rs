//! Converts errors of the TOML parser to messages for operators: (what is wrong, what to do).

/// Message about text that is not valid TOML, on this line of the file.
pub(super) fn syntax_problem_text(message: &str, line: &str) -> (String, String) {
    if let Some((key, number)) = decimal_comma(line) {
        let remedy = format!("write a point: {key} = {}", number.replace(',', "."));
        return (format!("{key} = {number} has a comma in a number"), remedy);
    }
    (
        format!("is not valid TOML: {}", message.replace('\n', ", ")),
        "correct the line; strings need quotes, as in root = \"/srv/nestd\"".into(),
    )
}

/// Key and number of a line such as `clearance_mm = 2,5`.
fn decimal_comma(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.split_once('=')?;
    let value = value.split('#').next().unwrap_or_default().trim();
    is_comma_number(value).then_some((key.trim(), value))
}

fn is_comma_number(text: &str) -> bool {
    let is_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let unsigned = text.strip_prefix(['-', '+']).unwrap_or(text);
    unsigned.split_once(',').is_some_and(|(whole, rest)| is_digits(whole) && is_digits(rest))
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
    let remedy = match (expected, what.split('"').nth(1)) {
        ("", _) => "correct the value".to_owned(),
        (_, Some(text)) if expected == "f64" && is_comma_number(text) => {
            format!("write a point, and no quotes: {}", text.replace(',', "."))
        }
        (expected, _) => format!("give {}", describe_kind(expected)),
    };
    (describe_value(key, what), remedy)
}

/// What is wrong with a value, in words for people: the parser says `invalid type: integer `5``.
fn describe_value(key: &str, what: &str) -> String {
    let Some((kind, value)) = what.strip_prefix("invalid ").and_then(|what| what.split_once(": ")) else {
        return match what.strip_prefix("invalid length ") {
            Some(length) => format!("{key} cannot have {length} values"),
            None => format!("{key}: {what}"),
        };
    };
    if !matches!(kind, "type" | "value") {
        return format!("{key}: {what}");
    }
    let value = match value {
        "sequence" => "a list",
        "map" => "a table",
        value => value
            .split_once(' ')
            .filter(|_| value.starts_with("string "))
            .map_or_else(|| words_in_backticks(value).first().copied().unwrap_or(value), |(_, text)| text),
    };
    format!("{key} cannot be {value}")
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
    fn a_number_with_a_comma_is_said_to_need_a_point() {
        let (text, remedy) = syntax_problem_text("unexpected key or value", "clearance_mm = 2,5 # mm");
        assert_eq!(
            (text.as_str(), remedy.as_str()),
            ("clearance_mm = 2,5 has a comma in a number", "write a point: clearance_mm = 2.5")
        );
        assert!(decimal_comma("volume_mm = [1,2,3]").is_none() && decimal_comma("a = 1,2,3").is_none());
        let (text, remedy) = value_problem_text("layer_mm", "invalid type: string \"0,1\", expected f64");
        assert_eq!(
            (text.as_str(), remedy.as_str()),
            ("layer_mm cannot be \"0,1\"", "write a point, and no quotes: 0.1")
        );
    }

    #[test]
    fn what_the_parser_says_is_told_in_words_for_people() {
        for (message, text, remedy) in [
            ("invalid type: integer `5`, expected a string", "note cannot be 5", "give a text in quotes"),
            (
                "invalid type: floating point `2.5`, expected u32",
                "note cannot be 2.5",
                "give a whole number, 0 or more",
            ),
            ("invalid type: boolean `true`, expected f64", "note cannot be true", "give a number"),
            ("invalid type: sequence, expected f64", "note cannot be a list", "give a number"),
            ("invalid value: integer `-5`, expected u32", "note cannot be -5", "give a whole number, 0 or more"),
            (
                "invalid length 2, expected an array of length 3",
                "note cannot have 2 values",
                "give three lengths, as in [200, 200, 200]",
            ),
        ] {
            assert_eq!(value_problem_text("note", message), (text.to_owned(), remedy.to_owned()));
        }
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
