//! Keys of requests that are being carried out: one request has a key at a time.

use std::{
    collections::HashSet,
    sync::{Mutex, PoisonError},
};

use axum::http::StatusCode;
use tokio::sync::Semaphore;

use super::error::{HandlerError, HandlerResult};

/// Files that are judged at the same time.
const JUDGED_AT_ONCE: usize = 1;

/// Requests that are being carried out.
#[derive(Debug)]
pub(super) struct OrderDoor {
    keys: Mutex<HashSet<(String, String)>>,
    /// Who holds it judges a file.
    pub(super) judging: Semaphore,
}

impl Default for OrderDoor {
    fn default() -> Self {
        Self { keys: Mutex::default(), judging: Semaphore::new(JUDGED_AT_ONCE) }
    }
}

/// Holds a key while its request is carried out.
pub(super) struct KeyGuard<'a> {
    door: &'a OrderDoor,
    key: (String, String),
}

impl OrderDoor {
    /// Holds the key of a client.
    ///
    /// # Errors
    /// `Refused` while another request has it.
    pub(super) fn begin_request(&self, client: &str, key: &str) -> HandlerResult<KeyGuard<'_>> {
        let key = (client.to_owned(), key.to_owned());
        let is_first = self.keys.lock().unwrap_or_else(PoisonError::into_inner).insert(key.clone());
        let text = "a request with this Idempotency-Key is being carried out: ask again in a moment";
        match is_first {
            true => Ok(KeyGuard { door: self, key }),
            false => Err(HandlerError::Refused(StatusCode::CONFLICT, text.to_owned())),
        }
    }
}

impl Drop for KeyGuard<'_> {
    fn drop(&mut self) {
        self.door.keys.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.key);
    }
}
