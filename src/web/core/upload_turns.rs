//! Turns at uploads: one request writes to an upload at a time, and ends when another one comes for it.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use axum::http::StatusCode;
use tokio::sync::{OwnedMutexGuard, watch};

use crate::web::base::error::{HandlerError, HandlerResult};

/// How long a request waits for one to end that sends to the same upload: its connection was cut.
const TURN_TIMEOUT: Duration = Duration::from_secs(5);

/// A turn at an upload: one request writes at a time, and ends when another one comes.
#[derive(Debug)]
struct UploadTurn {
    busy: Arc<tokio::sync::Mutex<()>>,
    comes: watch::Sender<u64>,
}

/// The uploads that requests are at.
#[derive(Debug, Default)]
pub(crate) struct UploadTurns(Mutex<HashMap<String, Arc<UploadTurn>>>);

impl UploadTurns {
    fn turn_of(&self, id: &str) -> Arc<UploadTurn> {
        let mut turns = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Those that nobody is at.
        turns.retain(|_, turn| Arc::strong_count(turn) > 1 || Arc::strong_count(&turn.busy) > 1);
        let new = || Arc::new(UploadTurn { busy: Arc::default(), comes: watch::Sender::new(0) });
        turns.entry(id.to_owned()).or_insert_with(new).clone()
    }

    /// A turn if no other request is at an upload. One that is goes on.
    pub(crate) fn try_turn(&self, id: &str) -> Option<OwnedMutexGuard<()>> {
        self.turn_of(id).busy.clone().try_lock_owned().ok()
    }

    /// Has other requests at an upload end, and waits for that.
    pub(crate) async fn take_turn(&self, id: &str) -> HandlerResult<(OwnedMutexGuard<()>, watch::Receiver<u64>)> {
        let turn = self.turn_of(id);
        turn.comes.send_modify(|count| *count += 1);
        let held = tokio::time::timeout(TURN_TIMEOUT, turn.busy.clone().lock_owned()).await;
        let busy = |_| HandlerError::Refused(StatusCode::LOCKED, "another request sends to this upload".to_owned());
        let held = held.map_err(busy)?;
        Ok((held, turn.comes.subscribe()))
    }
}
