//! What a kind of job must say of itself.

use anyhow::Result;

/// A kind of work outside the event loop of `O`: its subject, and what happens when it ends.
pub trait BackgroundJob<O: 'static>: Clone + Send + 'static {
    /// Name in logs and of its threads.
    const KIND: &'static str;
    /// Whether it only looks, now and then, whether there is anything to do: while it runs, nobody waits for its end.
    const IS_LOOK: bool = false;
    /// Result of the work.
    type Outcome: Send + 'static;
    /// What its end may touch of the owner; `&'a mut O` = all of it.
    type Desk<'a>: From<&'a mut O>;

    /// The subject of this job; only one job of a kind and subject runs at a time.
    fn subject(&self) -> String;

    /// Takes in the result.
    ///
    /// # Errors
    /// What the owner of the loop must hear of.
    fn on_done(self, desk: Self::Desk<'_>, outcome: Self::Outcome) -> impl Future<Output = Result<()>>;

    /// The work panicked.
    ///
    /// # Errors
    /// What the owner of the loop must hear of.
    fn on_panic(self, _desk: Self::Desk<'_>, _message: &str) -> impl Future<Output = Result<()>> {
        async { Ok(()) }
    }

    /// The thread could not be started: nothing was done, and whoever started the job will find the work again.
    fn on_not_started(self, _desk: Self::Desk<'_>, _why: &str) {}
}

/// What a job has of the loop's owner while it runs: a thing, or a mark that something is under way.
pub trait Carried<O: 'static>: Send + 'static {
    /// What it touches of the owner when it comes back.
    type Desk<'a>: From<&'a mut O>;

    /// Puts it back, before anything else is done with the end of the job: whether that is done, panicked or was not
    /// started.
    fn give_back(self, desk: Self::Desk<'_>);
}

/// Nothing.
impl<O: 'static> Carried<O> for () {
    type Desk<'a> = &'a mut O;

    fn give_back(self, _owner: Self::Desk<'_>) {}
}
