//! The addresses of the pages, in one list: the server serves them, and the guard learns from it who may ask. So no page is served that
//! nobody thought of a role for.

use std::sync::Arc;

use access::Role;
use axum::{
    Router,
    extract::DefaultBodyLimit,
    http::Method,
    routing::{MethodFilter, get, on},
};

use super::{asset_route, drop, metrics, sent_form};
use crate::web::{
    board::components,
    break_out::break_out,
    core::{command, content, device_name, picture, scene, state::DashboardState},
    doors::api_route::{HandlerMaker, is_path_of},
    forms::{build_forms, finish_forms, machine_forms, order_forms, part_forms},
    help::pages as help,
    pages::{
        build, costs, downloads, farm as farm_page, flush, history, live, month, needs, order, part, pick_page, search,
    },
    paper::{label_form, record_page},
    people::{account, people_page, sign_in},
};

/// What may be done at an address of the pages.
pub(crate) struct PageRoute {
    /// GET or POST.
    pub(crate) method: &'static str,
    pub(crate) path: &'static str,
    /// Who may; `None` = whoever can connect.
    pub(crate) role: Option<Role>,
    /// Which of several nodes answers.
    pub(crate) answered_by: AnsweringNode,
    handler: HandlerMaker,
}

/// Which node of a farm answers what is asked of a machine, or of a build of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AnsweringNode {
    /// The one that is asked.
    Any,
    /// The one that serves the machine, while it runs: there, screens are kept apart, and files need not be fetched.
    OfMachine,
    /// No other than the one that serves the machine: the folders are there.
    OnlyOfMachine,
}

/// Something to look at.
const fn look(path: &'static str, handler: HandlerMaker) -> PageRoute {
    PageRoute { method: "GET", path, role: Some(Role::Read), answered_by: AnsweringNode::Any, handler }
}

/// Something that a node answers which knows more than the others.
const fn at(answered_by: AnsweringNode, route: PageRoute) -> PageRoute {
    PageRoute { answered_by, ..route }
}

/// Something to look at without saying who one is.
const fn open(path: &'static str, handler: HandlerMaker) -> PageRoute {
    PageRoute { role: None, ..look(path, handler) }
}

/// A form that orders, or changes what waits.
const fn order(path: &'static str, handler: HandlerMaker) -> PageRoute {
    PageRoute { method: "POST", role: Some(Role::Order), ..look(path, handler) }
}

/// A form that says what is done.
const fn operate(path: &'static str, handler: HandlerMaker) -> PageRoute {
    PageRoute { role: Some(Role::Operate), ..order(path, handler) }
}

use AnsweringNode::{OfMachine, OnlyOfMachine};

