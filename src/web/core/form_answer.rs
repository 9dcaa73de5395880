//! A form of a page: the key in it, and what became of it.

use axum::{
    http::{HeaderValue, StatusCode, header},
    response::{IntoResponse, Redirect, Response},
};
use jiff::Timestamp;
use language::say;
use ledger::AnsweredRequest;
use maud::{Markup, html};
use serde::{Deserialize, Serialize};

use super::state::DashboardState;

/// How long a page that is slow to come may still say what was done, s.
const TOLD_SECS: u32 = 20;

/// The field with the key of a form. It comes first: a form with files is not read without it.
pub(crate) fn key_field(web: &DashboardState) -> Markup {
    // Browsers would put an earlier key back when a page is loaded again.
    html! { input type="hidden" name="key" value=(web.form_keys.make_key()) autocomplete="off"; }
}

/// An address of this dashboard that a form names; else the farm's. No other site can be among them, however it is written.
pub(crate) fn address_here(text: &str) -> &str {
    let is_here =
        text.starts_with('/') && !text.starts_with("//") && !text.contains(|c: char| c == '\\' || c.is_control());
    if is_here { text } else { "/" }
}

/// What became of a form: sentences, if there is anything to say, and the page where it came from.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FormAnswer {
    pub(crate) title: String,
    pub(crate) sentences: Vec<String>,
    pub(crate) back: String,
    /// Whether nothing was done: then the same form may be sent again, also with something else in it.
    pub(crate) is_refused: bool,
    /// Whether it is being carried out, unless its daemon has crashed.
    #[serde(default)]
    pub(crate) is_open: bool,
    /// When it was answered.
    pub(crate) at: Timestamp,
    /// The button that sends it once more and has it done anyway.
    pub(crate) anyway: Option<FormButton>,
    /// The button that takes it back.
    #[serde(default)]
    pub(crate) undo: Option<FormButton>,
    /// Whether the page `back` shows what was done, so that the sentences only stand on it for a while.
    #[serde(default)]
    is_seen: bool,
}

/// A button that sends a form.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FormButton {
    label: String,
    /// Address and fields of the form.
    pub(crate) action: String,
    pub(crate) fields: Vec<(String, String)>,
}

impl FormButton {
    /// The button that takes back what was done, by a form with these fields.
    pub(crate) fn undo(action: &str, fields: &[(&str, String)]) -> Self {
        let fields = fields.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        Self { label: say!("undo"), action: action.to_owned(), fields }
    }

    /// The button, in a form with a key of its own. `is_anyway` = it says that what was refused is meant.
    pub(crate) fn to_form(&self, web: &DashboardState, is_anyway: bool) -> Markup {
        html! {
            form.order method="post" action=(self.action) {
                (key_field(web))
                @for (name, value) in self.fields.iter().filter(|(name, _)| name != "key") { input type="hidden" name=(name) value=(value); }
                @if is_anyway { input type="hidden" name="anyway" value="yes"; }
                button type="submit" { (self.label) }
            }
        }
    }
}

impl FormAnswer {
    /// It is done: the page `back` shows that.
    pub(crate) fn back_to(back: &str) -> Self {
        Self::told(&say!("done"), Vec::new(), back)
    }

    /// It is done, and this is to be said of it.
    pub(crate) fn told(title: &str, sentences: Vec<String>, back: &str) -> Self {
        let (title, back) = (title.to_owned(), back.to_owned());
        Self {
            title,
            sentences,
            back,
            is_refused: false,
            is_open: false,
            at: Timestamp::now(),
            anyway: None,
            undo: None,
            is_seen: false,
        }
    }

    /// It is done, and the page `back` shows that; these sentences stand on it for a while.
    pub(crate) fn seen_at(back: &str, sentences: Vec<String>) -> Self {
        Self { is_seen: true, ..Self::told(&say!("done"), sentences, back) }
    }

    /// With a button that takes back what was done.
    pub(crate) fn or_undo(self, undo: Option<FormButton>) -> Self {
        Self { undo: undo.filter(|_| !self.is_refused), ..self }
    }

    /// Nothing was done, for these reasons.
    pub(crate) fn refused(reasons: Vec<String>, back: &str) -> Self {
        Self { is_refused: true, ..Self::told(&say!("refused"), reasons, back) }
    }

    /// With a button that has it done anyway.
    pub(crate) fn or_anyway(self, label: &str) -> Self {
        let button = FormButton { label: label.to_owned(), action: String::new(), fields: Vec::new() };
        Self { anyway: Some(button), ..self }
    }

    /// What is known until it is done.
    pub(crate) fn not_known() -> Self {
        let text = say!("form-not-known-text");
        Self { is_open: true, ..Self::told(&say!("form-not-known"), vec![text], "/") }
    }

    /// The answer that the ledger keeps.
    pub(crate) fn parse(known: &AnsweredRequest) -> Option<Self> {
        serde_json::from_str(&known.answer).ok()
    }

    /// Leads the browser to what is to be seen. `is_again` = the form was carried out some time before.
    pub(crate) fn lead_on(&self, number: &str, is_again: bool) -> Response {
        let is_on_page = self.is_seen || self.sentences.is_empty();
        let to = match (is_again, is_on_page) {
            (false, true) => self.back.clone(),
            (false, false) => format!("/told/{number}"),
            (true, _) => format!("/told/{number}?again=true"),
        };
        let mut response = Redirect::to(&to).into_response();
        if !is_again && self.is_seen && !self.sentences.is_empty() {
            // The script of the page shows it, and takes the cookie away.
            let cookie = format!("told={number}; Path=/; Max-Age={TOLD_SECS}; SameSite=Strict");
            if let Ok(cookie) = HeaderValue::from_str(&cookie) {
                response.headers_mut().append(header::SET_COOKIE, cookie);
            }
        }
        response
    }
}

impl IntoResponse for FormAnswer {
    /// Whoever carries the form out makes of it what the browser gets.
    fn into_response(self) -> Response {
        let mut response = StatusCode::SEE_OTHER.into_response();
        response.extensions_mut().insert(self);
        response
    }
}
