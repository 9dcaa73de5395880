//! Tests of order lists as people write them: `samples/lists/` holds them byte for byte, `samples/lists.txt` says what each
//! must mean for the files beside it.

use std::{collections::BTreeMap, ffi::OsStr, fs, path::Path};

use super::*;
use crate::DueDate;

/// What a list must mean: by the name of a file, or by one of the words `beside`, `missing`, `warns` and `list`.
type ListMeaning = BTreeMap<String, String>;

fn samples_dir() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src/samples")
}

/// The lists with their meanings.
fn sample_lists() -> Vec<(String, ListMeaning)> {
    let text = fs::read_to_string(samples_dir().join("lists.txt")).unwrap();
    let sections = text.split("\n== ").skip(1);
    let parse = |section: &str| {
        let (head, body) = section.split_once('\n').unwrap();
        let name = head.split_whitespace().next().unwrap().to_owned();
        let lines = body.lines().filter(|line| !line.is_empty());
        let parse_line = |line: &str| {
            let (key, value) = line.split_once(": ").unwrap_or_else(|| panic!("{name}: no colon in {line:?}"));
            (key.to_owned(), value.to_owned())
        };
        (name.clone(), lines.map(parse_line).collect())
    };
    sections.map(parse).collect()
}

fn ticket_text(ticket: &Ticket) -> String {
    let mut words = vec![ticket.copies.map_or("no copies".to_owned(), |copies| copies.to_string())];
    words.extend(ticket.due.map(|due| match due {
        DueDate::Day(day) => format!("due {day}"),
        DueDate::Local(time) => format!("due {time}"),
        DueDate::At(time) => format!("due {time}"),
    }));
    words.extend(ticket.order.as_ref().map(|order| format!("order {order}")));
    words.extend(ticket.priority.map(|priority| format!("priority {priority}")));
    let orientation = ticket.orientation.map(|rule| serde_json::to_value(rule).unwrap());
    words.extend(orientation.map(|rule| rule.as_str().unwrap().to_owned()));
    words.extend(ticket.clearance_mm.map(|clearance_mm| format!("clearance {clearance_mm}")));
    words.extend(ticket.unit.map(|unit| match unit {
        build_file::LengthUnit::Millimeter => "unit mm".to_owned(),
        other => format!("unit {other:?}").to_lowercase(),
    }));
    words.extend(ticket.customer.as_ref().map(|customer| format!("customer {customer}")));
    words.extend(ticket.material.as_ref().map(|material| format!("material {material}")));
    words.extend(ticket.note.as_ref().map(|note| format!("note {}", note.replace('\n', " "))));
    words.join("; ")
}

/// Compares a list with what it must mean. Returns the differences.
fn differences(bytes: &[u8], meaning: &ListMeaning) -> Vec<String> {
    let split = |key: &str| -> Vec<&str> { meaning.get(key).map_or(Vec::new(), |all| all.split(" | ").collect()) };
    let beside = split("beside");
    let files: Vec<&OsStr> = beside.iter().map(OsStr::new).collect();
    let list = OrderList::parse_for_files(bytes, &files);
    let rows = match (list.rows(), meaning.get("list")) {
        (Err(_), None) => return vec![format!("the list is refused: {:?}", list.rows())],
        (Ok(_), Some(_)) => return vec!["the list is not refused".to_owned()],
        (Err(why), Some(expected)) => {
            let expected = expected.strip_prefix("refused ").unwrap();
            return if why.contains(expected) { Vec::new() } else { vec![format!("{why:?} is not {expected:?}")] };
        }
        (Ok(rows), None) => rows,
    };
    let matches = list.match_files(files.iter().copied());
    let mut wrong = Vec::new();
    for (&name, file) in beside.iter().zip(&files) {
        let read = match matches.files.get(*file).map(|found| list.matched_row(found, file)) {
            None => "unlisted".to_owned(),
            Some(Err(why)) => format!("refused {why}"),
            Some(Ok(row)) if OrderList::parse_single_row(&row.text).and_then(|alone| alone.ticket) != row.ticket => {
                format!("a row that means another thing alone: {:?}", row.text)
            }
            Some(Ok(row)) => ticket_text(row.ticket.as_ref().unwrap()),
        };
        let expected = meaning.get(name).map_or("", String::as_str);
        let is_right = match expected.strip_prefix("refused ") {
            Some(part) => read.starts_with("refused ") && read.contains(part),
            None => read == expected,
        };
        if !is_right {
            wrong.push(format!("{name} must mean {expected:?}, but is read as {read:?}"));
        }
    }
    let missing = |at: &usize| !rows[*at].file.is_empty() && !matches.named.contains(at);
    let missing: Vec<&str> = (0..rows.len()).filter(missing).map(|at| rows[at].file.as_str()).collect();
    if missing != split("missing") {
        wrong.push(format!("rows without a file: {missing:?}"));
    }
    if list.unknown != split("warns") {
        wrong.push(format!("unknown columns: {:?}", list.unknown));
    }
    if rows.iter().any(|row| row.file.is_empty()) {
        wrong.push("a row names no file".to_owned());
    }
    wrong
}

#[test]
fn lists_as_people_write_them_mean_what_they_must() {
    let lists = sample_lists();
    assert!(lists.len() >= 100, "only {} lists", lists.len());
    assert_eq!(lists.len(), fs::read_dir(samples_dir().join("lists")).unwrap().count());
    let mut wrong = Vec::new();
    for (name, meaning) in &lists {
        let bytes = fs::read(samples_dir().join("lists").join(name)).unwrap();
        let found = differences(&bytes, meaning);
        wrong.extend((!found.is_empty()).then(|| format!("{name}: {}", found.join("; "))));
    }
    assert!(wrong.is_empty(), "{} of {} lists are misread:\n{}", wrong.len(), lists.len(), wrong.join("\n"));
}
