//! Looks up a build, a part or an order, with everything that the ledger knows about it.

use std::collections::BTreeSet;

use anyhow::Result;
use farm::{BuildFact, DatedOrder, MachinePlan, MaterialReading, PartQuestion, build_fact, copy_counts, customer_note};
use jiff::Timestamp;
use ledger::{
    BuildId, BuildRow, BuildState, EventRow, Ledger, LineCopies, OrderSummary, OutcomeRow, PartId, PartRow,
    PlacementRow,
};
use serde::Serialize;
use settings::{FarmZone, MachineProfile, Materials};

use super::values::parse_prefixed_number;
use crate::tables::{CountedPart, PlacedCopy};

/// What the user wants to see. A bare number or name may match a build, a part, an order and a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LookupQuery {
    /// A build number.
    build: Option<i64>,
    /// A part number.
    part: Option<i64>,
    /// A name of an order.
    order: Option<String>,
    /// A name of a file as dropped.
    file: Option<String>,
}

/// Everything that was found.
#[derive(Debug, Default, Serialize)]
pub struct LookupResult {
    /// A build.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub build: Option<BuildDetails>,
    /// A part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<PartDetails>,
    /// How an order stands, with what its customer can be told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_sheet: Option<OrderDetails>,
    /// The parts of an order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub order: Vec<PartDetails>,
    /// The parts of a file name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub named: Vec<PartDetails>,
}

/// How an order stands.
#[derive(Debug, Serialize)]
pub struct OrderDetails {
    /// Its row and its copies, with when it is done.
    #[serde(flatten)]
    pub dated: DatedOrder,
    /// What can be sent to its customer.
    pub customer_note: String,
}

/// A build with all that belongs to it.
#[derive(Debug, Serialize)]
pub struct BuildDetails {
    /// Its row.
    pub build: BuildRow,
    /// How far it is.
    #[serde(flatten)]
    pub fact: BuildFact,
    /// The path where its file was published; the printer may have taken it since.
    pub file: Option<std::path::PathBuf>,
    /// Its machine as it was then, where the configuration or the build knows it.
    #[serde(skip)]
    pub machine: Option<MachineProfile>,
    /// Its parts.
    pub parts: Vec<PartRow>,
    /// The waiting parts of an open build: an open build takes no copies before it fires.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub waiting: Vec<CountedPart>,
    /// Its copies with their poses.
    pub placements: Vec<PlacementRow>,
    /// Its recorded outcomes.
    pub outcomes: Vec<OutcomeRow>,
    /// What happened to it.
    pub events: Vec<EventRow>,
}

/// A part with all that belongs to it.
#[derive(Debug, Serialize)]
pub struct PartDetails {
    /// Its row.
    pub part: PartRow,
    /// What became of its copies.
    pub copies: LineCopies,
    /// What is asked of it.
    pub questions: Vec<PartQuestion>,
    /// Where its copies are.
    pub placements: Vec<PlacedCopy>,
    /// What happened to it.
    pub events: Vec<EventRow>,
}

impl LookupQuery {
    /// Parses the words of the command line.
    pub fn from_words(words: &[String]) -> Self {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["build", n] if parse_prefixed_number(n, 'b').is_some() => {
                Self { build: parse_prefixed_number(n, 'b'), ..Self::default() }
            }
            ["part", n] if parse_prefixed_number(n, 'p').is_some() => {
                Self { part: parse_prefixed_number(n, 'p'), ..Self::default() }
            }
            ["part", name @ ..] if !name.is_empty() => Self { file: Some(name.join(" ")), ..Self::default() },
            ["order", name @ ..] if !name.is_empty() => Self { order: Some(name.join(" ")), ..Self::default() },
            [word] => Self {
                build: parse_prefixed_number(word, 'b'),
                part: parse_prefixed_number(word, 'p'),
                order: Some((*word).to_owned()),
                file: Some((*word).to_owned()),
            },
            words => Self { order: Some(words.join(" ")), file: Some(words.join(" ")), ..Self::default() },
        }
    }
}

