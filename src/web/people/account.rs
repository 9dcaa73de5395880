//! What people change for themselves: password and PIN, and where they are signed in.

use std::sync::Arc;

use access::{PasswordHash, Role, hash_token, is_password, is_pin, random_token};
use anyhow::Context;
use axum::{
    Form,
    extract::State,
    http::{Extensions, HeaderMap, StatusCode},
    response::{IntoResponse, Redirect, Response},
};
use language::say;
use ledger::PersonChange;
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    sign_in::{Secret, check_secret},
    visitor::session_cookie,
};
use crate::{
    tables::role_text,
    web::{
        base::{
            client_gate::peer_address,
            error::{HandlerError, HandlerResult},
            page::html_page,
            query::Query,
        },
        clients::client::{RequestClient, SignInWay, SignedIn, user_of_person},
        core::{form_answer::key_field, state::DashboardState},
    },
};

/// What was done before the page was shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum AccountChange {
    Password,
    Pin,
    Everywhere,
}

/// What the page was asked.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct AccountQuery {
    done: Option<AccountChange>,
}

/// The form that changes something.
#[derive(Deserialize)]
pub(crate) struct AccountFields {
    #[serde(default)]
    key: String,
    what: AccountChange,
    #[serde(default)]
    current: String,
    #[serde(default)]
    new: String,
    #[serde(default)]
    again: String,
}

/// Refuses what comes from no page of this farm.
pub(super) fn check_key(web: &DashboardState, key: &str) -> HandlerResult<()> {
    let refused = || HandlerError::Refused(StatusCode::FORBIDDEN, say!("form-not-of-farm"));
    web.form_keys.is_own(key).then_some(()).ok_or_else(refused)
}

/// Hashes a password or PIN where that holds up no other request.
pub(super) async fn hash_secret(web: &DashboardState, secret: &str) -> HandlerResult<PasswordHash> {
    if secret.is_empty() {
        return Ok(PasswordHash::default());
    }
    let secret = secret.to_owned();
    let hashed = web.attempts.work(move || PasswordHash::of(&secret)).await?;
    Ok(hashed.context("there is no memory to hash a password")?)
}

