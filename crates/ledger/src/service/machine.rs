//! Machines as the daemon sees them, for users who monitor the farm. When a machine becomes unavailable or available
//! again, this is written as one event, even if the daemon restarts meanwhile. Each machine is served by one node.

use std::collections::BTreeMap;

use serde::Serialize;
use sqlx::AssertSqlSafe;

use crate::{
    EventKind, Ledger, PartId, ServerError, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// Columns of a machine that its node records.
const MACHINE_COLUMNS: usize = 8;
/// Machines that one statement records.
const MACHINES_PER_STATEMENT: usize = 100;

/// State of a machine as observed by the daemon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObservedMachine {
    /// Machine.
    pub machine: String,
    /// When its hot folder was last scanned; `None` = not since the daemon started.
    pub scanned_at: Option<UtcTimestamp>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable; "" = it is available, `None` = not known yet.
    pub trouble: Option<String>,
    /// Its file with the defaults of the farm, in TOML; "" = it stays as it was said.
    pub profile: String,
}

/// Last observed state of a machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MachineRow {
    /// Machine.
    pub machine: String,
    /// When its hot folder was last scanned.
    pub scanned_at: Option<UtcTimestamp>,
    /// Whether its hot folder can be used.
    pub is_inbox_there: bool,
    /// Whether its queue folder can be written to.
    pub is_queue_writable: bool,
    /// Why it is unavailable; "" = it is available.
    pub trouble: String,
    /// Since when it has been unavailable.
    pub trouble_at: Option<UtcTimestamp>,
    /// The node that serves it; "" = not known yet.
    pub node: String,
    /// Its file with the defaults of its farm, in TOML; "" = its node has not said it.
    #[serde(skip)]
    pub profile: String,
}

sql_row!(MachineRow { machine, scanned_at, is_inbox_there, is_queue_writable, trouble, trouble_at, node, profile });

impl Ledger {
    /// The last observed states of all machines, by name.
    pub async fn list_machines(&self) -> Result<Vec<MachineRow>> {
        Ok(sql::select_as("FROM station ORDER BY machine").fetch_all(self.reader()?).await?)
    }

    /// Makes a node the one that serves machines, except those that another node serves. Returns these, each with its node. The files of
    /// parts that a machine brings along are on the node that served it: they are fetched. The one node of a file serves all its
    /// machines, and nothing is written.
    pub async fn claim_machines(&self, node: &str, machines: &[String]) -> Result<BTreeMap<String, String>> {
        if self.file().is_some() {
            return Ok(BTreeMap::new());
        }
        let mut others = BTreeMap::new();
        let mut change = self.begin_change().await?;
        for machine in machines {
            // A node that is not known any more serves nothing.
            let before =
                sql::query_scalar("SELECT s.node FROM station s JOIN node n ON n.name = s.node WHERE s.machine = $1");
            let before: Option<String> = before.bind(machine).fetch_optional(change.db()).await?;
            match before {
                Some(before) if before == node => continue,
                Some(other) => {
                    others.insert(machine.clone(), other);
                    continue;
                }
                None => {}
            }
            let claim = sql::query(
                "INSERT INTO station (machine, is_inbox_there, is_queue_writable, node) VALUES ($1, FALSE, FALSE, $2) \
                 ON CONFLICT (machine) DO UPDATE SET node = excluded.node",
            );
            claim.bind(machine).bind(node).execute(change.db()).await?;
            fetch_files_of(&mut change, machine).await?;
        }
        change.commit().await?;
        Ok(others)
    }

    /// The machines that another node serves, each with its node.
    pub async fn machines_of_others(&self, node: &str, machines: &[String]) -> Result<BTreeMap<String, String>> {
        if self.file().is_some() {
            return Ok(BTreeMap::new());
        }
        let query =
            sql::query_as("SELECT s.machine, s.node FROM station s JOIN node n ON n.name = s.node WHERE s.node <> $1");
        let rows: Vec<(String, String)> = query.bind(node).fetch_all(self.reader()?).await?;
        Ok(rows.into_iter().filter(|(machine, _)| machines.contains(machine)).collect())
    }

    /// The node that serves a machine; `None` = none does.
    pub async fn node_of_machine(&self, machine: &str) -> Result<Option<String>> {
        let query = sql::query_scalar("SELECT node FROM station WHERE machine = $1").bind(machine);
        let node: Option<String> = query.fetch_optional(self.reader()?).await?;
        Ok(node.filter(|node| !node.is_empty()))
    }

    /// Whether another node than `node` serves a machine, and the ledger has lost no changes of it.
    pub async fn is_machine_of_sound_node(&self, machine: &str, node: &str) -> Result<bool> {
        let Some(serving) = self.node_of_machine(machine).await?.filter(|serving| serving != node) else {
            return Ok(false);
        };
        Ok(self.file().is_none() && !self.find_repair_due().await?.contains(&serving))
    }

    /// The newest part; 0 = there is none.
    pub async fn newest_part(&self) -> Result<PartId> {
        Ok(sql::query_scalar("SELECT coalesce(max(id), 0) FROM part").fetch_one(self.reader()?).await?)
    }

    /// The contents of the live parts that are newer than a part, each with the node that serves its machine; "" = none does.
    pub async fn live_contents(&self, after: PartId) -> Result<Vec<(String, String)>> {
        let query = sql::query_as(
            "SELECT DISTINCT p.content_hash, coalesce(s.node, '') FROM part p LEFT JOIN station s ON s.machine = p.machine \
             WHERE p.state IN ('claimed', 'waiting', 'batched') AND p.id > $1",
        );
        Ok(query.bind(after).fetch_all(self.reader()?).await?)
    }

