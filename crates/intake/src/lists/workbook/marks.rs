//! Rows of a workbook that people took back without deleting them: hidden by hand or by a filter, or struck through.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    io::{Cursor, Read},
};

use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};
use zip::ZipArchive;

/// How a row is marked, as its cells cannot say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowMark {
    /// It cannot be seen.
    Hidden,
    /// A text in it is struck through, whole or in part.
    Struck,
}

impl RowMark {
    /// What is written into a cell of its own behind the row.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Hidden => "hidden row",
            Self::Struck => "struck through",
        }
    }
}

/// The marked rows of each sheet, by its name and counted from 0. What cannot be read has no marks: the cells are read by another
/// reader, which says what is damaged.
pub(super) fn row_marks(bytes: &[u8]) -> HashMap<String, BTreeMap<u32, RowMark>> {
    let Some(mut package) = ZipArchive::new(Cursor::new(bytes)).ok() else { return HashMap::new() };
    let mut text = |path: &str| {
        let mut text = String::new();
        package.by_name(path).ok()?.read_to_string(&mut text).ok()?;
        Some(text)
    };
    let styles = text("xl/styles.xml").map_or_else(BTreeSet::new, |text| struck_formats(&text));
    let shared = text("xl/sharedStrings.xml").map_or_else(BTreeSet::new, |text| struck_texts(&text));
    let (Some(book), Some(relations)) = (text("xl/workbook.xml"), text("xl/_rels/workbook.xml.rels")) else {
        return HashMap::new();
    };
    let targets: HashMap<String, String> = elements(&relations, "Relationship")
        .filter_map(|relation| Some((attribute(&relation, "Id")?, attribute(&relation, "Target")?)))
        .collect();
    let mut marks = HashMap::new();
    for sheet in elements(&book, "sheet") {
        let target = attribute(&sheet, "id").and_then(|id| targets.get(&id));
        let (Some(name), Some(target)) = (attribute(&sheet, "name"), target) else { continue };
        let path = target.strip_prefix('/').map_or_else(|| format!("xl/{target}"), str::to_owned);
        marks.insert(name, text(&path).map_or_else(BTreeMap::new, |text| marked_rows(&text, &styles, &shared)));
    }
    marks
}

/// The events of a document, up to what is damaged.
fn events(text: &str) -> impl Iterator<Item = Event<'_>> {
    let mut reader = Reader::from_str(text);
    std::iter::from_fn(move || reader.read_event().ok().filter(|event| !matches!(event, Event::Eof)))
}

/// The elements of this name, without their prefix.
fn elements<'t>(text: &'t str, name: &'static str) -> impl Iterator<Item = BytesStart<'t>> {
    events(text).filter_map(move |event| match event {
        Event::Start(element) | Event::Empty(element) if element.local_name().as_ref() == name => Some(element),
        _ => None,
    })
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = element.attributes().flatten().find(|one| one.key.local_name().as_ref() == name)?;
    Some(found.normalized_value(XmlVersion::Implicit1_0).ok()?.into_owned())
}

fn is_true(value: Option<String>, unsaid: bool) -> bool {
    value.map_or(unsaid, |value| !matches!(value.as_str(), "0" | "false" | "none"))
}

fn is_strike(element: &BytesStart<'_>) -> bool {
    element.local_name().as_ref() == "strike" && is_true(attribute(element, "val"), true)
}

/// The numbers of the cell formats whose font is struck through.
fn struck_formats(styles: &str) -> BTreeSet<u32> {
    let (mut fonts, mut formats) = (BTreeSet::new(), BTreeSet::new());
    let (mut font, mut format) = (0_u32, 0_u32);
    let (mut in_fonts, mut in_formats) = (false, false);
    for event in events(styles) {
        match event {
            Event::Start(element) | Event::Empty(element) => match element.local_name().as_ref() {
                "fonts" => in_fonts = true,
                "cellXfs" => in_formats = true,
                "font" if in_fonts => font += 1,
                "strike" if in_fonts && is_strike(&element) => _ = fonts.insert(font.saturating_sub(1).to_string()),
                "xf" if in_formats => {
                    if attribute(&element, "fontId").is_some_and(|id| fonts.contains(&id)) {
                        formats.insert(format);
                    }
                    format += 1;
                }
                _ => {}
            },
            Event::End(element) => match element.local_name().as_ref() {
                "fonts" => in_fonts = false,
                "cellXfs" => in_formats = false,
                _ => {}
            },
            _ => {}
        }
    }
    formats
}

/// The numbers of the shared texts of which a piece is struck through.
fn struck_texts(shared: &str) -> BTreeSet<u32> {
    let (mut struck, mut at) = (BTreeSet::new(), 0_u32);
    for event in events(shared) {
        match event {
            Event::Start(element) | Event::Empty(element) if is_strike(&element) => _ = struck.insert(at),
            Event::End(element) if element.local_name().as_ref() == "si" => at += 1,
            Event::Empty(element) if element.local_name().as_ref() == "si" => at += 1,
            _ => {}
        }
    }
    struck
}

/// The rows of a sheet that are hidden, or hold a text that is struck through.
fn marked_rows(sheet: &str, styles: &BTreeSet<u32>, shared: &BTreeSet<u32>) -> BTreeMap<u32, RowMark> {
    let mut marks = BTreeMap::new();
    let (mut row, mut is_hidden) = (0_u32, false);
    let (mut is_struck, mut is_shared, mut is_value, mut has_text) = (false, false, false, false);
    for event in events(sheet) {
        match event {
            Event::Start(element) => match element.local_name().as_ref() {
                "row" => {
                    row = attribute(&element, "r").and_then(|row| row.parse().ok()).unwrap_or(row + 1);
                    is_hidden = is_true(attribute(&element, "hidden"), false);
                }
                "c" => {
                    let style = attribute(&element, "s").and_then(|style| style.parse().ok());
                    is_struck = style.is_some_and(|style| styles.contains(&style));
                    is_shared = attribute(&element, "t").as_deref() == Some("s");
                    has_text = false;
                }
                "v" | "t" => (is_value, has_text) = (element.local_name().as_ref() == "v", true),
                _ => is_struck |= is_strike(&element),
            },
            Event::Empty(element) => is_struck |= is_strike(&element),
            Event::Text(text) if is_value && is_shared => {
                let number = text.trim().parse().ok();
                is_struck |= number.is_some_and(|number| shared.contains(&number));
            }
            Event::End(element) => match element.local_name().as_ref() {
                "v" => is_value = false,
                "c" if has_text && is_hidden => _ = marks.insert(row.saturating_sub(1), RowMark::Hidden),
                "c" if has_text && is_struck => {
                    marks.entry(row.saturating_sub(1)).or_insert(RowMark::Struck);
                }
                _ => {}
            },
            _ => {}
        }
    }
    marks
}
