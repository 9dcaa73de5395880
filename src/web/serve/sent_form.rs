//! Forms of pages. Each has a key of its own, made when its page is made, and is carried out once, however often it is sent: by a double
//! click, a reload, or back and once more. Afterwards the browser is led to a page that may be loaded again. A key is kept as the
//! `Idempotency-Key` of a program is.

use std::{future::Future, sync::Arc, time::Duration};

use anyhow::Context;
use axum::{
    body::{Body, to_bytes},
    extract::{Path, Request, State},
    http::{StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use jiff::{SignedDuration, Timestamp};
use language::say;
use ledger::AnsweredRequest;
use maud::{Markup, html};
use serde::Deserialize;

use crate::web::{
    base::{
        error::{HandlerError, HandlerResult},
        format::prose_with_pages,
        page::html_page,
        query::Query,
    },
    clients::client::RequestClient,
    core::{
        command::check_takes_orders, form_answer::FormAnswer, form_keys::number_of, order_keys::KeyGuard,
        state::DashboardState,
    },
    doors::request_stage::{MAX_BODY_BYTES, brings_files},
};

/// How long a form waits for the same form that is being carried out.
const TURN_TIMEOUT: Duration = Duration::from_secs(30);
/// How long another node may carry out a form; after that it is as if it had crashed.
const AT_WORK: SignedDuration = SignedDuration::from_secs(30);
/// Time between two looks whether it has ended.
const TURN_INTERVAL: Duration = Duration::from_millis(50);
/// A form that comes again so soon is another click of the same person, who need not be told.
const SAME_PRESS: SignedDuration = SignedDuration::from_secs(3);

/// Carries out every form of a page once. One with files is received first, by its handler, which calls [`carry_out_form`] itself.
pub(super) async fn carry_out_once(State(web): State<Arc<DashboardState>>, request: Request, next: Next) -> Response {
    let path = request.uri().path();
    let is_form = !request.method().is_safe() && !path.starts_with("/api/");
    if !is_form || is_of_people(path) || brings_files(&request) {
        return next.run(request).await;
    }
    receive_form(web, request, next).await.unwrap_or_else(IntoResponse::into_response)
}

/// Whether forms of people are sent there: they have passwords in them, of which nothing is kept, and do no harm when they come twice.
fn is_of_people(path: &str) -> bool {
    matches!(path, "/sign-in" | "/sign-in/pin" | "/sign-out" | "/you" | "/people")
}

async fn receive_form(web: Arc<DashboardState>, request: Request, next: Next) -> HandlerResult<Response> {
    let client = request.extensions().get().cloned().unwrap_or_else(RequestClient::nobody);
    let (head, body) = request.into_parts();
    let bytes = to_bytes(body, MAX_BODY_BYTES).await.context("the form did not arrive as a whole")?;
    let fields: Vec<(String, String)> = serde_urlencoded::from_bytes(&bytes).unwrap_or_default();
    let key = fields.iter().find(|(name, _)| name == "key").map(|(_, key)| key.clone()).unwrap_or_default();
    let mut asked = blake3::Hasher::new();
    asked.update(head.uri.path().as_bytes()).update(b"\n").update(&bytes);
    let fingerprint = asked.finalize().to_hex().to_string();
    let action = head.uri.path().to_owned();
    let answering = async move {
        let mut response = next.run(Request::from_parts(head, Body::from(bytes))).await;
        let answer = response.extensions_mut().get_mut::<FormAnswer>();
        if let Some(button) = answer.and_then(|answer| answer.anyway.as_mut()) {
            (button.action, button.fields) = (action, fields);
        }
        response
    };
    carry_out_form(web, &client, &key, fingerprint, answering).await
}

/// Refuses a form where the farm takes none, or that comes from no page of this farm.
pub(super) fn check_form_key(web: &DashboardState, key: &str) -> HandlerResult<()> {
    check_takes_orders(web)?;
    let unknown = || HandlerError::Refused(StatusCode::FORBIDDEN, say!("form-not-of-farm"));
    web.form_keys.is_own(key).then_some(()).ok_or_else(unknown)
}

/// Carries out a form, unless it was carried out before; then it is answered as it was. Once it has begun, it ends, also when its browser
/// has gone: a second click sends the first one away. `fingerprint` = BLAKE3 of what is asked.
pub(crate) async fn carry_out_form(
    web: Arc<DashboardState>,
    client: &RequestClient,
    key: &str,
    fingerprint: String,
    work: impl Future<Output = Response> + Send + 'static,
) -> HandlerResult<Response> {
    check_form_key(&web, key)?;
    let (client_name, number) = (client.key_name(), number_of(key).to_owned());
    let turn = take_turn(&web, &client_name, &number).await?;
    let known = settled_answer(&web, &client_name, &number).await?;
    if let Some((known, answer)) = &known
        && !answer.is_refused
    {
        return answer_again(known, answer, &fingerprint, &number);
    }
    let known = known.map(|(known, _)| known);
    let carry_out = async move {
        let _turn = turn;
        record_and_answer(&web, &client_name, &number, (fingerprint, known), work).await
    };
    tokio::spawn(language::current().scope(client.clone().scope(carry_out)))
        .await
        .context("a form was not carried out")?
}

/// Waits while the same form is being carried out.
async fn take_turn(web: &DashboardState, client: &str, number: &str) -> HandlerResult<KeyGuard> {
    let asked = std::time::Instant::now();
    loop {
        match web.door.begin_request(client, number) {
            Err(busy) if busy.status_code() == StatusCode::CONFLICT && asked.elapsed() < TURN_TIMEOUT => {
                tokio::time::sleep(TURN_INTERVAL).await;
            }
            turn => return turn,
        }
    }
}

/// What is known of a form, once no other node is at it; of one that never ends, that nothing is known.
async fn settled_answer(
    web: &DashboardState,
    client: &str,
    number: &str,
) -> HandlerResult<Option<(AnsweredRequest, FormAnswer)>> {
    let asked = std::time::Instant::now();
    loop {
        let known = web.ledger.find_answered_request(client, number).await?;
        let known = known.and_then(|known| FormAnswer::parse(&known).map(|answer| (known, answer)));
        // The clock of another server may be wrong by some.
        let is_at_it = |answer: &FormAnswer| answer.is_open && answer.at.duration_until(Timestamp::now()) < AT_WORK;
        match &known {
            Some((_, answer)) if web.ledger.file().is_none() && is_at_it(answer) && asked.elapsed() < TURN_TIMEOUT => {
                tokio::time::sleep(TURN_INTERVAL).await;
            }
            _ => return Ok(known),
        }
    }
}

fn answer_again(
    known: &AnsweredRequest,
    answer: &FormAnswer,
    fingerprint: &str,
    number: &str,
) -> HandlerResult<Response> {
    if known.fingerprint != fingerprint {
        let text = say!("form-sent-otherwise");
        return Err(HandlerError::Refused(StatusCode::UNPROCESSABLE_ENTITY, text));
    }
    Ok(answer.lead_on(number, answer.at.duration_until(Timestamp::now()) > SAME_PRESS))
}

/// Notes the form before anything is done, and what became of it afterwards: after a crash in between it is not done again.
async fn record_and_answer(
    web: &DashboardState,
    client: &str,
    number: &str,
    (fingerprint, mut known): (String, Option<AnsweredRequest>),
    work: impl Future<Output = Response>,
) -> HandlerResult<Response> {
    let answered = |answer: &FormAnswer| {
        let answer = serde_json::to_string(answer).context("writing the answer")?;
        HandlerResult::Ok(AnsweredRequest { fingerprint: fingerprint.clone(), answer })
    };
    let begun = answered(&FormAnswer::not_known())?;
    while !web.ledger.record_answered_request(client, number, &begun, known.as_ref()).await? {
        // Another node has begun with it just now; what that refuses is as if it was never sent.
        match settled_answer(web, client, number).await? {
            Some((known, answer)) if !answer.is_refused => return answer_again(&known, &answer, &fingerprint, number),
            _ => known = web.ledger.find_answered_request(client, number).await?,
        }
    }
    let response = work.await;
    let Some(answer) = response.extensions().get::<FormAnswer>() else {
        // Where the farm itself failed, something may be done.
        if response.status().is_client_error() {
            web.ledger.forget_answered_request(client, number).await?;
        }
        return Ok(response);
    };
    web.ledger.record_answered_request(client, number, &answered(answer)?, Some(&begun)).await?;
    let mut leading = answer.lead_on(number, false);
    if let Some(cookie) = response.headers().get(header::SET_COOKIE) {
        leading.headers_mut().append(header::SET_COOKIE, cookie.clone());
    }
    Ok(leading)
}

/// Whether the form was sent once more.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct ToldQuery {
    #[serde(default)]
    again: bool,
}

/// The page that says what became of a form.
pub(super) async fn show_told(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<String>,
    Query(query): Query<ToldQuery>,
    client: RequestClient,
) -> HandlerResult<Markup> {
    let known = web.ledger.find_answered_request(&client.key_name(), &number).await?;
    let answer = known.as_ref().and_then(FormAnswer::parse);
    let FormAnswer { title, sentences, back, at, anyway, undo, .. } =
        answer.ok_or_else(|| HandlerError::NotFound(say!("form-of-number")))?;
    let content = html! {
        h1 { (title) }
        div #answer role="status" {
            @if query.again {
                p { (say!("form-sent-before", time = web.time_view().time_text(at.into()))) }
            }
            @for sentence in &sentences { p { (prose_with_pages(sentence)) } }
        }
        @if let Some(button) = &anyway { (button.to_form(&web, true)) }
        @if let Some(button) = &undo { div #undo { (button.to_form(&web, false)) } }
        p { a href=(back) { (say!("back")) } }
    };
    Ok(html_page(&title, "", None, &content))
}
