//! Limits the number of connections to the dashboard and the time that a connection may be silent. The farm needs the
//! daemon's open files first: a client that connects and sends nothing holds one of them for a few seconds only.
//! Clients beyond the limit wait in the kernel's backlog.

use std::{
    convert::Infallible,
    io,
    pin::Pin,
    sync::{
        Arc,
        atomic::{AtomicU8, Ordering},
    },
    task::{Context, Poll, ready},
    time::Duration,
};

use axum::{
    extract::{ConnectInfo, FromRequestParts, connect_info::Connected},
    http::request::Parts,
    serve::{IncomingStream, Listener},
};
use rustix::process::{Resource, getrlimit};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    sync::{OwnedSemaphorePermit, Semaphore},
    time::{Instant, Sleep, sleep},
};

/// Most connections at once, unless the limit of open files allows fewer.
const MAX_CONNECTIONS: u64 = 128;
/// Connections take at most one in four of the daemon's open files.
const OPEN_FILES_DIVISOR: u64 = 4;
/// Connections that are always allowed: one browser opens up to six at once.
const MIN_CONNECTIONS: u64 = 8;

/// How long a connection stays open without progress. When all places are taken, a third of these times.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConnectionTimeouts {
    /// From the first byte of a request to its last; for the first request, from the connect.
    pub(crate) request: Duration,
    /// From one piece of a response to the next piece or the next request. The change stream sends something every 15
    /// s.
    pub(crate) idle: Duration,
}

impl ConnectionTimeouts {
    pub(crate) const DEFAULT: Self = Self { request: Duration::from_secs(10), idle: Duration::from_secs(60) };
}

/// A listener that accepts a limited number of connections at once.
#[derive(Debug)]
pub(crate) struct LimitedListener<L> {
    listener: L,
    permits: Arc<Semaphore>,
    timeouts: ConnectionTimeouts,
}

impl<L> LimitedListener<L> {
    /// Allows as many connections as the limit of open files permits.
    pub(crate) fn with_default_limits(listener: L) -> Self {
        let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
        Self::new(
            listener,
            (files / OPEN_FILES_DIVISOR).clamp(MIN_CONNECTIONS, MAX_CONNECTIONS) as usize,
            ConnectionTimeouts::DEFAULT,
        )
    }

    pub(crate) fn new(listener: L, max_connections: usize, timeouts: ConnectionTimeouts) -> Self {
        Self { listener, permits: Arc::new(Semaphore::new(max_connections)), timeouts }
    }
}

impl<L: Listener<Addr: ClientAddress>> Listener for LimitedListener<L> {
    type Io = LimitedConnection<L::Io>;
    type Addr = L::Addr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        let place = self.permits.clone().acquire_owned().await.expect("the semaphore is never closed");
        let (stream, address) = self.listener.accept().await;
        let mut visit = LimitedConnection {
            stream,
            deadline: Box::pin(sleep(self.timeouts.request)),
            timeouts: self.timeouts,
            is_receiving: true,
            in_progress: RequestInProgress { client: address.client_name().into(), ..RequestInProgress::default() },
            permits: self.permits.clone(),
            _permit: place,
        };
        visit.restart_timeout(self.timeouts.request);
        (visit, address)
    }

    fn local_addr(&self) -> io::Result<Self::Addr> {
        self.listener.local_addr()
    }
}

/// An address that a client connects from.
pub(crate) trait ClientAddress {
    /// What all connections of the client have in common.
    fn client_name(&self) -> String;
}

/// What stands for the address of whoever connects to a Unix socket.
pub(crate) const OF_SOCKET: &str = "socket";

impl ClientAddress for std::net::SocketAddr {
    fn client_name(&self) -> String {
        self.ip().to_canonical().to_string()
    }
}

impl ClientAddress for tokio::net::unix::SocketAddr {
    fn client_name(&self) -> String {
        OF_SOCKET.to_owned()
    }
}

/// How far the request of a connection is: it arrives, it is answered, or files arrive. And where it comes from.
#[derive(Debug, Clone, Default)]
pub(crate) struct RequestInProgress {
    stage: Arc<AtomicU8>,
    client: Arc<str>,
}

/// The request arrives, within the time of a request.
const ARRIVING: u8 = 0;
/// It is complete. Until the response is ready the connection does not time out: the client waits for us.
const ANSWERING: u8 = 1;
/// Its files arrive, which may take long; each piece of them must come within the time of an idle connection.
const UPLOADING: u8 = 2;

