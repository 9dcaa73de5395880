//! What one client may take of the farm: requests in a time, and bytes that are under way. A client is a token, or an address without one.
//! Who asks too much is told when to ask again; the others, and the farm, do not notice.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use super::error::HandlerError;

/// Clients that are remembered before those are forgotten that take nothing.
const MANY_CLIENTS: usize = 1000;

/// What each client may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClientRates {
    /// Requests per second, for long.
    pub(super) per_sec: f64,
    /// Requests at once.
    pub(super) burst: u32,
    /// Bytes under way.
    pub(super) bytes: u64,
}

/// What the clients take.
#[derive(Debug)]
pub(super) struct ClientLimits {
    rates: ClientRates,
    uses: Mutex<HashMap<String, ClientUse>>,
}

/// What a client takes.
#[derive(Debug)]
struct ClientUse {
    /// When all its requests would have come, had they come at the allowed rate (generic cell rate algorithm, ITU-T I.371).
    expected_at: Instant,
    bytes: u64,
}

/// Counts bytes of a client as under way until it is dropped.
#[derive(Debug)]
pub(super) struct BytesUnderWay {
    limits: Arc<ClientLimits>,
    client: String,
    bytes: u64,
}

impl ClientLimits {
    pub(super) fn new(rates: ClientRates) -> Arc<Self> {
        Arc::new(Self { rates, uses: Mutex::default() })
    }

    /// Counts a request of a client.
    ///
    /// # Errors
    /// `TooMany` when it sends more than it may.
    pub(super) fn count_request(&self, client: &str) -> Result<(), HandlerError> {
        let wait = self.try_request(client, Instant::now()).err();
        let text = || format!("you send more than {} requests a second", self.rates.per_sec);
        wait.map_or(Ok(()), |wait| Err(HandlerError::TooMany(wait.as_secs_f64().ceil().max(1.0) as u64, text())))
    }

    /// Counts a request that comes at this time, or returns how long the client has to wait.
    fn try_request(&self, client: &str, now: Instant) -> Result<(), Duration> {
        let interval = Duration::from_secs_f64(1.0 / self.rates.per_sec);
        let mut uses = self.uses.lock().unwrap_or_else(PoisonError::into_inner);
        if uses.len() > MANY_CLIENTS {
            uses.retain(|_, used| used.bytes > 0 || used.expected_at > now);
        }
        let used = uses.entry(client.to_owned()).or_insert(ClientUse { expected_at: now, bytes: 0 });
        let expected_at = used.expected_at.max(now) + interval;
        match (expected_at - now).checked_sub(interval * self.rates.burst) {
            Some(wait) if !wait.is_zero() => Err(wait),
            _ => {
                used.expected_at = expected_at;
                Ok(())
            }
        }
    }

    /// Counts bytes that a client is about to send, beside `on_disk` that wait there for the rest of their file.
    ///
    /// # Errors
    /// `TooMany` when they are more than it may have under way.
    pub(super) fn begin_bytes(
        self: &Arc<Self>,
        client: &str,
        bytes: u64,
        on_disk: u64,
    ) -> Result<BytesUnderWay, HandlerError> {
        let mut uses = self.uses.lock().unwrap_or_else(PoisonError::into_inner);
        let used = uses.entry(client.to_owned()).or_insert(ClientUse { expected_at: Instant::now(), bytes: 0 });
        if used.bytes.saturating_add(bytes).saturating_add(on_disk) > self.rates.bytes {
            let text = format!("you would have more than {} bytes under way (web.client_bytes)", self.rates.bytes);
            return Err(HandlerError::TooMany(10, text));
        }
        used.bytes += bytes;
        drop(uses);
        Ok(BytesUnderWay { limits: self.clone(), client: client.to_owned(), bytes })
    }
}

impl Drop for BytesUnderWay {
    fn drop(&mut self) {
        let mut uses = self.limits.uses.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(used) = uses.get_mut(&self.client) {
            used.bytes -= self.bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Arc<ClientLimits> {
        ClientLimits::new(ClientRates { per_sec: 10.0, burst: 5, bytes: 100 })
    }

    #[test]
    fn a_client_may_ask_in_bursts_and_then_at_its_rate_and_others_do_not_notice() {
        let (limits, begin) = (limits(), Instant::now());
        let ask = |client: &str, millis| limits.try_request(client, begin + Duration::from_millis(millis));
        assert_eq!((0..20).filter(|_| ask("a", 0).is_ok()).count(), 5);
        let wait = ask("a", 0).unwrap_err();
        assert!(wait > Duration::from_millis(99) && wait < Duration::from_millis(101), "{wait:?}");
        assert!(ask("b", 0).is_ok() && ask("a", 101).is_ok() && ask("a", 101).is_err());
        // Ten seconds of a flood, 1000 requests a second.
        let through = (1_000..11_000).filter(|millis| ask("a", *millis).is_ok()).count();
        assert!((100..=106).contains(&through), "{through}");
        assert!(matches!(limits.count_request("c"), Ok(())));
    }

    #[test]
    fn bytes_count_while_they_are_under_way() {
        let limits = limits();
        let first = limits.begin_bytes("a", 60, 0).unwrap();
        assert!(matches!(limits.begin_bytes("a", 41, 0), Err(HandlerError::TooMany(10, _))));
        assert!(limits.begin_bytes("a", 20, 21).is_err() && limits.begin_bytes("b", 100, 0).is_ok());
        drop(first);
        assert!(limits.begin_bytes("a", 100, 0).is_ok());
    }
}
