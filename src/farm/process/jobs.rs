//! Work that would block the event loop (reading, nesting, proving, copying) runs on threads of its own. Each kind of
//! job defines how the owner of the loop takes in its result, including a panic or a thread that could not be started.
//! What a job has of its owner meanwhile is back before anything else is done with its end, so that no error loses it.

use std::{
    any::Any,
    collections::HashSet,
    fmt,
    panic::{AssertUnwindSafe, catch_unwind},
    pin::Pin,
    sync::mpsc,
    thread,
};

use anyhow::Result;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tracing::warn;

/// A kind of work outside the event loop of `O`: its subject, and what happens when it ends.
pub trait BackgroundJob<O>: Clone + Send + 'static {
    /// Name in logs and of its threads.
    const KIND: &'static str;
    /// Result of the work.
    type Outcome: Send + 'static;

    /// The subject of this job; only one job of a kind and subject runs at a time.
    fn subject(&self) -> String;

    /// Takes in the result.
    async fn on_done(self, owner: &mut O, outcome: Self::Outcome) -> Result<()>;

    /// The work panicked.
    async fn on_panic(self, _owner: &mut O, _message: &str) -> Result<()> {
        Ok(())
    }

    /// The thread could not be started: nothing was done, and the step will find the work again.
    fn on_not_started(self, _owner: &mut O, _why: &str) {}
}

/// What a job has of its owner while it runs: a thing, or a mark that something is under way.
pub trait Carried<O>: Send + 'static {
    /// Puts it back, before anything else is done with the end of the job: whether that is done, panicked or was not
    /// started.
    fn give_back(self, owner: &mut O);
}

/// Nothing.
impl<O> Carried<O> for () {
    fn give_back(self, _owner: &mut O) {}
}

/// Kind and subject of a job.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct JobKey {
    kind: &'static str,
    subject: String,
}

impl fmt::Display for JobKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.subject.as_str() {
            "" => f.write_str(self.kind),
            about => write!(f, "{}({about})", self.kind),
        }
    }
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

    /// Whether this is the end of a job of a given kind.
    pub fn is_end_of<J: BackgroundJob<O>>(&self) -> bool {
        self.job.as_ref().is_some_and(|key| key.kind == J::KIND)
    }

    /// Takes in the event.
    pub async fn apply_to(self, owner: &mut O) -> Result<()> {
        (self.handler)(owner).await
    }
}

/// How a job has ended.
enum JobResult<T> {
    Completed(T),
    Panicked(String),
    NotStarted(String),
}

/// Tells the compiler that the future borrows the owner.
fn box_handler<O, F>(take: F) -> EventHandler<O>
where
    F: for<'a> FnOnce(&'a mut O) -> EventFuture<'a> + Send + 'static,
{
    Box::new(take)
}

fn job_end_event<O: 'static, J: BackgroundJob<O>>(
    key: JobKey,
    job: J,
    carried: impl Carried<O>,
    end: JobResult<J::Outcome>,
) -> LoopEvent<O> {
    let name = key.clone();
    let take = box_handler(move |owner: &mut O| {
        carried.give_back(owner);
        Box::pin(async move {
            match end {
                JobResult::Completed(outcome) => job.on_done(owner, outcome).await,
                JobResult::Panicked(message) => {
                    warn!("A job panicked ({name}): {message}.");
                    job.on_panic(owner, &message).await
                }
                JobResult::NotStarted(why) => {
                    warn!("A job could not be started ({name}): {why}.");
                    job.on_not_started(owner, &why);
                    Ok(())
                }
            }
        })
    });
    LoopEvent { job: Some(key), handler: take }
}

/// The running jobs, and the events that wait to be taken in.
pub struct JobRunner<O> {
    running: HashSet<JobKey>,
    sender: UnboundedSender<LoopEvent<O>>,
    events: UnboundedReceiver<LoopEvent<O>>,
}

impl<O> Default for JobRunner<O> {
    fn default() -> Self {
        let (sender, events) = unbounded_channel();
        Self { running: HashSet::new(), sender, events }
    }
}