impl RequestInProgress {
    /// A request of a client with this address.
    #[cfg(test)]
    pub(crate) fn of_client(address: &str) -> Self {
        Self { client: address.into(), ..Self::default() }
    }

    /// The address of the client, as [`ClientAddress`] names it.
    pub(crate) fn client(&self) -> &str {
        &self.client
    }

    fn is_at(&self, stage: u8) -> bool {
        self.stage.load(Ordering::Relaxed) == stage
    }

    /// A request is complete, or its files arrive. So it is until the guard is dropped, or until its files are complete.
    pub(crate) fn begin_answer(&self, has_files: bool) -> InProgressGuard {
        self.stage.store(if has_files { UPLOADING } else { ANSWERING }, Ordering::Relaxed);
        InProgressGuard(self.clone())
    }

    /// The files of a request are complete: the client waits for the answer.
    pub(crate) fn note_complete(&self) {
        _ = self.stage.compare_exchange(UPLOADING, ANSWERING, Ordering::Relaxed, Ordering::Relaxed);
    }
}

impl<S: Send + Sync> FromRequestParts<S> for RequestInProgress {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        let info = parts.extensions.get::<ConnectInfo<Self>>();
        Ok(info.map(|info| info.0.clone()).unwrap_or_default())
    }
}

impl<L: Listener<Addr: ClientAddress>> Connected<IncomingStream<'_, LimitedListener<L>>> for RequestInProgress {
    fn connect_info(stream: IncomingStream<'_, LimitedListener<L>>) -> Self {
        stream.io().in_progress.clone()
    }
}

/// Marks how far a request is until the guard is dropped.
pub(crate) struct InProgressGuard(RequestInProgress);

impl Drop for InProgressGuard {
    fn drop(&mut self) {
        self.0.stage.store(ARRIVING, Ordering::Relaxed);
    }
}

/// A connection that holds a place, and fails with `TimedOut` when it makes no progress for too long.
#[derive(Debug)]
pub(crate) struct LimitedConnection<S> {
    stream: S,
    deadline: Pin<Box<Sleep>>,
    timeouts: ConnectionTimeouts,
    /// A request has begun and no response byte was sent since. Further request bytes do not restart the timeout, so
    /// that a client cannot send a request byte by byte.
    is_receiving: bool,
    in_progress: RequestInProgress,
    permits: Arc<Semaphore>,
    _permit: OwnedSemaphorePermit,
}

impl<S> LimitedConnection<S> {
    fn restart_timeout(&mut self, timeout: Duration) {
        let is_full = self.permits.available_permits() == 0;
        let timeout = if is_full { timeout / 3 } else { timeout };
        self.deadline.as_mut().reset(Instant::now() + timeout);
    }

    fn note_read(&mut self) {
        if self.in_progress.is_at(UPLOADING) {
            self.restart_timeout(self.timeouts.idle);
        } else if !self.is_receiving {
            self.is_receiving = true;
            self.restart_timeout(self.timeouts.request);
        }
    }

    fn note_written(&mut self) {
        self.is_receiving = false;
        self.restart_timeout(self.timeouts.idle);
    }

    /// Ready when the connection made no progress for too long.
    fn poll_timeout(&mut self, context: &mut Context<'_>) -> Poll<io::Error> {
        loop {
            ready!(self.deadline.as_mut().poll(context));
            if !self.in_progress.is_at(ANSWERING) {
                return Poll::Ready(io::ErrorKind::TimedOut.into());
            }
            self.restart_timeout(self.timeouts.request);
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for LimitedConnection<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        match Pin::new(&mut self.stream).poll_read(context, buffer) {
            Poll::Ready(read) => {
                self.note_read();
                Poll::Ready(read)
            }
            Poll::Pending => self.poll_timeout(context).map(Err),
        }
    }
}

impl<S: AsyncWrite + Unpin> LimitedConnection<S> {
    fn finish_write<T>(&mut self, written: Poll<io::Result<T>>, context: &mut Context<'_>) -> Poll<io::Result<T>> {
        match written {
            Poll::Ready(written) => {
                self.note_written();
                Poll::Ready(written)
            }
            Poll::Pending => self.poll_timeout(context).map(Err),
        }
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for LimitedConnection<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.finish_write(written, context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.finish_write(written, context)
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
#[path = "tests/connection_limits_tests.rs"]
mod tests;
