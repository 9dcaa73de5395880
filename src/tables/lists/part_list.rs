//! Lists of parts and of their copies: by state or name, by build, by order, and waiting parts.

use std::collections::BTreeMap;

use anyhow::Result;
use farm::{BuildFact, CakePart, CopyWord, MachinePlan, build_of_copy, copy_fact, read_part_facts, said_state};
use language::say;
use ledger::{BuildId, Ledger, LineCopies, PartRow, PlacementRow, RefusalCause};
use serde::Serialize;

use crate::tables::{
    columns::{cell_value::CellValue, table_column::TableColumn, time_view::GivenDate},
    fields,
    lists::order_list::line_copies_text,
};

/// A part in a list of parts, and how far it is.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedPart {
    /// The part.
    pub part: PartRow,
    /// How far it is.
    pub word: String,
}

impl ListedPart {
    /// Parts with how far each is according to the plans of the machines.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn of_plans(ledger: &Ledger, parts: Vec<PartRow>, plans: &[MachinePlan]) -> Result<Vec<Self>> {
        let states: Vec<_> = parts.iter().map(|part| (part.id, part.state)).collect();
        let mut facts = read_part_facts(ledger, &states, plans).await?;
        let listed = |part: PartRow| Self { word: facts.remove(&part.id).unwrap_or_default(), part };
        Ok(parts.into_iter().map(listed).collect())
    }

    /// A part that is not built.
    pub fn unbuilt(part: PartRow) -> Self {
        Self { word: said_state(&part.state.to_string()).to_owned(), part }
    }
}

/// A part in a list that counts some of its copies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CountedPart {
    /// The part.
    pub part: PartRow,
    /// The number of its copies that the list counts.
    pub copies: u32,
    /// The numbers of its copies, from 1, that were told bad in the shown build.
    pub bad: Vec<u32>,
}

/// Numbers of bad copies that a cell names.
const MAX_NUMBERS: usize = 12;

impl CountedPart {
    /// A part of which no copy was told bad.
    pub fn new(part: PartRow, copies: u32) -> Self {
        Self { part, copies, bad: Vec::new() }
    }

    /// A part with what was told of its copies in a build.
    pub fn of_build(part: PartRow, copies: u32, placements: &[PlacementRow]) -> Self {
        let bad = placements.iter().filter(|placed| placed.part_id == part.id && placed.is_bad);
        let bad = bad.map(|placed| placed.copy + 1).collect();
        Self { part, copies, bad }
    }

    /// `2: copies 3, 7`; `None` = none was told bad.
    fn bad_text(&self) -> Option<String> {
        let (shown, more) = self.bad.split_at(self.bad.len().min(MAX_NUMBERS));
        let mut numbers: Vec<String> = shown.iter().map(u32::to_string).collect();
        numbers.extend((!more.is_empty()).then(|| say!("and-more", count = more.len())));
        let count = self.bad.len() as u32;
        (count > 0).then(|| say!("bad-copies-of", count = count, numbers = language::join_names(numbers)))
    }
}

/// A part with the builds that hold its copies.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderedPart {
    /// The part.
    pub part: PartRow,
    /// Its copies in builds.
    pub placed: Vec<PlacedCopy>,
    /// What became of its copies.
    pub copies: LineCopies,
}

/// A copy that was taken into a build, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacedCopy {
    /// Where it stands.
    #[serde(flatten)]
    pub placed: PlacementRow,
    /// What became of it.
    pub copy_state: CopyWord,
    /// How far its build is.
    #[serde(flatten)]
    pub build: BuildFact,
}

impl PlacedCopy {
    /// What became of copies according to the plans of the machines.
    pub fn of_plans(placements: Vec<PlacementRow>, plans: &[MachinePlan]) -> Vec<Self> {
        let fact = |placed: PlacementRow| Self {
            copy_state: copy_fact(&placed, plans),
            build: build_of_copy(&placed, plans),
            placed,
        };
        placements.into_iter().map(fact).collect()
    }
}

