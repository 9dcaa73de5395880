//! Who may ask with a token, or without one where the farm allows that; and which proxy is believed when it names its users.

use std::{
    net::IpAddr,
    path::PathBuf,
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use access::{Role, TokenWatch, hash_token};
use axum::{
    extract::ConnectInfo,
    http::{Extensions, HeaderMap, HeaderName, StatusCode, header},
};

use super::{
    connection_limits::{OF_SOCKET, RequestInProgress},
    error::HandlerError,
};
use crate::web::clients::client::{KnownBy, ON_BEHALF, RequestClient, bearer_token};

/// How long it is taken as known whether there are people.
const PEOPLE_SEEN_FOR: Duration = Duration::from_secs(1);

/// The tokens that the farm knows.
#[derive(Debug, Default)]
pub(crate) struct ClientGate {
    /// The one token of `web.token_file`, which may everything.
    pub(crate) token: Option<String>,
    /// The secret by which the nodes of the farm know each other; "" = there are no others.
    pub(crate) node_secret: String,
    /// The file of the tokens with names and roles.
    pub(crate) tokens_file: Option<PathBuf>,
    /// What requests may that come without a token and from nobody who is signed in; `None` = nothing.
    pub(crate) without_token: Option<Role>,
    /// Whether people have to sign in also while there are none.
    pub(crate) sign_in: bool,
    /// Whether there were people when that was last looked up.
    pub(crate) people: PeopleSeen,
    pub(crate) watch: Mutex<TokenWatch>,
}

/// Whether there are people: looked up once in a while, and kept while the ledger does not answer.
#[derive(Debug, Default)]
pub(crate) struct PeopleSeen(Mutex<Option<(Instant, bool)>>);

impl PeopleSeen {
    /// Whether there are people; `is_fresh` = as far as was seen within a second.
    pub(crate) fn known(&self, is_fresh: bool) -> Option<bool> {
        let seen = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        seen.filter(|(at, _)| !is_fresh || at.elapsed() < PEOPLE_SEEN_FOR).map(|(_, any)| any)
    }

    /// Notes that it was looked up.
    pub(crate) fn note(&self, any: bool) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((Instant::now(), any));
    }
}

impl ClientGate {
    /// Whether there are tokens at all.
    pub(crate) fn has_tokens(&self) -> bool {
        self.token.is_some() || self.tokens_file.is_some()
    }

    /// Who sends a request with these headers.
    ///
    /// # Errors
    /// `Refused` where it needs a token that the farm knows.
    pub(crate) fn identify_client(&self, headers: &HeaderMap) -> Result<RequestClient, HandlerError> {
        if !self.has_tokens() {
            return Ok(RequestClient::NAMELESS);
        }
        match (headers.contains_key(header::AUTHORIZATION), self.without_token) {
            (false, Some(role)) => Ok(RequestClient { role, ..RequestClient::NAMELESS }),
            _ => self.client_of_token(bearer_token(headers).unwrap_or_default()),
        }
    }

    /// Another node of this farm, or the client in whose name it asks; `None` = it is none.
    ///
    /// # Errors
    /// `Refused` where this version does not understand in whose name it asks.
    pub(crate) fn identify_node(&self, headers: &HeaderMap) -> Result<Option<RequestClient>, HandlerError> {
        let sent = headers.get(farm::NODE_HEADER).and_then(|secret| secret.to_str().ok()).unwrap_or_default();
        // Hashes are compared, so that the time says nothing of the secret.
        if self.node_secret.is_empty() || hash_token(&self.node_secret) != hash_token(sent) {
            return Ok(None);
        }
        let Some(named) = headers.get(ON_BEHALF) else {
            return Ok(Some(RequestClient { known_by: KnownBy::Token(None), ..RequestClient::NAMELESS }));
        };
        let text = "this version does not understand in whose name the other node asks: bring all nodes to one version";
        RequestClient::passed_on(named).map(Some).ok_or_else(|| refused(StatusCode::BAD_REQUEST, text))
    }

    /// Who has a token.
    ///
    /// # Errors
    /// `Refused` where the farm does not know it.
    pub(crate) fn client_of_token(&self, token: &str) -> Result<RequestClient, HandlerError> {
        let unknown = || refused(StatusCode::UNAUTHORIZED, "this farm asks for a bearer token");
        self.find_client(token)?.ok_or_else(unknown)
    }

    fn find_client(&self, token: &str) -> Result<Option<RequestClient>, HandlerError> {
        // Hashes are compared, so that the time says nothing of the token.
        if self.token.as_ref().is_some_and(|known| hash_token(known) == hash_token(token)) {
            return Ok(Some(RequestClient { known_by: KnownBy::Token(None), ..RequestClient::NAMELESS }));
        }
        let Some(file) = &self.tokens_file else { return Ok(None) };
        let found = self.watch.lock().unwrap_or_else(PoisonError::into_inner).find_token(file, token);
        let found = found.map_err(|error| refused(StatusCode::SERVICE_UNAVAILABLE, &error.to_string()))?;
        Ok(found.map(|known| RequestClient {
            counted_as: format!("token {}", known.name),
            known_by: KnownBy::Token(Some(known.name)),
            role: known.role,
            ..RequestClient::NAMELESS
        }))
    }
}

fn refused(status: StatusCode, text: &str) -> HandlerError {
    HandlerError::Refused(status, text.to_owned())
}

/// The address from which a request comes; "" = from within this process.
pub(crate) fn peer_address(extensions: &Extensions) -> &str {
    extensions.get::<ConnectInfo<RequestInProgress>>().map_or("", |connection| connection.0.client())
}

/// The header in which a reverse proxy names its user, and the proxies that are believed.
#[derive(Debug, Clone)]
pub(crate) struct ProxyHeader {
    pub(crate) header: HeaderName,
    /// Their addresses; none = whatever runs on this server.
    pub(crate) from: Vec<IpAddr>,
}

impl ProxyHeader {
    /// Whom the proxy names. A header that comes twice is not believed: one of the two may be the client's own.
    pub(crate) fn user_named(&self, address: &str, headers: &HeaderMap) -> Option<String> {
        let is_believed = match address.parse::<IpAddr>() {
            Ok(address) if self.from.is_empty() => address.is_loopback(),
            Ok(address) => self.from.contains(&address),
            Err(_) => address == OF_SOCKET,
        };
        let mut values = headers.get_all(&self.header).iter();
        let (first, others) = (values.next(), values.next());
        let name = first.filter(|_| is_believed && others.is_none())?.to_str().ok()?.trim();
        (!name.is_empty()).then(|| name.to_owned())
    }
}
