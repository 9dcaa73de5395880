//! Runs a task on a thread of its own, without the interpreter's lock. The calling thread waits for it, hands on what
//! it reports, and looks for Ctrl-C meanwhile.

use std::{
    any::Any,
    sync::mpsc::{self, RecvTimeoutError, Sender},
    thread::{self, JoinHandle},
    time::Duration,
};

use pyo3::{exceptions::PyRuntimeError, prelude::*};

/// Longest time until a signal is seen.
const SIGNAL_POLL: Duration = Duration::from_millis(20);
/// Stack of the thread, as large as that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// What the thread of a task sends.
enum TaskMessage<N, T> {
    Report(N),
    Done(T),
}

/// Passes reports of a task on to the thread that waits for it.
pub(crate) struct TaskReporter<N, T>(Sender<TaskMessage<N, T>>);

impl<N, T> TaskReporter<N, T> {
    /// Sends a report. Nobody may be there any more to read it: then it is dropped.
    pub(crate) fn report(&self, report: N) {
        let _ = self.0.send(TaskMessage::Report(report));
    }
}

/// Runs a task and returns its result. `on_report` is called in the calling thread, with the interpreter's lock.
///
/// # Errors
/// A signal handler has raised (`KeyboardInterrupt`), `on_report` has failed, or the task has panicked. In the first
/// two cases the task still runs: the caller has to end it, and its result is dropped.
pub(crate) fn run_reporting<N: Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    task: impl FnOnce(&TaskReporter<N, T>) -> T + Send + 'static,
    mut on_report: impl FnMut(N) -> PyResult<()>,
) -> PyResult<T> {
    let (sender, mut receiver) = mpsc::channel();
    let work = move || {
        let reporter = TaskReporter(sender);
        let done = task(&reporter);
        let _ = reporter.0.send(TaskMessage::Done(done));
    };
    let thread = thread::Builder::new().name("nestd-nester".to_owned()).stack_size(STACK_BYTES).spawn(work)?;
    loop {
        let inbox = &mut receiver;
        match py.detach(move || inbox.recv_timeout(SIGNAL_POLL)) {
            Ok(TaskMessage::Report(report)) => on_report(report)?,
            Ok(TaskMessage::Done(done)) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(panic_error(py, thread)),
        }
        py.check_signals()?;
    }
}

/// Like [`run_reporting`], for a task without reports that may fail.
pub(crate) fn run_beside<T: Send + 'static>(
    py: Python<'_>,
    task: impl FnOnce() -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    run_reporting(py, |_: &TaskReporter<(), _>| task(), |()| Ok(()))?
}

/// The exception for a thread that has panicked.
fn panic_error(py: Python<'_>, thread: JoinHandle<()>) -> PyErr {
    let payload = py.detach(|| thread.join().err());
    let text = payload.as_deref().map_or("no reason is known", panic_text);
    PyRuntimeError::new_err(format!("the native code of nestd-nester has failed: {text}. This is a defect: report it."))
}

fn panic_text(payload: &(dyn Any + Send)) -> &str {
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    owned.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no reason is known")
}