/// Copies of a part that are together in a build and of which the same became: `16 in build 4, in the queue`.
#[derive(Debug, Clone, PartialEq)]
pub struct CopyGroup {
    /// The first of them.
    pub first: PlacedCopy,
    /// How many they are.
    pub copies: u32,
}

impl CopyGroup {
    /// The groups of copies, in the order of their first ones.
    pub fn of_copies(copies: &[PlacedCopy]) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for copy in copies {
            let is_same = |group: &&mut Self| {
                group.first.placed.build_id == copy.placed.build_id && group.first.copy_state == copy.copy_state
            };
            match groups.iter_mut().find(is_same) {
                Some(group) => group.copies += 1,
                None => groups.push(Self { first: copy.clone(), copies: 1 }),
            }
        }
        groups
    }
}

/// Parts with a given state or name.
pub const PART_COLUMNS: &[TableColumn<ListedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.part.machine).into()),
    TableColumn::new("state", fields::STATE, |row| CellValue::State(row.word.clone())),
    TableColumn::new("copies", fields::COPIES, |row| copies_cell(&row.part)),
    TableColumn::new("priority", fields::PRIORITY, |row| row.part.terms.priority.into()),
    TableColumn::new("due_at", fields::DUE, |row| GivenDate::of_terms(&row.part.terms).into()),
    TableColumn::new("order", fields::ORDER, |row| CellValue::Order(row.part.terms.order_name.clone())),
    TableColumn::new("name", fields::NAME, |row| CellValue::NamedPart(row.part.id, row.part.full_name())),
    TableColumn::for_people("reason_or_warning", fields::REASON_OR_WARNING, |row| reason_or_warning(&row.part)),
];

/// Parts of a build.
pub const BUILD_PART_COLUMNS: &[TableColumn<CountedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| CellValue::NamedPart(row.part.id, row.part.full_name())),
    TableColumn::new("order", fields::ORDER, |row| CellValue::Order(row.part.terms.order_name.clone())),
    TableColumn::new("state", fields::STATE, |row| row.part.state.into()),
    TableColumn::for_people("copies_here", fields::COPIES_HERE, |row| row.copies.into()),
    TableColumn::new("copies", fields::COPIES_OF, |row| copies_cell(&row.part)),
    TableColumn::for_people("bad", fields::BAD_COPIES, |row| row.bad_text().into()),
    TableColumn::new("due_at", fields::DUE, |row| GivenDate::of_terms(&row.part.terms).into()),
    TableColumn::for_people("reason_or_warning", fields::REASON_OR_WARNING, |row| reason_or_warning(&row.part)),
];

/// Parts that an open build is made for, in waiting order.
pub const WAITING_PART_COLUMNS: &[TableColumn<CountedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| row.part.full_name().into()),
    TableColumn::new("order", fields::ORDER, |row| CellValue::Order(row.part.terms.order_name.clone())),
    TableColumn::for_people("copies_waiting", fields::COPIES_WAITING, |row| row.copies.into()),
    TableColumn::new("copies", fields::COPIES_OF, |row| copies_cell(&row.part)),
];

/// Parts of an order or a file name, with the builds that contain them.
pub const ORDERED_PART_COLUMNS: &[TableColumn<OrderedPart>] = &[
    TableColumn::new("part", fields::PART, |row| row.part.id.into()),
    TableColumn::new("name", fields::NAME, |row| row.part.full_name().into()),
    TableColumn::new("machine", fields::MACHINE, |row| (&row.part.machine).into()),
    TableColumn::for_people("copies", fields::COPIES_NOW, |row| {
        line_copies_text(row.part.is_number_known(), &row.copies).into()
    }),
    TableColumn::new("due_at", fields::DUE, |row| GivenDate::of_terms(&row.part.terms).into()),
    TableColumn::for_people("where", fields::WHERE, where_or_why),
];

