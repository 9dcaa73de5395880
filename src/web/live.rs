//! Live updates: a page hears when something has changed and asks for itself again. It hears at once when it begins to listen,
//! so that what changed since it was made is not lost.

use std::{convert::Infallible, sync::Arc, time::Duration};

use axum::{
    extract::State,
    http::StatusCode,
    response::sse::{Event, KeepAlive, Sse},
};
use tokio::sync::watch;
use tokio_stream::{Stream, StreamExt, wrappers::WatchStream};

use super::{
    problem::{Answer, Problem},
    state::Web,
};

/// So many pages listen at once at most: each keeps one of the connections that may be open, and others want to ask, too.
pub(super) const MOST_LISTENING: usize = 48;

/// Between two looks at the ledger while somebody watches.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// The stream of changes: an event `changed` at once, and whenever the farm's state is another one.
pub(super) async fn live(State(web): State<Arc<Web>>) -> Answer<Sse<impl Stream<Item = Result<Event, Infallible>>>> {
    if web.changes.receiver_count() >= MOST_LISTENING {
        let text = "too many pages listen for changes already".to_owned();
        return Err(Problem::Refused(StatusCode::TOO_MANY_REQUESTS, text));
    }
    let changes = WatchStream::new(web.changes.subscribe());
    let events = changes.map(|number| Ok(Event::default().event("changed").data(number.to_string())));
    Ok(Sse::new(events).keep_alive(KeepAlive::default()))
}

/// Looks whether the farm's state has changed, as long as somebody wants to know.
pub(super) async fn look(web: Arc<Web>, changes: watch::Sender<u64>) {
    let mut seen = String::new();
    loop {
        tokio::time::sleep(LOOK_EVERY).await;
        if changes.receiver_count() == 0 {
            continue;
        }
        // What cannot be read now is read a second later.
        let Ok(now) = web.pulse().await else { continue };
        if now != seen {
            seen = now;
            changes.send_modify(|number| *number += 1);
        }
    }
}
