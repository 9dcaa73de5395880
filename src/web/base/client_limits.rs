//! What one client may take of the farm: requests in a time, and bytes that are under way. A client is a token, or an address without one.
//! Who asks too much is told when to ask again; the others, and the farm, do not notice.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::Context;
use tokio::sync::Semaphore;

use super::error::HandlerError;

/// Clients that are remembered before those are forgotten that take nothing.
const MANY_CLIENTS: usize = 1000;
/// Files that one client may send at the same time: others have the other places.
const PLACES_PER_CLIENT: usize = 2;

/// What each client may take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClientRates {
    /// Requests per second, for long.
    pub(crate) per_sec: f64,
    /// Requests at once.
    pub(crate) burst: u32,
    /// Bytes under way.
    pub(crate) bytes: u64,
}

/// What the clients take.
#[derive(Debug)]
pub(crate) struct ClientLimits {
    rates: ClientRates,
    uses: Mutex<HashMap<String, ClientUse>>,
}

/// What a client takes.
#[derive(Debug)]
struct ClientUse {
    /// When all its requests would have come, had they come at the allowed rate (generic cell rate algorithm, ITU-T I.371).
    expected_at: Instant,
    bytes: u64,
    /// Files that arrive from it.
    places: usize,
}

/// Counts a file of a client as arriving until it is dropped.
#[derive(Debug)]
pub(crate) struct ClientPlace {
    limits: Arc<ClientLimits>,
    client: String,
}

/// Counts bytes of a client as under way until it is dropped.
#[derive(Debug)]
pub(crate) struct BytesUnderWay {
    limits: Arc<ClientLimits>,
    client: String,
    /// Those that were announced, or have arrived beyond that.
    bytes: u64,
    received: u64,
}

impl ClientUse {
    fn new(expected_at: Instant) -> Self {
        Self { expected_at, bytes: 0, places: 0 }
    }
}

impl ClientLimits {
    pub(crate) fn new(rates: ClientRates) -> Arc<Self> {
        Arc::new(Self { rates, uses: Mutex::default() })
    }

    /// Counts a request of a client.
    ///
    /// # Errors
    /// `TooMany` when it sends more than it may.
    pub(crate) fn count_request(&self, client: &str) -> Result<(), HandlerError> {
        let wait = self.try_request(client, Instant::now()).err();
        let text = || format!("you send more than {} requests a second", self.rates.per_sec);
        wait.map_or(Ok(()), |wait| Err(HandlerError::TooMany(wait.as_secs_f64().ceil().max(1.0) as u64, text())))
    }