/// Parts of a build that may be known only from its file.
pub const CAKE_PART_COLUMNS: &[TableColumn<CakePart>] = &[
    TableColumn::new("name", fields::NAME, |part| (&part.name).into()),
    TableColumn::new("order", fields::ORDER, |part| (&part.order).into()),
    TableColumn::for_people("copies_here", fields::COPIES_HERE, |part| part.copies.len().into()),
    TableColumn::new("due", fields::DUE, |part| (&part.due).into()),
    TableColumn::new("note", fields::NOTE, |part| (&part.note).into()),
    TableColumn::new("reference", fields::REFERENCE, |part| (&part.reference).into()),
];

/// The columns of a page of parts, by their keys.
pub const PART_PAGE_KEYS: [&str; 7] = ["name", "order", "state", "copies", "due_at", "machine", "reason_or_warning"];
/// The columns of a page with the parts of a build, by their keys.
pub const BUILD_PART_PAGE_KEYS: [&str; 8] =
    ["name", "order", "copies_here", "copies", "bad", "due_at", "part", "reason_or_warning"];

/// The columns of copies that are together in a build and of which the same became.
pub const COPY_GROUP_COLUMNS: &[TableColumn<CopyGroup>] = &[
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("build", fields::BUILD, |row| {
        CellValue::BuildWithPart(row.first.placed.build_id, row.first.placed.part_id)
    }),
    TableColumn::for_people("copy_state", fields::STATE, |row| {
        CellValue::State(row.first.copy_state.word().to_owned())
    }),
    TableColumn::new("ends_at", fields::UNPACKED, |row| CellValue::estimate(row.first.build.ends_at)),
];

/// How many copies of a part are wanted, unless nobody said.
fn copies_cell(part: &PartRow) -> CellValue {
    if part.is_number_known() { part.wanted_copies().into() } else { say!("not-known").into() }
}

/// How many copies of a part are wanted, for its own sheet.
pub fn wanted_text(part: &PartRow) -> String {
    if part.is_number_known() { part.wanted_copies().to_string() } else { say!("not-known-taken-as-one") }
}

/// Why a part was refused; otherwise what it waits for and its warnings.
fn reason_or_warning(part: &PartRow) -> CellValue {
    if !part.refused.reason.is_empty() {
        let reasons = part.refused.reason.lines().map(|reason| RefusalCause::introduce(part.refused.refusal, reason));
        return CellValue::Prose(language::join_sentences(reasons));
    }
    let asked = Some(part.owed.question.trim_end_matches('.')).filter(|asked| !asked.is_empty());
    // What is asked was a warning before.
    let warnings = part.told_warnings().filter(|line| asked.is_none() || intake::read_print_question(line).is_none());
    let asked = asked.map(|asked| say!("waits-for-yes-to", question = language::told(asked)));
    let awaits = part.owed.awaits_material.then(|| awaited_material(part));
    CellValue::Prose(language::join_sentences(asked.into_iter().chain(awaits).chain(warnings.map(language::told))))
}

fn awaited_material(part: &PartRow) -> String {
    say!("waits-for-material", material = &part.terms.material, machine = &part.machine)
}

fn where_or_why(row: &OrderedPart) -> CellValue {
    match row.part.refused.reason.as_str() {
        "" if row.part.owed.awaits_material => {
            format!("{}; {}", whereabouts(&row.placed), awaited_material(&row.part)).into()
        }
        "" => whereabouts(&row.placed).into(),
        reason => CellValue::Prose(RefusalCause::introduce(row.part.refused.refusal, reason)),
    }
}

/// `2 in build 3 (in the queue), 1 in build 4 (being made)`.
pub fn whereabouts(placed: &[PlacedCopy]) -> String {
    let mut builds: BTreeMap<(BuildId, &str), u32> = BTreeMap::new();
    for copy in placed {
        let state = match copy.copy_state {
            CopyWord::InBuild => &copy.build.word,
            word => word.word(),
        };
        *builds.entry((copy.placed.build_id, state)).or_default() += 1;
    }
    let texts: Vec<String> = builds
        .iter()
        .map(|((id, state), n)| {
            say!("in-build-state", copies = *n, build = id.to_string(), state = language::say_word("state", state))
        })
        .collect();
    if texts.is_empty() { say!("none-in-build") } else { language::join_names(texts) }
}
