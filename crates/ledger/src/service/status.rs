//! Status per machine: what is waiting, what is being nested, and what was published last.

use std::collections::BTreeMap;

use jiff::{SignedDuration, Timestamp};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    printer::BUILDS_AHEAD,
    status_queries::{AWAITED, COUNTS, DUE, DUE_ARRIVALS, LAST, LOADED, NESTING, OPEN, PAUSES, REFUSED},
};
use crate::{
    BuildId, BuildState, BuildsAhead, Ledger, NightState, OccupyingBuild, PauseCause, ToldPrint, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, FromSqlRow, SqlRow, SqlTransaction, sql_row},
    },
};

/// Time for which a refused part can be retried and counts as refused.
pub const RETRY_PERIOD: SignedDuration = SignedDuration::from_hours(30 * 24);

/// Current status of a machine. A machine without any rows in the ledger has none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct MachineStatus {
    /// Its name.
    pub machine: String,
    /// Claimed parts that are not read yet.
    pub claimed_parts: u32,
    /// Parts with a waiting copy.
    pub waiting_parts: u32,
    /// Waiting copies.
    pub waiting_copies: u32,
    /// Those of them that can be in the next build.
    pub collecting_copies: u32,
    /// Those of them that wait for an answer of a person: a yes, or their original once more.
    pub asked_copies: u32,
    /// What is loaded there; "" = nothing, or nothing is said.
    pub material: String,
    /// Its lot; "" = not said.
    pub lot: String,
    /// The waiting parts whose material is not loaded there, by material; they are among those that wait.
    pub awaiting: Vec<AwaitedMaterial>,
    /// Parts that were refused in the last 30 days ([`RETRY_PERIOD`]), of which copies are wanted; cancelled ones do not count.
    pub refused_parts: u32,
    /// When the oldest waiting part was claimed.
    pub oldest_at: Option<UtcTimestamp>,
    /// Since when the part waits that has waited longest of those that can be built.
    pub waits_since: Option<UtcTimestamp>,
    /// The nearest due date of the waiting parts.
    pub due_at: Option<UtcTimestamp>,
    /// That date as it was given, "" = none, or not known.
    pub due_text: String,
    /// What is due first of what can be built: the order, or else the file; "" = nothing.
    pub due_of: String,
    /// The due dates of the waiting parts that can be built, the earliest first.
    #[serde(skip)]
    pub due_arrivals: Vec<DueArrival>,
    /// When the newest part arrived, be it read or not.
    #[serde(skip)]
    pub newest_at: Option<UtcTimestamp>,
    /// The builds that occupy its printers, where a part that can be built has a due date.
    #[serde(skip)]
    pub occupying: Vec<OccupyingBuild>,
    /// The prints from which is learned how long one takes, as for `occupying`.
    #[serde(skip)]
    pub told_prints: Vec<ToldPrint>,
    /// The open build.
    pub open: Option<OpenBuildForecast>,
    /// Builds that are being nested or published.
    pub nesting: Vec<NestingBuild>,
    /// Builds that are made for each printer that is in use, or lie in its queue; "" = the printer is not decided.
    #[serde(skip)]
    pub ahead: Vec<BuildsAhead>,
    /// The pause of the machine, if any.
    pub paused: Option<PauseStatus>,
    /// The build that was published last.
    pub last_published: Option<PublishedBuild>,
}

impl MachineStatus {
    /// The status of a machine without any rows.
    pub fn nothing_of(machine: &str) -> Self {
        Self { machine: machine.to_owned(), ..Self::default() }
    }

    /// The status of a machine among those of all machines.
    pub fn of_machine(statuses: &[Self], machine: &str) -> Self {
        let found = statuses.iter().find(|status| status.machine == machine);
        found.cloned().unwrap_or_else(|| Self::nothing_of(machine))
    }
}

/// Waiting parts whose material is not loaded on their machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct AwaitedMaterial {
    /// Their material.
    pub material: String,
    /// Number of parts.
    pub parts: u32,
    /// Number of their copies.
    pub copies: u32,
}

sql_row!(AwaitedMaterial { material, parts, copies });

/// A due date, and when the first waiting part with that date arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DueArrival {
    /// The due date.
    pub due_at: UtcTimestamp,
    /// When the part began to wait, or copies of it were put back.
    pub arrived_at: UtcTimestamp,
}