    /// Counts a request that comes at this time, or returns how long the client has to wait.
    fn try_request(&self, client: &str, now: Instant) -> Result<(), Duration> {
        let interval = Duration::from_secs_f64(1.0 / self.rates.per_sec);
        let mut uses = self.uses.lock().unwrap_or_else(PoisonError::into_inner);
        if uses.len() > MANY_CLIENTS {
            uses.retain(|_, used| used.bytes > 0 || used.places > 0 || used.expected_at > now);
        }
        let used = uses.entry(client.to_owned()).or_insert(ClientUse::new(now));
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
    pub(crate) fn begin_bytes(
        self: &Arc<Self>,
        client: &str,
        bytes: u64,
        on_disk: u64,
    ) -> Result<BytesUnderWay, HandlerError> {
        self.add_bytes(client, bytes, on_disk)?;
        Ok(BytesUnderWay { limits: self.clone(), client: client.to_owned(), bytes, received: 0 })
    }

    fn add_bytes(&self, client: &str, bytes: u64, on_disk: u64) -> Result<(), HandlerError> {
        let mut uses = self.uses.lock().unwrap_or_else(PoisonError::into_inner);
        let used = uses.entry(client.to_owned()).or_insert(ClientUse::new(Instant::now()));
        if used.bytes.saturating_add(bytes).saturating_add(on_disk) > self.rates.bytes {
            let text = format!("you would have more than {} bytes under way (web.client_bytes)", self.rates.bytes);
            return Err(HandlerError::TooMany(10, text));
        }
        used.bytes += bytes;
        Ok(())
    }

    /// Counts a file that is about to arrive from a client.
    ///
    /// # Errors
    /// `TooMany` while as many arrive from it as may at a time.
    pub(crate) fn begin_file(self: &Arc<Self>, client: &str) -> Result<ClientPlace, HandlerError> {
        let mut uses = self.uses.lock().unwrap_or_else(PoisonError::into_inner);
        let used = uses.entry(client.to_owned()).or_insert(ClientUse::new(Instant::now()));
        if used.places >= PLACES_PER_CLIENT {
            let text = format!("you are sending {PLACES_PER_CLIENT} files just now: send the next one afterwards");
            return Err(HandlerError::TooMany(1, text));
        }
        used.places += 1;
        drop(uses);
        Ok(ClientPlace { limits: self.clone(), client: client.to_owned() })
    }
}

impl BytesUnderWay {
    /// Counts bytes that have arrived: those beyond what was announced are under way from now on.
    ///
    /// # Errors
    /// `TooMany` when they are more than the client may have under way.
    pub(crate) fn count_received(&mut self, bytes: u64) -> Result<(), HandlerError> {
        self.received += bytes;
        let beyond = self.received.saturating_sub(self.bytes);
        self.limits.add_bytes(&self.client, beyond, 0)?;
        self.bytes += beyond;
        Ok(())
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

impl Drop for ClientPlace {
    fn drop(&mut self) {
        let mut uses = self.limits.uses.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(used) = uses.get_mut(&self.client) {
            used.places -= 1;
        }
    }
}

/// Passwords that are compared or hashed at the same time.
const MAX_PASSWORDS: usize = 2;
/// How often a name may be tried with a wrong password or PIN.
pub(crate) const NAME_ATTEMPTS: u32 = 5;
/// How often an address may; behind a proxy, many people have one.
pub(crate) const ADDRESS_ATTEMPTS: u32 = 30;
/// Failed attempts are forgotten this long after the first of them.
const ATTEMPTS_KEPT: Duration = Duration::from_secs(15 * 60);

/// Failed attempts to sign in, by name and by address. Also names that nobody has are counted: else it would show who is known.
#[derive(Debug)]
pub(crate) struct SignInAttempts {
    counts: Mutex<HashMap<String, (u32, Instant)>>,
    /// Who holds one of these compares or hashes a password, which takes a core and 19 MiB.
    slots: Arc<Semaphore>,
}

impl Default for SignInAttempts {
    fn default() -> Self {
        Self { counts: Mutex::default(), slots: Arc::new(Semaphore::new(MAX_PASSWORDS)) }
    }
}

impl SignInAttempts {
    /// Compares or hashes a password where that holds up no other request.
    pub(crate) async fn work<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> anyhow::Result<T> {
        let slot = self.slots.clone().acquire_owned().await.context("nobody works on passwords any more")?;
        let in_slot = move || {
            let _slot = slot;
            work()
        };
        tokio::task::spawn_blocking(in_slot).await.context("working on a password")
    }

    /// Counts an attempt for each of these, which may have so many; or returns how long to wait. An attempt counts before it is judged, so
    /// that many at once are no way around.
    pub(crate) fn begin(&self, tried: &[(String, u32)], now: Instant) -> Result<(), Duration> {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        counts.retain(|_, (_, since)| now.saturating_duration_since(*since) < ATTEMPTS_KEPT);
        let wait_of = |(name, most): &(String, u32)| {
            let (_, since) = counts.get(name).filter(|(count, _)| count >= most)?;
            Some(ATTEMPTS_KEPT.saturating_sub(now.saturating_duration_since(*since)))
        };
        if let Some(wait) = tried.iter().filter_map(wait_of).max() {
            return Err(wait);
        }
        for (name, _) in tried {
            counts.entry(name.clone()).or_insert((0, now)).0 += 1;
        }
        Ok(())
    }

    /// The attempt was right: it does not count, and neither do those before it under the name, the first of these.
    pub(crate) fn succeed(&self, tried: &[(String, u32)]) {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        for (at, (name, _)) in tried.iter().enumerate() {
            match counts.get_mut(name) {
                Some((count, _)) if at > 0 && *count > 1 => *count -= 1,
                _ => {
                    counts.remove(name);
                }
            }
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
        let mut unannounced = limits.begin_bytes("a", 0, 0).unwrap();
        assert!(unannounced.count_received(60).is_ok() && unannounced.count_received(40).is_ok());
        assert!(unannounced.count_received(1).is_err() && limits.begin_bytes("a", 1, 0).is_err());
        drop(unannounced);
        let mut announced = limits.begin_bytes("a", 100, 0).unwrap();
        assert!(announced.count_received(100).is_ok());
    }

    #[test]
    fn a_name_and_an_address_may_fail_a_few_times_and_a_right_password_makes_the_name_free_again() {
        let (attempts, begin) = (SignInAttempts::default(), Instant::now());
        let try_it = |name: &str, address: &str, secs| {
            let tried = [(format!("name {name}"), NAME_ATTEMPTS), (format!("address {address}"), ADDRESS_ATTEMPTS)];
            attempts.begin(&tried, begin + Duration::from_secs(secs)).map(|()| tried)
        };
        assert_eq!((0..9).filter(|_| try_it("anna", "1", 0).is_ok()).count(), 5);
        assert!(try_it("anna", "2", 60).unwrap_err() == Duration::from_secs(840) && try_it("bert", "1", 60).is_ok());
        let right = try_it("bert", "1", 61).unwrap();
        attempts.succeed(&right);
        assert_eq!((0..9).filter(|_| try_it("bert", "1", 62).is_ok()).count(), 5, "the former ones are forgotten");
        // 5 of anna, 1 and 5 of bert: the address has 19 left, whatever names it tries.
        assert_eq!((0..99).filter(|at| try_it(&format!("n{at}"), "1", 63).is_ok()).count(), 19);
        assert!(try_it("anna", "1", 901).is_ok(), "after a quarter of an hour");
    }
}
