//! Who asks: by a token, or without one where the farm allows that. Each token has a name, for events and limits, and a role.

use std::{
    convert::Infallible,
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use access::{Role, TokenWatch, hash_token};
use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, StatusCode, header, request::Parts},
};

use super::error::HandlerError;

/// Who sent a request, and what he may do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RequestClient {
    /// Name of the token; `None` = it has none.
    pub(crate) name: Option<String>,
    pub(crate) role: Role,
    /// Whether it came with a token.
    pub(crate) has_token: bool,
    /// Under which name its limits are counted: that of its token, or its address.
    pub(crate) counted_as: String,
}

impl RequestClient {
    const NAMELESS: Self = Self { name: None, role: Role::Operate, has_token: false, counted_as: String::new() };

    /// Who need not say who he is.
    pub(crate) fn nobody() -> Self {
        Self { role: Role::Read, ..Self::NAMELESS }
    }

    /// The name under which its requests and its keys are kept.
    pub(crate) fn key_name(&self) -> &str {
        self.name.as_deref().unwrap_or("anybody")
    }
}

impl<S: Send + Sync> FromRequestParts<S> for RequestClient {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        // The guard has put it there.
        Ok(parts.extensions.get().cloned().unwrap_or_else(Self::nobody))
    }
}

/// The tokens that the farm knows.
#[derive(Debug, Default)]
pub(crate) struct ClientGate {
    /// The one token of `web.token_file`, which may everything.
    pub(crate) token: Option<String>,
    /// The file of the tokens with names and roles.
    pub(crate) tokens_file: Option<PathBuf>,
    /// What requests without a token may where there are tokens; `None` = nothing.
    pub(crate) without_token: Option<Role>,
    pub(crate) watch: Mutex<TokenWatch>,
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
        let given = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        match (given, self.without_token) {
            (None, Some(role)) => Ok(RequestClient { role, ..RequestClient::NAMELESS }),
            (given, _) => {
                let token = given.and_then(|value| value.strip_prefix("Bearer ")).unwrap_or_default();
                let unknown = || refused(StatusCode::UNAUTHORIZED, "this farm asks for a bearer token");
                self.find_client(token)?.ok_or_else(unknown)
            }
        }
    }

    fn find_client(&self, token: &str) -> Result<Option<RequestClient>, HandlerError> {
        // Hashes are compared, so that the time says nothing of the token.
        if self.token.as_ref().is_some_and(|known| hash_token(known) == hash_token(token)) {
            return Ok(Some(RequestClient { has_token: true, ..RequestClient::NAMELESS }));
        }
        let Some(file) = &self.tokens_file else { return Ok(None) };
        let found = self.watch.lock().unwrap_or_else(PoisonError::into_inner).find_token(file, token);
        let found = found.map_err(|error| refused(StatusCode::SERVICE_UNAVAILABLE, &error.to_string()))?;
        Ok(found.map(|known| RequestClient {
            counted_as: format!("token {}", known.name),
            name: Some(known.name),
            role: known.role,
            has_token: true,
        }))
    }
}

fn refused(status: StatusCode, text: &str) -> HandlerError {
    HandlerError::Refused(status, text.to_owned())
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
