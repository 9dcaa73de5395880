//! The sheets of `nestd show` for people.

use std::collections::BTreeMap;

use build_file::visible;

use super::{
    lookup::{BuildSheet, Found, PartSheet, Waits},
    reach::{brief, zoned},
    table::{Table, number, or_dash, percent, text},
};
use crate::ledger::{BuildId, BuildRow, BuildState, EventRow, PartRow, PlacementRow};

/// Everything that was found.
pub fn found(found: &Found) -> String {
    let mut sheets = Vec::new();
    sheets.extend(found.build.as_ref().map(build));
    sheets.extend(found.part.as_ref().map(part));
    if let Some(first) = found.order.first() {
        let name = &first.part.order_name;
        sheets.push(format!("Order {name}\n\n{}", parts(&found.order)));
    }
    match found.named.as_slice() {
        [] => {}
        [one] => sheets.push(part(one)),
        [first, ..] => sheets.push(format!("Parts named {}\n\n{}", first.part.name, parts(&found.named))),
    }
    sheets.join("\n")
}

fn build(sheet: &BuildSheet) -> String {
    let row = &sheet.build;
    let mut lines = build_lines(sheet);
    lines.push((
        "file",
        sheet.file.as_ref().map_or_else(|| or_dash(row.file_name.as_ref()), |f| f.display().to_string()),
    ));
    if let Some(hash) = &row.file_hash {
        lines.push(("content", format!("{} bytes, BLAKE3 {hash}", or_dash(row.file_bytes))));
    }
    let mut sheet_text = format!("Build {} of {}: {}\n{}", row.id, row.profile, row.state, aligned(&lines));
    if !sheet.parts.is_empty() {
        sheet_text += &format!("\n{}", parts_in_build(sheet));
    }
    if !sheet.waiting.is_empty() {
        sheet_text += &format!("\n{}", parts_that_wait(&sheet.waiting));
    }
    if !sheet.outcomes.is_empty() {
        let mut table = Table::new(&["TOLD (UTC)", "OUTCOME", "BY", "NOTE"]);
        for told in &sheet.outcomes {
            let cells = [brief(Some(told.told_at)), told.outcome.to_string(), told.told_by.clone(), text(&told.note)];
            table.row(cells.to_vec());
        }
        sheet_text += &format!("\n{table}");
    }
    sheet_text + &events(&sheet.events)
}

fn build_lines(sheet: &BuildSheet) -> Vec<(&'static str, String)> {
    let row = &sheet.build;
    let mut lines = vec![
        (
            "height",
            format!(
                "{} mm, no build of these parts is below {} mm",
                number(row.height_mm, 2),
                number(row.lower_bound_mm, 2)
            ),
        ),
        ("layers", or_dash(row.layers)),
        ("density", format!("{} %", percent(row.density))),
        ("copies", format!("{}, {} cm3", copies_of(sheet), number(row.part_volume_mm3.map(|v| v / 1000.0), 2))),
        (
            "clearance",
            format!("{} mm asked, {} mm proved", number(row.clearance_mm, 2), number(row.clearance_proved_mm, 3)),
        ),
        ("search", search(row)),
        (
            "fired by",
            format!(
                "{}, nested {}",
                text(&row.fired_by),
                if row.attempts == 1 { "once".to_owned() } else { format!("{} times", row.attempts) }
            ),
        ),
        ("opened", zoned(Some(row.opened_at))),
        ("nesting", zoned(row.nesting_at)),
        ("verified", zoned(row.verified_at)),
        ("published", zoned(row.published_at)),
    ];
    if !row.reason.is_empty() {
        lines.insert(0, ("reason", row.reason.clone()));
    }
    lines
}

/// How many copies are in a build; an open one has a forecast and takes none.
fn copies_of(sheet: &BuildSheet) -> String {
    match sheet.build.state {
        BuildState::Open => {
            let waiting: usize = sheet.waiting.iter().map(|w| w.copies).sum();
            format!("{} in the layout so far, {waiting} wait", sheet.build.copies.unwrap_or(0))
        }
        _ => or_dash(sheet.build.copies),
    }
}

fn search(row: &BuildRow) -> String {
    format!(
        "{}, seed {}, {} evaluations, {} CPU s, {} wall s, nestd {}",
        or_dash(row.method.as_ref()),
        or_dash(row.seed),
        or_dash(row.evaluations),
        number(row.cpu_secs, 1),
        number(row.wall_secs, 1),
        or_dash(row.version.as_ref())
    )
}

