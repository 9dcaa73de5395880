//! Notices of changes. Each change that others may have to act on notifies whoever listens, with the names of its machines, when it is
//! committed. A notice is a hint, which a connection that was lost has missed: whoever relies on it looks at the ledger now and then.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use sqlx::{
    Acquire, Connection, PgConnection,
    postgres::{PgListener, PgNotification},
};
use tokio::task::AbortHandle;

use super::connections::ServerConnections;
use crate::{ServerError, base::error::Result};

/// The channel of the notices. A farm has its database for itself.
const CHANNEL: &str = "nestd_changes";
/// The most bytes of names in a notice, below the limit of PostgreSQL. Longer ones concern all machines.
const MAX_BYTES: usize = 7000;
/// Without a notice for this long, or when another connection gives no sign of life, the connection is asked whether it lives; it answers within the other time.
const ASK_AFTER: Duration = Duration::from_secs(4);
const ANSWERED_WITHIN: Duration = Duration::from_secs(2);
/// Between two attempts to listen.
const RETRY: Duration = Duration::from_secs(1);

/// The notices that a process has got. Clones are the same ones.
#[derive(Debug, Clone, Default)]
pub struct ChangeNotices(Arc<Mutex<NoticeCounts>>);

#[derive(Debug, Default)]
struct NoticeCounts {
    is_listening: bool,
    /// Changes of no machine alone, and times at which some may have been missed.
    of_all: u64,
    of_machine: BTreeMap<String, u64>,
}

/// Tells whoever listens of a change of these machines, when it is committed; none, or "" = of all.
pub async fn notify(db: &mut PgConnection, machines: &BTreeSet<String>) -> Result<()> {
    let names: Vec<&str> = machines.iter().map(String::as_str).collect();
    let names = if machines.contains("") { String::new() } else { names.join(",") };
    let names = if names.len() > MAX_BYTES { String::new() } else { names };
    let told = sqlx::query("SELECT pg_notify($1, $2)").bind(CHANNEL).bind(names).execute(db).await;
    told.map_err(ServerError::mark_unreachable)?;
    Ok(())
}

impl ChangeNotices {
    /// Number of the changes that these machines may be concerned by; `None` = changes are missed at present.
    pub fn count_for<'m>(&self, machines: impl IntoIterator<Item = &'m str>) -> Option<u64> {
        self.change(|counts| {
            let of_machines = machines.into_iter().filter_map(|machine| counts.of_machine.get(machine)).sum::<u64>();
            counts.is_listening.then_some(counts.of_all + of_machines)
        })
    }

    /// This process has made a change.
    pub fn count_own(&self, is_told: bool) {
        self.change(|counts| counts.of_all += u64::from(is_told));
    }

    /// Listens from now on, on a connection of its own, until the connections are closed.
    pub fn listen_on(&self, connections: &ServerConnections) -> AbortHandle {
        let (notices, connections) = (self.clone(), connections.clone());
        let listening = async move {
            while !connections.pool().is_closed() {
                if let Err(error) = notices.listen(&connections).await {
                    tracing::debug!("Changes of the ledger are not told at present: {error}.");
                }
                notices.change(|counts| counts.is_listening = false);
                tokio::time::sleep(RETRY).await;
            }
        };
        tokio::spawn(listening).abort_handle()
    }

    async fn listen(&self, connections: &ServerConnections) -> Result<()> {
        // A connection that is dead without an end takes no place of the others.
        let own = connections.separate_one()?;
        let mut listener = PgListener::connect_with(&own).await?;
        listener.eager_reconnect(false);
        listener.listen(CHANNEL).await?;
        self.change(|counts| {
            // What came before was missed.
            counts.of_all += 1;
            counts.is_listening = true;
        });
        loop {
            let told = tokio::select! {
                told = tokio::time::timeout(ASK_AFTER, listener.try_recv()) => told.ok(),
                () = connections.in_doubt() => None,
            };
            match told {
                Some(notice) => match notice? {
                    Some(notice) => self.take(&notice),
                    None => return Ok(()),
                },
                // It may have fallen silent.
                None => {
                    let ask = async { listener.acquire().await?.ping().await };
                    if tokio::time::timeout(ANSWERED_WITHIN, ask).await.is_err() {
                        return Ok(());
                    }
                }
            }
        }
    }

    fn take(&self, notice: &PgNotification) {
        self.change(|counts| match notice.payload() {
            "" => counts.of_all += 1,
            names => names.split(',').for_each(|name| *counts.of_machine.entry(name.to_owned()).or_default() += 1),
        });
    }

    fn change<T>(&self, change: impl FnOnce(&mut NoticeCounts) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
