//! Live updates: the server notifies a page that something has changed, and the page reloads its content. The first event
//! comes as soon as a page subscribes, so that a change since the page was rendered is not lost. Each event names the time zone
//! of the farm, in which a page that loses its connection says since when.

use std::{convert::Infallible, sync::Arc, time::Duration};

use axum::{
    extract::State,
    http::StatusCode,
    response::sse::{Event, KeepAlive, Sse},
};
use tokio::sync::watch;
use tokio_stream::{Stream, StreamExt, wrappers::WatchStream};

use crate::web::{
    base::error::{HandlerError, HandlerResult},
    core::state::DashboardState,
};

/// Most pages that listen at once. Each of them keeps a connection open, and other requests need connections as well.
pub(crate) const MAX_LISTENERS: usize = 48;

/// Whether an address is that of a change stream: `/live`, or that of a build, `/builds/N/live`, which the node of its machine answers, as it
/// does for its break-out. There it is known which copies the screens show. An order may be called so, too: `/orders/live` is its page.
pub(crate) fn is_stream_of_changes(path: &str) -> bool {
    let of_build = || path.strip_prefix("/builds/").and_then(|rest| rest.strip_suffix("/live"));
    path == "/live" || of_build().is_some_and(|build| !build.contains('/'))
}

/// Time between two reads of the ledger while a page listens.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// The change stream: an event `changed` at once, and again whenever the farm's state changes. Its data is the name of the farm's
/// time zone; empty where that has no name.
pub(crate) async fn stream_changes(
    State(web): State<Arc<DashboardState>>,
) -> HandlerResult<Sse<impl Stream<Item = Result<Event, Infallible>>>> {
    if web.changes.receiver_count() >= MAX_LISTENERS {
        let text = "too many pages listen for changes already".to_owned();
        return Err(HandlerError::Refused(StatusCode::TOO_MANY_REQUESTS, text));
    }
    let changes = WatchStream::new(web.changes.subscribe());
    let events = changes.map(move |_| {
        let zone = web.current_settings().time_zone.time_zone().iana_name().unwrap_or_default().to_owned();
        Ok(Event::default().event("changed").data(zone))
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::default()))
}

/// Checks once a second, and as soon as a person said something, whether the farm's state has changed, while any page listens.
pub(crate) async fn watch_for_changes(web: Arc<DashboardState>, changes: watch::Sender<u64>) {
    let mut seen = String::new();
    loop {
        // Either way it is time to look.
        let _ = tokio::time::timeout(POLL_INTERVAL, web.said.notified()).await;
        if changes.receiver_count() == 0 {
            continue;
        }
        // A read that fails is repeated a second later.
        let Ok(now) = web.change_token().await else { continue };
        if now != seen {
            seen = now;
            changes.send_modify(|number| *number += 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_stream_of_changes;

    #[test]
    fn pages_of_what_is_called_live_are_pages() {
        assert!(["/live", "/builds/7/live"].into_iter().all(is_stream_of_changes));
        let pages = ["/orders/live", "/builds/7/break-out", "/builds/7/parts/live", "/machines/live"];
        assert!(!pages.into_iter().any(is_stream_of_changes));
    }
}
