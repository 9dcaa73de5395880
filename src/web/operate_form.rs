//! What forms say of published builds: judged and carried out as `farm::operate` does, also for the command line and programs. Where the
//! file of a build lies in its queue, the answer has the button that says it anyway.

use axum::response::{IntoResponse, Response};
use maud::html;

use super::{command::answer_page, error::HandlerResult, format::prose_with_pages, page, state::DashboardState};
use crate::{
    farm,
    ledger::{InQueueError, LedgerError, OperatorWord},
};

/// A form that was sent, so that it can be sent once more.
pub(super) struct SentForm<'a> {
    /// Its address.
    pub(super) action: &'a str,
    /// Its fields but the key.
    pub(super) fields: &'a [(&'a str, &'a str)],
    /// Whether the button was pressed that says it anyway.
    pub(super) anyway: bool,
    /// The page to go back to.
    pub(super) back: &'a str,
}

/// Says a word of a form, and shows what became of it.
pub(super) async fn say_word(
    web: &DashboardState,
    word: &OperatorWord,
    by: &str,
    form: &SentForm<'_>,
) -> HandlerResult<Response> {
    let answer = farm::operate(&web.ledger, &web.current_settings(), word, by, form.anyway).await;
    if let Err(LedgerError::InQueue(lies @ InQueueError::LiesThere { .. })) = &answer {
        return Ok(ask_again(web, &lies.to_string(), form));
    }
    answer_page(answer.map(|answer| answer.sentences), form.back)
}

/// Why the word is refused, and the button that says it anyway.
fn ask_again(web: &DashboardState, refusal: &str, form: &SentForm<'_>) -> Response {
    let content = html! {
        h1 { "Refused" }
        div #answer role="status" { p { (prose_with_pages(refusal)) "." } }
        form.order method="post" action=(form.action) {
            input type="hidden" name="key" value=(web.form_key);
            @for (name, value) in form.fields { input type="hidden" name=(name) value=(value); }
            input type="hidden" name="anyway" value="yes";
            button type="submit" { "Take it out of the queue and do it anyway" }
        }
        p { a href=(form.back) { "Back" } }
    };
    page::html_page("Refused", "", None, &content).into_response()
}
