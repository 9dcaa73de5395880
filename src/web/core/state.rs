//! The state that all request handlers share.

use std::sync::{Arc, PoisonError};

use access::Role;
use axum::body::Bytes;
use farm::{FarmReading, JudgedFiles, MachinePlan, QuoteMeshes, ServiceBridge, read_plans};
use jiff::Timestamp;
use ledger::Ledger;
use settings::{Settings, SharedSettings};
use tokio::sync::{Notify, Semaphore, watch};

use super::{form_keys::FormKeys, order_keys::OrderDoor, shown_copies::ShownCopies, upload_turns::UploadTurns};
use crate::{
    metrics::MetricsExporter,
    tables::TimeView,
    web::{
        base::{
            cache::RecentCache,
            client_gate::{ClientGate, ProxyHeader},
            client_limits::{ClientLimits, SignInAttempts},
            compressed::CompressedBody,
            error::HandlerResult,
        },
        clients::client::RequestClient,
        figures::pick_map::CachedPickMap,
    },
};

/// The state that all request handlers share.
pub(crate) struct DashboardState {
    pub(crate) ledger: Ledger,
    /// Tells whether the farm has halted.
    pub(crate) farm: ServiceBridge,
    /// What was read of files whose orders were taken.
    pub(crate) judged: JudgedFiles,
    pub(crate) settings: SharedSettings,
    /// Whether the dashboard listens on TCP. Only then can another site make a browser send requests to it.
    pub(crate) is_tcp: bool,
    pub(crate) hosts: Vec<String>,
    pub(crate) orders: bool,
    /// The reverse proxy that names its users.
    pub(crate) proxy: Option<ProxyHeader>,
    /// What each client may take.
    pub(crate) limits: Arc<ClientLimits>,
    /// Who may ask what.
    pub(crate) clients: ClientGate,
    /// Failed attempts to sign in, and who compares passwords.
    pub(crate) attempts: SignInAttempts,
    /// Uploads that requests are at.
    pub(crate) uploads: UploadTurns,
    /// Orders that are being taken.
    pub(crate) door: Arc<OrderDoor>,
    /// Makes the key that each form carries, so that it is carried out once, and no other site can post one (CSRF token).
    pub(crate) form_keys: FormKeys,
    pub(crate) caches: PageCaches,
    pub(crate) metrics: MetricsExporter,
    /// Who holds it makes something for the caches: looking takes one core and the meshes of one build from the farm at most.
    pub(crate) render_slot: Arc<Semaphore>,
    /// Who holds one of these receives files from a form.
    pub(crate) upload_slots: Arc<Semaphore>,
    /// Who holds one of these has another node answer.
    pub(crate) pass_slots: Arc<Semaphore>,
    /// Who holds one of these hears changes of another node.
    pub(crate) listen_slots: Arc<Semaphore>,
    /// Who holds one of these makes a quote.
    pub(crate) quote_slots: Arc<Semaphore>,
    /// The meshes of the machine that was quoted for last.
    pub(crate) quote_meshes: QuoteMeshes,
    pub(crate) changes: watch::Sender<u64>,
    /// The copies that screens show while builds are broken out.
    pub(crate) shown: ShownCopies,
    /// Wakes whoever looks for changes: a person said something that others wait for.
    pub(crate) said: Notify,
}

/// What is made of builds once, and kept.
pub(crate) struct PageCaches {
    pub(crate) scenes: RecentCache<CompressedBody>,
    pub(crate) picks: RecentCache<CachedPickMap>,
    pub(crate) pictures: RecentCache<Bytes>,
    pub(crate) parts: RecentCache<Bytes>,
}

impl DashboardState {
    /// The current settings.
    pub(crate) fn current_settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether a page shows a form to whoever looks at it: the farm takes orders from pages, and the form needs no more than this role.
    pub(crate) fn offers(&self, role: Role) -> bool {
        self.orders && RequestClient::current().is_none_or(|client| client.role >= role)
    }

    /// How the pages show times.
    pub(crate) fn time_view(&self) -> TimeView {
        TimeView::current(&self.current_settings().time_zone)
    }

    /// The plans of all machines, as of now.
    pub(crate) async fn read_plans(&self) -> HandlerResult<Vec<MachinePlan>> {
        Ok(read_plans(&self.ledger, self.current_settings().profiles.values(), Timestamp::now()).await?)
    }

    /// A text that changes whenever anything changes that the pages show, and never otherwise.
    pub(crate) async fn change_token(&self) -> HandlerResult<String> {
        if let Some(halted) = self.farm.halt_reason() {
            return Ok(halted);
        }
        let (settings, last) = (self.current_settings(), self.ledger.last_event_id().await?);
        let reading = FarmReading::read(&self.ledger, settings.profiles.values(), Timestamp::now()).await?;
        let nodes = self.ledger.list_nodes().await?;
        let alive = nodes.iter().map(|node| node.alive).collect::<Vec<_>>();
        let notices = farm::alerts_of_farm(&settings, &nodes);
        let picked = (self.ledger.last_pick_id().await?, self.shown.taken());
        let (status, facts) = (&reading.rows.statuses, reading.facts());
        // What each printer does is a word that time alone changes, too.
        let doing: Vec<_> =
            facts.iter().flat_map(|fact| &fact.printers).map(|printer| (printer.state, printer.build)).collect();
        Ok(format!("{alive:?} {last} {picked:?} {status:?} {notices:?} {doing:?}"))
    }
}
