//! Who gives a command on a page. Pages have no login: a reverse proxy that asks people for their names says it in a header
//! (`web.user_header`). Settings allow that only where nobody but programs of this server can connect.

use std::{convert::Infallible, sync::Arc};

use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderName, request::Parts},
};

use super::state::DashboardState;

/// Who gives the commands of pages when no proxy says it.
const NOBODY: &str = "dashboard";
/// Longest name that is taken, characters.
const MAX_NAME: usize = 64;

/// The user as events name him: `ann@dashboard`, a whole mail address, or `dashboard`.
pub(super) struct RequestUser(pub(super) String);

impl FromRequestParts<Arc<DashboardState>> for RequestUser {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, web: &Arc<DashboardState>) -> Result<Self, Infallible> {
        Ok(Self(user_of_request(&parts.headers, web.user_header.as_ref())))
    }
}

fn user_of_request(headers: &HeaderMap, user_header: Option<&HeaderName>) -> String {
    let given = user_header.and_then(|header| headers.get(header)).and_then(|value| value.to_str().ok());
    let name: String = given.unwrap_or_default().trim().chars().take(MAX_NAME).collect();
    match name.as_str() {
        "" => NOBODY.to_owned(),
        address if address.contains('@') => name,
        _ => format!("{name}@{NOBODY}"),
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    #[test]
    fn only_the_configured_header_names_the_user() {
        let header = HeaderName::from_static("x-remote-user");
        let named = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert("x-other", HeaderValue::from_static("mallory"));
            headers.insert(&header, HeaderValue::from_str(value).unwrap());
            headers
        };
        assert_eq!(user_of_request(&named("ann"), Some(&header)), "ann@dashboard");
        assert_eq!(user_of_request(&named("ann@example.org"), Some(&header)), "ann@example.org");
        assert_eq!(user_of_request(&named(" "), Some(&header)), "dashboard");
        assert_eq!(user_of_request(&named("ann"), None), "dashboard");
        assert_eq!(user_of_request(&HeaderMap::new(), Some(&header)), "dashboard");
        assert_eq!(user_of_request(&named(&"a".repeat(200)), Some(&header)).len(), MAX_NAME + "@dashboard".len());
    }
}
