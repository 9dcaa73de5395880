//! The page on which people sign in, with a password; or, on a device that several share and where somebody gave one, with a PIN. Every
//! sign-in makes a new token, so that nobody knows it beforehand; it is in a cookie, and never in an address.

use std::{sync::Arc, time::Instant};

use access::{PasswordHash, hash_token, is_person_name, random_token};
use axum::{
    Form,
    extract::State,
    http::{Extensions, HeaderMap, StatusCode, header},
    response::{IntoResponse, Redirect, Response},
};
use language::say;
use ledger::PersonSecrets;
use maud::{Markup, html};
use serde::Deserialize;

use super::visitor::{find_session, session_cookie, session_hash};
use crate::web::{
    base::{
        client_gate::peer_address,
        client_limits::{ADDRESS_ATTEMPTS, NAME_ATTEMPTS},
        error::{HandlerError, HandlerResult, page_with_status},
        page::html_page,
        query::Query,
    },
    clients::client::RequestClient,
    core::{form_answer::address_here, state::DashboardState},
};

/// What the page asks again after it was refused.
#[derive(Debug, Default)]
pub(crate) struct SignInForm {
    /// Where the person wants to go.
    pub(crate) to: String,
    pub(crate) name: String,
    /// Why not.
    pub(crate) problem: Option<String>,
}

/// The fields of both forms.
#[derive(Deserialize)]
pub(crate) struct SignInFields {
    #[serde(default)]
    name: String,
    #[serde(default)]
    password: String,
    #[serde(default)]
    pin: String,
    /// The device is used by several.
    #[serde(default)]
    shared: bool,
    #[serde(default)]
    to: String,
}

/// The page with the forms; where others share the device, theirs first.
pub(crate) async fn form_page(web: &DashboardState, headers: &HeaderMap, asked: &SignInForm) -> HandlerResult<Markup> {
    let session = find_session(web, headers).await?.map(|(_, session)| session);
    let is_shared = session.is_some_and(|session| session.is_shared);
    let with_pin: Vec<String> = match is_shared {
        true => web.ledger.list_people().await?.into_iter().filter(|one| one.has_pin).map(|one| one.name).collect(),
        false => Vec::new(),
    };
    let is_empty = !is_shared && !web.ledger.has_people().await?;
    let current = RequestClient::current();
    let person = current.as_ref().and_then(RequestClient::person);
    let content = html! {
        h1 #sign-in { (say!("sign-in")) }
        @if let Some(problem) = &asked.problem { p #problem role="alert" { (problem) } }
        @if is_empty { p { (say!("no-people-yet")) " " code translate="no" { "nestd people add NAME --role admin" } } }
        @if let Some(person) = person {
            p { (say!("you-are", name = &person.name)) " " a href="/you" { (say!("your-account")) } }
        }
        @if !with_pin.is_empty() {
            section {
                h2 { (say!("go-on-with-pin")) }
                form.tell method="post" action="/sign-in/pin" {
                    input type="hidden" name="to" value=(asked.to);
                    label { (say!("pin")) input name="pin" type="password" inputmode="numeric" autocomplete="off" required maxlength="8"; }
                    @for name in &with_pin { button type="submit" name="name" value=(name) translate="no" { (name) } }
                }
            }
            h2 { (say!("with-password")) }
        }
        form.tell method="post" action="/sign-in" {
            input type="hidden" name="to" value=(asked.to);
            label { (say!("your-name")) input name="name" value=(asked.name) autocomplete="username" autocapitalize="none" required maxlength="64"; }
            label { (say!("password")) input name="password" type="password" autocomplete="current-password" required maxlength="200"; }
            label.check { input type="checkbox" name="shared" value="true" checked[is_shared]; (say!("device-is-shared")) }
            button type="submit" { (say!("sign-in")) }
        }
    };
    Ok(html_page(&say!("sign-in"), "/sign-in", None, &content))
}

/// Where a person came from.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct SignInQuery {
    #[serde(default)]
    to: String,
}

/// The page by itself. It leads back to the page whose link was followed.
pub(crate) async fn show_form(
    State(web): State<Arc<DashboardState>>,
    Query(query): Query<SignInQuery>,
    headers: HeaderMap,
) -> HandlerResult<Markup> {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let came_from = text(header::REFERER).split_once("://").and_then(|(_, rest)| rest.strip_prefix(text(header::HOST)));
    let to = Some(query.to.as_str()).filter(|to| !to.is_empty()).or(came_from).unwrap_or_default();
    let to = if to.starts_with("/sign-in") { "/" } else { address_here(to) };
    form_page(&web, &headers, &SignInForm { to: to.to_owned(), ..SignInForm::default() }).await
}

/// A name and a password.
pub(crate) async fn post_password(
    State(web): State<Arc<DashboardState>>,
    extensions: Extensions,
    headers: HeaderMap,
    Form(fields): Form<SignInFields>,
) -> HandlerResult<Response> {
    let address = peer_address(&extensions).to_owned();
    let checked = check_secret(&web, &address, &fields.name, &fields.password, Secret::Password).await?;
    let Some(person) = checked else {
        return refuse(&web, &headers, &fields, StatusCode::FORBIDDEN, say!("wrong-password")).await;
    };
    let token = random_token();
    let former = session_hash(&headers).unwrap_or_default();
    web.ledger.open_session(&hash_token(&token), &person, fields.shared, &former).await?;
    tracing::info!("{person} signed in from {}.", place_of(&address));
    Ok(lead_with_token(&headers, &token, &fields.to))
}

