//! The addresses of the JSON interface, in one list: the server serves them, the guard learns from it who may ask, and `openapi.json` is
//! derived from it.

use std::sync::Arc;

use access::Role;
use axum::{
    Router,
    extract::DefaultBodyLimit,
    http::Method,
    middleware::from_fn,
    routing::{MethodFilter, on},
};
use farm::{CostReport, DatedBuild, DatedOrder, MachinePlan, OrderQuote};
use ledger::{FinishingStep, HeightSummary};

use super::{
    api,
    api_route::{ApiRoute, RequestBody, SchemaMaker, ask, is_path_of, operate, schema_of, tell},
    dto::{BuildResponse, PartResource, PartResponse, RecordResponse},
    edit_door, operate_door, order_door, order_request, put_content, quote, upload_door,
};
use crate::{
    tables::PickList,
    web::{
        base::query::refuse_query,
        core::state::DashboardState,
        pages::{costs, history, month, order, part, pick_page},
    },
};

const EDIT: RequestBody = RequestBody::Json(schema_of::<edit_door::EditRequest>);
const ORDER: RequestBody = RequestBody::Form("order", schema_of::<order_request::OrderRequest>);
const ACCEPTED: (&str, Option<SchemaMaker>) = ("202", Some(schema_of::<order_door::OrderAccepted>));

/// What programs may ask.
const QUESTIONS: [ApiRoute; 16] = [
    ask("/api/v1/farm", "farm", "The farm as it stands", schema_of::<api::FarmResponse>, |method| {
        on(method, api::get_farm)
    }),
    ApiRoute {
        query: Some(schema_of::<history::HistoryFilter>),
        ..ask(
            "/api/v1/builds",
            "builds",
            "Builds past nesting, newest first unless sorted otherwise, 500 at a time",
            schema_of::<Vec<DatedBuild>>,
            |method| on(method, api::list_builds),
        )
    },
    ApiRoute {
        query: Some(schema_of::<history::HistoryFilter>),
        without: &["sort", "after"],
        ..ask(
            "/api/v1/heights",
            "heights",
            "What the published builds come to, by machine; filtered as the builds are",
            schema_of::<Vec<HeightSummary>>,
            |method| on(method, api::list_height_sums),
        )
    },
    ask(
        "/api/v1/builds/{build}",
        "build",
        "A build with its parts and placements",
        schema_of::<BuildResponse>,
        |method| on(method, api::get_build),
    ),
    ask(
        "/api/v1/builds/{build}/pick",
        "pick",
        "The copies of a build in the order in which they come out of the cake",
        schema_of::<PickList>,
        |method| on(method, pick_page::get_pick_list),
    ),
    ApiRoute {
        query: Some(schema_of::<part::PartFilter>),
        ..ask(
            "/api/v1/parts",
            "parts",
            "Parts, newest first, 500 at a time; without a state or a name those that are not built yet, of the refused ones \
                those of the last 30 days",
            schema_of::<Vec<PartResource>>,
            |method| on(method, api::list_parts),
        )
    },
    ask(
        "/api/v1/parts/{part}",
        "part",
        "A part, where its copies are and what happened to it",
        schema_of::<PartResponse>,
        |method| on(method, api::get_part),
    ),
    ask(
        "/api/v1/parts/{part}/record",
        "record",
        "How the copies of a part were made: powder, file, proof and print of each build, and who took each copy out",
        schema_of::<RecordResponse>,
        |method| on(method, api::get_record),
    ),
    ApiRoute {
        query: Some(schema_of::<order::OrderFilter>),
        ..ask(
            "/api/v1/orders",
            "orders",
            "Orders with what became of their copies and when they are done: by due date, and last those that are over",
            schema_of::<Vec<DatedOrder>>,
            |method| on(method, order::get_orders),
        )
    },
    ApiRoute {
        query: Some(schema_of::<month::MonthQuestion>),
        ..ask(
            "/api/v1/month",
            "month",
            "What each machine made in a month and in the one before, what came late and what failed",
            schema_of::<month::MonthResponse>,
            |method| on(method, month::get_month),
        )
    },
    ApiRoute {
        query: Some(schema_of::<costs::CostQuestion>),
        ..ask(
            "/api/v1/costs",
            "costs",
            "What the builds of a month, an order or one build cost, and which order bears what of it",
            schema_of::<CostReport>,
            |method| on(method, costs::get_costs),
        )
    },
    ApiRoute {
        query: Some(schema_of::<api::PlanQuestion>),
        ..ask(
            "/api/v1/plan",
            "plan",
            "The builds to come of each machine, if nothing more arrives, and the due dates at risk",
            schema_of::<Vec<MachinePlan>>,
            |method| on(method, api::get_plans),
        )
    },
    ApiRoute {
        query: Some(schema_of::<api::EventQuestion>),
        ..ask(
            "/api/v1/events",
            "events",
            "What happened, each event once in the order of their numbers, as a webhook gets it; last says what to ask for next",
            schema_of::<api::EventsResponse>,
            |method| on(method, api::get_events),
        )
    },
    ask(
        "/api/v1/orders/{order}",
        "order",
        "An order with its lines: what became of their copies, and the builds that hold them",
        schema_of::<order::OrderResponse>,
        |method| on(method, order::get_order),
    ),
    ask(
        "/api/v1/orders/{order}/lines/{line}",
        "line",
        "A line, as the order was answered or by the number of its part: its parts, and why one was refused",
        schema_of::<edit_door::LineResponse>,
        |method| on(method, edit_door::get_line),
    ),
    ask(
        "/api/v1/content/{hash}",
        "content",
        "Whether the farm has a file of this BLAKE3 that was put",
        schema_of::<put_content::ContentResource>,
        |method| on(method, put_content::get_put_content),
    ),
];

