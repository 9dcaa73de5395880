//! Work that would hold up the event loop (reading, nesting, proving, copying) runs on threads of its own. A kind of job says
//! how its end is taken in by the owner of the loop, also when it panicked or got no thread.

use std::{
    any::Any,
    collections::HashSet,
    fmt,
    panic::{AssertUnwindSafe, catch_unwind},
    pin::Pin,
    thread,
};

use anyhow::Result;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tracing::warn;

/// A kind of work off the event loop of `O`: what it is about, and what follows when it ends.
pub trait Job<O>: Clone + Send + 'static {
    /// Its name in logs and of its threads.
    const KIND: &'static str;
    /// What comes of the work.
    type Outcome: Send + 'static;

    /// What this one is about; only one job of a kind and a subject runs at a time.
    fn about(&self) -> String;

    /// Takes in what came of the work.
    async fn done(self, owner: &mut O, outcome: Self::Outcome) -> Result<()>;

    /// The work panicked.
    async fn panicked(self, _owner: &mut O, _message: &str) -> Result<()> {
        Ok(())
    }

    /// There was no thread for the work: nothing was done, and its step finds it again.
    fn not_started(self, _owner: &mut O, _why: &str) {}
}

/// A kind of job and what it is about.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct JobKey {
    kind: &'static str,
    about: String,
}

impl fmt::Display for JobKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.about.as_str() {
            "" => f.write_str(self.kind),
            about => write!(f, "{}({about})", self.kind),
        }
    }
}

/// What the owner of the loop does to take in an event.
type Taking<'a> = Pin<Box<dyn Future<Output = Result<()>> + 'a>>;
type Take<O> = Box<dyn for<'a> FnOnce(&'a mut O) -> Taking<'a> + Send>;

/// What the event loop of `O` hears: a job has ended, or something else has happened.
pub struct Event<O> {
    job: Option<JobKey>,
    take: Take<O>,
}

impl<O: 'static> Event<O> {
    /// Something has happened that is no job.
    pub fn new(take: impl FnOnce(&mut O) + Send + 'static) -> Self {
        let take = taking(move |owner: &mut O| {
            take(owner);
            Box::pin(async { Ok(()) })
        });
        Self { job: None, take }
    }

    /// Whether a job of a kind has ended.
    pub fn is_of<J: Job<O>>(&self) -> bool {
        self.job.as_ref().is_some_and(|key| key.kind == J::KIND)
    }

    /// Takes it in.
    pub async fn take_in(self, owner: &mut O) -> Result<()> {
        (self.take)(owner).await
    }
}

/// How the work of a job has ended.
enum End<T> {
    Done(T),
    Panicked(String),
    NotStarted(String),
}

/// Lets the compiler know that the future borrows the owner.
fn taking<O, F>(take: F) -> Take<O>
where
    F: for<'a> FnOnce(&'a mut O) -> Taking<'a> + Send + 'static,
{
    Box::new(take)
}

fn ended<O: 'static, J: Job<O>>(key: JobKey, job: J, end: End<J::Outcome>) -> Event<O> {
    let told = key.clone();
    let take = taking(move |owner: &mut O| {
        Box::pin(async move {
            match end {
                End::Done(outcome) => job.done(owner, outcome).await,
                End::Panicked(message) => {
                    warn!("A job panicked ({told}): {message}.");
                    job.panicked(owner, &message).await
                }
                End::NotStarted(why) => {
                    warn!("A job could not be started ({told}): {why}.");
                    job.not_started(owner, &why);
                    Ok(())
                }
            }
        })
    });
    Event { job: Some(key), take }
}

/// Jobs that run now, and the events that wait to be taken in.
pub struct Jobs<O> {
    running: HashSet<JobKey>,
    sender: UnboundedSender<Event<O>>,
    events: UnboundedReceiver<Event<O>>,
}

impl<O> Default for Jobs<O> {
    fn default() -> Self {
        let (sender, events) = unbounded_channel();
        Self { running: HashSet::new(), sender, events }
    }
}

