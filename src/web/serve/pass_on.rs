//! What only another node can answer is passed on to it as it is, in the name of whoever asks, and its answer is passed back: what is
//! dropped for its machines, the files of its builds, break-outs at which several devices are, and uploads that began there. So any node can
//! be asked, also by a browser or program that a load balancer leads to another one each time.
//!
//! Each has a thread of its own while it lasts, since the other node may be slow: those of the dashboard answer what is asked here.

use std::{
    io::{self, Read},
    sync::Arc,
    time::Duration,
};

use anyhow::Context;
use axum::{
    body::{Body, Bytes, to_bytes},
    extract::{Request, State},
    http::{HeaderName, HeaderValue, Method, StatusCode, header, request::Parts},
    middleware::Next,
    response::{IntoResponse, Response},
};
use farm::NodeClient;
use language::say;
use ledger::BuildId;
use settings::MachineProfile;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot};
use tokio_stream::{StreamExt, wrappers::ReceiverStream};
use ureq::SendBody;

use super::page_routes::{AnsweringNode, find_page};
use crate::web::{
    base::error::{AnsweredElsewhere, HandlerError, HandlerResult},
    clients::client::{ON_BEHALF, RequestClient},
    core::{
        content::{CHUNKS_AHEAD, send_pieces},
        request_user::user_of_parts,
        state::DashboardState,
    },
    doors::{
        request_stage::MAX_BODY_BYTES,
        upload_door::{find_upload_here, upload_of_path},
    },
    pages::live::is_stream_of_changes,
};

/// Requests that other nodes answer at the same time.
pub(super) const MAX_PASSED_ON: usize = 32;
/// How long another node may take to say whether it has an upload.
const ASK_TIMEOUT: Duration = Duration::from_secs(5);

/// What is said between two programs alone, or for one server alone.
const OF_ONE_CONNECTION: [HeaderName; 12] = [
    header::HOST,
    header::AUTHORIZATION,
    header::CONNECTION,
    header::TRANSFER_ENCODING,
    header::TE,
    header::TRAILER,
    header::UPGRADE,
    header::EXPECT,
    header::ACCEPT_ENCODING,
    header::ORIGIN,
    header::REFERER,
    HeaderName::from_static("keep-alive"),
];

/// Passes a request on to the node that answers it, or has it answered here.
pub(super) async fn pass_on(State(web): State<Arc<DashboardState>>, request: Request, next: Next) -> Response {
    if web.ledger.file().is_some() {
        return next.run(request).await;
    }
    let is_passed_on = request.extensions().get().is_some_and(RequestClient::is_passed_on);
    match find_answering_node(&web, request.method(), request.uri().path(), is_passed_on).await {
        Ok(None) => next.run(request).await,
        Ok(Some((node, AnsweringNode::OfMachine))) => ask_or_answer(&web, node, request, next).await,
        Ok(Some((node, _))) => {
            let (mut parts, body) = request.into_parts();
            let passed = passed_request(&web, &mut parts);
            let source = (!passed.method().is_safe()).then(|| ReceivedBody::of(body));
            send_to(&web, node, passed, source).await.unwrap_or_else(|failure| failure.problem.into_response())
        }
        Err(problem) => problem.into_response(),
    }
}

/// Has the node of a machine answer; where it was not reached at all, this one does.
async fn ask_or_answer(web: &DashboardState, node: NodeClient, request: Request, next: Next) -> Response {
    let (mut parts, body) = request.into_parts();
    let passed = passed_request(web, &mut parts);
    // It brings no files, and was received as a whole.
    let Ok(bytes) = to_bytes(body, MAX_BODY_BYTES).await else { return StatusCode::BAD_REQUEST.into_response() };
    let source = (!passed.method().is_safe()).then(|| ReceivedBody::of(Body::from(bytes.clone())));
    match send_to(web, node, passed, source).await {
        Ok(answer) => answer,
        Err(failure) if failure.was_not_sent => next.run(Request::from_parts(parts, Body::from(bytes))).await,
        Err(failure) => failure.problem.into_response(),
    }
}