/// The forecast of the next build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OpenBuildForecast {
    /// Its number.
    pub build: BuildId,
    /// Height of its layout so far, mm.
    pub height_mm: Option<f64>,
    /// Density of its layout so far, 0..1.
    pub density: Option<f64>,
    /// Copies in its layout so far.
    pub copies: Option<u32>,
    /// Whether its layout is lowered further while it waits; `None` = that has not begun, or is switched off.
    pub night: Option<NightState>,
    /// CPU seconds of that since the last arrival.
    pub night_cpu_secs: Option<f64>,
    /// What that has gained since the last arrival, mm.
    pub night_gain_mm: Option<f64>,
}

sql_row!(OpenBuildForecast { build, height_mm, density, copies, night, night_cpu_secs, night_gain_mm });

/// A build that has been started and is not published.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NestingBuild {
    /// Its number.
    pub build: BuildId,
    /// Nesting or verified.
    pub state: BuildState,
    /// Copies taken into it.
    pub copies: u32,
    /// Trigger.
    pub fired_by: String,
    /// Number of nesting attempts.
    pub attempts: u32,
    /// When it was started ("fired").
    pub nesting_at: Option<UtcTimestamp>,
}

sql_row!(NestingBuild { build, state, copies, fired_by, attempts, nesting_at });

/// A pause.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PauseStatus {
    /// user@host, or the name of the daemon.
    pub paused_by: String,
    /// Why.
    #[serde(skip)]
    pub cause: PauseCause,
    /// When it was paused.
    pub paused_at: UtcTimestamp,
}

sql_row!(PauseStatus { paused_by, cause, paused_at });

/// A build in the queue.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PublishedBuild {
    /// Its number.
    pub build: BuildId,
    /// When its file was put into the queue.
    pub published_at: UtcTimestamp,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Number of placed copies.
    pub copies: Option<u32>,
    /// Name of the build file.
    pub file_name: Option<String>,
}

sql_row!(PublishedBuild { build, published_at, height_mm, density, copies, file_name });

/// A row together with its machine.
struct WithMachine<T> {
    machine: String,
    row: T,
}

impl<T: FromSqlRow> FromSqlRow for WithMachine<T> {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        Ok(Self { machine: row.column("machine")?, row: T::from_sql_row(row)? })
    }
}

/// Numbers of parts of a machine.
struct PartCounts {
    claimed_parts: u32,
    waiting_parts: u32,
    waiting_copies: u32,
    collecting_copies: u32,
    asked_copies: u32,
    oldest_at: Option<UtcTimestamp>,
    waits_since: Option<UtcTimestamp>,
    newest_at: Option<UtcTimestamp>,
}

sql_row!(PartCounts {
    claimed_parts,
    waiting_parts,
    waiting_copies,
    collecting_copies,
    asked_copies,
    oldest_at,
    waits_since,
    newest_at
});

/// The nearest due date.
struct NearestDue {
    due_at: UtcTimestamp,
    due_text: String,
}

sql_row!(NearestDue { due_at, due_text });

/// A due date of parts that can be built.
struct DueDateRow {
    due_at: UtcTimestamp,
    arrived_at: UtcTimestamp,
    due_of: String,
}

sql_row!(DueDateRow { due_at, arrived_at, due_of });

impl Ledger {
    /// Parts that were refused before this time do not count any more.
    pub(crate) fn refused_since(&self) -> UtcTimestamp {
        UtcTimestamp(self.now().checked_sub(RETRY_PERIOD).unwrap_or(Timestamp::MIN))
    }