/// What programs may order and tell.
const DOORS: [ApiRoute; 19] = [
    ApiRoute {
        answer: ("201", Some(schema_of::<put_content::ContentResource>)),
        ..tell(
            ("POST", "/api/v1/content"),
            "post_content",
            "Puts a file, and says its BLAKE3",
            RequestBody::Bytes,
            |method| on(method, put_content::post_content),
        )
    },
    ApiRoute {
        answer: ("201", Some(schema_of::<put_content::ContentResource>)),
        ..tell(
            ("PUT", "/api/v1/content/{hash}"),
            "put_content",
            "Puts a file whose BLAKE3 this is, so that lines can order copies of it; kept for 7 days after it was last put or ordered",
            RequestBody::Bytes,
            |method| on(method, put_content::put_content),
        )
    },
    ApiRoute {
        answer: ACCEPTED,
        headers: &["Idempotency-Key"],
        ..tell(
            ("POST", "/api/v1/orders"),
            "post_order",
            "Orders copies of files. The order is durable when it is answered; its parts follow within seconds",
            ORDER,
            |method| on(method, order_door::post_order),
        )
    },
    ApiRoute {
        answer: ACCEPTED,
        headers: &["Idempotency-Key"],
        ..tell(
            ("POST", "/api/v1/orders/{order}/lines"),
            "post_lines",
            "Adds lines to an order; a line of a name that still waits there is a revision of it",
            ORDER,
            |method| on(method, order_door::post_lines),
        )
    },
    ApiRoute {
        role: Role::Read,
        answer: ("200", Some(schema_of::<OrderQuote>)),
        ..tell(
            ("POST", "/api/v1/quote"),
            "post_quote",
            "When parts could be done that nobody has ordered yet, and what they would add; nothing is changed",
            RequestBody::Form("quote", schema_of::<order_request::OrderRequest>),
            |method| on(method, quote::post_quote).layer(DefaultBodyLimit::disable()),
        )
    },
    tell(
        ("PATCH", "/api/v1/orders/{order}"),
        "patch_order",
        "Changes what was asked with the waiting lines of an order, and who it is for; copies, orientation and unit are changed line by line",
        EDIT,
        |method| on(method, edit_door::patch_order),
    ),
    tell(
        ("DELETE", "/api/v1/orders/{order}"),
        "delete_order",
        "Cancels what arrives, is read or waits of an order; copies in builds stay there",
        RequestBody::Nothing,
        |method| on(method, edit_door::delete_order),
    ),
    operate(
        "/api/v1/orders/{order}/close",
        "post_close",
        "Closes an order as it is: what waits of it is cancelled, what was refused asks nobody any more",
        RequestBody::Nothing,
        |method| on(method, operate_door::post_close),
    ),
    tell(
        ("PATCH", "/api/v1/orders/{order}/lines/{line}"),
        "patch_line",
        "Changes what was asked with a line; the copies of a file that holds several parts by the numbers of these",
        EDIT,
        |method| on(method, edit_door::patch_line),
    ),
    tell(
        ("DELETE", "/api/v1/orders/{order}/lines/{line}"),
        "delete_line",
        "Cancels what arrives, is read or waits of a line; copies in builds stay there",
        RequestBody::Nothing,
        |method| on(method, edit_door::delete_line),
    ),
    operate(
        "/api/v1/builds/{build}/outcome",
        "post_outcome",
        "Tells what became of the print of a build; bad copies wait again",
        RequestBody::Json(schema_of::<operate_door::OutcomeRequest>),
        |method| on(method, operate_door::post_outcome),
    ),
    operate(
        "/api/v1/builds/{build}/release",
        "post_release",
        "Says that a proved build may be published",
        RequestBody::Json(schema_of::<operate_door::ReleaseRequest>),
        |method| on(method, operate_door::post_release),
    ),
    operate(
        "/api/v1/machines/{machine}/load",
        "post_load",
        "Says what material is loaded in a machine; parts of another one wait from then on",
        RequestBody::Json(schema_of::<operate_door::LoadRequest>),
        |method| on(method, operate_door::post_load),
    ),
    ApiRoute {
        answer: ("200", Some(schema_of::<Vec<FinishingStep>>)),
        ..operate(
            "/api/v1/parts/{part}/finishing",
            "post_finishing",
            "Says of a finishing step of a part whether it is done",
            RequestBody::Json(schema_of::<operate_door::FinishingRequest>),
            |method| on(method, operate_door::post_finishing),
        )
    },
    operate(
        "/api/v1/parts/{part}/retry",
        "post_retry",
        "Reads a refused part again; its mesh is mended only if that is said",
        RequestBody::Json(schema_of::<operate_door::RetryRequest>),
        |method| on(method, operate_door::post_retry),
    ),
    operate(
        "/api/v1/parts/{part}/confirm",
        "post_confirm",
        "Prints a part that waits for an answer as it is",
        RequestBody::Nothing,
        |method| on(method, operate_door::post_confirm),
    ),
    operate(
        "/api/v1/machines/{machine}/flush",
        "post_flush",
        "Nests and publishes the waiting parts of a machine now",
        RequestBody::Nothing,
        |method| on(method, operate_door::post_flush),
    ),
    operate(
        "/api/v1/machines/{machine}/pause",
        "post_pause",
        "Lets a machine begin no build until it is resumed",
        RequestBody::Nothing,
        |method| on(method, operate_door::post_pause),
    ),
    operate(
        "/api/v1/machines/{machine}/resume",
        "post_resume",
        "Lets a paused machine begin builds again",
        RequestBody::Nothing,
        |method| on(method, operate_door::post_resume),
    ),
];

