//! Who may ask: names of this machine only (a page of another site must not reach the farm through a browser here), the
//! bearer token where one is asked for, for pages of other sites only links that a person follows, and orders from our own
//! pages. Every answer forbids what pages do not need.

use std::sync::Arc;

use axum::{
    extract::{Request, State},
    http::{HeaderValue, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};

use super::{
    problem::{Problem, in_form},
    state::Web,
};

/// No other host, no inline script, no frame around our pages.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
    connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

/// Lets a request through or refuses it.
pub(super) async fn guard(State(web): State<Arc<Web>>, request: Request, next: Next) -> Response {
    let path = request.uri().path().to_owned();
    let response = match judge(&web, &request) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    };
    let mut response = in_form(response, &path);
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
    if response.status() == StatusCode::UNAUTHORIZED {
        response.headers_mut().insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    }
    response
}

fn judge(web: &Web, request: &Request) -> Result<(), Problem> {
    let refused = |status, text: &str| Err(Problem::Refused(status, text.to_owned()));
    let said = |name: &'static str| request.headers().get(name).and_then(|value| value.to_str().ok());
    // A watchdog asks without a token whether the process lives.
    if request.uri().path() == "/healthz" {
        return Ok(());
    }
    if let Some(token) = &web.token {
        let given = said("authorization").and_then(|value| value.strip_prefix("Bearer ")).unwrap_or_default();
        if !is_same(given, token) {
            return refused(StatusCode::UNAUTHORIZED, "this farm asks for a bearer token");
        }
    } else if !is_own_name(web, said("host").unwrap_or_default()) {
        return refused(StatusCode::MISDIRECTED_REQUEST, "this farm does not answer to that name; see web.hosts");
    }
    let is_link = *request.method() == Method::GET && is_followed_link(&said);
    if !is_link && !is_from_us(&said) {
        return refused(
            StatusCode::FORBIDDEN,
            "to other sites' pages this farm answers only when a person follows a link, and orders are taken from its own pages",
        );
    }
    if !request.method().is_safe() && !is_from_our_site(web, &said) {
        return refused(
            StatusCode::FORBIDDEN,
            "orders are taken from this farm's own pages, and another site's page asks; behind a proxy its name must be in web.hosts",
        );
    }
    Ok(())
}

/// Whether what changes something was sent by a page of ours, or by no page. Over plain http to another name than localhost
/// browsers do not say `Sec-Fetch-Site`, but they name the page's site in `Origin`, or the page in `Referer`.
fn is_from_our_site<'r>(web: &Web, said: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    if said("sec-fetch-site").is_some() {
        return true; // judged above
    }
    let Some(site) = said("origin").or_else(|| said("referer")) else { return true };
    let Some((_, rest)) = site.split_once("://") else { return false }; // "null": a page that hides where it is from
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let is_here = said("host").is_some_and(|host| host.eq_ignore_ascii_case(authority));
    // A proxy may ask under another name than the browser; it listens on its scheme's own port.
    is_here || web.hosts.iter().any(|host| host.eq_ignore_ascii_case(authority))
}

/// Whether our own pages, a person (the address bar) or a program asks. What other sites' pages ask for, also those of our
/// neighbours and of other ports of this machine, they may not read; answering would only make this machine work.
fn is_from_us<'r>(said: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    said("sec-fetch-site").is_none_or(|site| site == "same-origin" || site == "none")
}

/// Whether a page is opened as a page of its own: not fetched, not an image, not in a frame, not in case somebody wants it.
fn is_followed_link<'r>(said: &impl Fn(&'static str) -> Option<&'r str>) -> bool {
    said("sec-fetch-mode") == Some("navigate")
        && said("sec-fetch-dest").is_none_or(|place| place == "document")
        && said("sec-purpose").is_none()
}

/// Compares in a time that does not tell how much is right.
fn is_same(given: &str, token: &str) -> bool {
    blake3::hash(given.as_bytes()) == blake3::hash(token.as_bytes())
}

/// Whether the Host header names this machine or a configured name. Behind a socket there is no browser of this machine.
fn is_own_name(web: &Web, host: &str) -> bool {
    let name = match host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, _)) => address,
        None => host.rsplit_once(':').map_or(host, |(name, _)| name),
    };
    let known = ["localhost", "127.0.0.1", "::1"].contains(&name) || web.hosts.iter().any(|h| h == name);
    known || !web.is_tcp
}
