//! The web server: its routes and its start.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use axum::{Router, extract::DefaultBodyLimit, middleware, routing::get};
use farm::{JudgedFiles, QuoteMeshes, ServiceBridge};
use language::say;
use ledger::{Ledger, LedgerUser};
use settings::{SharedSettings, WebSettings};
use tokio::sync::{Semaphore, watch};
use tracing::info;

use super::{drop, guard, page_routes, pass_on, sent_form, spoken};
use crate::{
    metrics::MetricsExporter,
    web::{
        base::{
            cache::RecentCache,
            client_gate::{ClientGate, ProxyHeader},
            client_limits::{ClientLimits, ClientRates},
            compressed::compress_pages,
            connection_limits::{LimitedListener, RequestInProgress},
            error::HandlerError,
            listener::DashboardListener,
        },
        core::{
            form_keys::FormKeys,
            order_keys::OrderDoor,
            picture, scene,
            state::{DashboardState, PageCaches},
        },
        doors::{
            api_routes, openapi, quote,
            request_stage::{self, MAX_BODY_BYTES},
        },
        pages::{live, pick_page},
    },
};

/// Serves the dashboard until the future is dropped. The daemon must have opened the ledger before: it creates and
/// checks it.
///
/// # Errors
/// When the address cannot be bound, when it needs a token and none is configured, or when the token cannot be read.
pub async fn serve_dashboard(
    settings: SharedSettings,
    web: WebSettings,
    farm: ServiceBridge,
    judged: JudgedFiles,
) -> Result<()> {
    let mut clients = read_clients(&web)?;
    let current = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
    let (path, quote_meshes) = (current.ledger.clone(), QuoteMeshes::of_farm(&current));
    let opened = Ledger::open_existing_for(&path, LedgerUser::Pages).await;
    let ledger = opened.context("opening the ledger for the dashboard")?;
    clients.node_secret = farm::node_secret(&ledger).await.context("the secret of the nodes")?;
    // Requests that are still in progress hold the ledger as well.
    let _closed = LedgerCloseGuard(ledger.clone());
    let listener = DashboardListener::bind_socket(&web.listen).await?;
    listener.require_token(clients.has_tokens() || clients.sign_in)?;
    // From now on it is known whether people sign in, also when the ledger does not answer.
    clients.people.note(ledger.has_people().await.context("looking for people")?);
    let changes = watch::Sender::new(0);
    info!("The dashboard is at {}.", web.listen);
    let shared = Arc::new(DashboardState {
        farm,
        judged,
        settings,
        is_tcp: matches!(listener, DashboardListener::Tcp(_)),
        hosts: web.hosts,
        proxy: web
            .user_header
            .and_then(|header| header.parse().ok())
            .map(|header| ProxyHeader { header, from: web.user_header_from }),
        orders: web.orders,
        limits: ClientLimits::new(ClientRates {
            per_sec: web.client_requests_per_sec,
            burst: web.client_burst,
            bytes: web.client_bytes,
        }),
        clients,
        attempts: Default::default(),
        uploads: Default::default(),
        door: Arc::new(OrderDoor::default()),
        form_keys: FormKeys::of_farm(&ledger).await.context("the secret of the keys of forms")?,
        caches: PageCaches {
            scenes: RecentCache::new(scene::CACHED_SCENES),
            picks: RecentCache::new(pick_page::CACHED_MAPS),
            pictures: RecentCache::new(picture::CACHED_PICTURES),
            parts: RecentCache::new(picture::CACHED_PARTS),
        },
        metrics: MetricsExporter::default(),
        render_slot: Arc::new(Semaphore::new(1)),
        upload_slots: Arc::new(Semaphore::new(drop::MAX_UPLOADS)),
        pass_slots: Arc::new(Semaphore::new(pass_on::MAX_PASSED_ON)),
        listen_slots: Arc::new(Semaphore::new(live::MAX_LISTENERS)),
        quote_slots: Arc::new(Semaphore::new(quote::MAX_QUOTES)),
        quote_meshes,
        changes: changes.clone(),
        shown: Default::default(),
        said: Default::default(),
        ledger,
    });
    tokio::spawn(live::watch_for_changes(shared.clone(), changes));
    if shared.orders {
        tokio::spawn(drop::sweep_unfinished(shared.clone()));
    }
    let routes = build_router(shared).into_make_service_with_connect_info::<RequestInProgress>();
    match listener {
        DashboardListener::Tcp(listener) => axum::serve(LimitedListener::with_default_limits(listener), routes).await,
        DashboardListener::Unix(listener) => axum::serve(LimitedListener::with_default_limits(listener), routes).await,
    }
    .context("serving the dashboard")
}

/// Who may ask, as the settings and the files of tokens say.
fn read_clients(web: &WebSettings) -> Result<ClientGate> {
    if let Some(file) = &web.tokens_file {
        access::read_tokens(file)?;
    }
    Ok(ClientGate {
        token: web.token_file.as_deref().map(access::read_secret).transpose()?,
        node_secret: String::new(),
        tokens_file: web.tokens_file.clone(),
        without_token: web.without_token,
        sign_in: web.sign_in,
        people: Default::default(),
        watch: Mutex::default(),
    })
}

/// All routes of the dashboard.
pub(crate) fn build_router(web: Arc<DashboardState>) -> Router {
    page_routes::routes()
        .merge(api_routes::routes())
        .route("/api/v1/openapi.json", get(openapi::document))
        .fallback(|| async { HandlerError::NotFound(say!("page-of-address")) })
        .layer(middleware::from_fn_with_state(web.clone(), sent_form::carry_out_once))
        .layer(middleware::from_fn_with_state(web.clone(), pass_on::pass_on))
        .layer(middleware::from_fn(request_stage::buffer_then_answer))
        .layer(middleware::from_fn_with_state(web.clone(), guard::guard_request))
        .layer(middleware::from_fn(compress_pages))
        .layer(middleware::from_fn_with_state(web.clone(), spoken::speak))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .with_state(web)
}

/// Closes the ledger when the dashboard ends.
struct LedgerCloseGuard(Ledger);

impl Drop for LedgerCloseGuard {
    fn drop(&mut self) {
        let ledger = self.0.clone();
        tokio::spawn(async move { ledger.close().await });
    }
}