/// A name and a PIN, on a device that is shared.
pub(crate) async fn post_pin(
    State(web): State<Arc<DashboardState>>,
    extensions: Extensions,
    headers: HeaderMap,
    Form(fields): Form<SignInFields>,
) -> HandlerResult<Response> {
    let session = find_session(&web, &headers).await?.filter(|(_, session)| session.is_shared);
    let Some((device, _)) = session else {
        return refuse(&web, &headers, &fields, StatusCode::FORBIDDEN, say!("pin-needs-shared-device")).await;
    };
    let address = peer_address(&extensions).to_owned();
    let Some(person) = check_secret(&web, &address, &fields.name, &fields.pin, Secret::Pin).await? else {
        let is_over = web.ledger.count_wrong_pin(&device).await?;
        let text = if is_over { say!("too-many-pins") } else { say!("wrong-pin") };
        return refuse(&web, &headers, &fields, StatusCode::FORBIDDEN, text).await;
    };
    let token = random_token();
    if !web.ledger.hand_session_on(&device, &hash_token(&token), Some(&person)).await? {
        return refuse(&web, &headers, &fields, StatusCode::FORBIDDEN, say!("pin-needs-shared-device")).await;
    }
    Ok(lead_with_token(&headers, &token, &fields.to))
}

/// What is to end.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct SignOutFields {
    /// Whether a shared device needs a password again.
    #[serde(default)]
    device: bool,
}

/// The person leaves this browser. A shared device waits for the PIN of another one.
pub(crate) async fn post_sign_out(
    State(web): State<Arc<DashboardState>>,
    headers: HeaderMap,
    Form(fields): Form<SignOutFields>,
) -> HandlerResult<Response> {
    let Some(hash) = session_hash(&headers) else { return Ok(Redirect::to("/sign-in").into_response()) };
    let is_shared = web.ledger.find_session(&hash).await?.is_some_and(|session| session.is_shared);
    let token = (is_shared && !fields.device).then(random_token);
    match &token {
        Some(token) => {
            web.ledger.hand_session_on(&hash, &hash_token(token), None).await?;
        }
        None => web.ledger.end_session(&hash).await?,
    }
    let cookie = session_cookie(&headers, token.as_deref());
    Ok((cookie.into_iter().collect::<HeaderMap>(), Redirect::to("/sign-in")).into_response())
}

/// What a person must know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Secret {
    Password,
    Pin,
}

/// Whether a person knows the secret: then the name, as events have it. Who is not known, or has none, is refused after as long a time.
///
/// # Errors
/// `TooMany` after too many wrong ones, of the name or from the address.
pub(super) async fn check_secret(
    web: &DashboardState,
    address: &str,
    name: &str,
    given: &str,
    secret: Secret,
) -> HandlerResult<Option<String>> {
    let name = name.trim();
    let found = if is_person_name(name) { web.ledger.find_secrets(name).await? } else { None };
    let folded: String = name.to_lowercase().chars().take(64).collect();
    let tried = [(format!("{secret:?} of {folded}"), NAME_ATTEMPTS), (format!("from {address}"), ADDRESS_ATTEMPTS)];
    if let Err(wait) = web.attempts.begin(&tried, Instant::now()) {
        let secs = wait.as_secs().max(1);
        return Err(HandlerError::TooMany(secs, say!("too-many-attempts", minutes = secs.div_ceil(60))));
    }
    let hash = match (&found, secret) {
        (Some(PersonSecrets { password, .. }), Secret::Password) => password.clone(),
        (Some(PersonSecrets { pin, .. }), Secret::Pin) => pin.clone(),
        (None, _) => PasswordHash::default(),
    };
    let given = given.to_owned();
    let is_right = web.attempts.work(move || hash.is_of(&given)).await?;
    if is_right {
        web.attempts.succeed(&tried);
    } else {
        // What somebody types as a name may be the password.
        let known = found.as_ref().map_or("a name that nobody has", |found| found.name.as_str());
        let what = if secret == Secret::Pin { "PIN" } else { "password" };
        tracing::warn!("A wrong {what} for {known}, from {}.", place_of(address));
    }
    Ok(found.filter(|_| is_right).map(|found| found.name))
}

fn place_of(address: &str) -> &str {
    if address.is_empty() { "this server" } else { address }
}

fn lead_with_token(headers: &HeaderMap, token: &str, to: &str) -> Response {
    let cookie: HeaderMap = session_cookie(headers, Some(token)).into_iter().collect();
    (cookie, Redirect::to(address_here(to))).into_response()
}

async fn refuse(
    web: &DashboardState,
    headers: &HeaderMap,
    fields: &SignInFields,
    status: StatusCode,
    problem: String,
) -> HandlerResult<Response> {
    let asked = SignInForm {
        to: address_here(&fields.to).to_owned(),
        name: fields.name.clone(),
        problem: Some(problem.clone()),
    };
    Ok(page_with_status(status, problem, form_page(web, headers, &asked).await?))
}
