//! The server: what all handlers share, the routes, and where it listens.

use std::{
    os::unix::fs::FileTypeExt,
    path::Path,
    sync::{Arc, PoisonError},
    time::Duration,
};

use anyhow::{Context, Result, bail};
use axum::{
    Router,
    body::Bytes,
    extract::DefaultBodyLimit,
    middleware,
    routing::{get, post},
};
use tokio::{
    net::{TcpListener, UnixListener},
    sync::watch,
};
use tracing::info;

use super::{
    api, assets, build,
    cache::Cache,
    farm as farm_page, guard, history, live, metrics, order, part, pick,
    picture::{self, Pictures},
    problem::{Answer, Problem},
    scene,
};
use crate::{
    access, farm,
    ledger::{Ledger, LedgerError},
    metrics::Metrics,
    settings::{Listen, Settings, Shared, Web as WebSettings},
};

/// Between two tries to open a ledger that the daemon is still making.
const OPEN_AGAIN: Duration = Duration::from_millis(200);
/// Largest form, bytes.
const MOST_BODY: usize = 4096;

/// What all handlers share.
pub(super) struct Web {
    pub(super) ledger: Ledger,
    pub(super) settings: Shared,
    pub(super) listen: Listen,
    pub(super) hosts: Vec<String>,
    pub(super) orders: bool,
    pub(super) token: Option<String>,
    /// Stands in every form, so that no other site can post one.
    pub(super) form_key: String,
    pub(super) scenes: Cache<Bytes>,
    pub(super) picks: Cache<pick::Map>,
    pub(super) metrics: Metrics,
    pub(super) pictures: Pictures,
    pub(super) changes: watch::Sender<u64>,
}

impl Web {
    /// The settings as they are now.
    pub(super) fn settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// A text that changes when anything does that pages show.
    pub(super) async fn pulse(&self) -> Answer<String> {
        let status = self.ledger.status().await?;
        let alive = self.ledger.daemon().await?.is_some_and(|daemon| daemon.alive);
        let notices = farm::kept_notices(&self.settings().state_dir);
        Ok(format!("{alive} {status:?} {notices:?}"))
    }
}

/// Serves the dashboard until the process ends. The daemon makes the ledger; it is waited for.
///
/// # Errors
/// When the address cannot be listened on, or the token cannot be read.
pub async fn serve(settings: Shared, web: WebSettings) -> Result<()> {
    let token = web.token_file.as_deref().map(access::read_secret).transpose()?;
    let path = settings.read().unwrap_or_else(PoisonError::into_inner).ledger.clone();
    let door = Door::open(&web.listen).await?;
    let ledger = ledger(&path).await?;
    let changes = watch::Sender::new(0);
    info!("The dashboard is at {}.", web.listen);
    let shared = Arc::new(Web {
        ledger,
        settings,
        listen: web.listen,
        hosts: web.hosts,
        orders: web.orders,
        token,
        form_key: format!("{:032x}", rand::random::<u128>()),
        scenes: Cache::new(scene::KEPT),
        picks: Cache::new(pick::KEPT),
        metrics: Metrics::default(),
        pictures: Pictures::default(),
        changes: changes.clone(),
    });
    tokio::spawn(live::look(shared.clone(), changes));
    let routes = routes(shared);
    match door {
        Door::Tcp(listener) => axum::serve(listener, routes).await,
        Door::Unix(listener) => axum::serve(listener, routes).await,
    }
    .context("serving the dashboard")
}

/// Every address of the dashboard.
pub(super) fn routes(web: Arc<Web>) -> Router {
    Router::new()
        .route("/", get(farm_page::show))
        .route("/builds/{build}", get(build::show))
        .route("/builds/{build}/pick", get(pick::show))
        .route("/builds/{build}/picture", get(picture::picture))
        .route("/builds/{build}/scene", get(scene::scene))
        .route("/history", get(history::show))
        .route("/history.csv", get(history::csv))
        .route("/history.json", get(history::json))
        .route("/parts", get(part::list))
        .route("/parts/{part}", get(part::show))
        .route("/live", get(live::live))
        .route("/orders", post(order::order))
        .route("/assets/{name}", get(assets::asset))
        .route("/api/v1/openapi.json", get(api::openapi))
        .route("/api/v1/farm", get(api::farm))
        .route("/api/v1/builds", get(api::builds))
        .route("/api/v1/builds/{build}", get(api::build))
        .route("/api/v1/parts/{part}", get(api::part))
        .route("/metrics", get(metrics::metrics))
        .route("/healthz", get(|| async { "alive\n" }))
        .route("/readyz", get(metrics::readyz))
        .fallback(|| async { Problem::NotFound("page of that address".to_owned()) })
        .layer(middleware::from_fn_with_state(web.clone(), guard::guard))
        .layer(DefaultBodyLimit::max(MOST_BODY))
        .with_state(web)
}

async fn ledger(path: &Path) -> Result<Ledger> {
    loop {
        match Ledger::open_existing(path).await {
            Err(LedgerError::Missing { .. } | LedgerError::OlderSchema { .. }) => tokio::time::sleep(OPEN_AGAIN).await,
            opened => return opened.context("opening the ledger for the dashboard"),
        }
    }
}

/// A socket that is listened on.
enum Door {
    Tcp(TcpListener),
    Unix(UnixListener),
}

impl Door {
    async fn open(listen: &Listen) -> Result<Self> {
        let cannot = || format!("listening on {listen}");
        match listen {
            Listen::Tcp(address) => TcpListener::bind(address).await.map(Self::Tcp).with_context(cannot),
            Listen::Unix(path) => {
                // The socket of a daemon that is gone would be in the way.
                if std::fs::symlink_metadata(path).is_ok_and(|meta| meta.file_type().is_socket()) {
                    std::fs::remove_file(path).with_context(cannot)?;
                }
                UnixListener::bind(path).map(Self::Unix).with_context(cannot)
            }
            Listen::Systemd => Self::of_systemd().with_context(cannot),
        }
    }

    fn of_systemd() -> Result<Self> {
        let mut sockets = listenfd::ListenFd::from_env();
        if let Ok(Some(socket)) = sockets.take_tcp_listener(0) {
            socket.set_nonblocking(true)?;
            return Ok(Self::Tcp(TcpListener::from_std(socket)?));
        }
        if let Ok(Some(socket)) = sockets.take_unix_listener(0) {
            socket.set_nonblocking(true)?;
            return Ok(Self::Unix(UnixListener::from_std(socket)?));
        }
        bail!("systemd passed no socket: start nestd by its socket unit")
    }
}
