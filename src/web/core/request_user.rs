//! Who gives a command on a page. Pages have no login: a reverse proxy that asks people for their names says it in a header
//! (`web.user_header`). Settings allow that only where nobody but programs of this server can connect. Without one, people say their
//! name once on each device; the browser keeps it in a cookie. Who comes with a token that has a name is known by that.

use std::{convert::Infallible, sync::Arc};

use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderName, HeaderValue, header, request::Parts},
};
use language::say;

use super::state::DashboardState;
use crate::web::base::client::{RequestClient, cookie_value};

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
        let client = parts.extensions.get::<RequestClient>().and_then(|client| client.name.as_deref());
        Ok(Self(user_of_request(&parts.headers, web.user_header.as_ref(), client)))
    }
}

/// `token` = the name of the token that the request came with.
fn user_of_request(headers: &HeaderMap, user_header: Option<&HeaderName>, token: Option<&str>) -> String {
    let by_proxy = |header| headers.get(header).and_then(|value| value.to_str().ok()).filter(|name| !name.is_empty());
    let given = match user_header.map(by_proxy) {
        Some(Some(name)) => Some(name.to_owned()),
        _ if token.is_some() => return format!("{}@token", token.unwrap_or_default()),
        Some(None) => None,
        None => name_in_cookies(headers).map(|name| name.replace('@', " at ")),
    };
    let name: String = given.unwrap_or_default().trim().chars().take(MAX_NAME).collect();
    match name.as_str() {
        "" => NOBODY.to_owned(),
        address if address.contains('@') => name,
        _ => format!("{name}@{NOBODY}"),
    }
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

    #[test]
    fn only_the_configured_header_or_else_the_cookie_of_the_device_names_the_user() {
        let header_name = HeaderName::from_static("x-remote-user");
        let named = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert("x-other", HeaderValue::from_static("mallory"));
            headers.insert(&header_name, HeaderValue::from_str(value).unwrap());
            headers
        };
        assert_eq!(user_of_request(&named("ann"), Some(&header_name), None), "ann@dashboard");
        assert_eq!(user_of_request(&named("ann@example.org"), Some(&header_name), None), "ann@example.org");
        assert_eq!(user_of_request(&named(" "), Some(&header_name), None), "dashboard");
        assert_eq!(user_of_request(&named("ann"), None, None), "dashboard");
        assert_eq!(user_of_request(&named("ann"), Some(&header_name), Some("proxy")), "ann@dashboard");
        assert_eq!(user_of_request(&HeaderMap::new(), Some(&header_name), Some("mes")), "mes@token");
        assert_eq!(user_of_request(&HeaderMap::new(), Some(&header_name), None), "dashboard");
        let mut device = HeaderMap::new();
        set_name_cookie(&mut device, " Jörg; x=1 ");
        let cookie = device[header::SET_COOKIE].to_str().unwrap();
        assert!(cookie.contains("SameSite=Strict") && cookie.contains("HttpOnly"), "{cookie}");
        let kept = format!("other=1; {}", cookie.split(';').next().unwrap());
        device.insert(header::COOKIE, HeaderValue::from_str(&kept).unwrap());
        assert_eq!(user_of_request(&device, None, None), "Jörg; x=1@dashboard");
        assert_eq!(user_of_request(&device, Some(&header_name), None), "dashboard", "only the proxy says who it is");
        device.insert(header::COOKIE, HeaderValue::from_static("nestd_name=root%40host"));
        assert_eq!(
            user_of_request(&device, None, None),
            "root at host@dashboard",
            "nobody poses as a user of the terminal"
        );
        assert_eq!(["Jörg@dashboard", "op@host"].map(name_of_user), ["Jörg", "op@host"]);
        assert_eq!(
            user_of_request(&named(&"a".repeat(200)), Some(&header_name), None).len(),
            MAX_NAME + "@dashboard".len()
        );
    }
}
