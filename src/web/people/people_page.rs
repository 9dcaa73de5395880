//! The page on which an admin says who may sign in, and what each may do.

use std::sync::Arc;

use access::{PasswordHash, Role, is_person_name};
use axum::{
    Form,
    extract::State,
    response::{IntoResponse, Redirect, Response},
};
use language::say;
use ledger::{PersonChange, PersonRow};
use maud::{Markup, html};
use serde::Deserialize;

use super::account::{check_key, check_password, hash_secret, refused};
use crate::{
    tables::{PEOPLE_COLUMNS, role_text},
    web::{
        base::{
            error::{HandlerError, HandlerResult},
            listing::table_of,
            page::html_page,
        },
        clients::client::RequestClient,
        core::{form_answer::key_field, request_user::RequestUser, state::DashboardState},
    },
};

/// What an admin does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PersonAct {
    Add,
    Role,
    Password,
    NoPin,
    SignOut,
    Remove,
}

/// The form that does it.
#[derive(Deserialize)]
pub(crate) struct PersonFields {
    #[serde(default)]
    key: String,
    act: PersonAct,
    name: String,
    role: Option<Role>,
    #[serde(default)]
    password: String,
}

/// All people, each with what may be changed.
pub(crate) async fn show_people(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
) -> HandlerResult<Markup> {
    let people = web.ledger.list_people().await?;
    let own = client.person().map(|person| person.name.as_str());
    let title = say!("people");
    let content = html! {
        h1 { (title) }
        (table_of(&title, None, PEOPLE_COLUMNS, &people, &web.time_view()))
        h2 { (say!("change-person")) }
        @for person in &people { (person_forms(&web, person, own == Some(person.name.as_str()))) }
        h2 { (say!("add-person")) }
        p { (say!("add-person-text")) }
        (act_form(&web, "add", None, html! {
            label { (say!("field-name")) input name="name" required maxlength="64" autocapitalize="none" autocomplete="off"; }
            (role_field(Role::Operate))
            (password_field())
        }, say!("add-person")))
    };
    Ok(html_page(&title, "/people", None, &content))
}

fn person_forms(web: &DashboardState, person: &PersonRow, is_own: bool) -> Markup {
    let name = Some(person.name.as_str());
    html! {
        details {
            summary translate="no" { (person.name) }
            // Nobody locks himself out.
            @if !is_own { (act_form(web, "role", name, role_field(person.role), say!("change-role"))) }
            (act_form(web, "password", name, password_field(), say!("change-password")))
            @if person.has_pin { (act_form(web, "no-pin", name, html! {}, say!("take-pin-away"))) }
            (act_form(web, "sign-out", name, html! {}, say!("sign-out-everywhere")))
            @if !is_own { (act_form(web, "remove", name, html! {}, say!("remove-person"))) }
        }
    }
}

fn act_form(web: &DashboardState, act: &str, name: Option<&str>, fields: Markup, button: String) -> Markup {
    html! {
        form.filters method="post" action="/people" {
            (key_field(web))
            input type="hidden" name="act" value=(act);
            @if let Some(name) = name { input type="hidden" name="name" value=(name); }
            (fields)
            button type="submit" { (button) @if let Some(name) = name { span.unseen translate="no" { " " (name) } } }
        }
    }
}

fn role_field(chosen: Role) -> Markup {
    html! {
        label { (say!("field-role"))
            select name="role" {
                @for role in Role::ALL {
                    option value=(role.as_str()) selected[role == chosen] { (role.as_str()) ": " (role_text(role)) }
                }
            }
        }
    }
}

fn password_field() -> Markup {
    html! { label { (say!("new-password")) input name="password" type="password" autocomplete="new-password" maxlength="200"; } }
}

/// Changes something for a person.
pub(crate) async fn post_people(
    State(web): State<Arc<DashboardState>>,
    client: RequestClient,
    RequestUser(by): RequestUser,
    Form(fields): Form<PersonFields>,
) -> HandlerResult<Response> {
    check_key(&web, &fields.key)?;
    let name = fields.name.trim();
    let known = web.ledger.find_person(name).await?;
    let is_own = known.as_ref().is_some_and(|known| client.person().is_some_and(|person| person.name == known.name));
    if is_own && matches!(fields.act, PersonAct::Role | PersonAct::Remove) {
        return Err(refused(say!("not-oneself")));
    }
    let change = match fields.act {
        PersonAct::Add => {
            if !is_person_name(name) {
                return Err(refused(say!("person-name-rule")));
            }
            if known.is_some() {
                return Err(refused(say!("person-is-there", name = name)));
            }
            let password = password_of(&web, &fields.password, name).await?;
            let role = fields.role.unwrap_or(Role::Read);
            web.ledger.add_person(name, role, &password, &by).await?;
            return Ok(Redirect::to("/people").into_response());
        }
        PersonAct::Role => PersonChange::Role(fields.role.unwrap_or(Role::Read)),
        PersonAct::Password => {
            PersonChange::Password(hash_secret(&web, check_password(&fields.password, name)?).await?)
        }
        PersonAct::NoPin => PersonChange::Pin(PasswordHash::default()),
        PersonAct::SignOut => PersonChange::SignedOut,
        PersonAct::Remove => PersonChange::Removed,
    };
    if known.is_none() {
        return Err(HandlerError::NotFound(say!("person-of-name", name = name)));
    }
    web.ledger.change_person(name, &change, &by).await?;
    Ok(Redirect::to("/people").into_response())
}

/// The hash of a password; an empty one is none: then a proxy says who it is.
async fn password_of(web: &DashboardState, text: &str, name: &str) -> HandlerResult<PasswordHash> {
    match text {
        "" => Ok(PasswordHash::default()),
        text => hash_secret(web, check_password(text, name)?).await,
    }
}
