//! What the event loop takes in: the end of a job, or something else that has happened.

use std::{fmt, pin::Pin};

use anyhow::Result;
use tracing::warn;

use crate::{BackgroundJob, Carried};

/// Kind and subject of a job.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct JobKey {
    pub(crate) kind: &'static str,
    pub(crate) subject: String,
}

impl fmt::Display for JobKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.subject.as_str() {
            "" => f.write_str(self.kind),
            about => write!(f, "{}({about})", self.kind),
        }
    }
}

/// How a job has ended.
pub(crate) enum JobEnd<T> {
    Completed(T),
    Panicked(String),
    NotStarted(String),
}

/// Future in which the owner of the loop takes in an event.
type EventFuture<'a> = Pin<Box<dyn Future<Output = Result<()>> + 'a>>;
type EventHandler<O> = Box<dyn for<'a> FnOnce(&'a mut O) -> EventFuture<'a> + Send>;

/// An event for the event loop of `O`: a job has ended, or something else has happened.
pub struct LoopEvent<O> {
    job: Option<JobKey>,
    handler: EventHandler<O>,
}

impl<O: 'static> LoopEvent<O> {
    /// An event that is not the end of a job.
    pub fn new(take: impl FnOnce(&mut O) + Send + 'static) -> Self {
        let take = box_handler(move |owner: &mut O| {
            take(owner);
            Box::pin(async { Ok(()) })
        });
        Self { job: None, handler: take }
    }

    /// The end of a job. What it has of the owner is back before anything else is done, so that no error loses it.
    pub(crate) fn end_of<J: BackgroundJob<O>>(
        key: JobKey,
        job: J,
        carried: impl Carried<O>,
        end: JobEnd<J::Outcome>,
    ) -> Self {
        let name = key.clone();
        let take = box_handler(move |owner: &mut O| {
            carried.give_back((&mut *owner).into());
            Box::pin(async move {
                match end {
                    JobEnd::Completed(outcome) => job.on_done(owner.into(), outcome).await,
                    JobEnd::Panicked(message) => {
                        warn!("A job panicked ({name}): {message}.");
                        job.on_panic(owner.into(), &message).await
                    }
                    JobEnd::NotStarted(why) => {
                        warn!("A job could not be started ({name}): {why}.");
                        job.on_not_started(owner.into(), &why);
                        Ok(())
                    }
                }
            })
        });
        Self { job: Some(key), handler: take }
    }

    /// Whether this is the end of a job of a given kind.
    pub fn is_end_of<J: BackgroundJob<O>>(&self) -> bool {
        self.job.as_ref().is_some_and(|key| key.kind == J::KIND)
    }

    /// The job of which this is the end.
    pub(crate) fn ended_job(&self) -> Option<&JobKey> {
        self.job.as_ref()
    }

    /// Takes in the event.
    ///
    /// # Errors
    /// What the job's own way of taking in its end returns.
    pub async fn apply_to(self, owner: &mut O) -> Result<()> {
        (self.handler)(owner).await
    }
}

/// Tells the compiler that the future borrows the owner.
fn box_handler<O, F>(take: F) -> EventHandler<O>
where
    F: for<'a> FnOnce(&'a mut O) -> EventFuture<'a> + Send + 'static,
{
    Box::new(take)
}