/// All addresses of the pages.
pub(crate) const PAGES: &[PageRoute] = &[
    look("/", |method| on(method, farm_page::show_farm)),
    look("/builds/{build}", |method| on(method, build::show_build)),
    operate("/builds/{build}/told", |method| on(method, build_forms::post_told)),
    look("/builds/{build}/pick", |method| on(method, pick_page::show_pick_map)),
    at(OfMachine, look("/builds/{build}/break-out", |method| on(method, break_out::show_step))),
    at(OfMachine, operate("/builds/{build}/break-out", |method| on(method, break_out::post_mark))),
    at(OfMachine, look("/builds/{build}/live", |method| on(method, live::stream_changes))),
    at(OnlyOfMachine, look("/builds/{build}/file", |method| on(method, downloads::get_build_file))),
    at(OfMachine, look("/builds/{build}/report.html", |method| on(method, downloads::get_report))),
    look("/builds/{build}/pick.csv", |method| on(method, downloads::get_pick_csv)),
    at(OnlyOfMachine, look("/builds/{build}/search.json", |method| on(method, downloads::get_search_report))),
    at(OfMachine, operate("/builds/{build}/break-out/all", |method| on(method, break_out::post_all))),
    at(OfMachine, operate("/builds/{build}/break-out/undo", |method| on(method, break_out::post_undo))),
    look("/builds/{build}/parts/{part}/picture", |method| on(method, picture::get_part_picture)),
    look("/builds/{build}/picture", |method| on(method, picture::get_picture)),
    look("/builds/{build}/labels.pdf", |method| on(method, label_form::get_build_labels)),
    look("/builds/{build}/scene", |method| on(method, scene::get_scene)),
    look("/machines/{machine}/flush", |method| on(method, flush::show_preview)),
    look("/machines/{machine}/drop", |method| on(method, drop::show_form)),
    at(
        OnlyOfMachine,
        order("/machines/{machine}/files", |method| on(method, drop::post_files).layer(DefaultBodyLimit::disable())),
    ),
    at(OnlyOfMachine, operate("/machines/{machine}/dismiss", |method| on(method, needs::post_dismiss))),
    operate("/machines/{machine}/load", |method| on(method, machine_forms::post_load)),
    operate("/machines/{machine}/printer", |method| on(method, machine_forms::post_printer)),
    look("/history", |method| on(method, history::show_history)),
    look("/history.csv", |method| on(method, history::download_csv)),
    look("/history.json", |method| on(method, history::download_json)),
    look("/costs", |method| on(method, costs::show_costs)),
    look("/costs.csv", |method| on(method, costs::download_csv)),
    look("/costs-by-build.csv", |method| on(method, costs::download_shares_csv)),
    look("/costs.json", |method| on(method, costs::get_costs)),
    look("/month", |method| on(method, month::show_month)),
    look("/month.csv", |method| on(method, month::download_csv)),
    look("/month.json", |method| on(method, month::get_month)),
    look("/plan", |method| on(method, farm_page::lead_to_board)),
    look("/components", |method| on(method, components::show_components)),
    look("/parts", |method| on(method, part::list_parts)),
    look("/parts/{part}", |method| on(method, part::show_part)),
    look("/parts/{part}/record", |method| on(method, record_page::show_record)),
    look("/parts/{part}/record.pdf", |method| on(method, record_page::get_record_pdf)),
    look("/parts/{part}/picture", |method| on(method, picture::get_lone_picture)),
    order("/parts/{part}/edit", |method| on(method, part_forms::post_edit)),
    operate("/parts/{part}/finish", |method| on(method, finish_forms::post_finish)),
    operate("/parts/{part}/reprint", |method| on(method, part_forms::post_reprint)),
    look("/search", |method| on(method, search::show_found)),
    look("/help", |method| on(method, help::show_contents)),
    look("/help/{chapter}", |method| on(method, help::show_chapter)),
    look("/live", |method| on(method, live::stream_changes)),
    open("/sign-in", |method| on(method, sign_in::show_form)),
    PageRoute { method: "POST", ..open("/sign-in", |method| on(method, sign_in::post_password)) },
    PageRoute { method: "POST", ..open("/sign-in/pin", |method| on(method, sign_in::post_pin)) },
    PageRoute { method: "POST", ..open("/sign-out", |method| on(method, sign_in::post_sign_out)) },
    look("/you", |method| on(method, account::show_account)),
    PageRoute { method: "POST", ..look("/you", |method| on(method, account::post_account)) },
    PageRoute { role: Some(Role::Admin), ..look("/people", |method| on(method, people_page::show_people)) },
    PageRoute { role: Some(Role::Admin), ..operate("/people", |method| on(method, people_page::post_people)) },
    operate("/commands", |method| on(method, command::post_command)),
    PageRoute { method: "POST", ..look("/name", |method| on(method, device_name::post_name)) },
    look("/told/{number}", |method| on(method, sent_form::show_told)),
    look("/orders", |method| on(method, order::list_orders)),
    look("/orders/{order}", |method| on(method, order::show_order)),
    order("/orders/{order}/cancel", |method| on(method, order_forms::post_cancel)),
    operate("/orders/{order}/close", |method| on(method, order_forms::post_close)),
    order("/orders/{order}/edit", |method| on(method, order_forms::post_edit)),
    look("/orders/{order}/labels.pdf", |method| on(method, label_form::get_order_labels)),
    order("/orders/{order}/move", |method| on(method, order_forms::post_move)),
    operate("/orders/{order}/reprint", |method| on(method, order_forms::post_reprint)),
    open("/assets/{name}", |method| on(method, asset_route::get_asset)),
    look("/content/{hash}", |method| on(method, content::get_content)),
    PageRoute {
        role: Some(Role::Operate),
        ..look("/builds/{build}/seen", |method| on(method, content::get_seen_file))
    },
    look("/metrics", |method| on(method, metrics::get_metrics)),
    look("/readyz", |method| on(method, metrics::get_readiness)),
    open("/healthz", |_| get(|| async { "alive\n" })),
];

/// What may be done at this address with this method; `None` = it is none of the pages.
pub(super) fn find_page(method: &Method, path: &str) -> Option<&'static PageRoute> {
    // Whoever may get a page may get its head.
    let method = if *method == Method::HEAD { "GET" } else { method.as_str() };
    PAGES.iter().find(|route| route.method == method && is_path_of(route.path, path))
}

/// The addresses of the pages.
pub(super) fn routes() -> Router<Arc<DashboardState>> {
    let add = |router: Router<Arc<DashboardState>>, route: &PageRoute| {
        let method = if route.method == "GET" { MethodFilter::GET } else { MethodFilter::POST };
        router.route(route.path, (route.handler)(method))
    };
    PAGES.iter().fold(Router::new(), add)
}