impl<O: 'static> JobRunner<O> {
    /// The sender of events.
    pub fn event_sender(&self) -> UnboundedSender<LoopEvent<O>> {
        self.sender.clone()
    }

    /// The next event; its job no longer counts as running. Cancel safe: dropping the future loses no event.
    pub async fn next_event(&mut self) -> Option<LoopEvent<O>> {
        let event = self.events.recv().await;
        self.remove_ended_job(event)
    }

    /// Same as [`JobRunner::next_event`], without waiting.
    pub fn try_next_event(&mut self) -> Option<LoopEvent<O>> {
        let event = self.events.try_recv().ok();
        self.remove_ended_job(event)
    }

    fn remove_ended_job(&mut self, event: Option<LoopEvent<O>>) -> Option<LoopEvent<O>> {
        if let Some(LoopEvent { job: Some(key), .. }) = &event {
            self.running.remove(key);
        }
        event
    }

    /// Whether a job of this kind and subject is running.
    pub fn is_running<J: BackgroundJob<O>>(&self, about: impl fmt::Display) -> bool {
        self.running.contains(&JobKey { kind: J::KIND, subject: about.to_string() })
    }

    /// The subjects of the running jobs of a kind.
    pub fn running_subjects<J: BackgroundJob<O>>(&self) -> impl Iterator<Item = &str> {
        self.running.iter().filter(|key| key.kind == J::KIND).map(|key| key.subject.as_str())
    }

    /// Whether no job but those of one kind is running.
    pub fn runs_only<J: BackgroundJob<O>>(&self) -> bool {
        self.running.iter().all(|key| key.kind == J::KIND)
    }

    /// Whether no job is running.
    pub fn is_idle(&self) -> bool {
        self.running.is_empty()
    }

    /// Starts `work` on its own thread, unless a job of this kind and subject is running.
    pub fn start<J: BackgroundJob<O>>(&mut self, job: J, work: impl FnOnce() -> J::Outcome + Send + 'static) {
        if !self.is_running::<J>(job.subject()) {
            self.start_with(job, (), |()| work());
        }
    }

    /// Same as [`JobRunner::start`], with what the work has of the owner.
    pub fn start_with<J: BackgroundJob<O>, C: Carried<O>>(
        &mut self,
        job: J,
        carried: C,
        work: impl FnOnce(&mut C) -> J::Outcome + Send + 'static,
    ) {
        let key = JobKey { kind: J::KIND, subject: job.subject() };
        // If the loop has ended, nobody needs an event: every step finds its work again.
        let sender = self.sender.clone();
        if !self.running.insert(key.clone()) {
            let _ = sender.send(LoopEvent::new(|owner| carried.give_back(owner)));
            return;
        }
        let name = key.to_string().chars().take(15).collect();
        let (hand_over, handed_over) = mpsc::channel::<C>();
        let spawned = thread::Builder::new().name(name).spawn({
            let (key, job, sender) = (key.clone(), job.clone(), sender.clone());
            move || {
                let Ok(mut carried) = handed_over.recv() else { return };
                let end = catch_unwind(AssertUnwindSafe(|| work(&mut carried)))
                    .map_or_else(|panic| JobResult::Panicked(panic_message(&*panic)), JobResult::Completed);
                let _ = sender.send(job_end_event(key, job, carried, end));
            }
        });
        match spawned {
            Ok(_) => drop(hand_over.send(carried)),
            Err(error) => {
                let end = JobResult::NotStarted(format!("no thread: {error}"));
                let _ = sender.send(job_end_event(key, job, carried, end));
            }
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

    impl BackgroundJob<Vec<String>> for Add {
        const KIND: &'static str = "Add";
        type Outcome = u32;

        fn subject(&self) -> String {
            self.0.to_string()
        }

        async fn on_done(self, owner: &mut Vec<String>, outcome: u32) -> Result<()> {
            owner.push(format!("{} gave {outcome}", self.0));
            Ok(())
        }

        async fn on_panic(self, owner: &mut Vec<String>, message: &str) -> Result<()> {
            owner.push(format!("{} panicked: {message}", self.0));
            anyhow::bail!("it cannot be taken in")
        }
    }

    /// A text that a job has while it runs.
    struct Text(String);

    impl Carried<Vec<String>> for Text {
        fn give_back(self, owner: &mut Vec<String>) {
            owner.push(self.0);
        }
    }

    #[tokio::test]
    async fn what_a_job_has_of_its_owner_is_back_before_its_end_is_taken_in_also_after_a_panic_or_twice() {
        let (mut jobs, mut owner) = (JobRunner::default(), Vec::new());
        let (go, wait) = std::sync::mpsc::channel::<()>();
        jobs.start_with(Add(1), Text("a".to_owned()), move |text| {
            text.0 += "b";
            wait.recv().unwrap();
            panic!("no sum")
        });
        jobs.start_with(Add(1), Text("of one that runs already".to_owned()), |_| 8);
        jobs.next_event().await.unwrap().apply_to(&mut owner).await.unwrap();
        go.send(()).unwrap();
        jobs.next_event().await.unwrap().apply_to(&mut owner).await.unwrap_err();
        assert_eq!(owner, ["of one that runs already", "ab", "1 panicked: no sum"]);
    }

    #[tokio::test]
    async fn a_job_of_a_subject_runs_once_at_a_time_and_its_end_is_taken_in_even_after_a_panic() {
        let (mut jobs, mut owner) = (JobRunner::default(), Vec::new());
        let (go, wait) = std::sync::mpsc::channel::<()>();
        jobs.start(Add(1), move || wait.recv().map_or(0, |()| 7));
        jobs.start(Add(1), || 8);
        assert!(jobs.is_running::<Add>(1) && !jobs.is_running::<Add>(2) && jobs.running_subjects::<Add>().count() == 1);
        go.send(()).unwrap();
        jobs.start(Add(2), || panic!("no sum"));
        for _ in 0..2 {
            let event = jobs.next_event().await.unwrap();
            assert!(event.is_end_of::<Add>());
            let _ = event.apply_to(&mut owner).await;
        }
        owner.sort();
        assert_eq!(owner, ["1 gave 7", "2 panicked: no sum"]);
        assert!(jobs.is_idle() && jobs.try_next_event().is_none());
    }
}
