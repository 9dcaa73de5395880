//! Who asks: a program by its token, a person by a session or by the word of a proxy, or nobody in particular. Who does so has a name, for
//! events and limits, and a role.

use std::convert::Infallible;

use access::Role;
use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderName, HeaderValue, header, request::Parts},
};
use base64::Engine;
use serde::{Deserialize, Serialize};

/// The header with the client in whose name another node of the farm asks. It counts only beside the secret of the nodes.
pub(crate) const ON_BEHALF: HeaderName = HeaderName::from_static("nestd-on-behalf-of");

tokio::task_local! {
    /// Who sent the request that is being answered.
    static CURRENT: RequestClient;
}

/// A person who is signed in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SignedIn {
    pub(crate) name: String,
    pub(crate) way: SignInWay,
    /// Whether others may go on at this device with their PIN.
    pub(crate) is_shared: bool,
}

/// How a person said who it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum SignInWay {
    Password,
    Pin,
    Proxy,
}

/// How it is known who asks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum KnownBy {
    /// There are no people: nobody is asked who he is.
    Nothing,
    /// Others are signed in; this one is not.
    NoName,
    /// A token; that of `web.token_file` has no name.
    Token(Option<String>),
    /// A person.
    Person(SignedIn),
}

/// Who sent a request, and what he may do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct RequestClient {
    pub(crate) known_by: KnownBy,
    pub(crate) role: Role,
    /// Under which name its limits are counted: that of its token or person, or its address.
    pub(crate) counted_as: String,
    /// The user as events name him, where another node of the farm passes the request on.
    pub(crate) passed_on_for: Option<String>,
}

impl RequestClient {
    pub(crate) const NAMELESS: Self =
        Self { known_by: KnownBy::Nothing, role: Role::Operate, counted_as: String::new(), passed_on_for: None };

    /// Who need not say who he is.
    pub(crate) fn nobody() -> Self {
        Self { role: Role::Read, ..Self::NAMELESS }
    }

    /// Who is not signed in and has no token, where others are.
    pub(crate) fn stranger(role: Role) -> Self {
        Self { role, known_by: KnownBy::NoName, ..Self::NAMELESS }
    }

    /// A person. A PIN is short, and is typed where others look on: it is not enough to say who else may sign in.
    pub(crate) fn of_person(person: SignedIn, role: Role) -> Self {
        let role = if person.way == SignInWay::Pin { role.min(Role::Operate) } else { role };
        Self {
            counted_as: format!("person {}", person.name),
            known_by: KnownBy::Person(person),
            role,
            ..Self::NAMELESS
        }
    }

    /// The person who is signed in.
    pub(crate) fn person(&self) -> Option<&SignedIn> {
        match &self.known_by {
            KnownBy::Person(person) => Some(person),
            _ => None,
        }
    }

    /// The name of its token.
    pub(crate) fn token_name(&self) -> Option<&str> {
        match &self.known_by {
            KnownBy::Token(name) => name.as_deref(),
            _ => None,
        }
    }

    /// The name under which its requests and its keys are kept.
    pub(crate) fn key_name(&self) -> String {
        match &self.known_by {
            KnownBy::Person(person) => user_of_person(&person.name),
            _ => self.token_name().unwrap_or("anybody").to_owned(),
        }
    }

    /// Whether another node of the farm passes the request on.
    pub(crate) fn is_passed_on(&self) -> bool {
        self.passed_on_for.is_some()
    }

    /// The header in which a node names this client, and the user as events name him, to another one.
    pub(crate) fn to_header(&self, user: &str) -> Option<HeaderValue> {
        let named = Self { passed_on_for: Some(user.to_owned()), ..self.clone() };
        let text = base64::engine::general_purpose::STANDARD.encode(serde_json::to_vec(&named).ok()?);
        HeaderValue::from_str(&text).ok()
    }

    /// The client that another node names, in whose name it asks; `None` = this version does not understand it. What admins do is passed
    /// on to nobody.
    pub(crate) fn passed_on(header: &HeaderValue) -> Option<Self> {
        let text = base64::engine::general_purpose::STANDARD.decode(header).ok()?;
        let named: Self = serde_json::from_slice(&text).ok()?;
        Some(Self { role: named.role.min(Role::Operate), ..named }).filter(Self::is_passed_on)
    }

    /// Does some work on behalf of this client.
    pub(crate) async fn scope<T>(self, work: impl Future<Output = T>) -> T {
        CURRENT.scope(self, work).await
    }

    /// Who sent the request that is being answered.
    pub(crate) fn current() -> Option<Self> {
        CURRENT.try_with(Clone::clone).ok()
    }
}

/// A person as events name him: `ann@dashboard`, or a whole mail address.
pub(crate) fn user_of_person(name: &str) -> String {
    if name.contains('@') { name.to_owned() } else { format!("{name}@dashboard") }
}

impl<S: Send + Sync> FromRequestParts<S> for RequestClient {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        // The guard has put it there.
        Ok(parts.extensions.get().cloned().unwrap_or_else(Self::nobody))
    }
}

/// The bearer token of a request.
pub(crate) fn bearer_token(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::AUTHORIZATION)?.to_str().ok()?.strip_prefix("Bearer ")
}

/// The value of a cookie, decoded.
pub(crate) fn cookie_value(headers: &HeaderMap, cookie: &str) -> Option<String> {
    let texts = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    let pair = texts
        .flat_map(|text| text.split(';'))
        .map(str::trim)
        .find(|pair| pair.split_once('=').is_some_and(|(name, _)| name == cookie))?;
    let pairs: Vec<(String, String)> = serde_urlencoded::from_str(pair).ok()?;
    pairs.into_iter().next().map(|(_, value)| value)
}