    /// All machines with rows in the ledger, by name.
    pub async fn machine_statuses(&self) -> Result<Vec<MachineStatus>> {
        let mut snapshot = self.begin_snapshot().await?;
        let db = &mut snapshot;
        let mut machines = BTreeMap::new();
        note_counts(db, &mut machines).await?;
        let refused = sql::query_as::<(String, u32)>(REFUSED).bind(self.refused_since()).fetch_all(&mut *db).await?;
        for (machine, parts) in refused {
            machine_entry(&mut machines, &machine).refused_parts = parts;
        }
        for WithMachine { machine, row } in fetch_by_machine::<NearestDue>(db, DUE).await? {
            let status = machine_entry(&mut machines, &machine);
            (status.due_at, status.due_text) = (Some(row.due_at), row.due_text);
        }
        for WithMachine { machine, row } in fetch_by_machine::<DueDateRow>(db, DUE_ARRIVALS).await? {
            let status = machine_entry(&mut machines, &machine);
            if status.due_arrivals.is_empty() {
                status.due_of = row.due_of;
            }
            status.due_arrivals.push(DueArrival { due_at: row.due_at, arrived_at: row.arrived_at });
        }
        for WithMachine { machine, row } in fetch_by_machine::<OpenBuildForecast>(db, OPEN).await? {
            let status = machine_entry(&mut machines, &machine);
            // A layout with more copies than are waiting contains parts that were cancelled since, so it is not a
            // forecast any more.
            let is_of_now = row.copies.unwrap_or(0) <= status.waiting_copies;
            status.open = Some(match is_of_now {
                true => row,
                false => OpenBuildForecast {
                    height_mm: None,
                    density: None,
                    copies: None,
                    night: None,
                    night_cpu_secs: None,
                    night_gain_mm: None,
                    ..row
                },
            });
        }
        for WithMachine { machine, row } in fetch_by_machine(db, NESTING).await? {
            machine_entry(&mut machines, &machine).nesting.push(row);
        }
        for WithMachine { machine, row } in fetch_by_machine(db, BUILDS_AHEAD).await? {
            machine_entry(&mut machines, &machine).ahead.push(row);
        }
        note_materials(db, &mut machines).await?;
        for WithMachine { machine, row } in fetch_by_machine(db, PAUSES).await? {
            machine_entry(&mut machines, &machine).paused = Some(row);
        }
        for WithMachine { machine, row } in fetch_by_machine(db, LAST).await? {
            machine_entry(&mut machines, &machine).last_published = Some(row);
        }
        drop(snapshot);
        let now = self.now();
        for (machine, status) in machines.iter_mut().filter(|(_, status)| !status.due_arrivals.is_empty()) {
            status.occupying = self.occupying_builds(machine, now).await?;
            status.told_prints = self.told_prints(machine).await?;
        }
        Ok(machines.into_values().collect())
    }
}

impl Ledger {
    /// When the newest part of a machine that waits or is read arrived.
    pub async fn newest_arrival(&self, machine: &str) -> Result<Option<UtcTimestamp>> {
        let query = "SELECT max(CASE WHEN put_back_at > state_at THEN put_back_at ELSE state_at END) FROM part \
            WHERE machine = $1 AND state IN ('claimed', 'waiting')";
        Ok(sql::query_scalar(query).bind(machine).fetch_one(self.reader()?).await?)
    }
}

/// Notes how many parts and copies are read or wait on machines.
async fn note_counts(db: &mut SqlTransaction, machines: &mut BTreeMap<String, MachineStatus>) -> Result<()> {
    for WithMachine { machine, row } in fetch_by_machine::<PartCounts>(db, COUNTS).await? {
        let counted = MachineStatus {
            claimed_parts: row.claimed_parts,
            waiting_parts: row.waiting_parts,
            waiting_copies: row.waiting_copies,
            collecting_copies: row.collecting_copies,
            asked_copies: row.asked_copies,
            oldest_at: row.oldest_at,
            waits_since: row.waits_since,
            newest_at: row.newest_at,
            ..machine_entry(machines, &machine).clone()
        };
        machines.insert(machine, counted);
    }
    Ok(())
}

/// Notes what is loaded on machines, and what waits for another material there.
async fn note_materials(db: &mut SqlTransaction, machines: &mut BTreeMap<String, MachineStatus>) -> Result<()> {
    for WithMachine { machine, row } in fetch_by_machine(db, AWAITED).await? {
        machine_entry(machines, &machine).awaiting.push(row);
    }
    for (machine, material, lot) in sql::query_as::<(String, String, String)>(LOADED).fetch_all(&mut *db).await? {
        machines.entry(machine).and_modify(|status| (status.material, status.lot) = (material, lot));
    }
    Ok(())
}

async fn fetch_by_machine<T: FromSqlRow + Send>(
    db: &mut SqlTransaction,
    query: &'static str,
) -> Result<Vec<WithMachine<T>>> {
    Ok(sql::query_as(query).fetch_all(db).await?)
}

/// Returns the status entry of a machine, and inserts it if it is missing.
fn machine_entry<'a>(machines: &'a mut BTreeMap<String, MachineStatus>, machine: &str) -> &'a mut MachineStatus {
    machines.entry(machine.to_owned()).or_insert_with(|| MachineStatus::nothing_of(machine))
}
