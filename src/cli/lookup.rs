//! Looks up a build, a part or an order, with everything that the ledger knows of it.

use std::collections::BTreeSet;

use anyhow::Result;
use serde::Serialize;

use super::values::numbered;
use crate::{
    ledger::{BuildId, BuildRow, BuildState, EventRow, Ledger, OutcomeRow, PartId, PartRow, PlacementRow},
    settings::Profile,
    tables::CountedPart,
};

/// What somebody wants to see; a bare number or name may be several things.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wanted {
    /// A build number.
    build: Option<i64>,
    /// A part number.
    part: Option<i64>,
    /// A name of an order.
    order: Option<String>,
    /// A name of a file as dropped.
    file: Option<String>,
}

/// What was found.
#[derive(Debug, Default, Serialize)]
pub struct Found {
    /// A build.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub build: Option<BuildSheet>,
    /// A part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<PartSheet>,
    /// The parts of an order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub order: Vec<PartSheet>,
    /// The parts of a file name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub named: Vec<PartSheet>,
}

/// A build with all that belongs to it.
#[derive(Debug, Serialize)]
pub struct BuildSheet {
    /// Its row.
    pub build: BuildRow,
    /// Where its file was put; the printer may have taken it.
    pub file: Option<std::path::PathBuf>,
    /// Its machine as it was then, where the configuration or the build knows it.
    #[serde(skip)]
    pub machine: Option<Profile>,
    /// Its parts.
    pub parts: Vec<PartRow>,
    /// What waits for it while it is open: it takes no copy before it is fired.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub waiting: Vec<CountedPart>,
    /// Its copies with their poses.
    pub placements: Vec<PlacementRow>,
    /// What was told of it.
    pub outcomes: Vec<OutcomeRow>,
    /// What happened to it.
    pub events: Vec<EventRow>,
}

/// A part with all that belongs to it.
#[derive(Debug, Serialize)]
pub struct PartSheet {
    /// Its row.
    pub part: PartRow,
    /// Where its copies are.
    pub placements: Vec<PlacementRow>,
    /// What happened to it.
    pub events: Vec<EventRow>,
}

impl Wanted {
    /// From the words of the command line.
    pub fn parse(words: &[String]) -> Self {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["build", n] if numbered(n, 'b').is_some() => Self { build: numbered(n, 'b'), ..Self::default() },
            ["part", n] if numbered(n, 'p').is_some() => Self { part: numbered(n, 'p'), ..Self::default() },
            ["part", name @ ..] if !name.is_empty() => Self { file: Some(name.join(" ")), ..Self::default() },
            ["order", name @ ..] if !name.is_empty() => Self { order: Some(name.join(" ")), ..Self::default() },
            [word] => Self {
                build: numbered(word, 'b'),
                part: numbered(word, 'p'),
                order: Some((*word).to_owned()),
                file: Some((*word).to_owned()),
            },
            words => Self { order: Some(words.join(" ")), file: Some(words.join(" ")), ..Self::default() },
        }
    }
}

impl Found {
    /// Whether nothing was.
    pub fn is_empty(&self) -> bool {
        self.build.is_none() && self.part.is_none() && self.order.is_empty() && self.named.is_empty()
    }
}

/// Asks the ledger for everything of that number or name.
pub async fn look(ledger: &Ledger, wanted: &Wanted) -> Result<Found> {
    let mut found = Found::default();
    if let Some(number) = wanted.build {
        found.build = build_sheet(ledger, BuildId(number)).await?;
    }
    if let Some(number) = wanted.part
        && let Some(part) = ledger.part(PartId(number)).await?
    {
        found.part = Some(part_sheet(ledger, part).await?);
    }
    if let Some(name) = &wanted.order {
        for part in ledger.order(name).await? {
            found.order.push(part_sheet(ledger, part).await?);
        }
    }
    if let Some(name) = &wanted.file {
        for part in ledger.parts_named(name).await? {
            found.named.push(part_sheet(ledger, part).await?);
        }
    }
    Ok(found)
}

/// The builds that hold copies of the orders and parts that are wanted.
pub async fn builds_named(ledger: &Ledger, wanted: &Wanted) -> Result<Vec<BuildId>> {
    let found = look(ledger, &Wanted { build: None, ..wanted.clone() }).await?;
    let sheets = found.part.iter().chain(&found.order).chain(&found.named);
    let builds: BTreeSet<BuildId> = sheets.flat_map(|sheet| sheet.placements.iter().map(|p| p.build_id)).collect();
    Ok(builds.into_iter().collect())
}

async fn build_sheet(ledger: &Ledger, id: BuildId) -> Result<Option<BuildSheet>> {
    let Some(build) = ledger.build(id).await? else { return Ok(None) };
    let line = match build.state {
        BuildState::Open => ledger.waiting_copies(&build.profile).await?,
        _ => Vec::new(),
    };
    Ok(Some(BuildSheet {
        build,
        file: None,
        machine: None,
        parts: ledger.parts_of_build(id).await?,
        waiting: line.into_iter().map(|w| CountedPart { copies: w.copies.len() as u32, part: w.part }).collect(),
        placements: ledger.placements_of_build(id).await?,
        outcomes: ledger.outcomes(id).await?,
        // Of its parts it is enough to see them in the list.
        events: ledger.events_of_build(id).await?.into_iter().filter(|e| e.part_id.is_none()).collect(),
    }))
}

async fn part_sheet(ledger: &Ledger, part: PartRow) -> Result<PartSheet> {
    let (placements, events) = (ledger.placements_of_part(part.id).await?, ledger.events_of_part(part.id).await?);
    Ok(PartSheet { part, placements, events })
}
