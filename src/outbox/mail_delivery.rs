//! Delivery of mails: the events that wait are gathered, and each recipient gets one mail about them. The position of the receiver follows
//! mail by mail, so that a restart repeats no more than the one that was under way.

use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};
use jiff::{SignedDuration, Timestamp};
use ledger::{EventRow, Ledger, ReceiverKind};
use settings::{EmailSettings, Settings};
use tracing::warn;

use super::{
    delivery::{DeliveryStep, ReceiverDelivery, SEND_GRACE},
    email::{MailError, send_mail},
    mail::{Mail, compose_mails},
    send::kinds_for,
};

/// Most events that one mail tells.
const MAX_GATHERED: u32 = 200;

impl ReceiverDelivery {
    /// Whether a mail was sent so recently that the next one waits. What could not be delivered does not wait.
    pub(super) fn is_gathering(&self, email: &EmailSettings) -> bool {
        let gather = SignedDuration::try_from_secs_f64(email.gather_secs).unwrap_or(SignedDuration::MAX);
        let elapsed = self.told_at.map(|at| Timestamp::now().duration_since(at));
        // A clock that was put back holds nothing up.
        self.last_error.is_empty() && elapsed.is_some_and(|elapsed| !elapsed.is_negative() && elapsed < gather)
    }

    /// Delivers the events after `at` in one mail for each recipient.
    pub(super) async fn deliver_mails(
        &mut self,
        (settings, email): (&Settings, &EmailSettings),
        ledger: &Ledger,
        at: i64,
    ) -> Result<DeliveryStep> {
        let kinds = kinds_for(self.receiver, &settings.interfaces.notify);
        let events = ledger.events_after(at, &kinds, MAX_GATHERED).await?;
        let Some(last) = events.last() else { return Ok(DeliveryStep::Idle) };
        let mails = compose_mails((email, settings.language), self.receiver, &events, ledger, &self.mailed).await?;
        for (index, mail) in mails.iter().enumerate() {
            if let Err(failure) = self.deliver_mail((settings, email), ledger, mail).await? {
                let first = events.iter().find(|event| mail.events.contains(&event.id)).unwrap_or(last);
                return self.record_failure(settings, ledger, first, failure.to_string()).await;
            }
            self.mailed.extend(mail.events.iter().flat_map(|event| mail.to.iter().map(|to| (*event, to.clone()))));
            let next = mails[index + 1..].iter().flat_map(|mail| mail.events.iter().copied()).min();
            self.record_delivery(ledger, last_before(&events, next, at)).await?;
        }
        if mails.is_empty() {
            ledger.pass_events(self.receiver, last.id).await?;
            (self.position, self.recorded_position) = (Some(last.id), (last.id, Instant::now()));
            return Ok(DeliveryStep::Delivered);
        }
        self.mailed.clear();
        self.told_at = Some(Timestamp::now());
        Ok(DeliveryStep::Delivered)
    }

    /// Sends one mail. A customer whom the server refuses for ever holds up nobody else: that is told, and counts as delivered.
    async fn deliver_mail(
        &self,
        (settings, email): (&Settings, &EmailSettings),
        ledger: &Ledger,
        mail: &Mail,
    ) -> Result<Result<(), MailError>> {
        let timeout = Duration::from_secs_f64(settings.interfaces.notify.timeout_secs);
        let (sent_email, sent_mail) = (email.clone(), mail.clone());
        let sending = tokio::task::spawn_blocking(move || send_mail(&sent_email, timeout, &sent_mail));
        let sent = match tokio::time::timeout(timeout + SEND_GRACE, sending).await {
            Ok(Ok(sent)) => sent,
            Ok(Err(failure)) => Err(MailError::Failed(failure.into())),
            Err(_) => Err(MailError::Failed(anyhow!("it did not answer in time"))),
        };
        match sent {
            Err(MailError::NoRecipient(why)) if self.receiver == ReceiverKind::EmailOrderComplete => {
                warn!("A customer gets no mail: {why}.");
                for event in &mail.events {
                    ledger.record_refused_delivery(self.receiver, *event, &why).await?;
                }
                Ok(Ok(()))
            }
            other => Ok(other),
        }
    }
}

/// The last of these events before `next`, the first that is not delivered yet; `at` if there is none.
fn last_before(events: &[EventRow], next: Option<i64>, at: i64) -> i64 {
    let done = events.iter().map(|event| event.id).take_while(|id| next.is_none_or(|next| *id < next));
    done.last().unwrap_or(at)
}
