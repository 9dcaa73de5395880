//! Decides which requests are answered:
//! - The Host header must name this machine: a page of another site must not reach the farm through a browser here.
//! - Where there are people or bearer tokens, the request must come from a person who is signed in, or carry a token; the role must allow
//!   what it asks.
//! - Pages of other sites may only link here; a link must be followed by a person.
//! - Commands must come from the dashboard's own pages.
//! - While the farm is halted because of its ledger, every answer is the reason.
//!
//! Security headers of every response forbid what the pages do not need.

use std::sync::Arc;

use access::Role;
use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, Method, StatusCode, header, request::Parts},
    middleware::Next,
    response::{IntoResponse, Response},
};
use language::say;

use super::{role_rules::needed_role, spoken::is_of_programs};
use crate::web::{
    base::{
        client_gate::peer_address,
        error::{HandlerError, format_error_response, page_with_status},
    },
    clients::client::{KnownBy, RequestClient},
    core::state::DashboardState,
    pages::live::is_stream_of_changes,
    people::{
        sign_in::{self, SignInForm},
        visitor,
    },
};

/// Allows no other host, no inline script and no frame around the pages.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; img-src 'self' data: blob:; \
    connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

/// Where uploads by tus are; every answer there names the version of the protocol.
const UPLOADS: &str = "/api/v1/uploads";

/// Passes a request on or refuses it, and adds the security headers.
pub(super) async fn guard_request(State(web): State<Arc<DashboardState>>, request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    let path = parts.uri.path().to_owned();
    let halted = web.farm.halt_reason().filter(|_| needs_ledger(&path));
    let response = match (check_request(&web, &parts).await, halted) {
        // Also where the ledger cannot say who asks.
        (Ok(_) | Err(HandlerError::Ledger(_)), Some(why)) => {
            HandlerError::Refused(StatusCode::SERVICE_UNAVAILABLE, why).into_response()
        }
        (Ok(client), None) => {
            let mut request = Request::from_parts(parts, body);
            request.extensions_mut().insert(client.clone());
            client.scope(next.run(request)).await
        }
        (Err(HandlerError::Refused(StatusCode::UNAUTHORIZED, text)), None) => ask_to_sign_in(&web, &parts, text).await,
        (Err(problem), _) => problem.into_response(),
    };
    let mut response = format_error_response(response, &path);
    let fixed = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::REFERRER_POLICY, "same-origin"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    let headers = response.headers_mut();
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    if path.starts_with(UPLOADS) {
        response.headers_mut().insert("tus-resumable", HeaderValue::from_static("1.0.0"));
    }
    if response.status() == StatusCode::UNAUTHORIZED {
        response.headers_mut().insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    }
    response
}

/// Whether the answer at an address comes from the ledger.
fn needs_ledger(path: &str) -> bool {
    path != "/healthz" && path != "/help" && !path.starts_with("/help/") && !path.starts_with("/assets/")
}

/// Who has to sign in is shown the form for that, in place of the page; programs and forms are told.
async fn ask_to_sign_in(web: &DashboardState, parts: &Parts, text: String) -> Response {
    let told = |text| HandlerError::Refused(StatusCode::UNAUTHORIZED, text).into_response();
    let is_page =
        parts.method.is_safe() && !is_of_programs(parts.uri.path()) && !is_stream_of_changes(parts.uri.path());
    if !is_page || !visitor::asks_for_people(web).await.unwrap_or(false) {
        return told(text);
    }
    let to = parts.uri.path_and_query().map_or("/", |to| to.as_str()).to_owned();
    let asked = SignInForm { to, ..SignInForm::default() };
    match sign_in::form_page(web, &parts.headers, &asked).await {
        Ok(page) => page_with_status(StatusCode::UNAUTHORIZED, text, page),
        Err(problem) => problem.into_response(),
    }
}

/// Who asks, unless it asks too much. `is_open` = whoever can connect may.
async fn identify_client(web: &DashboardState, parts: &Parts, is_open: bool) -> Result<RequestClient, HandlerError> {
    let address = peer_address(&parts.extensions);
    let is_file_of_pages = parts.uri.path().starts_with("/assets/");
    let found = if is_file_of_pages { Ok(RequestClient::nobody()) } else { visitor::identify(web, parts).await };
    match found {
        Ok(client) if client.counted_as.is_empty() => {
            web.limits.count_request(address)?;
            Ok(RequestClient { counted_as: address.to_owned(), ..client })
        }
        Ok(client) => web.limits.count_request(&client.counted_as).map(|()| client),
        Err(HandlerError::Refused(..)) if is_open => {
            web.limits.count_request(address)?;
            Ok(RequestClient { counted_as: address.to_owned(), ..RequestClient::stranger(Role::Read) })
        }
        Err(problem) => web.limits.count_request(address).and(Err(problem)),
    }
}

