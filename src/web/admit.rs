//! How many may be connected to the dashboard at once, and for how long without a word. The daemon's open files are the
//! farm's first: whoever connects and says nothing takes a few of them for a few seconds, and the others wait in the kernel's
//! backlog meanwhile.

use std::{
    io,
    pin::Pin,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    task::{Context, Poll, ready},
    time::Duration,
};

use axum::{
    body::{Body, to_bytes},
    extract::{ConnectInfo, Request, connect_info::Connected},
    http::{Method, StatusCode},
    middleware::Next,
    response::{IntoResponse, Response},
    serve::{IncomingStream, Listener},
};
use rustix::process::{Resource, getrlimit};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    sync::{OwnedSemaphorePermit, Semaphore},
    time::{Instant, Sleep, sleep},
};

use super::problem::Problem;

/// Largest form, bytes.
pub(super) const MOST_BODY: usize = 4096;

/// So many are connected at once at most,
const MOST: u64 = 128;
/// and with no more than one of so many of the daemon's open files.
const SHARE: u64 = 4;
/// A browser makes up to six at once.
const LEAST: u64 = 8;

/// How long a connection stays open without progress. Where others wait for its place, it is a third of that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    /// From the first byte of a request (for the first one: from connecting) to its last.
    pub(super) request: Duration,
    /// From one piece of an answer to the next, or to the next request. A stream of changes says something every 15 s.
    pub(super) idle: Duration,
}

impl Patience {
    pub(super) const USUAL: Self = Self { request: Duration::from_secs(10), idle: Duration::from_secs(60) };
}

/// A listener that admits so many at once.
#[derive(Debug)]
pub(super) struct Admitting<L> {
    listener: L,
    places: Arc<Semaphore>,
    patience: Patience,
}

impl<L> Admitting<L> {
    /// As many as the daemon's open files allow.
    pub(super) fn usual(listener: L) -> Self {
        let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
        Self::new(listener, (files / SHARE).clamp(LEAST, MOST) as usize, Patience::USUAL)
    }

    pub(super) fn new(listener: L, most: usize, patience: Patience) -> Self {
        Self { listener, places: Arc::new(Semaphore::new(most)), patience }
    }
}

impl<L: Listener> Listener for Admitting<L> {
    type Io = Visit<L::Io>;
    type Addr = L::Addr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        let place = self.places.clone().acquire_owned().await.expect("the semaphore is never closed");
        let (stream, address) = self.listener.accept().await;
        let mut visit = Visit {
            stream,
            deadline: Box::pin(sleep(self.patience.request)),
            patience: self.patience,
            is_asking: true,
            answering: Answering::default(),
            places: self.places.clone(),
            _place: place,
        };
        visit.wait(self.patience.request);
        (visit, address)
    }

    fn local_addr(&self) -> io::Result<Self::Addr> {
        self.listener.local_addr()
    }
}

/// Whether a request of a connection is whole and being answered: then it is for us to go on, however long it takes.
#[derive(Debug, Clone, Default)]
pub(super) struct Answering(Arc<AtomicBool>);

impl<L: Listener> Connected<IncomingStream<'_, Admitting<L>>> for Answering {
    fn connect_info(stream: IncomingStream<'_, Admitting<L>>) -> Self {
        stream.io().answering.clone()
    }
}

/// Until it is dropped, a request is being answered.
struct AtWork(Answering);

impl AtWork {
    fn on(answering: Answering) -> Self {
        answering.0.store(true, Ordering::Relaxed);
        Self(answering)
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        self.0.0.store(false, Ordering::Relaxed);
    }
}

/// Takes a request in as a whole while its connection's patience runs, then answers it without.
pub(super) async fn answer(mut request: Request, next: Next) -> Response {
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        let (head, body) = request.into_parts();
        let Ok(body) = to_bytes(body, MOST_BODY).await else {
            let text = "the form is too long, or did not arrive as a whole".to_owned();
            return Problem::Refused(StatusCode::PAYLOAD_TOO_LARGE, text).into_response();
        };
        request = Request::from_parts(head, Body::from(body));
    }
    let answering = request.extensions().get::<ConnectInfo<Answering>>().map(|info| info.0.clone());
    let _at_work = answering.map(AtWork::on);
    next.run(request).await
}

/// A connection that has a place, and ends with an error when nothing moves for too long.
#[derive(Debug)]
pub(super) struct Visit<S> {
    stream: S,
    deadline: Pin<Box<Sleep>>,
    patience: Patience,
    /// A request has begun, and nothing was answered since: its bytes win no time, so that none can be sent drop by drop.
    is_asking: bool,
    answering: Answering,
    places: Arc<Semaphore>,
    _place: OwnedSemaphorePermit,
}

impl<S> Visit<S> {
    fn wait(&mut self, patience: Duration) {
        let is_full = self.places.available_permits() == 0;
        let patience = if is_full { patience / 3 } else { patience };
        self.deadline.as_mut().reset(Instant::now() + patience);
    }

    fn has_read(&mut self) {
        if !self.is_asking {
            self.is_asking = true;
            self.wait(self.patience.request);
        }
    }

    fn has_written(&mut self) {
        self.is_asking = false;
        self.wait(self.patience.idle);
    }

    /// Ready when nothing has moved for too long.
    fn poll_late(&mut self, context: &mut Context<'_>) -> Poll<io::Error> {
        loop {
            ready!(self.deadline.as_mut().poll(context));
            if !self.answering.0.load(Ordering::Relaxed) {
                return Poll::Ready(io::ErrorKind::TimedOut.into());
            }
            self.wait(self.patience.request);
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Visit<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        match Pin::new(&mut self.stream).poll_read(context, buffer) {
            Poll::Ready(read) => {
                self.has_read();
                Poll::Ready(read)
            }
            Poll::Pending => self.poll_late(context).map(Err),
        }
    }
}

impl<S: AsyncWrite + Unpin> Visit<S> {
    fn written<T>(&mut self, written: Poll<io::Result<T>>, context: &mut Context<'_>) -> Poll<io::Result<T>> {
        match written {
            Poll::Ready(written) => {
                self.has_written();
                Poll::Ready(written)
            }
            Poll::Pending => self.poll_late(context).map(Err),
        }
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Visit<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.written(written, context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.written(written, context)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
#[path = "admit_tests.rs"]
mod tests;
