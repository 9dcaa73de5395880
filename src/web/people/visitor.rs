//! Who asks, where there are people: a program by its token, a person by the word of a trusted proxy or by the session of the browser. Without
//! people, all is as it was before there were any.

use access::hash_token;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use jiff::{SignedDuration, Timestamp};
use language::say;
use ledger::SessionRow;

use crate::web::{
    base::{
        client_gate::peer_address,
        error::{HandlerError, HandlerResult},
    },
    clients::client::{RequestClient, SignInWay, SignedIn, bearer_token, cookie_value},
    core::state::DashboardState,
};

/// The cookie with the token of a session.
const SESSION_COOKIE: &str = "nestd_session";
/// A session is noted as seen once in this time, s.
const SEEN_STEP: SignedDuration = SignedDuration::from_secs(60);
/// What the script of a page sends when it looks for changes by itself: nobody need sit there.
const REFRESH_HEADER: &str = "nestd-refresh";

/// Whether people have to say who they are.
pub(crate) async fn asks_for_people(web: &DashboardState) -> HandlerResult<bool> {
    if web.clients.sign_in {
        return Ok(true);
    }
    if let Some(any) = web.clients.people.known(true) {
        return Ok(any);
    }
    match web.ledger.has_people().await {
        Ok(any) => {
            web.clients.people.note(any);
            Ok(any)
        }
        Err(error) => web.clients.people.known(false).ok_or_else(|| error.into()),
    }
}

/// Who sends a request.
///
/// # Errors
/// `Refused` where it is neither a token that the farm knows nor a person who is signed in.
pub(crate) async fn identify(
    web: &DashboardState,
    request: &axum::http::request::Parts,
) -> HandlerResult<RequestClient> {
    let headers = &request.headers;
    if let Some(client) = web.clients.identify_node(headers)? {
        return Ok(client);
    }
    if !asks_for_people(web).await? {
        return web.clients.identify_client(headers);
    }
    if let Some(token) = bearer_token(headers) {
        return web.clients.client_of_token(token);
    }
    let by_proxy = web.proxy.as_ref().and_then(|proxy| proxy.user_named(peer_address(&request.extensions), headers));
    if let Some(name) = by_proxy {
        let Some(person) = web.ledger.find_person(&name).await? else {
            return Err(HandlerError::Refused(StatusCode::FORBIDDEN, say!("proxy-names-unknown", name = name)));
        };
        let signed_in = SignedIn { name: person.name, way: SignInWay::Proxy, is_shared: false };
        return Ok(RequestClient::of_person(signed_in, person.role));
    }
    if let Some((hash, session)) = find_session(web, headers).await?
        && let (Some(name), Some(role)) = (session.person, session.role)
    {
        let is_quiet = Timestamp::now().duration_since(*session.seen_at) < SEEN_STEP;
        if !is_quiet && is_done_by_person(request) {
            web.ledger.note_session_seen(&hash).await?;
        }
        let way = if session.with_pin { SignInWay::Pin } else { SignInWay::Password };
        return Ok(RequestClient::of_person(SignedIn { name, way, is_shared: session.is_shared }, role));
    }
    let text = || HandlerError::Refused(StatusCode::UNAUTHORIZED, say!("not-signed-in"));
    web.clients.without_token.map(RequestClient::stranger).ok_or_else(text)
}

/// Whether a person did something: opened a page, or sent a form.
fn is_done_by_person(request: &axum::http::request::Parts) -> bool {
    let accept = request.headers.get(header::ACCEPT).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let is_page = accept.contains("text/html") && !request.headers.contains_key(REFRESH_HEADER);
    request.method != Method::GET || is_page
}

/// The session of a browser and the hash of its token.
pub(super) async fn find_session(
    web: &DashboardState,
    headers: &HeaderMap,
) -> HandlerResult<Option<(String, SessionRow)>> {
    let Some(hash) = session_hash(headers) else { return Ok(None) };
    Ok(web.ledger.find_session(&hash).await?.map(|session| (hash, session)))
}

/// The hash of the token that a browser has.
pub(super) fn session_hash(headers: &HeaderMap) -> Option<String> {
    cookie_value(headers, SESSION_COOKIE).filter(|token| !token.is_empty()).map(|token| hash_token(&token))
}

/// Has a browser keep the token of a session, or forget it. Over TLS, it sends it over TLS only.
pub(super) fn session_cookie(request: &HeaderMap, token: Option<&str>) -> Option<(header::HeaderName, HeaderValue)> {
    let is_encrypted = request.get(header::ORIGIN).is_some_and(|origin| origin.as_bytes().starts_with(b"https://"));
    let secure = if is_encrypted { "; Secure" } else { "" };
    let age_secs = token.map_or(0, |_| ledger::SESSION_HOURS * 3600);
    let token = token.unwrap_or_default();
    let cookie = format!("{SESSION_COOKIE}={token}; Path=/; Max-Age={age_secs}; SameSite=Lax; HttpOnly{secure}");
    HeaderValue::from_str(&cookie).ok().map(|cookie| (header::SET_COOKIE, cookie))
}
