//! The name of whoever uses a device: asked once, kept in a cookie, and written into the events of what is done there. Where a reverse
//! proxy names the user, nobody is asked.

use axum::{Form, http::HeaderMap};
use language::say;
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    form_answer::{FormAnswer, key_field},
    request_user::{is_nobody, name_of_user, set_name_cookie},
    state::DashboardState,
};

/// Who uses this device; asks for the name where it is not known.
pub(crate) fn device_user(web: &DashboardState, user: &str, back: &str) -> Markup {
    // A proxy says who it is.
    if !web.orders || web.user_header.is_some() {
        return html! {};
    }
    let form = html! {
        form.filters method="post" action="/name" {
            (key_field(web))
            input type="hidden" name="back" value=(back);
            label { (say!("your-name")) input name="name" maxlength="40" autocomplete="name" value=[(!is_nobody(user)).then(|| name_of_user(user))]; }
            button type="submit" { (say!("that-is-me")) }
        }
    };
    // An open fold with a field keeps a page from showing what is new.
    html! {
        @if is_nobody(user) { p { (say!("who-works")) } (form) }
        @else { details { summary { (say!("you-are", name = name_of_user(user))) } (form) } }
    }
}

/// The form that says the name.
#[derive(Debug, Deserialize)]
pub(crate) struct NameForm {
    #[serde(default)]
    name: String,
    #[serde(default)]
    back: String,
}

/// Notes the name in a cookie of the device.
pub(crate) async fn post_name(Form(form): Form<NameForm>) -> (HeaderMap, FormAnswer) {
    let is_here = form.back.starts_with('/') && !form.back.starts_with("//") && !form.back.contains('\\');
    let mut headers = HeaderMap::new();
    set_name_cookie(&mut headers, &form.name);
    (headers, FormAnswer::back_to(if is_here { &form.back } else { "/" }))
}