    /// Gives a machine to a node. The node that served it is fenced off: it changes nothing more until it was started again. Returns
    /// that node; `None` = no other node served it.
    ///
    /// `NodeAlive` if that node serves it still.
    pub async fn adopt_machine(&self, name: &str, node: &str, told_by: &str) -> Result<Option<String>> {
        let mut change = self.begin_change().await?;
        let query = sql::query_scalar("SELECT node FROM station WHERE machine = $1").bind(name);
        let before: Option<String> = query.fetch_optional(change.db()).await?;
        let Some(before) = before.filter(|before| !before.is_empty() && before != node) else { return Ok(None) };
        if let Some(owner) = self.revoke_lapsed(change.db(), &before).await? {
            let (machine, node) = (name.to_owned(), before);
            return Err(ServerError::NodeAlive { machine, node, owner }.into());
        }
        let adopt = sql::query("UPDATE station SET node = $1 WHERE machine = $2").bind(node).bind(name);
        adopt.execute(change.db()).await?;
        fetch_files_of(&mut change, name).await?;
        let detail = format!("by node {node} from node {before}, as {told_by} said");
        change.write_event(EventKind::Adopted, name, None, None, &detail).await?;
        change.commit().await?;
        Ok(Some(before))
    }
}

impl Ledger {
    /// A node does not run although nobody stopped it: its machines are unavailable, until it says otherwise.
    pub async fn record_node_gone(&self, node: &str) -> Result<()> {
        let its = "SELECT machine FROM station WHERE node = $1 AND trouble = ''";
        let its: Vec<String> = sql::query_scalar(its).bind(node).fetch_all(self.reader()?).await?;
        if its.is_empty() {
            return Ok(());
        }
        let mut change = self.begin_change().await?;
        let (now, why) = (change.now, format!("its node {node} does not run"));
        for machine in its {
            let set = sql::query(
                "UPDATE station SET trouble = $1, trouble_at = $2 WHERE machine = $3 AND node = $4 AND trouble = ''",
            );
            let set = set.bind(&why).bind(now).bind(&machine).bind(node);
            if set.execute(change.db()).await? > 0 {
                change.write_event(EventKind::Unavailable, &machine, None, None, &why).await?;
            }
        }
        change.commit().await
    }
}

/// Has the files of all live parts of a machine fetched from where they are.
async fn fetch_files_of(change: &mut LedgerChange, machine: &str) -> Result<()> {
    let now = change.now;
    let fetch = sql::query(
        "UPDATE part SET fetch_at = coalesce(fetch_at, $1) WHERE machine = $2 AND state IN ('claimed', 'waiting', 'batched') \
         AND damaged_at IS NULL",
    );
    fetch.bind(now).bind(machine).execute(change.db()).await?;
    Ok(())
}

/// Records the machines that a node observed. Removes those that it does not serve any more, so that another node can take them; not those
/// that were given to it and that it has files of: it takes them yet.
pub(super) async fn record_machines(
    change: &mut LedgerChange,
    node: &str,
    (seen, configured): (&[ObservedMachine], &[String]),
) -> Result<()> {
    let known = sql::select_as("FROM station WHERE node IN ('', $1)").bind(node);
    let known: Vec<MachineRow> = known.fetch_all(change.db()).await?;
    let is_left = |row: &&MachineRow| {
        let is_to_be_taken = row.node == node && configured.contains(&row.machine);
        !is_to_be_taken && !seen.iter().any(|s| s.machine == row.machine)
    };
    for gone in known.iter().filter(is_left) {
        sql::query("DELETE FROM station WHERE machine = $1").bind(&gone.machine).execute(change.db()).await?;
    }
    let mut rows = Vec::with_capacity(seen.len());
    for seen in seen {
        let known = known.iter().find(|row| row.machine == seen.machine);
        let was = known.map_or("", |row| &row.trouble);
        let is = seen.trouble.as_deref().unwrap_or(was);
        let since = match (was.is_empty(), is.is_empty()) {
            (_, true) => None,
            (true, false) => Some(change.now),
            (false, false) => known.and_then(|row| row.trouble_at),
        };
        match (was.is_empty(), is.is_empty()) {
            (true, false) => change.write_event(EventKind::Unavailable, &seen.machine, None, None, is).await?,
            (false, true) => change.write_event(EventKind::Available, &seen.machine, None, None, "").await?,
            _ => {}
        }
        rows.push((seen, is, since));
    }
    // Of whatever size it is, one statement.
    for rows in rows.chunks(MACHINES_PER_STATEMENT) {
        let places = (0..rows.len()).map(|row| {
            let places: Vec<String> =
                (1..=MACHINE_COLUMNS).map(|column| format!("${}", row * MACHINE_COLUMNS + column)).collect();
            format!("({})", places.join(", "))
        });
        let mut record = sql::query(AssertSqlSafe(format!(
            "INSERT INTO station (machine, scanned_at, is_inbox_there, is_queue_writable, trouble, trouble_at, node, profile) \
             VALUES {} ON CONFLICT (machine) DO UPDATE SET node = excluded.node, \
             scanned_at = coalesce(excluded.scanned_at, station.scanned_at), is_inbox_there = excluded.is_inbox_there, \
             is_queue_writable = excluded.is_queue_writable, trouble = excluded.trouble, trouble_at = excluded.trouble_at, \
             profile = CASE WHEN excluded.profile = '' THEN station.profile ELSE excluded.profile END",
            places.collect::<Vec<_>>().join(", ")
        )));
        for (seen, trouble, since) in rows {
            record = record.bind(&seen.machine).bind(seen.scanned_at).bind(seen.is_inbox_there);
            record = record.bind(seen.is_queue_writable).bind(*trouble).bind(*since).bind(node).bind(&seen.profile);
        }
        record.execute(change.db()).await?;
    }
    Ok(())
}
