//! What is wrong, said once: the same complaint is logged again only when it changes or lasts.

use std::{
    collections::HashMap,
    time::{Duration, Instant},
};

use tracing::error;

/// Different complaints remembered at most.
const MAX_COMPLAINTS: usize = 1000;
/// The same complaint is logged again after so long.
const COMPLAIN_AGAIN: Duration = Duration::from_secs(600);

/// The complaints of a running farm.
#[derive(Debug, Default)]
pub struct Complaints {
    known: HashMap<String, (String, Instant)>,
}

impl Complaints {
    /// Logs a complaint about something, unless it was said a while ago.
    pub fn note(&mut self, about: &str, text: &str) {
        let known = self.known.get(about);
        if known.is_some_and(|(said, at)| said == text && at.elapsed() < COMPLAIN_AGAIN) {
            return;
        }
        error!("{}.", text.trim_end_matches('.'));
        if self.known.len() >= MAX_COMPLAINTS {
            self.known.clear();
        }
        self.known.insert(about.to_owned(), (text.to_owned(), Instant::now()));
    }

    /// There is nothing to complain about any more.
    pub fn settled(&mut self, about: &str) {
        self.known.remove(about);
    }
}