async fn check_request(web: &DashboardState, parts: &Parts) -> Result<RequestClient, HandlerError> {
    let refused = |status, text: String| Err(HandlerError::Refused(status, text));
    let header = |name: &'static str| parts.headers.get(name).and_then(|value| value.to_str().ok());
    let needed = needed_role(&parts.method, parts.uri.path());
    let client = match parts.uri.path() {
        // A watchdog asks without a token whether the process is alive.
        "/healthz" => return Ok(RequestClient::nobody()),
        _ => identify_client(web, parts, needed.is_none()).await?,
    };
    let has_token = matches!(client.known_by, KnownBy::Token(_)) || client.is_passed_on();
    if !has_token && !is_known_host(web, &parts.headers) {
        return refused(StatusCode::MISDIRECTED_REQUEST, say!("guard-host"));
    }
    if let Some(needed) = needed.filter(|needed| client.role < *needed) {
        let text = say!("guard-role", needed = needed.as_str(), own = client.role.as_str());
        return Err(HandlerError::Refused(StatusCode::FORBIDDEN, text));
    }
    let is_link = parts.method == Method::GET && is_followed_link(&header);
    if !is_link && !is_same_origin(&header) {
        return refused(StatusCode::FORBIDDEN, say!("guard-other-site"));
    }
    if !parts.method.is_safe() && !is_from_own_page(web, &header) {
        return refused(StatusCode::FORBIDDEN, say!("guard-other-page"));
    }
    Ok(client)
}

/// Whether a request that changes something was sent by one of our own pages, or by a program. Over plain HTTP to a
/// name other than localhost, browsers send no `Sec-Fetch-Site`. They still send the page's site in `Origin`, or the
/// page in `Referer`.
fn is_from_own_page<'r>(web: &DashboardState, header: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    if header("sec-fetch-site").is_some() {
        return true; // checked above
    }
    let Some(site) = header("origin").or_else(|| header("referer")) else { return true };
    let Some((_, rest)) = site.split_once("://") else { return false }; // "null": a page that hides its origin
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let is_here = header("host").is_some_and(|host| host.eq_ignore_ascii_case(authority));
    // A proxy may send another Host than the browser did; it listens on its scheme's default port.
    is_here || web.hosts.iter().any(|host| host.eq_ignore_ascii_case(authority))
}

/// Whether the request comes from our own pages, from a person (the address bar) or from a program. Pages of other
/// sites, of sibling domains and of other ports of this machine cannot read the response anyway; answering would only
/// cost work.
fn is_same_origin<'r>(header: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    header("sec-fetch-site").is_none_or(|site| site == "same-origin" || site == "none")
}

/// Whether the browser opens a page at top level: not a fetch, not an image, not a frame, not a prefetch.
fn is_followed_link<'r>(header: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    header("sec-fetch-mode") == Some("navigate")
        && header("sec-fetch-dest").is_none_or(|place| place == "document")
        && header("sec-purpose").is_none()
}

/// Whether the Host header, which comes once, names this machine or a configured host. On a Unix socket every name is accepted,
/// because no browser can reach it directly.
fn is_known_host(web: &DashboardState, headers: &HeaderMap) -> bool {
    let mut hosts = headers.get_all(header::HOST).iter();
    let (first, others) = (hosts.next().and_then(|host| host.to_str().ok()), hosts.next());
    let known = first.filter(|_| others.is_none()).and_then(name_of_host).is_some_and(|name| {
        let configured = web.hosts.iter().map(String::as_str);
        ["localhost", "127.0.0.1", "::1"].into_iter().chain(configured).any(|known| known.eq_ignore_ascii_case(name))
    });
    known || !web.is_tcp
}

/// The name or address of a Host header: `name`, `name:port`, `[address]` or `[address]:port`, and nothing else.
fn name_of_host(host: &str) -> Option<&str> {
    let (name, port) = match host.strip_prefix('[') {
        Some(rest) => rest.split_once(']')?,
        None => host.split_at(host.find(':').unwrap_or(host.len())),
    };
    let is_port = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_digit()) && digits.parse::<u16>().is_ok();
    (port.is_empty() || port.strip_prefix(':').is_some_and(is_port)).then_some(name)
}
