//! Starts jobs, and hands their ends to the event loop.

use std::{
    any::Any,
    collections::HashMap,
    fmt,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::mpsc,
    thread,
};

use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::{
    BackgroundJob, Carried, LoopEvent,
    loop_event::{JobEnd, JobKey},
};

/// The running jobs, and the events that wait to be taken in.
pub struct JobRunner<O> {
    /// Each with whether it only looks.
    running: HashMap<JobKey, bool>,
    sender: UnboundedSender<LoopEvent<O>>,
    events: UnboundedReceiver<LoopEvent<O>>,
}

impl<O> Default for JobRunner<O> {
    fn default() -> Self {
        let (sender, events) = unbounded_channel();
        Self { running: HashMap::new(), sender, events }
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
        if let Some(key) = event.as_ref().and_then(LoopEvent::ended_job) {
            self.running.remove(key);
        }
        event
    }

    /// Whether a job of this kind and subject is running.
    pub fn is_running<J: BackgroundJob<O>>(&self, about: impl fmt::Display) -> bool {
        self.running.contains_key(&JobKey { kind: J::KIND, subject: about.to_string() })
    }

    /// The subjects of the running jobs of a kind.
    pub fn running_subjects<J: BackgroundJob<O>>(&self) -> impl Iterator<Item = &str> {
        self.running.keys().filter(|key| key.kind == J::KIND).map(|key| key.subject.as_str())
    }

    /// Whether no job is running for whose end anything waits.
    pub fn only_looks(&self) -> bool {
        self.running.values().all(|&is_look| is_look)
    }

    /// The running jobs by name, separated by commas.
    pub fn running_names(&self) -> String {
        let mut names: Vec<String> = self.running.keys().map(JobKey::to_string).collect();
        names.sort_unstable();
        names.join(", ")
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
        if self.running.insert(key.clone(), J::IS_LOOK).is_some() {
            let _ = sender.send(LoopEvent::new(|owner: &mut O| carried.give_back(owner.into())));
            return;
        }
        let name = key.to_string().chars().take(15).collect();
        let (hand_over, handed_over) = mpsc::channel::<C>();
        let spawned = thread::Builder::new().name(name).spawn({
            let (key, job, sender) = (key.clone(), job.clone(), sender.clone());
            move || {
                let Ok(mut carried) = handed_over.recv() else { return };
                let end = catch_unwind(AssertUnwindSafe(|| work(&mut carried)))
                    .map_or_else(|panic| JobEnd::Panicked(panic_message(&*panic)), JobEnd::Completed);
                let _ = sender.send(LoopEvent::end_of(key, job, carried, end));
            }
        });
        match spawned {
            Ok(_) => drop(hand_over.send(carried)),
            Err(error) => {
                let end = JobEnd::NotStarted(format!("no thread: {error}"));
                let _ = sender.send(LoopEvent::end_of(key, job, carried, end));
            }
        }
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panicked".to_owned())
}