/// The parts of a build with how many of their copies are in it and how high these stand.
fn parts_in_build(sheet: &BuildSheet) -> Table {
    let mut table = Table::new(&[">PART", "NAME", "ORDER", "STATE", ">COPIES HERE", ">OF"]);
    for part in &sheet.parts {
        let here = sheet.placements.iter().filter(|p| p.part_id == part.id).count();
        table.row(vec![
            part.id.to_string(),
            part.full_name(),
            text(&part.order_name),
            part.state.to_string(),
            here.to_string(),
            part.copies.to_string(),
        ]);
    }
    table
}

/// The parts that an open build is made for, in their order in line.
fn parts_that_wait(waiting: &[Waits]) -> Table {
    let mut table = Table::new(&[">PART", "NAME", "ORDER", ">COPIES WAITING", ">OF"]);
    for Waits { part, copies } in waiting {
        let of = part.copies.to_string();
        table.row(vec![part.id.to_string(), part.full_name(), text(&part.order_name), copies.to_string(), of]);
    }
    table
}

fn part(sheet: &PartSheet) -> String {
    let row = &sheet.part;
    let size =
        row.size_mm().map(|[x, y, z]| format!("{x:.2} x {y:.2} x {z:.2} mm, {} triangles", or_dash(row.triangles)));
    let mut lines = vec![
        ("profile", row.profile.clone()),
        ("order", text(&row.order_name)),
        ("copies", format!("{}, {}", row.copies, whereabouts(&sheet.placements))),
        ("priority", row.priority.to_string()),
        ("due", zoned(row.due_at)),
        ("orientation", orientation(row)),
        ("size", or_dash(size)),
        ("volume", format!("{} cm3", number(row.volume_mm3.map(|v| v / 1000.0), 2))),
        ("content", format!("{} bytes, BLAKE3 {}", row.bytes, row.content_hash)),
        ("claimed", zoned(Some(row.claimed_at))),
    ];
    if let Some(clearance_mm) = row.clearance_mm {
        lines.insert(6, ("clearance", format!("{clearance_mm} mm, as its ticket says")));
    }
    lines.extend(
        [("note", row.note.clone()), ("reason", row.reason.clone())].into_iter().filter(|(_, t)| !t.is_empty()),
    );
    lines.extend(row.warnings.lines().map(|warning| ("warning", warning.to_owned())));
    format!("Part {}, {}: {}\n{}{}", row.id, row.full_name(), row.state, aligned(&lines), events(&sheet.events))
}

fn orientation(row: &PartRow) -> String {
    let tilts = row.tilts.0.iter().map(|tilt| format!(", {}", tilt.in_words()));
    format!("{:?}", row.orientation).to_lowercase() + &tilts.collect::<String>()
}

/// '2 in build 3 (published), 1 in build 4 (nesting)'.
fn whereabouts(placements: &[PlacementRow]) -> String {
    let mut builds: BTreeMap<BuildId, (String, u32)> = BTreeMap::new();
    for placement in placements {
        builds.entry(placement.build_id).or_insert_with(|| (placement.build_state.to_string(), 0)).1 += 1;
    }
    let told: Vec<String> = (builds.iter()).map(|(id, (state, n))| format!("{n} in build {id} ({state})")).collect();
    if told.is_empty() { "none in a build".to_owned() } else { told.join(", ") }
}

fn parts(sheets: &[PartSheet]) -> Table {
    let mut table = Table::new(&[">PART", "NAME", "PROFILE", "STATE", ">COPIES", ">PUBLISHED", "DUE (UTC)", "WHERE"]);
    for sheet in sheets {
        let part = &sheet.part;
        let published = sheet.placements.iter().filter(|p| p.published_at.is_some()).count();
        table.row(vec![
            part.id.to_string(),
            part.full_name(),
            part.profile.clone(),
            part.state.to_string(),
            part.copies.to_string(),
            published.to_string(),
            brief(part.due_at),
            if part.reason.is_empty() { whereabouts(&sheet.placements) } else { part.reason.clone() },
        ]);
    }
    table
}

fn events(events: &[EventRow]) -> String {
    let mut table = Table::new(&["EVENT (UTC)", "KIND", ">BUILD", "DETAIL"]);
    for event in events {
        let cells = [brief(Some(event.at)), event.kind.clone(), or_dash(event.build_id), event.detail.clone()];
        table.row(cells.to_vec());
    }
    if table.is_empty() { String::new() } else { format!("\n{table}") }
}

fn aligned(lines: &[(&str, String)]) -> String {
    lines.iter().map(|(name, value)| format!("  {name:<12}{}\n", visible(value))).collect()
}
