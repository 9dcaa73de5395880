//! The telling: a task per receiver goes from event to event. It stays at one until the receiver has it, waits longer after
//! each failure, and drops what is older than the settings keep.

use std::{
    sync::{Arc, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use jiff::{SignedDuration, Timestamp};
use tracing::{info, warn};

use super::{
    Message,
    message::kinds,
    send::{configured, send},
};
use crate::{
    ledger::{EventRow, Ledger, Receiver},
    settings::{Settings, Shared},
};

/// Between two looks for news.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// After the first failure, and after many.
const FIRST_WAIT: Duration = Duration::from_secs(1);
const LONGEST_WAIT: Duration = Duration::from_secs(300);
/// A receiver that cannot be told for so long needs a person.
const TROUBLE_AFTER: SignedDuration = SignedDuration::from_mins(5);
/// The place of a receiver behind events that were not for it is written down so often at most.
const NOTE_EVERY: Duration = Duration::from_secs(60);
/// What sends must end within its timeout; a thread that does not is left to itself.
const GRACE: Duration = Duration::from_secs(5);

/// Tells the receivers of the settings what happens, until it is dropped. `trouble` hears of a receiver that cannot be told
/// for long (and of `None` when it can).
pub async fn serve(settings: Shared, trouble: impl Fn(Receiver, Option<String>)) {
    let tell = |receiver| Telling::new(settings.clone(), receiver).run(&trouble);
    tokio::join!(tell(Receiver::Webhook), tell(Receiver::Command));
}

/// Forgets the places of receivers that are not configured; for where nobody is told anything.
///
/// # Errors
/// When the ledger does not answer.
pub async fn forget_others(settings: &Shared) -> Result<()> {
    let settings = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
    let known = configured(&settings.notify);
    let others: Vec<Receiver> =
        [Receiver::Webhook, Receiver::Command].into_iter().filter(|receiver| !known.contains(receiver)).collect();
    forget(&settings, &others).await
}

async fn forget(settings: &Settings, receivers: &[Receiver]) -> Result<()> {
    let ledger = Ledger::open_existing(&settings.ledger).await?;
    let mut forgotten = Ok(());
    for receiver in receivers {
        forgotten = forgotten.and(ledger.forget_receiver(*receiver).await);
    }
    ledger.close().await;
    Ok(forgotten?)
}

/// What came of one step.
enum Step {
    /// There is nothing to tell, or nobody.
    Idle,
    /// One event was told.
    Told,
    /// The receiver could not be told; with what a person must see to.
    Failed(Option<String>),
}

/// The telling of one receiver.
struct Telling {
    settings: Shared,
    receiver: Receiver,
    ledger: Option<Ledger>,
    /// The latest event that it has, or that is not for it; `None` = not asked for yet.
    at: Option<i64>,
    /// The same as it stands in the ledger, and since when.
    noted: (i64, Instant),
    /// Whether the ledger knows that the receiver is not configured.
    is_forgotten: bool,
    /// Why it could not be told last.
    failing: String,
}

impl Telling {
    fn new(settings: Shared, receiver: Receiver) -> Self {
        let (ledger, at, failing) = (None, None, String::new());
        Self { settings, receiver, ledger, at, noted: (0, Instant::now()), is_forgotten: false, failing }
    }

    fn settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    async fn run(mut self, trouble: &impl Fn(Receiver, Option<String>)) {
        let mut wait = FIRST_WAIT;
        loop {
            let settings = self.settings();
            match self.step(&settings).await {
                // Nothing waits for it, or it is not to be told any more.
                Ok(Step::Idle) => {
                    trouble(self.receiver, None);
                    tokio::time::sleep(LOOK_EVERY).await;
                }
                Ok(Step::Told) => {
                    trouble(self.receiver, None);
                    wait = FIRST_WAIT;
                }
                Ok(Step::Failed(needs_person)) => {
                    trouble(self.receiver, needs_person);
                    self.rest(wait, &settings).await;
                    wait = (2 * wait).min(LONGEST_WAIT);
                }
                Err(failure) => {
                    // The ledger is not there yet, or is damaged, which the farm tells.
                    tracing::debug!("The {} cannot be told now: {failure:#}.", self.receiver);
                    self.at = None;
                    self.rest(wait, &settings).await;
                    wait = (2 * wait).min(LONGEST_WAIT);
                }
            }
        }
    }

    /// Waits, but not when the settings become others.
    async fn rest(&self, wait: Duration, before: &Arc<Settings>) {
        let until = tokio::time::Instant::now() + wait;
        while tokio::time::Instant::now() < until && Arc::ptr_eq(before, &self.settings()) {
            tokio::time::sleep(LOOK_EVERY.min(wait)).await;
        }
    }

    async fn step(&mut self, settings: &Settings) -> Result<Step> {
        if !configured(&settings.notify).contains(&self.receiver) {
            return self.forget(settings).await;
        }
        self.is_forgotten = false;
        let ledger = match &self.ledger {
            Some(ledger) => ledger.clone(),
            None => self.ledger.insert(Ledger::open_existing(&settings.ledger).await?).clone(),
        };
        let at = match self.at {
            Some(at) => at,
            None => {
                let row = ledger.receiver(self.receiver).await?;
                (self.at, self.noted) = (Some(row.told_id), (row.told_id, Instant::now()));
                row.told_id
            }
        };
        let last = ledger.last_event_id().await?;
        if last > at
            && let Some(event) = ledger.next_event(at, &kinds(&settings.notify.events)).await?
        {
            return self.tell(settings, &ledger, &event).await;
        }
        self.at = Some(last.max(at));
        if last > self.noted.0 && self.noted.1.elapsed() >= NOTE_EVERY {
            ledger.told(self.receiver, last).await?;
            self.noted = (last, Instant::now());
        }
        Ok(Step::Idle)
    }

    /// Nobody is to be told: when somebody is again, he is told of what happens from then on.
    async fn forget(&mut self, settings: &Settings) -> Result<Step> {
        if !self.is_forgotten {
            forget(settings, &[self.receiver]).await?;
            (self.is_forgotten, self.at, self.ledger) = (true, None, None);
        }
        Ok(Step::Idle)
    }

    async fn tell(&mut self, settings: &Settings, ledger: &Ledger, event: &EventRow) -> Result<Step> {
        let message = Message::of(event, ledger).await?;
        let (notify, receiver) = (settings.notify.clone(), self.receiver);
        let within = Duration::from_secs_f64(notify.timeout_secs) + GRACE;
        let sending = tokio::task::spawn_blocking(move || send(&notify, receiver, &message));
        let sent = match tokio::time::timeout(within, sending).await {
            Ok(ended) => ended.context("sending").and_then(|sent| sent),
            Err(_) => Err(anyhow::anyhow!("it hangs")),
        };
        match sent {
            Ok(()) => {
                ledger.told(receiver, event.id).await?;
                (self.at, self.noted) = (Some(event.id), (event.id, Instant::now()));
                if !std::mem::take(&mut self.failing).is_empty() {
                    info!("The {receiver} can be told again.");
                }
                Ok(Step::Told)
            }
            Err(failure) => self.failed(settings, ledger, event, format!("{failure:#}")).await,
        }
    }

    async fn failed(&mut self, settings: &Settings, ledger: &Ledger, event: &EventRow, why: String) -> Result<Step> {
        let receiver = self.receiver;
        if why != self.failing {
            warn!("The {receiver} could not be told of event {}, which is tried again: {why}.", event.id);
        }
        ledger.not_told(receiver, &why).await?;
        let now = Timestamp::now();
        let keep = SignedDuration::try_from_secs_f64(settings.notify.keep_secs).unwrap_or(SignedDuration::MAX);
        let mut told = format!("the {receiver}: {why}");
        if now.duration_since(event.at.0) > keep {
            let before = now.checked_sub(keep).unwrap_or(Timestamp::UNIX_EPOCH);
            let dropped = ledger.drop_untold(receiver, before, &kinds(&settings.notify.events)).await?;
            warn!("{dropped} messages to the {receiver} were dropped: they are older than notify.keep_secs.");
            told += &format!("; {dropped} messages were dropped");
            self.at = None;
        }
        let row = ledger.receiver(receiver).await?;
        let is_long = row.failing_at.is_some_and(|since| now.duration_since(since.0) >= TROUBLE_AFTER);
        self.failing = why;
        Ok(Step::Failed(is_long.then_some(told)))
    }
}
