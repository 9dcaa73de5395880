//! The web server: its routes and its start.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use axum::{
    Router,
    extract::DefaultBodyLimit,
    middleware,
    routing::{get, post},
};
use language::say;
use ledger::{Ledger, LedgerUser};
use tokio::sync::{Semaphore, watch};
use tracing::info;

use super::{asset_route, drop, guard, metrics, sent_form, spoken};
use crate::{
    farm::{JudgedFiles, QuoteMeshes, ServiceBridge},
    metrics::MetricsExporter,
    settings::{SharedSettings, WebSettings},
    web::{
        base::{
            cache::RecentCache,
            client::ClientGate,
            client_limits::{ClientLimits, ClientRates},
            compressed::compress_pages,
            connection_limits::{LimitedListener, RequestInProgress},
            error::HandlerError,
            listener::DashboardListener,
        },
        board::components,
        break_out::break_out,
        core::{
            command, content, device_name,
            order_keys::OrderDoor,
            picture, scene,
            state::{DashboardState, PageCaches},
        },
        doors::{
            api_routes, openapi, quote,
            request_stage::{self, MAX_BODY_BYTES},
        },
        forms::{build_forms, machine_forms, order_forms, part_forms},
        help::pages as help,
        labels::label_form,
        pages::{
            build, costs, downloads, farm as farm_page, flush, history, live, month, needs, order, part, pick_page,
            search,
        },
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
    if let Some(file) = &web.tokens_file {
        access::read_tokens(file)?;
    }
    let clients = ClientGate {
        token: web.token_file.as_deref().map(access::read_secret).transpose()?,
        tokens_file: web.tokens_file,
        without_token: web.without_token,
        watch: Mutex::default(),
    };
    let current = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
    let (path, quote_meshes) = (current.ledger.clone(), QuoteMeshes::of_farm(&current));
    let opened = Ledger::open_existing_for(&path, LedgerUser::Pages).await;
    let ledger = opened.context("opening the ledger for the dashboard")?;
    // Requests that are still in progress hold the ledger as well.
    let _closed = LedgerCloseGuard(ledger.clone());
    let listener = DashboardListener::bind_socket(&web.listen).await?;
    listener.require_token(clients.has_tokens())?;
    let changes = watch::Sender::new(0);
    info!("The dashboard is at {}.", web.listen);
    let shared = Arc::new(DashboardState {
        ledger,
        farm,
        judged,
        settings,
        is_tcp: matches!(listener, DashboardListener::Tcp(_)),
        hosts: web.hosts,
        user_header: web.user_header.and_then(|header| header.parse().ok()),
        orders: web.orders,
        limits: ClientLimits::new(ClientRates {
            per_sec: web.client_requests_per_sec,
            burst: web.client_burst,
            bytes: web.client_bytes,
        }),
        clients,
        uploads: Default::default(),
        door: Arc::new(OrderDoor::default()),
        form_keys: Default::default(),
        caches: PageCaches {
            scenes: RecentCache::new(scene::CACHED_SCENES),
            picks: RecentCache::new(pick_page::CACHED_MAPS),
            pictures: RecentCache::new(picture::CACHED_PICTURES),
            parts: RecentCache::new(picture::CACHED_PARTS),
        },
        metrics: MetricsExporter::default(),
        render_slot: Arc::new(Semaphore::new(1)),
        upload_slots: Arc::new(Semaphore::new(drop::MAX_UPLOADS)),
        quote_slots: Arc::new(Semaphore::new(quote::MAX_QUOTES)),
        quote_meshes,
        changes: changes.clone(),
        shown: Default::default(),
        said: Default::default(),
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

/// All routes of the dashboard.
pub(crate) fn build_router(web: Arc<DashboardState>) -> Router {
    api_routes::routes()
        .route("/api/v1/openapi.json", get(openapi::document))
        .route("/", get(farm_page::show_farm))
        .route("/builds/{build}", get(build::show_build))
        .route("/builds/{build}/told", post(build_forms::post_told))
        .route("/builds/{build}/pick", get(pick_page::show_pick_map))
        .route("/builds/{build}/break-out", get(break_out::show_step).post(break_out::post_mark))
        .route("/builds/{build}/file", get(downloads::get_build_file))
        .route("/builds/{build}/report.html", get(downloads::get_report))
        .route("/builds/{build}/pick.csv", get(downloads::get_pick_csv))
        .route("/builds/{build}/search.json", get(downloads::get_search_report))
        .route("/builds/{build}/break-out/all", post(break_out::post_all))
        .route("/builds/{build}/break-out/undo", post(break_out::post_undo))
        .route("/builds/{build}/parts/{part}/picture", get(picture::get_part_picture))
        .route("/builds/{build}/picture", get(picture::get_picture))
        .route("/builds/{build}/labels.pdf", get(label_form::get_build_labels))
        .route("/builds/{build}/scene", get(scene::get_scene))
        .route("/machines/{machine}/flush", get(flush::show_preview))
        .route("/machines/{machine}/drop", get(drop::show_form))
        .route("/machines/{machine}/files", post(drop::post_files).layer(DefaultBodyLimit::disable()))
        .route("/machines/{machine}/dismiss", post(needs::post_dismiss))
        .route("/machines/{machine}/load", post(machine_forms::post_load))
        .route("/machines/{machine}/printer", post(machine_forms::post_printer))
        .route("/history", get(history::show_history))
        .route("/history.csv", get(history::download_csv))
        .route("/history.json", get(history::download_json))
        .route("/costs", get(costs::show_costs))
        .route("/costs.csv", get(costs::download_csv))
        .route("/costs-by-build.csv", get(costs::download_shares_csv))
        .route("/costs.json", get(costs::get_costs))
        .route("/month", get(month::show_month))
        .route("/month.csv", get(month::download_csv))
        .route("/month.json", get(month::get_month))
        .route("/plan", get(farm_page::lead_to_board))
        .route("/components", get(components::show_components))
        .route("/parts", get(part::list_parts))
        .route("/parts/{part}", get(part::show_part))
        .route("/parts/{part}/picture", get(picture::get_lone_picture))
        .route("/parts/{part}/edit", post(part_forms::post_edit))
        .route("/parts/{part}/reprint", post(part_forms::post_reprint))
        .route("/search", get(search::show_found))
        .route("/help", get(help::show_contents))
        .route("/help/{chapter}", get(help::show_chapter))
        .route("/live", get(live::stream_changes))
        .route("/commands", post(command::post_command))
        .route("/name", post(device_name::post_name))
        .route("/told/{number}", get(sent_form::show_told))
        .route("/orders", get(order::list_orders))
        .route("/orders/{order}", get(order::show_order))
        .route("/orders/{order}/cancel", post(order_forms::post_cancel))
        .route("/orders/{order}/close", post(order_forms::post_close))
        .route("/orders/{order}/edit", post(order_forms::post_edit))
        .route("/orders/{order}/labels.pdf", get(label_form::get_order_labels))
        .route("/orders/{order}/move", post(order_forms::post_move))
        .route("/orders/{order}/reprint", post(order_forms::post_reprint))
        .route("/assets/{name}", get(asset_route::get_asset))
        .route("/content/{hash}", get(content::get_content))
        .route("/metrics", get(metrics::get_metrics))
        .route("/healthz", get(|| async { "alive\n" }))
        .route("/readyz", get(metrics::get_readiness))
        .fallback(|| async { HandlerError::NotFound(say!("page-of-address")) })
        .layer(middleware::from_fn_with_state(web.clone(), sent_form::carry_out_once))
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