impl<O: 'static> Jobs<O> {
    /// Where events go.
    pub fn sender(&self) -> UnboundedSender<Event<O>> {
        self.sender.clone()
    }

    /// The next event; a job that it tells of does not run any more. Nothing is lost when this is not waited for.
    pub async fn next(&mut self) -> Option<Event<O>> {
        let event = self.events.recv().await;
        self.has_ended(event)
    }

    /// As [`Jobs::next`], without waiting.
    pub fn next_now(&mut self) -> Option<Event<O>> {
        let event = self.events.try_recv().ok();
        self.has_ended(event)
    }

    fn has_ended(&mut self, event: Option<Event<O>>) -> Option<Event<O>> {
        if let Some(Event { job: Some(key), .. }) = &event {
            self.running.remove(key);
        }
        event
    }

    /// Whether a job of this kind and subject runs.
    pub fn runs<J: Job<O>>(&self, about: impl fmt::Display) -> bool {
        self.running.contains(&JobKey { kind: J::KIND, about: about.to_string() })
    }

    /// What the running jobs of a kind are about.
    pub fn running<J: Job<O>>(&self) -> impl Iterator<Item = &str> {
        self.running.iter().filter(|key| key.kind == J::KIND).map(|key| key.about.as_str())
    }

    /// Whether nothing runs.
    pub fn is_idle(&self) -> bool {
        self.running.is_empty()
    }

    /// Starts `work` on a thread of its own unless a job of this kind and subject runs.
    pub fn start<J: Job<O>>(&mut self, job: J, work: impl FnOnce() -> J::Outcome + Send + 'static) {
        let key = JobKey { kind: J::KIND, about: job.about() };
        if !self.running.insert(key.clone()) {
            return;
        }
        let sender = self.sender.clone();
        let name = key.to_string().chars().take(15).collect();
        let spawned = thread::Builder::new().name(name).spawn({
            let (key, job) = (key.clone(), job.clone());
            move || {
                let end = catch_unwind(AssertUnwindSafe(work))
                    .map_or_else(|panic| End::Panicked(panic_message(&*panic)), End::Done);
                // The loop may have ended; then nobody needs the event, since every step finds its work again.
                let _ = sender.send(ended(key, job, end));
            }
        });
        if let Err(error) = spawned {
            let _ = self.sender.send(ended(key, job, End::NotStarted(format!("no thread: {error}"))));
        }
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panicked".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone)]
    struct Add(u32);

    impl Job<Vec<String>> for Add {
        const KIND: &'static str = "Add";
        type Outcome = u32;

        fn about(&self) -> String {
            self.0.to_string()
        }

        async fn done(self, owner: &mut Vec<String>, outcome: u32) -> Result<()> {
            owner.push(format!("{} gave {outcome}", self.0));
            Ok(())
        }

        async fn panicked(self, owner: &mut Vec<String>, message: &str) -> Result<()> {
            owner.push(format!("{} panicked: {message}", self.0));
            Ok(())
        }
    }

    #[tokio::test]
    async fn a_job_of_a_subject_runs_once_at_a_time_and_its_end_is_taken_in_even_after_a_panic() {
        let (mut jobs, mut owner) = (Jobs::default(), Vec::new());
        let (go, wait) = std::sync::mpsc::channel::<()>();
        jobs.start(Add(1), move || wait.recv().map_or(0, |()| 7));
        jobs.start(Add(1), || 8);
        assert!(jobs.runs::<Add>(1) && !jobs.runs::<Add>(2) && jobs.running::<Add>().count() == 1);
        go.send(()).unwrap();
        jobs.start(Add(2), || panic!("no sum"));
        for _ in 0..2 {
            let event = jobs.next().await.unwrap();
            assert!(event.is_of::<Add>());
            event.take_in(&mut owner).await.unwrap();
        }
        owner.sort();
        assert_eq!(owner, ["1 gave 7", "2 panicked: no sum"]);
        assert!(jobs.is_idle() && jobs.next_now().is_none());
    }
}
