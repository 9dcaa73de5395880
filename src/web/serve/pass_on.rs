//! What only another node can answer is passed on to it as it is, in the name of whoever asks, and its answer is passed back: what is
//! dropped for its machines, the files of its builds, break-outs at which several devices are, and uploads that began there. So any node can
//! be asked, also by a browser or program that a load balancer leads to another one each time.

use std::{
    io::{self, Read},
    sync::Arc,
    time::Duration,
};

use anyhow::Context;
use axum::{
    body::{Body, Bytes},
    extract::{Request, State},
    http::{HeaderName, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use farm::NodeClient;
use language::say;
use ledger::BuildId;
use settings::MachineProfile;
use tokio::sync::mpsc;
use tokio_stream::StreamExt;
use ureq::SendBody;

use super::page_routes::{AnsweringNode, find_page};
use crate::web::{
    base::error::{HandlerError, HandlerResult},
    clients::client::{ON_BEHALF, RequestClient},
    core::{content::stream_body, state::DashboardState},
    doors::upload_door::{find_upload_here, upload_of_path},
};

/// Pieces of a request that wait for a slow node.
const CHUNKS_AHEAD: usize = 4;
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
    if web.ledger.file().is_some() || request.headers().contains_key(ON_BEHALF) {
        return next.run(request).await;
    }
    match find_answering_node(&web, request.method(), request.uri().path()).await {
        Ok(None) => next.run(request).await,
        Ok(Some(node)) => send_to(node, request).await.unwrap_or_else(IntoResponse::into_response),
        Err(problem) => problem.into_response(),
    }
}

/// The other node that answers a request; `None` = this one does.
async fn find_answering_node(web: &DashboardState, method: &Method, path: &str) -> HandlerResult<Option<NodeClient>> {
    if let Some(upload) = upload_of_path(path) {
        return find_node_of_upload(web, upload).await;
    }
    let answered_by = find_page(method, path).map_or(AnsweringNode::Any, |route| route.answered_by);
    if answered_by == AnsweringNode::Any {
        return Ok(None);
    }
    let Some(machine) = machine_of_path(web, path).await? else { return Ok(None) };
    let node = NodeClient::of_machine(&web.current_settings(), &web.ledger, &machine).await?;
    match (node, answered_by) {
        (Some(node), _) if node.is_alive => Ok(Some(node)),
        (Some(node), AnsweringNode::OnlyOfMachine) => {
            let text = say!("node-of-machine-gone", machine = &machine.name, node = &node.name);
            Err(HandlerError::Refused(StatusCode::SERVICE_UNAVAILABLE, text))
        }
        _ => Ok(None),
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
    let (path, asked) = (format!("/api/v1/uploads/{id}"), RequestClient::current());
    let look = move || {
        let has_it = |node: &NodeClient| {
            let request = ureq::http::Request::get(&path).header(ON_BEHALF, name_of(asked.as_ref())).body(());
            let answer = request.map_err(anyhow::Error::from).and_then(|request| node.send(request, Some(ASK_TIMEOUT)));
            answer.is_ok_and(|answer| answer.status() == StatusCode::OK)
        };
        others.into_iter().find(has_it)
    };
    Ok(tokio::task::spawn_blocking(look).await.context("asking other nodes for an upload")?)
}

fn name_of(client: Option<&RequestClient>) -> header::HeaderValue {
    client.and_then(RequestClient::to_header).unwrap_or(header::HeaderValue::from_static(""))
}

/// Sends a request to another node, and answers with what that answers.
async fn send_to(node: NodeClient, request: Request) -> HandlerResult<Response> {
    let client = request.extensions().get::<RequestClient>().cloned();
    let (head, body) = request.into_parts();
    let mut passed = ureq::http::Request::new(());
    (*passed.method_mut(), *passed.uri_mut(), *passed.headers_mut()) = (head.method, head.uri, head.headers);
    let headers = passed.headers_mut();
    OF_ONE_CONNECTION.iter().for_each(|name| drop(headers.remove(name)));
    let of_browser: Vec<HeaderName> =
        headers.keys().filter(|name| name.as_str().starts_with("sec-")).cloned().collect();
    of_browser.iter().for_each(|name| drop(headers.remove(name)));
    headers.insert(ON_BEHALF, name_of(client.as_ref()));
    let name = node.name.clone();
    let source = if passed.method().is_safe() { None } else { Some(ReceivedBody::of(body)) };
    let sending = tokio::task::spawn_blocking(move || match source {
        None => node.send(passed, None),
        Some(source) => node.send(passed.map(|()| SendBody::from_owned_reader(source)), None),
    });
    let answer = sending.await.context("passing a request on")?.map_err(|failure| {
        let text = say!("node-does-not-answer", node = name, why = format!("{failure:#}"));
        HandlerError::Refused(StatusCode::BAD_GATEWAY, text)
    })?;
    let (head, body) = answer.into_parts();
    let mut response = (head.status, stream_body(body.into_reader())).into_response();
    for (name, value) in head.headers.iter().filter(|(name, _)| !OF_ONE_CONNECTION.contains(name)) {
        response.headers_mut().append(name, value.clone());
    }
    Ok(response)
}

/// The body of a request, for a thread that may wait for it.
struct ReceivedBody {
    chunks: mpsc::Receiver<io::Result<Bytes>>,
    left: Bytes,
}

impl ReceivedBody {
    /// It is received as it is read. One that is cut ends in an error.
    fn of(body: Body) -> Self {
        let (send, chunks) = mpsc::channel(CHUNKS_AHEAD);
        tokio::spawn(async move {
            let mut pieces = body.into_data_stream();
            while let Some(piece) = pieces.next().await {
                if send.send(piece.map_err(io::Error::other)).await.is_err() {
                    return;
                }
            }
        });
        Self { chunks, left: Bytes::new() }
    }
}

impl Read for ReceivedBody {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.left.is_empty() {
            match self.chunks.blocking_recv() {
                None => return Ok(0),
                Some(piece) => self.left = piece?,
            }
        }
        let count = self.left.len().min(into.len());
        into[..count].copy_from_slice(&self.left.split_to(count));
        Ok(count)
    }
}
