//! Query strings of addresses: writing and reading them.

use axum::http::StatusCode;
use serde::{Serialize, de::DeserializeOwned};

use super::error::{HandlerError, HandlerResult};

/// Writes the query string of an address.
pub(crate) fn query_string(asked: &impl Serialize) -> HandlerResult<String> {
    Ok(serde_urlencoded::to_string(asked).map_err(anyhow::Error::from)?)
}

/// The address of the page of an order.
pub(crate) fn order_address(name: &str) -> String {
    let encoded = serde_urlencoded::to_string([("", name)]).unwrap_or_default();
    // A plus sign means a blank in a query only.
    format!("/orders/{}", encoded.trim_start_matches('=').replace('+', "%20"))
}

/// Parses a field of a query; `None` when the field is empty. `what` says in the error what was expected.
pub(crate) fn parse_field<T: DeserializeOwned>(text: &str, what: &str) -> HandlerResult<Option<T>> {
    let value = || text.parse::<i64>().map_or_else(|_| text.into(), serde_json::Value::from);
    match text {
        "" => Ok(None),
        _ => match serde_json::from_value(value()) {
            Ok(value) => Ok(Some(value)),
            Err(_) => Err(HandlerError::Refused(StatusCode::BAD_REQUEST, format!("'{text}' is not {what}"))),
        },
    }
}