/// The other node that answers a request; `None` = this one does. What another node has passed on is passed on no further.
async fn find_answering_node(
    web: &DashboardState,
    method: &Method,
    path: &str,
    is_passed_on: bool,
) -> HandlerResult<Option<(NodeClient, AnsweringNode)>> {
    if let Some(upload) = upload_of_path(path).filter(|_| !is_passed_on) {
        let node = find_node_of_upload(web, upload).await?;
        return Ok(node.map(|node| (node, AnsweringNode::OnlyOfMachine)));
    }
    let answered_by = find_page(method, path).map_or(AnsweringNode::Any, |route| route.answered_by);
    if answered_by == AnsweringNode::Any {
        return Ok(None);
    }
    let Some(machine) = machine_of_path(web, path).await?.filter(|machine| !machine.of_node.is_empty()) else {
        return Ok(None);
    };
    let node = NodeClient::of_machine(&web.current_settings(), &web.ledger, &machine).await?;
    let node = node.filter(|node| node.is_alive && !node.address.is_empty() && !is_passed_on);
    match (node, answered_by) {
        (Some(node), _) => Ok(Some((node, answered_by))),
        (None, AnsweringNode::OnlyOfMachine) => {
            let text = match is_passed_on {
                true => say!("machine-just-moves", machine = &machine.name),
                false => say!("node-of-machine-gone", machine = &machine.name, node = &machine.of_node),
            };
            Err(HandlerError::Refused(StatusCode::SERVICE_UNAVAILABLE, text))
        }
        (None, _) => Ok(None),
    }
}

/// The machine that an address names, or that made the build that it names.
async fn machine_of_path(web: &DashboardState, path: &str) -> HandlerResult<Option<MachineProfile>> {
    let mut names = path.split('/').skip(1);
    let named = match (names.next(), names.next()) {
        (Some("machines"), Some(name)) => Some(name.to_owned()),
        (Some("builds"), Some(number)) => match number.parse() {
            Ok(number) => web.ledger.find_build(BuildId(number)).await?.map(|build| build.machine),
            Err(_) => None,
        },
        _ => None,
    };
    Ok(named.and_then(|name| web.current_settings().profiles.get(&name).cloned()))
}

/// The other node where an upload lies that is not here.
async fn find_node_of_upload(web: &DashboardState, id: &str) -> HandlerResult<Option<NodeClient>> {
    if find_upload_here(web, id).await? {
        return Ok(None);
    }
    let others = NodeClient::others(&web.current_settings(), &web.ledger).await?;
    let (path, name) = (format!("/api/v1/uploads/{id}"), name_of(RequestClient::current().as_ref(), ""));
    let look = move || {
        let mut silent = None;
        for node in others {
            let request = ureq::http::Request::get(&path).header(ON_BEHALF, name.clone()).body(());
            let asked = request.map_err(anyhow::Error::from).and_then(|request| node.send(request, Some(ASK_TIMEOUT)));
            match asked.map(|answer| answer.status()) {
                Ok(StatusCode::OK) => return Ok(Some(node)),
                Ok(StatusCode::NOT_FOUND) => {}
                Ok(status) => silent = Some(format!("the node {} answers {status}", node.name)),
                Err(failure) => silent = Some(format!("the node {}: {failure:#}", node.name)),
            }
        }
        silent.map_or(Ok(None), Err)
    };
    let found = on_thread(web, look)?.await.context("asking other nodes for an upload")?;
    found.map_err(|why| {
        let text = format!("it is not known whether another node has upload {id}: {why}. Ask again in a moment");
        HandlerError::Refused(StatusCode::SERVICE_UNAVAILABLE, text)
    })
}

fn name_of(client: Option<&RequestClient>, user: &str) -> HeaderValue {
    let nobody = RequestClient::nobody();
    client.unwrap_or(&nobody).to_header(user).unwrap_or(HeaderValue::from_static(""))
}

/// A request as it is sent on.
fn passed_request(web: &DashboardState, parts: &mut Parts) -> ureq::http::Request<()> {
    let user = user_of_parts(web, parts);
    let mut passed = ureq::http::Request::new(());
    (*passed.method_mut(), *passed.uri_mut()) = (parts.method.clone(), parts.uri.clone());
    let by_proxy = web.proxy.as_ref().map(|proxy| proxy.header.clone());
    let is_kept = |name: &HeaderName| {
        !OF_ONE_CONNECTION.contains(name) && Some(name) != by_proxy.as_ref() && !name.as_str().starts_with("sec-")
    };
    let headers = passed.headers_mut();
    for (name, value) in parts.headers.iter().filter(|(name, _)| is_kept(name)) {
        headers.append(name, value.clone());
    }
    match parts.method.is_safe() {
        true => drop(headers.remove(header::CONTENT_LENGTH)),
        // The other node may refuse it before it is sent.
        false => drop(headers.insert(header::EXPECT, HeaderValue::from_static("100-continue"))),
    }
    headers.insert(ON_BEHALF, name_of(parts.extensions.get::<RequestClient>(), &user));
    passed
}

