//! Who may ask: names of this machine only (a page of another site must not reach the farm through a browser here), the
//! bearer token where one is asked for, and orders only from our own pages. Every answer forbids what pages do not need.

use std::sync::Arc;

use axum::{
    extract::{Request, State},
    http::{HeaderValue, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};

use super::{
    problem::{Problem, in_form},
    server::Web,
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
    let said = |name| request.headers().get(name).and_then(|value| value.to_str().ok());
    // A watchdog asks without a token whether the process lives.
    if request.uri().path() == "/healthz" {
        return Ok(());
    }
    if let Some(token) = &web.token {
        let given = said(header::AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer ")).unwrap_or_default();
        if !is_same(given, token) {
            return refused(StatusCode::UNAUTHORIZED, "this farm asks for a bearer token");
        }
    } else if !is_own_name(web, said(header::HOST).unwrap_or_default()) {
        return refused(StatusCode::MISDIRECTED_REQUEST, "this farm does not answer to that name; see web.hosts");
    }
    if *request.method() != Method::GET && *request.method() != Method::HEAD {
        let from_us = said(header::HeaderName::from_static("sec-fetch-site"))
            .is_none_or(|site| site == "same-origin" || site == "none");
        if !from_us {
            return refused(StatusCode::FORBIDDEN, "orders are taken from this farm's own pages only");
        }
    }
    Ok(())
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
