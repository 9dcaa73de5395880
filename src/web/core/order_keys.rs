//! Keys of requests that are being carried out: one request has a key at a time.

use std::{
    collections::HashSet,
    sync::{Arc, Mutex, PoisonError},
};

use axum::http::StatusCode;
use tokio::sync::Semaphore;

use crate::web::base::error::{HandlerError, HandlerResult};

/// Files that are judged at the same time.
const JUDGED_AT_ONCE: usize = 1;

/// Orders that are being carried out, whether their clients still wait or not.
const MOST_AT_ONCE: usize = 64;

/// Requests that are being carried out.
#[derive(Debug)]
pub(crate) struct OrderDoor {
    keys: Mutex<HashSet<(String, String)>>,
    /// Who holds it judges a file.
    pub(crate) judging: Arc<Semaphore>,
}

impl Default for OrderDoor {
    fn default() -> Self {
        Self { keys: Mutex::default(), judging: Arc::new(Semaphore::new(JUDGED_AT_ONCE)) }
    }
}

/// Holds a key while its request is carried out.
pub(crate) struct KeyGuard {
    door: Arc<OrderDoor>,
    key: (String, String),
}

impl OrderDoor {
    /// Holds the key of a client.
    ///
    /// # Errors
    /// `Refused` while another request has it, `TooMany` while too many others are carried out.
    pub(crate) fn begin_request(self: &Arc<Self>, client: &str, key: &str) -> HandlerResult<KeyGuard> {
        let key = (client.to_owned(), key.to_owned());
        let mut keys = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        if keys.len() >= MOST_AT_ONCE && !keys.contains(&key) {
            return Err(HandlerError::TooMany(
                1,
                "many orders are being taken just now: ask again in a moment".to_owned(),
            ));
        }
        let is_first = keys.insert(key.clone());
        drop(keys);
        let text = "a request with this Idempotency-Key is being carried out: ask again in a moment";
        match is_first {
            true => Ok(KeyGuard { door: self.clone(), key }),
            false => Err(HandlerError::Refused(StatusCode::CONFLICT, text.to_owned())),
        }
    }
}

impl Drop for KeyGuard {
    fn drop(&mut self) {
        self.door.keys.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.key);
    }
}