impl LookupResult {
    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.build.is_none() && self.part.is_none() && self.order.is_empty() && self.named.is_empty()
    }
}

/// Finds everything in the ledger with that number or name, and what is so of it according to the plans of the machines.
pub async fn look_up(
    ledger: &Ledger,
    wanted: &LookupQuery,
    plans: &[MachinePlan],
    (zone, materials): (&FarmZone, &Materials),
) -> Result<LookupResult> {
    let mut found = LookupResult::default();
    let materials = &MaterialReading::read(ledger, materials).await?;
    if let Some(number) = wanted.build {
        found.build = read_build_details(ledger, BuildId(number), plans).await?;
    }
    if let Some(number) = wanted.part
        && let Some(part) = ledger.find_part(PartId(number)).await?
    {
        found.part = Some(read_part_details(ledger, part, (plans, materials)).await?);
    }
    if let Some(name) = &wanted.order {
        for part in ledger.parts_of_order(name).await? {
            found.order.push(read_part_details(ledger, part, (plans, materials)).await?);
        }
        found.order_sheet = read_order_details(ledger, name, plans, zone).await?;
    }
    if let Some(name) = &wanted.file {
        for part in ledger.parts_named(name).await? {
            found.named.push(read_part_details(ledger, part, (plans, materials)).await?);
        }
    }
    Ok(found)
}

/// The builds that hold copies of the matching orders and parts.
pub async fn find_builds(ledger: &Ledger, wanted: &LookupQuery) -> Result<Vec<BuildId>> {
    let wanted = LookupQuery { build: None, ..wanted.clone() };
    let found = look_up(ledger, &wanted, &[], (&FarmZone::default(), &Materials::default())).await?;
    let sheets = found.part.iter().chain(&found.order).chain(&found.named);
    let builds: BTreeSet<BuildId> =
        sheets.flat_map(|sheet| sheet.placements.iter().map(|copy| copy.placed.build_id)).collect();
    Ok(builds.into_iter().collect())
}

async fn read_order_details(
    ledger: &Ledger,
    name: &str,
    plans: &[MachinePlan],
    zone: &FarmZone,
) -> Result<Option<OrderDetails>> {
    let Some(order) = ledger.find_order(name).await? else { return Ok(None) };
    let (summary, now) = (OrderSummary::of_lines(order, &ledger.order_lines(name).await?), Timestamp::now());
    let dated = DatedOrder::of_plans(summary, plans, now);
    Ok(Some(OrderDetails { customer_note: customer_note(&dated, zone, now), dated }))
}

async fn read_build_details(ledger: &Ledger, id: BuildId, plans: &[MachinePlan]) -> Result<Option<BuildDetails>> {
    let Some(build) = ledger.find_build(id).await? else { return Ok(None) };
    let line = match build.state {
        BuildState::Open => ledger.waiting_copies(&build.machine).await?,
        _ => Vec::new(),
    };
    Ok(Some(BuildDetails {
        fact: build_fact(&build, plans),
        build,
        file: None,
        machine: None,
        parts: ledger.parts_of_build(id).await?,
        waiting: line.into_iter().map(|w| CountedPart::new(w.part, w.copies.len() as u32)).collect(),
        placements: ledger.placements_of_build(id).await?,
        outcomes: ledger.outcomes_of_build(id).await?,
        // Events of its parts are left out: the parts are listed.
        events: ledger.events_of_build(id).await?.into_iter().filter(|e| e.part_id.is_none()).collect(),
    }))
}

async fn read_part_details(
    ledger: &Ledger,
    part: PartRow,
    (plans, materials): (&[MachinePlan], &MaterialReading),
) -> Result<PartDetails> {
    let events = ledger.events_of_part(part.id).await?;
    let placements = PlacedCopy::of_plans(ledger.placements_of_part(part.id).await?, plans);
    let copies = copy_counts(&ledger.line_of_part(part.id).await?.copies, plans, |planned| planned.part == part.id);
    let questions = PartQuestion::of_part(&part, materials);
    Ok(PartDetails { part, copies, questions, placements, events })
}
