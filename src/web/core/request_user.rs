//! Who gives a command on a page: the person who is signed in. Else a reverse proxy that asks people for their names says it in a header
//! (`web.user_header`), which is believed from its own address only. Where there are no people and no proxy, everybody says a name once on
//! each device; the browser keeps it in a cookie. Who comes with a token that has a name is known by that.

use std::{convert::Infallible, sync::Arc};

use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderValue, header, request::Parts},
};
use language::say;

use super::state::DashboardState;
use crate::web::{
    base::client_gate::peer_address,
    clients::client::{KnownBy, RequestClient, cookie_value, user_of_person},
};

/// Who gives the commands of pages when no proxy says it.
const NOBODY: &str = "dashboard";
/// The cookie with the name that was said on a device.
const NAME_COOKIE: &str = "nestd_name";
/// How long a device keeps a name: a year, s.
const NAME_KEPT_SECS: u32 = 31_536_000;
/// Longest name that is taken, characters.
const MAX_NAME: usize = 64;

/// The user as events name him: `ann@dashboard`, a whole mail address, or `dashboard`.
pub(crate) struct RequestUser(pub(crate) String);

impl FromRequestParts<Arc<DashboardState>> for RequestUser {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, web: &Arc<DashboardState>) -> Result<Self, Infallible> {
        Ok(Self(user_of_parts(web, parts)))
    }
}

/// The user as events name him; of a request that another node passes on, as that found him.
pub(crate) fn user_of_parts(web: &DashboardState, parts: &Parts) -> String {
    let client = parts.extensions.get::<RequestClient>();
    if let Some(user) = client.and_then(|client| client.passed_on_for.clone()) {
        return user;
    }
    let by_proxy = web.proxy.as_ref().map(|proxy| proxy.user_named(peer_address(&parts.extensions), &parts.headers));
    user_of_request(&parts.headers, by_proxy, client.map_or(&KnownBy::Nothing, |client| &client.known_by))
}

/// `by_proxy` = whom the proxy names, where there is one.
fn user_of_request(headers: &HeaderMap, by_proxy: Option<Option<String>>, client: &KnownBy) -> String {
    let given = match (client, by_proxy) {
        (KnownBy::Person(person), _) => Some(person.name.clone()),
        (_, Some(Some(name))) => Some(name),
        (KnownBy::Token(Some(token)), _) => return format!("{token}@token"),
        // Where people sign in, a name that anybody may say is none.
        (KnownBy::NoName, None) | (_, Some(None)) => None,
        (KnownBy::Nothing | KnownBy::Token(None), None) => {
            name_in_cookies(headers).map(|name| name.replace('@', " at "))
        }
    };
    let name: String = given.unwrap_or_default().trim().chars().take(MAX_NAME).collect();
    if name.is_empty() { NOBODY.to_owned() } else { user_of_person(&name) }
}

/// The name that was said on this device.
fn name_in_cookies(headers: &HeaderMap) -> Option<String> {
    cookie_value(headers, NAME_COOKIE).map(|name| build_file::escape_invisible(&name))
}

/// Has the browser keep a name for a year; an empty one is forgotten.
pub(super) fn set_name_cookie(headers: &mut HeaderMap, name: &str) {
    let name: String = name.trim().chars().take(MAX_NAME).collect();
    let age_secs = if name.is_empty() { 0 } else { NAME_KEPT_SECS };
    let pair = serde_urlencoded::to_string([(NAME_COOKIE, name)]).unwrap_or_default();
    let cookie = format!("{pair}; Path=/; Max-Age={age_secs}; SameSite=Strict; HttpOnly");
    if let Ok(value) = HeaderValue::from_str(&cookie) {
        headers.insert(header::SET_COOKIE, value);
    }
}

/// Whether nobody said who gives the commands.
pub(super) fn is_nobody(user: &str) -> bool {
    user == NOBODY
}

/// The name of a user for people: without the mark of the dashboard.
pub(crate) fn name_of_user(user: &str) -> String {
    match user {
        NOBODY => say!("somebody"),
        _ => user.strip_suffix("@dashboard").unwrap_or(user).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::web::clients::client::{SignInWay, SignedIn};

    #[test]
    fn a_person_the_proxy_a_token_or_else_the_cookie_of_the_device_names_the_user() {
        let by_proxy = |name: &str| Some(Some(name.to_owned()).filter(|name| !name.is_empty()));
        let (nothing, token) = (KnownBy::Nothing, |name: Option<&str>| KnownBy::Token(name.map(str::to_owned)));
        let none = HeaderMap::new();
        assert_eq!(user_of_request(&none, by_proxy("ann"), &nothing), "ann@dashboard");
        assert_eq!(user_of_request(&none, by_proxy("ann@example.org"), &nothing), "ann@example.org");
        assert_eq!(user_of_request(&none, by_proxy(" "), &nothing), "dashboard");
        assert_eq!(user_of_request(&none, by_proxy("ann"), &token(Some("proxy"))), "ann@dashboard");
        assert_eq!(user_of_request(&none, by_proxy(""), &token(Some("mes"))), "mes@token");
        assert_eq!(user_of_request(&none, None, &token(Some("mes"))), "mes@token");
        assert_eq!(user_of_request(&none, by_proxy(""), &nothing), "dashboard");
        let mut device = HeaderMap::new();
        set_name_cookie(&mut device, " Jörg; x=1 ");
        let cookie = device[header::SET_COOKIE].to_str().unwrap();
        assert!(cookie.contains("SameSite=Strict") && cookie.contains("HttpOnly"), "{cookie}");
        let kept = format!("other=1; {}", cookie.split(';').next().unwrap());
        device.insert(header::COOKIE, HeaderValue::from_str(&kept).unwrap());
        assert_eq!(user_of_request(&device, None, &nothing), "Jörg; x=1@dashboard");
        assert_eq!(user_of_request(&device, by_proxy(""), &nothing), "dashboard", "only the proxy says who it is");
        assert_eq!(user_of_request(&device, None, &KnownBy::NoName), "dashboard", "others sign in");
        let (name, way) = ("anna".to_owned(), SignInWay::Pin);
        let anna = KnownBy::Person(SignedIn { name, way, is_shared: true });
        assert_eq!(user_of_request(&device, by_proxy("bert"), &anna), "anna@dashboard");
        device.insert(header::COOKIE, HeaderValue::from_static("nestd_name=root%40host"));
        assert_eq!(
            user_of_request(&device, None, &nothing),
            "root at host@dashboard",
            "nobody poses as a user of the terminal"
        );
        assert_eq!(["Jörg@dashboard", "op@host"].map(name_of_user), ["Jörg", "op@host"]);
        let long = user_of_request(&none, by_proxy(&"a".repeat(200)), &nothing);
        assert_eq!(long.len(), MAX_NAME + "@dashboard".len());
    }
}
