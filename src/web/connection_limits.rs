//! Limits the number of connections to the dashboard and the time that a connection may be silent. The farm needs the
//! daemon's open files first: a client that connects and sends nothing holds one of them for a few seconds only.
//! Clients beyond the limit wait in the kernel's backlog.

use std::{
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
    body::{Body, to_bytes},
    extract::{ConnectInfo, Request, connect_info::Connected},
    http::{Method, StatusCode, header},
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

use super::error::HandlerError;

/// Largest request body, bytes.
pub(super) const MAX_BODY_BYTES: usize = 4096;

/// Largest body of a program's request that brings no file, bytes.
pub(super) const MAX_JSON_BYTES: usize = 1 << 20;

/// Most connections at once, unless the limit of open files allows fewer.
const MAX_CONNECTIONS: u64 = 128;
/// Connections take at most one in four of the daemon's open files.
const OPEN_FILES_DIVISOR: u64 = 4;
/// Connections that are always allowed: one browser opens up to six at once.
const MIN_CONNECTIONS: u64 = 8;

/// How long a connection stays open without progress. When all places are taken, a third of these times.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConnectionTimeouts {
    /// From the first byte of a request to its last; for the first request, from the connect.
    pub(super) request: Duration,
    /// From one piece of a response to the next piece or the next request. The change stream sends something every 15
    /// s.
    pub(super) idle: Duration,
}

impl ConnectionTimeouts {
    pub(super) const DEFAULT: Self = Self { request: Duration::from_secs(10), idle: Duration::from_secs(60) };
}

/// A listener that accepts a limited number of connections at once.
#[derive(Debug)]
pub(super) struct LimitedListener<L> {
    listener: L,
    permits: Arc<Semaphore>,
    timeouts: ConnectionTimeouts,
}

impl<L> LimitedListener<L> {
    /// Allows as many connections as the limit of open files permits.
    pub(super) fn with_default_limits(listener: L) -> Self {
        let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
        Self::new(
            listener,
            (files / OPEN_FILES_DIVISOR).clamp(MIN_CONNECTIONS, MAX_CONNECTIONS) as usize,
            ConnectionTimeouts::DEFAULT,
        )
    }

    pub(super) fn new(listener: L, max_connections: usize, timeouts: ConnectionTimeouts) -> Self {
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
pub(super) trait ClientAddress {
    /// What all connections of the client have in common.
    fn client_name(&self) -> String;
}

impl ClientAddress for std::net::SocketAddr {
    fn client_name(&self) -> String {
        self.ip().to_canonical().to_string()
    }
}

impl ClientAddress for tokio::net::unix::SocketAddr {
    fn client_name(&self) -> String {
        "socket".to_owned()
    }
}

/// How far the request of a connection is: it arrives, it is answered, or files arrive. And where it comes from.
#[derive(Debug, Clone, Default)]
pub(super) struct RequestInProgress {
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
    /// The address of the client, as [`ClientAddress`] names it.
    pub(super) fn client(&self) -> &str {
        &self.client
    }

    fn is_at(&self, stage: u8) -> bool {
        self.stage.load(Ordering::Relaxed) == stage
    }
}

impl<L: Listener<Addr: ClientAddress>> Connected<IncomingStream<'_, LimitedListener<L>>> for RequestInProgress {
    fn connect_info(stream: IncomingStream<'_, LimitedListener<L>>) -> Self {
        stream.io().in_progress.clone()
    }
}

/// Marks how far a request is until the guard is dropped.
struct InProgressGuard(RequestInProgress);

impl InProgressGuard {
    fn new(progress: RequestInProgress, stage: u8) -> Self {
        progress.stage.store(stage, Ordering::Relaxed);
        Self(progress)
    }
}

impl Drop for InProgressGuard {
    fn drop(&mut self) {
        self.0.stage.store(ARRIVING, Ordering::Relaxed);
    }
}

/// Whether a request brings files: to the form that adds them to a machine, as content, as a piece of an upload, or with an order.
fn brings_files(request: &Request) -> bool {
    let path = request.uri().path();
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    match *request.method() {
        Method::POST if path.starts_with("/machines/") => path.ends_with("/files"),
        Method::POST if path == "/api/v1/content" => true,
        Method::POST => path.starts_with("/api/v1/orders") && kind.starts_with("multipart/"),
        Method::PUT => path.starts_with("/api/v1/content/"),
        Method::PATCH => path.starts_with("/api/v1/uploads/"),
        _ => false,
    }
}

/// Receives the whole request while the timeout of its connection runs, then answers it without that timeout. Files are received by
/// whoever answers.
pub(super) async fn buffer_then_answer(mut request: Request, next: Next) -> Response {
    let is_upload = brings_files(&request);
    if !is_upload && !matches!(*request.method(), Method::GET | Method::HEAD) {
        let (head, body) = request.into_parts();
        let most = if head.uri.path().starts_with("/api/") { MAX_JSON_BYTES } else { MAX_BODY_BYTES };
        let Ok(body) = to_bytes(body, most).await else {
            let text = "the form is too long, or did not arrive as a whole".to_owned();
            return HandlerError::Refused(StatusCode::PAYLOAD_TOO_LARGE, text).into_response();
        };
        request = Request::from_parts(head, Body::from(body));
    }
    let progress = request.extensions().get::<ConnectInfo<RequestInProgress>>().map(|info| info.0.clone());
    let stage = if is_upload { UPLOADING } else { ANSWERING };
    let _at_work = progress.map(|progress| InProgressGuard::new(progress, stage));
    next.run(request).await
}

/// A connection that holds a place, and fails with `TimedOut` when it makes no progress for too long.
#[derive(Debug)]
pub(super) struct LimitedConnection<S> {
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
#[path = "connection_limits_tests.rs"]
mod tests;
