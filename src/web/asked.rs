//! What addresses ask for in their query.

use axum::http::StatusCode;
use serde::{Serialize, de::DeserializeOwned};

use super::problem::{Answer, Problem};

/// The query of an address.
pub(super) fn query(asked: &impl Serialize) -> Answer<String> {
    Ok(serde_urlencoded::to_string(asked).map_err(anyhow::Error::from)?)
}

/// A value of a known kind; nothing when the field is empty.
pub(super) fn known<T: DeserializeOwned>(text: &str, what: &str) -> Answer<Option<T>> {
    let value = || text.parse::<i64>().map_or_else(|_| text.into(), serde_json::Value::from);
    match text {
        "" => Ok(None),
        _ => match serde_json::from_value(value()) {
            Ok(value) => Ok(Some(value)),
            Err(_) => Err(Problem::Refused(StatusCode::BAD_REQUEST, format!("'{text}' is not {what}"))),
        },
    }
}
