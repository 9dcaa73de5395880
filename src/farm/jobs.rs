//! Work that would hold up the event loop (reading, nesting, proving, copying) runs on threads of its own; each job ends
//! with one event, also when it panics.

use std::{
    any::Any,
    collections::HashSet,
    panic::{AssertUnwindSafe, catch_unwind},
    thread,
};

use tokio::sync::mpsc::UnboundedSender;

use super::event::Event;
use crate::ledger::{BuildId, PartId};

/// What a job is about; only one job of a key runs at a time.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JobKey {
    /// Looking through a profile's hot folder.
    Receive(String),
    /// Reading a part's file.
    Read(PartId),
    /// Improving a profile's open build.
    Improve(String),
    /// Nesting, writing and proving a build.
    Final(BuildId),
    /// Publishing a build.
    Publish(BuildId),
    /// Showing that a profile's folders are served.
    Hold(String),
    /// Holding a profile's folders against the ledger.
    Compare(String),
    /// Looking at stored files that were damaged.
    Damaged,
    /// Putting a claimed file where it belongs.
    End(String),
    /// Copying the original of a waiting part that is refused.
    Copy(PartId),
    /// Going through the archives.
    Purge,
    /// Looking for files beside the hot folders.
    Stray,
    /// Telling in a hot folder that nothing is done any more.
    Tell(String),
}

/// Jobs that run now.
#[derive(Debug)]
pub struct Jobs {
    running: HashSet<JobKey>,
    events: UnboundedSender<Event>,
}

impl Jobs {
    /// Where events go.
    pub fn events(&self) -> UnboundedSender<Event> {
        self.events.clone()
    }

    /// No jobs; each will end with an event.
    pub fn new(events: UnboundedSender<Event>) -> Self {
        Self { running: HashSet::new(), events }
    }

    /// Whether a job of this key runs.
    pub fn runs(&self, key: &JobKey) -> bool {
        self.running.contains(key)
    }

    /// How many jobs run for which `is` holds.
    pub fn count(&self, is: impl Fn(&JobKey) -> bool) -> usize {
        self.running.iter().filter(|key| is(key)).count()
    }

    /// Whether nothing runs.
    pub fn is_idle(&self) -> bool {
        self.running.is_empty()
    }

    /// Starts `work` on a thread of its own unless one of this key runs. A panic becomes [`Event::Panicked`].
    pub fn start(&mut self, key: JobKey, work: impl FnOnce() -> Event + Send + 'static) {
        if self.runs(&key) {
            return;
        }
        self.running.insert(key.clone());
        let events = self.events.clone();
        let name = format!("{key:?}").chars().take(15).collect();
        let spawned = thread::Builder::new().name(name).spawn({
            let key = key.clone();
            move || {
                let event = catch_unwind(AssertUnwindSafe(work))
                    .unwrap_or_else(|panic| Event::Panicked { key, message: panic_message(&*panic) });
                // The loop may have ended; then nobody needs the event, since every step finds its work again.
                let _ = events.send(event);
            }
        });
        if let Err(error) = spawned {
            let _ = self.events.send(Event::NotStarted { key, why: format!("no thread: {error}") });
        }
    }

    /// Notes that a job has ended.
    pub fn ended(&mut self, key: &JobKey) {
        self.running.remove(key);
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panicked".to_owned())
}