/// The page of the person who is signed in.
pub(crate) async fn show_account(
    State(web): State<Arc<DashboardState>>,
    Query(query): Query<AccountQuery>,
    client: RequestClient,
) -> HandlerResult<Response> {
    let Some(person) = client.person() else { return Ok(Redirect::to("/sign-in").into_response()) };
    let done = query.done.map(|done| match done {
        AccountChange::Password => say!("password-changed"),
        AccountChange::Pin => say!("pin-changed"),
        AccountChange::Everywhere => say!("signed-out-everywhere"),
    });
    let content = html! {
        h1 { (say!("your-account")) }
        @if let Some(done) = done { p #answer role="status" { (done) } }
        p { (say!("you-are", name = &person.name)) " " (say!("your-role", role = client.role.as_str(), may = role_text(client.role))) }
        @if client.role == Role::Admin { p { a href="/people" { (say!("people")) } } }
        @if person.way != SignInWay::Proxy { (sign_out_forms(person)) }
        @if person.way == SignInWay::Password { (secret_forms(&web)) }
        @if person.way == SignInWay::Pin { p { (say!("pin-changes-nothing")) } }
    };
    Ok(html_page(&say!("your-account"), "/you", None, &content).into_response())
}

fn sign_out_forms(person: &SignedIn) -> Markup {
    html! {
        form.order method="post" action="/sign-out" { button type="submit" { (say!("sign-out")) } }
        @if person.is_shared {
            form.order method="post" action="/sign-out" {
                input type="hidden" name="device" value="true";
                button type="submit" { (say!("share-no-more")) }
            }
        }
    }
}

/// A form for the password, one for the PIN, and one that ends all sessions.
fn secret_forms(web: &DashboardState) -> Markup {
    let form = |what: &str, fields: Markup, button: String| {
        html! {
            form.filters method="post" action="/you" {
                (key_field(web))
                input type="hidden" name="what" value=(what);
                (fields)
                button type="submit" { (button) }
            }
        }
    };
    let field = |label: String, name: &str, complete: &str| html! { label { (label) input name=(name) type="password" autocomplete=(complete) maxlength="200"; } };
    let current = || field(say!("current-password"), "current", "current-password");
    let new_password = html! {
        (current())
        (field(say!("new-password"), "new", "new-password"))
        (field(say!("once-more"), "again", "new-password"))
    };
    let new_pin = html! {
        (current())
        label { (say!("new-pin")) input name="new" type="password" inputmode="numeric" autocomplete="off" maxlength="8"; }
        label { (say!("once-more")) input name="again" type="password" inputmode="numeric" autocomplete="off" maxlength="8"; }
    };
    html! {
        h2 { (say!("password")) }
        p { (say!("password-rule")) }
        (form("password", new_password, say!("change-password")))
        h2 { (say!("pin")) }
        p { (say!("pin-rule")) }
        (form("pin", new_pin, say!("change-pin")))
        h2 { (say!("other-devices")) }
        (form("everywhere", html! {}, say!("sign-out-everywhere")))
    }
}

/// Changes something for the person who is signed in with a password.
pub(crate) async fn post_account(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    extensions: Extensions,
    headers: HeaderMap,
    Form(fields): Form<AccountFields>,
) -> HandlerResult<Response> {
    check_key(&web, &fields.key)?;
    let Some(person) = client.person().filter(|person| person.way == SignInWay::Password) else {
        return Err(refused(say!("account-needs-password")));
    };
    let by = user_of_person(&person.name);
    if fields.what == AccountChange::Everywhere {
        web.ledger.change_person(&person.name, &PersonChange::SignedOut, &by).await?;
        return Ok((new_session(&web, &headers, person).await?, Redirect::to("/you?done=everywhere")).into_response());
    }
    let address = peer_address(&extensions).to_owned();
    if check_secret(&web, &address, &person.name, &fields.current, Secret::Password).await?.is_none() {
        return Err(refused(say!("wrong-current-password")));
    }
    if fields.new != fields.again {
        return Err(refused(say!("not-the-same-twice")));
    }
    if fields.what == AccountChange::Pin {
        let pin = check_pin(&fields.new)?;
        web.ledger.change_person(&person.name, &PersonChange::Pin(hash_secret(&web, pin).await?), &by).await?;
        return Ok(Redirect::to("/you?done=pin").into_response());
    }
    let password = hash_secret(&web, check_password(&fields.new, &person.name)?).await?;
    web.ledger.change_person(&person.name, &PersonChange::Password(password), &by).await?;
    Ok((new_session(&web, &headers, person).await?, Redirect::to("/you?done=password")).into_response())
}

/// A new session for a person whose sessions have ended.
async fn new_session(web: &DashboardState, headers: &HeaderMap, person: &SignedIn) -> HandlerResult<HeaderMap> {
    let token = random_token();
    web.ledger.open_session(&hash_token(&token), &person.name, person.is_shared, "").await?;
    Ok(session_cookie(headers, Some(&token)).into_iter().collect())
}

/// A text that may be the password of a person.
pub(super) fn check_password<'t>(text: &'t str, name: &str) -> HandlerResult<&'t str> {
    if is_password(text, name) { Ok(text) } else { Err(refused(say!("password-rule"))) }
}

/// A text that may be a PIN, or nothing for none.
fn check_pin(text: &str) -> HandlerResult<&str> {
    if text.is_empty() || is_pin(text) { Ok(text) } else { Err(refused(say!("pin-rule"))) }
}

pub(super) fn refused(text: String) -> HandlerError {
    HandlerError::Refused(StatusCode::BAD_REQUEST, text)
}
