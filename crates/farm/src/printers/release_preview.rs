//! What a person sees of a proved build before it is published: height, density and hours, what waits beside it, and which due
//! dates it would miss: what the plan of its machine says of it.

use anyhow::Result;
use jiff::Timestamp;
use language::say;
use ledger::{BuildId, BuildRow, Ledger, MachineStatus, PartRow, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::{FarmZone, MachineProfile};

use super::printers::rules_of_build;
use crate::{
    planning::{FarmRows, awaits_release, plan_machine, read_occupation},
    scanning::machine_fit::find_misfit,
};

/// Maximum number of late parts that a sentence names.
const MAX_NAMED: usize = 5;

/// What publishing a build now would mean.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ReleasePreview {
    /// The build.
    pub build: BuildId,
    /// Whether it waits for a person's yes.
    pub awaits_release: bool,
    /// Copies in it.
    pub copies: u32,
    /// Build height, mm.
    pub height_mm: f64,
    /// Height of the machine's volume, mm.
    pub volume_z_mm: f64,
    /// Density, 0..1.
    pub density: f64,
    /// Hours of printing, without cooling.
    pub print_hours: f64,
    /// The printer that it is for.
    pub printer: String,
    /// When its print could begin; `None` = the calendar of the printer is not open again.
    pub begins_at: Option<UtcTimestamp>,
    /// When its parts could be unpacked.
    pub ends_at: Option<UtcTimestamp>,
    /// Copies that wait for the next build.
    pub waiting_copies: u32,
    /// Parts in it that are due before it could be unpacked.
    pub late: Vec<LatePreview>,
    /// Why it is made again instead, and its figures do not hold; `None` = it is published as it is.
    pub made_again_for: Option<String>,
}

/// A part that would be late.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LatePreview {
    /// File name.
    pub name: String,
    /// Its order; "" = none.
    pub order: String,
    /// When it is due.
    pub due_at: UtcTimestamp,
    /// The date as it was given.
    pub due_text: String,
}

/// The preview of a build that is not published yet.
///
/// # Errors
/// The ledger cannot be read.
pub async fn preview_release(
    ledger: &Ledger,
    profile: &MachineProfile,
    build: &BuildRow,
    now: Timestamp,
) -> Result<ReleasePreview> {
    let (rows, occupation) = (FarmRows::read(ledger).await?, read_occupation(ledger, profile, now).await?);
    let plan = plan_machine(ledger, profile, (&rows, &occupation), now).await?;
    let planned = plan.builds.iter().find(|planned| planned.build == Some(build.id));
    let (begins_at, ends_at) = planned.map_or((None, None), |planned| (planned.begins_at, planned.ends_at));
    let printer = planned.and_then(|planned| planned.printer.clone());
    let height_mm = build.measures.height_mm.unwrap_or_default();
    let mut late: Vec<LatePreview> =
        ledger.parts_of_build(build.id).await?.iter().filter_map(|part| late_part(part, ends_at)).collect();
    late.sort_by_key(|part| part.due_at);
    Ok(ReleasePreview {
        build: build.id,
        awaits_release: awaits_release(profile, build),
        copies: build.measures.copies.unwrap_or_default(),
        height_mm,
        volume_z_mm: profile.space.volume_mm.z,
        density: build.measures.density.unwrap_or_default(),
        print_hours: occupation.times.print_hours(height_mm),
        printer: printer.or_else(|| Some(rules_of_build(profile, build)?.name.clone())).unwrap_or_default(),
        begins_at,
        ends_at,
        waiting_copies: MachineStatus::of_machine(&rows.statuses, &profile.name).collecting_copies,
        late,
        made_again_for: find_misfit(profile, build),
    })
}

fn late_part(part: &PartRow, ends_at: Option<UtcTimestamp>) -> Option<LatePreview> {
    let due_at = part.terms.due_at?;
    let is_late = ends_at.is_none_or(|ends| ends > due_at);
    is_late.then(|| LatePreview {
        name: part.full_name(),
        order: part.terms.order_name.clone(),
        due_at,
        due_text: part.terms.due_text.clone(),
    })
}

impl ReleasePreview {
    /// `119 copies, 249.0 of 380 mm high, 17.5 % dense, about 31.1 h of printing`.
    pub fn brief_text(&self) -> String {
        let decimal = |number: f64| language::decimal(format!("{number:.1}"));
        say!(
            "release-brief",
            copies = self.copies,
            height = decimal(self.height_mm),
            limit = format!("{:.0}", self.volume_z_mm),
            density = decimal(100.0 * self.density),
            hours = decimal(self.print_hours)
        )
    }

    /// All of it in sentences.
    pub fn sentences(&self, zone: &FarmZone) -> Vec<String> {
        if let Some(why) = &self.made_again_for {
            return vec![say!("release-made-again", build = self.build.to_string(), why = why)];
        }
        let time = |at: UtcTimestamp| zone.format_minute(at.0);
        let mut sentences = vec![say!("release-build", build = self.build.to_string(), content = self.brief_text())];
        sentences.push(match (self.begins_at, self.ends_at) {
            (Some(begins), Some(ends)) => {
                say!("release-could-begin", printer = &self.printer, begins = time(begins), ends = time(ends))
            }
            _ => say!("release-not-known", printer = &self.printer),
        });
        sentences.push(match self.waiting_copies {
            0 => say!("release-nothing-waits"),
            copies => say!("release-copies-wait", copies = copies),
        });
        let named: Vec<String> = (self.late.iter().take(MAX_NAMED))
            .map(|part| {
                let due = zone.format_due(part.due_at.0, &part.due_text);
                match part.order.as_str() {
                    "" => say!("release-late-part", name = &part.name, due = due),
                    order => say!("release-late-part-of", name = &part.name, order = order, due = due),
                }
            })
            .collect();
        let more = self.late.len().saturating_sub(named.len());
        let named = language::join_names(named);
        sentences.push(match more {
            _ if named.is_empty() => say!("release-none-late"),
            0 => say!("release-late", names = named),
            more => say!("release-late", names = say!("name-and-more", name = named, count = more)),
        });
        sentences
    }
}
