//! What all handlers share.

use std::sync::{Arc, PoisonError};

use axum::body::Bytes;
use tokio::sync::{Semaphore, watch};

use super::{cache::Cache, pick_map::Map, problem::Answer};
use crate::{
    farm,
    ledger::Ledger,
    metrics::Metrics,
    settings::{Settings, Shared},
};

/// What all handlers share.
pub(super) struct Web {
    pub(super) ledger: Ledger,
    pub(super) settings: Shared,
    /// Whether it is asked over TCP: then a browser may be made to ask it in another site's name.
    pub(super) is_tcp: bool,
    pub(super) hosts: Vec<String>,
    pub(super) orders: bool,
    pub(super) token: Option<String>,
    /// Stands in every form, so that no other site can post one.
    pub(super) form_key: String,
    pub(super) caches: PageCaches,
    pub(super) metrics: Metrics,
    /// Who holds it makes something for the caches: looking takes one core and the meshes of one build from the farm at most.
    pub(super) looking: Arc<Semaphore>,
    pub(super) changes: watch::Sender<u64>,
}

/// What is made of builds once, and kept.
pub(super) struct PageCaches {
    pub(super) scenes: Cache<Bytes>,
    pub(super) picks: Cache<Map>,
    pub(super) pictures: Cache<Bytes>,
}

impl Web {
    /// The settings as they are now.
    pub(super) fn settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// A text that changes when anything does that pages show.
    pub(super) async fn pulse(&self) -> Answer<String> {
        let (status, last) = (self.ledger.status().await?, self.ledger.last_event_id().await?);
        let alive = self.ledger.daemon().await?.is_some_and(|daemon| daemon.alive);
        let notices = farm::kept_notices(&self.settings().state_dir);
        Ok(format!("{alive} {last} {status:?} {notices:?}"))
    }
}
