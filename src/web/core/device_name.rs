//! The name of whoever uses a device: asked once, kept in a cookie, and written into the events of what is done there. Where a reverse
//! proxy names the user, or people sign in, nobody is asked.

use axum::{Form, http::HeaderMap};
use language::say;
use maud::{Markup, html};
use serde::Deserialize;

use super::{
    form_answer::{FormAnswer, address_here, key_field},
    request_user::{is_nobody, name_of_user, set_name_cookie},
    state::DashboardState,
};
use crate::web::clients::client::{KnownBy, RequestClient};

/// Who uses this device; asks for the name where it is not known.
pub(crate) fn device_user(web: &DashboardState, user: &str, back: &str) -> Markup {
    // A proxy says who it is, or a session does.
    let is_asked = RequestClient::current().is_none_or(|client| client.known_by == KnownBy::Nothing);
    if !web.orders || web.proxy.is_some() || !is_asked {
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
    let mut headers = HeaderMap::new();
    set_name_cookie(&mut headers, &form.name);
    (headers, FormAnswer::back_to(address_here(&form.back)))
}
