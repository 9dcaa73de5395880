//! What the plan of a machine is made from.

use std::{collections::HashSet, sync::Arc};

use jiff::Timestamp;
use ledger::{BuildId, PartId, PartRow, WaitingPart, compare_precedence, rank_waiting_copies};
use nester::OrientationRule;
use settings::MachineProfile;

use super::packing_experience::PackingExperience;
use crate::decisions::printer_outlook::PrinterOutlook;

/// Waiting copies of one part, all of which stand in the open build, or none.
#[derive(Debug, Clone)]
pub struct PlanLine {
    /// The part.
    pub part: Arc<PartRow>,
    /// Number of copies, at least 1.
    pub copies: u32,
    /// Whether they stand in the layout of the open build.
    pub stands: bool,
    /// Volume of one of them, mm3.
    pub each_mm3: f64,
    /// The height that one of them needs at least, mm.
    pub least_mm: f64,
}

/// The layout of the open build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingLayout {
    /// Its build; `None` = it is not opened yet.
    pub build: Option<BuildId>,
    /// Its height, mm.
    pub height_mm: f64,
    /// Volume of the parts in it, mm3.
    pub part_volume_mm3: f64,
}

/// A build that has fired, and for which no printer is decided yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FiredBuild {
    /// Its number.
    pub build: BuildId,
    /// Its height, mm, as far as it is known.
    pub height_mm: f64,
}

/// Why nothing fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanHindrance {
    /// A person has paused the machine.
    Paused,
    /// The daemon found it unavailable.
    Unavailable,
    /// All its printers are down.
    NoPrinter,
}

/// What is known of a machine when its builds are planned.
#[derive(Debug, Clone)]
pub struct PlanFacts {
    /// The waiting copies, in order of precedence.
    pub lines: Vec<PlanLine>,
    /// The layout of the open build, if copies stand in it.
    pub layout: Option<StandingLayout>,
    /// When the newest part arrived.
    pub newest: Timestamp,
    /// Builds that have fired and have no printer yet, the oldest first.
    pub fired: Vec<FiredBuild>,
    /// The printers in use, and how long prints take.
    pub outlook: PrinterOutlook,
    /// Why nothing fires; `None` = nothing prevents it.
    pub hindrance: Option<PlanHindrance>,
    /// How high parts stand.
    pub packing: PackingExperience,
}

impl PlanLine {
    /// The line of copies of a part.
    pub fn new(profile: &MachineProfile, part: Arc<PartRow>, copies: u32, stands: bool) -> Self {
        let each_mm3 = part.measures.volume_mm3.unwrap_or(0.0).max(0.0);
        Self { copies, stands, each_mm3, least_mm: least_height_mm(profile, &part), part }
    }
}

impl PlanFacts {
    /// The lines of waiting copies, of which some stand in the open build.
    pub fn rank_lines(
        profile: &MachineProfile,
        waiting: Vec<WaitingPart>,
        standing: &HashSet<(PartId, u32)>,
    ) -> Vec<PlanLine> {
        let stands = |part: PartId, copy: u32| standing.contains(&(part, copy));
        let ranked = rank_waiting_copies(waiting, stands);
        let line = |WaitingPart { part, copies }: WaitingPart| {
            let stands = copies.first().is_some_and(|&copy| stands(part.id, copy));
            PlanLine::new(profile, Arc::new(part), copies.len() as u32, stands)
        };
        ranked.into_iter().map(line).collect()
    }

    /// Adds a line at its place in the order of precedence.
    pub fn insert_line(&mut self, line: PlanLine) {
        let goes_first = |other: &PlanLine| {
            compare_precedence((&other.part, other.stands), (&line.part, line.stands)) != std::cmp::Ordering::Greater
        };
        let at = self.lines.partition_point(goes_first);
        self.newest = self.newest.max(line.part.arrived_at().0);
        self.lines.insert(at, line);
    }
}

/// The height that a part needs at least: lying, if it may be turned and its base has room for that, mm.
fn least_height_mm(profile: &MachineProfile, part: &PartRow) -> f64 {
    let Some(size) = part.size_mm() else { return 0.0 };
    let room = profile.build_volume().size_mm;
    let [wide, deep] = [room.x.max(room.y), room.x.min(room.y)];
    let limits = part.orientation_limits();
    if matches!(limits.rule, OrientationRule::Fixed | OrientationRule::Upright) || !limits.tilts.is_empty() {
        return size[2];
    }
    let lies = |up: usize| {
        let (one, other) = (size[(up + 1) % 3], size[(up + 2) % 3]);
        one.max(other) <= wide && one.min(other) <= deep
    };
    let lying = (0..3).filter(|&up| lies(up)).map(|up| size[up]).min_by(f64::total_cmp);
    lying.unwrap_or_else(|| size[2].min(room.z))
}
