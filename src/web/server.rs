//! The server: the routes, and where it listens.

use std::sync::{Arc, PoisonError};

use anyhow::{Context, Result};
use axum::{
    Router,
    extract::DefaultBodyLimit,
    middleware,
    routing::{get, post},
};
use tokio::sync::{Semaphore, watch};
use tracing::info;

use super::{
    admit::{self, Admitting, Answering, MOST_BODY},
    assets, build,
    cache::Cache,
    door::Door,
    farm as farm_page, guard, history, live, metrics, openapi, order, part, pick, picture,
    problem::Problem,
    scene,
    state::{PageCaches, Web},
};
use crate::{
    access,
    ledger::Ledger,
    metrics::Metrics,
    settings::{Shared, Web as WebSettings},
};

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
        caches: PageCaches {
            scenes: Cache::new(scene::KEPT),
            picks: Cache::new(pick::KEPT),
            pictures: Cache::new(picture::KEPT),
        },
        metrics: Metrics::default(),
        looking: Arc::new(Semaphore::new(1)),
        changes: changes.clone(),
    });
    tokio::spawn(live::look(shared.clone(), changes));
    let routes = routes(shared).into_make_service_with_connect_info::<Answering>();
    match door {
        Door::Tcp(listener) => axum::serve(Admitting::usual(listener), routes).await,
        Door::Unix(listener) => axum::serve(Admitting::usual(listener), routes).await,
    }
    .context("serving the dashboard")
}

/// Every address of the dashboard.
pub(super) fn routes(web: Arc<Web>) -> Router {
    openapi::routes()
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
        .route("/metrics", get(metrics::metrics))
        .route("/healthz", get(|| async { "alive\n" }))
        .route("/readyz", get(metrics::readyz))
        .fallback(|| async { Problem::NotFound("page of that address".to_owned()) })
        .layer(middleware::from_fn(admit::answer))
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