const UPLOAD_PATH: &str = "/api/v1/uploads/{upload}";

/// Uploads that may be cut and go on, by tus 1.0.
const UPLOADS: [ApiRoute; 4] = [
    ApiRoute {
        answer: ("201", None),
        headers: &["Tus-Resumable", "Upload-Length", "Upload-Metadata"],
        ..tell(
            ("POST", "/api/v1/uploads"),
            "post_upload",
            "Begins an upload of Upload-Length bytes, by tus 1.0; Location says where. Upload-Metadata may name its blake3. Kept for a \
                day after its last byte",
            RequestBody::Nothing,
            |method| on(method, upload_door::post_upload).options(upload_door::get_options),
        )
    },
    ask(
        UPLOAD_PATH,
        "upload",
        "How far an upload is; HEAD tells the same as headers. A complete one says its content",
        schema_of::<upload_door::UploadResource>,
        |method| on(method, upload_door::get_upload),
    ),
    ApiRoute {
        answer: ("204", None),
        headers: &["Tus-Resumable", "Upload-Offset"],
        ..tell(
            ("PATCH", UPLOAD_PATH),
            "patch_upload",
            "Sends more of an upload, as application/offset+octet-stream, from Upload-Offset on",
            RequestBody::Piece,
            |method| on(method, upload_door::patch_upload),
        )
    },
    ApiRoute {
        answer: ("204", None),
        headers: &["Tus-Resumable"],
        ..tell(("DELETE", UPLOAD_PATH), "delete_upload", "Gives an upload up", RequestBody::Nothing, |method| {
            on(method, upload_door::delete_upload)
        })
    },
];

/// All routes of the interface.
pub(crate) fn all_routes() -> impl Iterator<Item = &'static ApiRoute> {
    static ALL: [&[ApiRoute]; 3] = [&QUESTIONS, &DOORS, &UPLOADS];
    ALL.iter().flat_map(|routes| routes.iter())
}

/// The addresses of the interface.
pub(crate) fn routes() -> Router<Arc<DashboardState>> {
    let method_of = |route: &ApiRoute| MethodFilter::try_from(Method::from_bytes(route.method.as_bytes()).ok()?).ok();
    let add = |router: Router<Arc<DashboardState>>, route: &ApiRoute| match method_of(route) {
        Some(method) => {
            let handler = (route.handler)(method);
            let asks = route.query.is_some();
            router.route(route.path, if asks { handler } else { handler.layer(from_fn(refuse_query)) })
        }
        None => router,
    };
    all_routes().fold(Router::new(), add).layer(DefaultBodyLimit::disable())
}

/// What may be done at this address with this method; `None` = it is none of the interface.
pub(crate) fn find_route(method: &Method, path: &str) -> Option<&'static ApiRoute> {
    all_routes().find(|route| route.method == method.as_str() && is_path_of(route.path, path))
}
