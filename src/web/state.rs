//! The state that all request handlers share.

use std::sync::{Arc, PoisonError};

use axum::body::Bytes;
use tokio::sync::{Semaphore, watch};

use super::{
    cache::RecentCache, client::ClientGate, client_limits::ClientLimits, compressed::CompressedBody,
    error::HandlerResult, form_keys::FormKeys, order_keys::OrderDoor, pick_map::CachedPickMap,
    upload_turns::UploadTurns,
};
use crate::{
    farm::{self, QuoteMeshes, ServiceBridge},
    ledger::Ledger,
    metrics::MetricsExporter,
    settings::{Settings, SharedSettings},
    tables::TimeView,
};

/// The state that all request handlers share.
pub(super) struct DashboardState {
    pub(super) ledger: Ledger,
    /// Tells whether the farm has halted.
    pub(super) farm: ServiceBridge,
    pub(super) settings: SharedSettings,
    /// Whether the dashboard listens on TCP. Only then can another site make a browser send requests to it.
    pub(super) is_tcp: bool,
    pub(super) hosts: Vec<String>,
    pub(super) orders: bool,
    /// Header in which a reverse proxy names the user.
    pub(super) user_header: Option<axum::http::HeaderName>,
    /// What each client may take.
    pub(super) limits: Arc<ClientLimits>,
    /// Who may ask what.
    pub(super) clients: ClientGate,
    /// Uploads that requests are at.
    pub(super) uploads: UploadTurns,
    /// Orders that are being taken.
    pub(super) door: Arc<OrderDoor>,
    /// Makes the key that each form carries, so that it is carried out once, and no other site can post one (CSRF token).
    pub(super) form_keys: FormKeys,
    pub(super) caches: PageCaches,
    pub(super) metrics: MetricsExporter,
    /// Who holds it makes something for the caches: looking takes one core and the meshes of one build from the farm at most.
    pub(super) render_slot: Arc<Semaphore>,
    /// Who holds one of these receives files from a form.
    pub(super) upload_slots: Arc<Semaphore>,
    /// Who holds one of these makes a quote.
    pub(super) quote_slots: Arc<Semaphore>,
    /// The meshes of the machine that was quoted for last.
    pub(super) quote_meshes: QuoteMeshes,
    pub(super) changes: watch::Sender<u64>,
}

/// What is made of builds once, and kept.
pub(super) struct PageCaches {
    pub(super) scenes: RecentCache<CompressedBody>,
    pub(super) picks: RecentCache<CachedPickMap>,
    pub(super) pictures: RecentCache<Bytes>,
}

impl DashboardState {
    /// The current settings.
    pub(super) fn current_settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// How the pages show times.
    pub(super) fn time_view(&self) -> TimeView {
        TimeView::current(&self.current_settings().time_zone)
    }

    /// A text that changes whenever anything changes that the pages show.
    pub(super) async fn change_token(&self) -> HandlerResult<String> {
        if let Some(halted) = self.farm.halt_reason() {
            return Ok(halted);
        }
        let (status, last) = (self.ledger.profile_statuses().await?, self.ledger.last_event_id().await?);
        let alive = self.ledger.list_nodes().await?.iter().map(|node| node.alive).collect::<Vec<_>>();
        let notices = farm::read_stored_alerts(&self.current_settings().state_dir);
        let picked = self.ledger.last_pick_id().await?;
        Ok(format!("{alive:?} {last} {picked} {status:?} {notices:?}"))
    }
}