/// Why there is no answer of another node.
struct PassFailure {
    problem: HandlerError,
    was_not_sent: bool,
}

impl From<HandlerError> for PassFailure {
    fn from(problem: HandlerError) -> Self {
        Self { problem, was_not_sent: false }
    }
}

/// Does some work that waits for another node on a thread of its own.
fn on_thread<T: Send + 'static>(
    web: &DashboardState,
    work: impl FnOnce() -> T + Send + 'static,
) -> HandlerResult<oneshot::Receiver<T>> {
    on_thread_with(&web.pass_slots, |done, _place| _ = done.send(work()))
}

fn on_thread_with<T: Send + 'static>(
    slots: &Arc<Semaphore>,
    work: impl FnOnce(oneshot::Sender<T>, OwnedSemaphorePermit) + Send + 'static,
) -> HandlerResult<oneshot::Receiver<T>> {
    let busy = |_| HandlerError::TooMany(1, say!("nodes-are-busy"));
    let place = slots.clone().try_acquire_owned().map_err(busy)?;
    let (done, waits) = oneshot::channel();
    let thread = std::thread::Builder::new().name("nestd-pass-on".to_owned());
    thread.spawn(move || work(done, place)).context("starting a thread")?;
    Ok(waits)
}

/// Sends a request to another node, and answers with what that answers.
async fn send_to(
    web: &DashboardState,
    node: NodeClient,
    passed: ureq::http::Request<()>,
    source: Option<ReceivedBody>,
) -> Result<Response, PassFailure> {
    let name = node.name.clone();
    // A page listens for as long as it is open: no other request waits for that.
    let slots = if is_stream_of_changes(passed.uri().path()) { &web.listen_slots } else { &web.pass_slots };
    let answered = on_thread_with(slots, move |answer, _place| {
        let sent = match source {
            None => node.send(passed, None),
            Some(source) => node.send(passed.map(|()| SendBody::from_owned_reader(source)), None),
        };
        match sent {
            Err(failure) => _ = answer.send(Err(failure)),
            Ok(sent) => {
                let (head, body) = sent.into_parts();
                let (send, chunks) = mpsc::channel(CHUNKS_AHEAD);
                if answer.send(Ok((head, chunks))).is_ok() {
                    send_pieces(body.into_reader(), &send);
                }
            }
        }
    })?;
    let answer = answered.await.map_err(|_| HandlerError::Failed(anyhow::anyhow!("passing a request on")))?;
    let (head, chunks) = answer.map_err(|failure| {
        let was_not_sent = farm::was_not_sent(&failure);
        let text = say!("node-does-not-answer", node = name, why = format!("{failure:#}"));
        PassFailure { problem: HandlerError::Refused(StatusCode::BAD_GATEWAY, text), was_not_sent }
    })?;
    let mut response = (head.status, Body::from_stream(ReceiverStream::new(chunks))).into_response();
    for (name, value) in head.headers.iter().filter(|(name, _)| !OF_ONE_CONNECTION.contains(name)) {
        response.headers_mut().append(name, value.clone());
    }
    response.extensions_mut().insert(AnsweredElsewhere);
    Ok(response)
}

/// The body of a request, for a thread that may wait for it. An empty piece is its end.
struct ReceivedBody {
    chunks: mpsc::Receiver<io::Result<Bytes>>,
    left: Bytes,
    has_ended: bool,
}

impl ReceivedBody {
    /// It is received as it is read. One that is cut ends in an error.
    fn of(body: Body) -> Self {
        let (send, chunks) = mpsc::channel(CHUNKS_AHEAD);
        tokio::spawn(async move {
            let mut pieces = body.into_data_stream();
            while let Some(piece) = pieces.next().await {
                let is_empty = piece.as_ref().is_ok_and(Bytes::is_empty);
                if !is_empty && send.send(piece.map_err(io::Error::other)).await.is_err() {
                    return;
                }
            }
            _ = send.send(Ok(Bytes::new())).await;
        });
        Self { chunks, left: Bytes::new(), has_ended: false }
    }
}

impl Read for ReceivedBody {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.left.is_empty() && !self.has_ended {
            self.left = self.chunks.blocking_recv().ok_or(io::ErrorKind::UnexpectedEof)??;
            self.has_ended = self.left.is_empty();
        }
        let count = self.left.len().min(into.len());
        into[..count].copy_from_slice(&self.left.split_to(count));
        Ok(count)
    }
}
