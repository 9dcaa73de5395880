//! The server: what all handlers share, the routes, and where it listens.

use std::{
    os::unix::{fs::FileTypeExt, net::UnixStream},
    path::Path,
    sync::{Arc, PoisonError},
};

use anyhow::{Context, Result, bail, ensure};
use axum::{
    Router,
    body::Bytes,
    extract::DefaultBodyLimit,
    middleware,
    routing::{get, post},
};
use tokio::{
    net::{TcpListener, UnixListener},
    sync::{Semaphore, watch},
};
use tracing::info;

use super::{
    api, assets, build,
    cache::Cache,
    farm as farm_page, guard, history, live, metrics, order, part, pick, picture,
    problem::{Answer, Problem},
    scene,
};
use crate::{
    access, farm,
    ledger::Ledger,
    metrics::Metrics,
    settings::{Listen, Settings, Shared, Web as WebSettings},
};

/// Largest form, bytes.
const MOST_BODY: usize = 4096;

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
    pub(super) scenes: Cache<Bytes>,
    pub(super) picks: Cache<pick::Map>,
    pub(super) metrics: Metrics,
    pub(super) pictures: Cache<Bytes>,
    /// Who holds it makes one of these three: looking takes one core and the meshes of one build from the farm at most.
    pub(super) looking: Arc<Semaphore>,
    pub(super) changes: watch::Sender<u64>,
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

/// Serves the dashboard until it is dropped. The ledger must be open already: the daemon makes it and finds it whole.
///
/// # Errors
/// When the address cannot be listened on, or only with a token and there is none, or the token cannot be read.
pub async fn serve(settings: Shared, web: WebSettings) -> Result<()> {
    let token = web.token_file.as_deref().map(access::read_secret).transpose()?;
    let path = settings.read().unwrap_or_else(PoisonError::into_inner).ledger.clone();
    let ledger = Ledger::open_existing(&path).await.context("opening the ledger for the dashboard")?;
    // Connections that are still being answered hold the ledger, too.
    let _closed = CloseAtEnd(ledger.clone());
    let door = Door::open(&web.listen).await?;
    door.demand_token(token.as_deref())?;
    let changes = watch::Sender::new(0);
    info!("The dashboard is at {}.", web.listen);
    let shared = Arc::new(Web {
        ledger,
        settings,
        is_tcp: matches!(door, Door::Tcp(_)),
        hosts: web.hosts,
        orders: web.orders,
        token,
        form_key: format!("{:032x}", rand::random::<u128>()),
        scenes: Cache::new(scene::KEPT),
        picks: Cache::new(pick::KEPT),
        metrics: Metrics::default(),
        pictures: Cache::new(picture::KEPT),
        looking: Arc::new(Semaphore::new(1)),
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
        .route("/api/v1/heights", get(api::heights))
        .route("/api/v1/builds/{build}", get(api::build))
        .route("/api/v1/builds/{build}/pick", get(pick::list))
        .route("/api/v1/parts", get(api::parts))
        .route("/api/v1/parts/{part}", get(api::part))
        .route("/metrics", get(metrics::metrics))
        .route("/healthz", get(|| async { "alive\n" }))
        .route("/readyz", get(metrics::readyz))
        .fallback(|| async { Problem::NotFound("page of that address".to_owned()) })
        .layer(middleware::from_fn_with_state(web.clone(), guard::guard))
        .layer(DefaultBodyLimit::max(MOST_BODY))
        .with_state(web)
}

/// Closes the ledger when the dashboard ends.
struct CloseAtEnd(Ledger);

impl Drop for CloseAtEnd {
    fn drop(&mut self) {
        let ledger = self.0.clone();
        tokio::spawn(async move { ledger.close().await });
    }
}

/// The socket of a daemon that is gone would be in the way; one that answers is somebody's.
fn remove_left(path: &Path) -> Result<()> {
    if !std::fs::symlink_metadata(path).is_ok_and(|meta| meta.file_type().is_socket()) {
        return Ok(());
    }
    ensure!(UnixStream::connect(path).is_err(), "somebody else listens there");
    Ok(std::fs::remove_file(path)?)
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
                remove_left(path).with_context(cannot)?;
                UnixListener::bind(path).map(Self::Unix).with_context(cannot)
            }
            Listen::Systemd => Self::of_systemd().with_context(cannot),
        }
    }

    /// Other machines may ask only with a token, whoever opened the socket.
    fn demand_token(&self, token: Option<&str>) -> Result<()> {
        let Self::Tcp(listener) = self else { return Ok(()) };
        let address = listener.local_addr()?;
        ensure!(
            token.is_some() || address.ip().is_loopback(),
            "{address} can be reached from other machines: set web.token_file, or listen to this machine only"
        );
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn whoever_opened_the_socket_other_machines_ask_only_with_a_token() {
        for (address, reachable) in [("127.0.0.1:0", false), ("[::1]:0", false), ("0.0.0.0:0", true)] {
            let Ok(listener) = TcpListener::bind(address).await else { continue };
            let door = Door::Tcp(listener);
            assert_eq!(door.demand_token(None).is_err(), reachable, "{address}");
            assert!(door.demand_token(Some("a token of some letters")).is_ok());
        }
    }

    #[tokio::test]
    async fn a_socket_that_answers_is_left_and_one_that_is_left_over_goes() {
        let folder = tempfile::tempdir().unwrap();
        let listen = Listen::Unix(folder.path().join("web.sock"));
        let first = Door::open(&listen).await.unwrap();
        let refused = Door::open(&listen).await.map(drop).unwrap_err();
        assert!(format!("{refused:#}").contains("somebody else"), "{refused:#}");
        drop(first);
        assert!(Door::open(&listen).await.is_ok());
    }
}
