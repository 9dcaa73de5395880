//! Query strings of addresses: writing and reading them.

use axum::{
    extract::{FromRequestParts, Request},
    http::{StatusCode, request::Parts},
    middleware::Next,
    response::{IntoResponse, Response},
};
use language::say;
use serde::{
    Deserializer, Serialize,
    de::{DeserializeOwned, Error, Visitor, value},
    forward_to_deserialize_any,
};

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

/// The address of the list of the orders of a customer.
pub(crate) fn customer_address(name: &str) -> String {
    format!("/orders?{}", serde_urlencoded::to_string([("customer", name)]).unwrap_or_default())
}

/// Parses a field of a query; `None` when the field is empty. `what` says in the error what was expected.
pub(crate) fn parse_field<T: DeserializeOwned>(text: &str, what: &str) -> HandlerResult<Option<T>> {
    let value = || text.parse::<i64>().map_or_else(|_| text.into(), serde_json::Value::from);
    match text {
        "" => Ok(None),
        _ => match serde_json::from_value(value()) {
            Ok(value) => Ok(Some(value)),
            Err(_) => {
                Err(HandlerError::Refused(StatusCode::BAD_REQUEST, say!("is-not-what", text = text, what = what)))
            }
        },
    }
}

/// Parameters that have another name now.
const FORMER: [(&str, &str); 1] = [("profile", "machine")];

/// What an address asks. A parameter that is none of `T` is refused by its name: whoever wrote it would else get an answer to another
/// question.
#[derive(Debug)]
pub(crate) struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Sync> FromRequestParts<S> for Query<T> {
    type Rejection = HandlerError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> HandlerResult<Self> {
        let text = parts.uri.query().unwrap_or_default();
        let mut known: &[&str] = &[];
        // It only says the names of the fields.
        T::deserialize(FieldNames(&mut known)).ok();
        ensure_known(text, known)?;
        serde_urlencoded::from_str(text)
            .map(Self)
            .map_err(|why| refusal(format!("the address cannot be understood: {why}")))
    }
}

/// Refuses every parameter, at an address that has none.
pub(crate) async fn refuse_query(request: Request, next: Next) -> Response {
    match ensure_known(request.uri().query().unwrap_or_default(), &[]) {
        Ok(()) => next.run(request).await,
        Err(refused) => refused.into_response(),
    }
}

fn ensure_known(query: &str, known: &[&str]) -> HandlerResult<()> {
    let given: Vec<(String, String)> = serde_urlencoded::from_str(query).unwrap_or_default();
    let Some((name, _)) = given.iter().find(|(name, _)| !known.contains(&name.as_str())) else { return Ok(()) };
    let now = FORMER.iter().find(|(former, now)| former == name && known.contains(now));
    let instead = match (now, known) {
        (Some((_, now)), _) => format!("it is '{now}' now"),
        (None, []) => "it has none".to_owned(),
        (None, known) => format!("there are {}", known.join(", ")),
    };
    Err(refusal(format!("'{name}' is no parameter of this address: {instead}")))
}

fn refusal(why: String) -> HandlerError {
    HandlerError::Refused(StatusCode::BAD_REQUEST, why)
}

/// Takes the names of the fields of a structure out of what it says to whoever reads it.
struct FieldNames<'n>(&'n mut &'static [&'static str]);

impl<'de> Deserializer<'de> for FieldNames<'_> {
    type Error = value::Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Self::Error> {
        *self.0 = fields;
        Err(Self::Error::custom("only its fields"))
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
        Err(Self::Error::custom("only its fields"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq
        tuple tuple_struct map enum identifier ignored_any
    }
}
