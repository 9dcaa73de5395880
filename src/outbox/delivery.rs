//! Delivery: one task for each receiver processes the events in order. It retries an event until the receiver accepts
//! it, waits longer after each failure, and drops events that are older than the settings allow.

use std::{
    collections::BTreeSet,
    sync::{Arc, PoisonError},
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use jiff::{SignedDuration, Timestamp};
use ledger::{EventRow, Ledger, LedgerOnDemand, ReceiverKind};
use settings::{Settings, SharedSettings};
use tracing::{info, warn};

use super::{
    EventMessage,
    send::{configured_receivers, kinds_for, send_message},
};

/// Interval of the checks for new events.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// The same for mails, which nobody waits for by the second.
const LOOK_FOR_MAILS: Duration = Duration::from_secs(2);
/// The same while another node delivers.
const LOOK_BESIDE_OTHER: Duration = Duration::from_secs(10);
/// Wait after the first failure, and maximum wait.
const FIRST_WAIT: Duration = Duration::from_secs(1);
const LONGEST_WAIT: Duration = Duration::from_secs(300);
/// A receiver that fails for longer than this needs a person.
const ALERT_AFTER: SignedDuration = SignedDuration::from_mins(5);
/// Minimum interval between two writes of a receiver's position when the events since then were not for it.
const POSITION_WRITE_INTERVAL: Duration = Duration::from_secs(60);
/// Where several nodes share the ledger, one of them delivers to a receiver. Another one takes this over when that one has begun no
/// attempt for this long after the longest one.
const DUTY_GRACE: Duration = Duration::from_secs(30);
/// Time allowed beyond the timeout; a sending thread that takes longer is abandoned.
pub(super) const SEND_GRACE: Duration = Duration::from_secs(5);

/// Delivers events to the configured receivers until the future is dropped. Calls `report_failure` with a message when a
/// receiver fails for long, and with `None` when it works.
pub async fn deliver_events(
    settings: SharedSettings,
    ledger: LedgerOnDemand,
    report_failure: impl Fn(ReceiverKind, Option<String>),
) {
    // In the heap: together they would not fit onto the stack of a small thread.
    let deliver =
        |receiver| Box::pin(ReceiverDelivery::new(settings.clone(), ledger.clone(), receiver).run(&report_failure));
    let mails = async {
        tokio::join!(
            deliver(ReceiverKind::EmailAlert),
            deliver(ReceiverKind::EmailRefused),
            deliver(ReceiverKind::EmailAtRisk),
            deliver(ReceiverKind::EmailOrderComplete)
        )
    };
    tokio::join!(deliver(ReceiverKind::Webhook), deliver(ReceiverKind::Command), mails);
}

/// Deletes the positions of receivers that are not configured. For a process that delivers nothing.
///
/// # Errors
/// The ledger cannot be read or changed.
pub async fn forget_unconfigured_receivers(settings: &SharedSettings) -> Result<()> {
    let settings = settings.read().unwrap_or_else(PoisonError::into_inner).clone();
    let known = configured_receivers(&settings.interfaces.notify);
    let others: Vec<ReceiverKind> =
        ReceiverKind::ALL.into_iter().filter(|receiver| !known.contains(receiver)).collect();
    forget_receivers(&settings, &others).await
}

async fn forget_receivers(settings: &Settings, receivers: &[ReceiverKind]) -> Result<()> {
    // Where several nodes share the ledger, another one may deliver to it.
    if settings.ledger.file().is_none() {
        return Ok(());
    }
    let ledger = Ledger::open_existing(&settings.ledger).await?;
    let mut forgotten = Ok(());
    for receiver in receivers {
        forgotten = forgotten.and(ledger.forget_receiver(*receiver).await);
    }
    ledger.close().await;
    Ok(forgotten?)
}

/// Result of one step.
pub(super) enum DeliveryStep {
    /// No event to deliver, or the receiver is not configured.
    Idle,
    /// Another node delivers.
    OfOther,
    /// Events are gathered for the next mail.
    Gathering,
    /// One event was delivered.
    Delivered,
    /// Delivery failed; with a message if a person must act.
    Failed(Option<String>),
}

/// Delivery to one receiver.
pub(super) struct ReceiverDelivery {
    settings: SharedSettings,
    pub(super) receiver: ReceiverKind,
    ledger: LedgerOnDemand,
    /// Id of the last event when there was nothing left to deliver; `None` = that is not known.
    idle_at: Option<i64>,
    /// Id of the last event that was delivered or skipped; `None` = not read from the ledger yet.
    pub(super) position: Option<i64>,
    /// The position stored in the ledger, and when it was stored.
    pub(super) recorded_position: (i64, Instant),
    /// Whether the ledger records that the receiver is not configured.
    is_forgotten: bool,
    /// When an event was delivered last; `None` = none was yet.
    pub(super) told_at: Option<Timestamp>,
    /// Events that went by mail to an address, although the position is not past them yet.
    pub(super) mailed: BTreeSet<(i64, String)>,
    /// Why the last delivery failed; "" = it did not.
    pub(super) last_error: String,
}

impl ReceiverDelivery {
    fn new(settings: SharedSettings, ledger: LedgerOnDemand, receiver: ReceiverKind) -> Self {
        let (idle_at, at, failing) = (None, None, String::new());
        Self {
            settings,
            receiver,
            ledger,
            idle_at,
            position: at,
            recorded_position: (0, Instant::now()),
            is_forgotten: false,
            told_at: None,
            mailed: BTreeSet::new(),
            last_error: failing,
        }
    }

    fn current_settings(&self) -> Arc<Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    async fn run(mut self, report_failure: &impl Fn(ReceiverKind, Option<String>)) {
        let mut wait = FIRST_WAIT;
        loop {
            let settings = self.current_settings();
            match self.deliver_next(&settings).await {
                // No event is due, or the receiver was removed from the configuration.
                Ok(DeliveryStep::Idle | DeliveryStep::Gathering) => {
                    report_failure(self.receiver, None);
                    tokio::time::sleep(self.look_every()).await;
                }
                Ok(DeliveryStep::OfOther) => {
                    report_failure(self.receiver, None);
                    tokio::time::sleep(LOOK_BESIDE_OTHER).await;
                }
                Ok(DeliveryStep::Delivered) => {
                    report_failure(self.receiver, None);
                    wait = FIRST_WAIT;
                }
                Ok(DeliveryStep::Failed(needs_person)) => {
                    report_failure(self.receiver, needs_person);
                    self.wait_before_retry(wait, &settings).await;
                    wait = (2 * wait).min(LONGEST_WAIT);
                }
                Err(failure) => {
                    // The ledger does not exist yet or is damaged; the farm reports that.
                    tracing::debug!("Nothing can be delivered to the {} now: {failure:#}.", self.receiver.noun());
                    (self.position, self.idle_at) = (None, None);
                    self.wait_before_retry(wait, &settings).await;
                    wait = (2 * wait).min(LONGEST_WAIT);
                }
            }
        }
    }

    fn look_every(&self) -> Duration {
        match self.receiver {
            ReceiverKind::Webhook | ReceiverKind::Command => LOOK_EVERY,
            _ => LOOK_FOR_MAILS,
        }
    }

    /// Waits, but ends early when the settings change.
    async fn wait_before_retry(&self, wait: Duration, before: &Arc<Settings>) {
        let until = tokio::time::Instant::now() + wait;
        while tokio::time::Instant::now() < until && Arc::ptr_eq(before, &self.current_settings()) {
            tokio::time::sleep(LOOK_EVERY.min(wait)).await;
        }
    }

    async fn deliver_next(&mut self, settings: &Settings) -> Result<DeliveryStep> {
        if !configured_receivers(&settings.interfaces.notify).contains(&self.receiver) {
            return self.forget_receiver(settings).await;
        }
        self.is_forgotten = false;
        let ledger = self.ledger.get(&settings.ledger).await?;
        let last = ledger.last_event_id().await?;
        let (recorded, recorded_at) = self.recorded_position;
        if self.idle_at == Some(last) && (recorded >= last || recorded_at.elapsed() < POSITION_WRITE_INTERVAL) {
            return Ok(DeliveryStep::Idle);
        }
        let duty = format!("messages to the {}", self.receiver);
        let lease = Duration::from_secs_f64(settings.interfaces.notify.timeout_secs) + SEND_GRACE + DUTY_GRACE;
        if !ledger.hold_duty(&duty, &settings.node.name, lease).await? {
            self.position = None;
            return Ok(DeliveryStep::OfOther);
        }
        if self.idle_at.take().is_some() && ledger.file().is_none() {
            // Another node may have delivered meanwhile.
            self.position = None;
        }
        let at = match self.position {
            Some(at) => at,
            None => {
                let row = ledger.find_or_add_receiver(self.receiver).await?;
                (self.position, self.recorded_position) = (Some(row.delivered_id), (row.delivered_id, Instant::now()));
                self.told_at = row.told_at.map(|at| at.0);
                row.delivered_id
            }
        };
        if last > at
            && let Some(event) = ledger.next_event(at, &kinds_for(self.receiver, &settings.interfaces.notify)).await?
        {
            return match (self.receiver, &settings.interfaces.notify.email) {
                (ReceiverKind::Webhook | ReceiverKind::Command, _) | (_, None) => {
                    Box::pin(self.deliver_event(settings, &ledger, &event)).await
                }
                (_, Some(email)) if self.is_gathering(email) => Ok(DeliveryStep::Gathering),
                (_, Some(email)) => Box::pin(self.deliver_mails((settings, email), &ledger, at)).await,
            };
        }
        self.position = Some(last.max(at));
        if last > self.recorded_position.0 && self.recorded_position.1.elapsed() >= POSITION_WRITE_INTERVAL {
            ledger.pass_events(self.receiver, last).await?;
            self.recorded_position = (last, Instant::now());
        }
        self.idle_at = Some(last);
        Ok(DeliveryStep::Idle)
    }

    /// The receiver is not configured. If it is configured again, it gets only events from then on.
    async fn forget_receiver(&mut self, settings: &Settings) -> Result<DeliveryStep> {
        if !self.is_forgotten {
            forget_receivers(settings, &[self.receiver]).await?;
            (self.is_forgotten, self.position, self.idle_at) = (true, None, None);
        }
        Ok(DeliveryStep::Idle)
    }

    async fn deliver_event(&mut self, settings: &Settings, ledger: &Ledger, event: &EventRow) -> Result<DeliveryStep> {
        let message = EventMessage::from_event(event, ledger).await?;
        let (notify, receiver) = (settings.interfaces.notify.clone(), self.receiver);
        let within = Duration::from_secs_f64(notify.timeout_secs) + SEND_GRACE;
        let sending = tokio::task::spawn_blocking(move || send_message(&notify, receiver, &message));
        let sent = match tokio::time::timeout(within, sending).await {
            Ok(ended) => ended.context("sending").and_then(|sent| sent),
            Err(_) => Err(anyhow::anyhow!("it did not answer in time")),
        };
        match sent {
            Ok(()) => {
                self.record_delivery(ledger, event.id).await?;
                Ok(DeliveryStep::Delivered)
            }
            Err(failure) => self.record_failure(settings, ledger, event, format!("{failure:#}")).await,
        }
    }

    pub(super) async fn record_delivery(&mut self, ledger: &Ledger, event: i64) -> Result<()> {
        ledger.mark_delivered(self.receiver, event).await?;
        (self.position, self.recorded_position) = (Some(event), (event, Instant::now()));
        if !std::mem::take(&mut self.last_error).is_empty() {
            info!("The {} accepts messages again.", self.receiver.noun());
        }
        Ok(())
    }

    pub(super) async fn record_failure(
        &mut self,
        settings: &Settings,
        ledger: &Ledger,
        event: &EventRow,
        why: String,
    ) -> Result<DeliveryStep> {
        let receiver = self.receiver;
        if why != self.last_error {
            warn!("Event {} could not be delivered to the {}; it is retried: {why}.", event.id, receiver.noun());
        }
        ledger.record_delivery_failure(receiver, &why).await?;
        let now = Timestamp::now();
        let keep =
            SignedDuration::try_from_secs_f64(settings.interfaces.notify.keep_secs).unwrap_or(SignedDuration::MAX);
        let mut message = format!("the {}: {why}", receiver.noun());
        if now.duration_since(event.at.0) > keep {
            let before = now.checked_sub(keep).unwrap_or(Timestamp::UNIX_EPOCH);
            let dropped =
                ledger.drop_undelivered(receiver, before, &kinds_for(receiver, &settings.interfaces.notify)).await?;
            let noun = receiver.noun();
            warn!("{dropped} messages to the {noun} were dropped: they are older than notify.keep_secs.");
            message += &format!("; {dropped} messages were dropped");
            self.position = None;
        }
        let row = ledger.find_or_add_receiver(receiver).await?;
        let is_long = row.failing_at.is_some_and(|since| now.duration_since(since.0) >= ALERT_AFTER);
        self.last_error = why;
        Ok(DeliveryStep::Failed(is_long.then_some(message)))
    }
}
