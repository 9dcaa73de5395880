//! What a kind of job must say of itself.

use anyhow::Result;

/// A kind of work outside the event loop of `O`: its subject, and what happens when it ends.
pub trait BackgroundJob<O>: Clone + Send + 'static {
    /// Name in logs and of its threads.
    const KIND: &'static str;
    /// Result of the work.
    type Outcome: Send + 'static;

    /// The subject of this job; only one job of a kind and subject runs at a time.
    fn subject(&self) -> String;

    /// Takes in the result.
    ///
    /// # Errors
    /// What the owner of the loop must hear of.
    fn on_done(self, owner: &mut O, outcome: Self::Outcome) -> impl Future<Output = Result<()>>;

    /// The work panicked.
    ///
    /// # Errors
    /// What the owner of the loop must hear of.
    fn on_panic(self, _owner: &mut O, _message: &str) -> impl Future<Output = Result<()>> {
        async { Ok(()) }
    }

    /// The thread could not be started: nothing was done, and whoever started the job will find the work again.
    fn on_not_started(self, _owner: &mut O, _why: &str) {}
}

/// What a job has of the loop's owner while it runs: a thing, or a mark that something is under way.
pub trait Carried<O>: Send + 'static {
    /// Puts it back, before anything else is done with the end of the job: whether that is done, panicked or was not
    /// started.
    fn give_back(self, owner: &mut O);
}

/// Nothing.
impl<O> Carried<O> for () {
    fn give_back(self, _owner: &mut O) {}
}
