//! Another node of the farm, as it is asked over HTTP: for the files that lie there, for what it sees in its queue folders, and for
//! whatever a page or program wants of its machines. Nodes know each other by a secret in their ledger.

use std::{path::PathBuf, time::Duration};

use anyhow::{Context, Result, bail};
use ledger::{Ledger, LedgerError, NodeRow};
use settings::{MachineProfile, Settings};
use ureq::{
    AsSendBody, Body, Timeout,
    http::{HeaderValue, Request, Response, StatusCode, header},
    tls::{RootCerts, TlsConfig},
};

/// A node without an answer for this long is asked again later.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);
/// A node that has a request may work on it for this time before it answers.
const WORK_TIMEOUT: Duration = Duration::from_secs(120);
/// A link over which nothing comes, or goes, for this time is cut.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(30);

/// The secret by which nodes of a farm know each other, in the ledger.
const SECRET: &str = "nodes";
/// The header with that secret.
pub const NODE_HEADER: &str = "nestd-node";

/// The secret by which the nodes of this farm know each other; "" = the ledger is in a file, and there are no others.
///
/// # Errors
/// The ledger cannot be read.
pub async fn node_secret(ledger: &Ledger) -> Result<String, LedgerError> {
    match ledger.file() {
        Some(_) => Ok(String::new()),
        None => ledger.farm_secret(SECRET, &blake3::Hash::from_bytes(rand::random()).to_hex()).await,
    }
}

/// Another node.
#[derive(Debug, Clone)]
pub struct NodeClient {
    /// Its name.
    pub name: String,
    /// Where its pages are; "" = its settings have no `node.address`.
    pub address: String,
    /// Whether it runs, by its heartbeats.
    pub is_alive: bool,
    secret: String,
    /// Of the farm, for nodes of older versions.
    token_file: Option<PathBuf>,
}

impl NodeClient {
    /// The node of a row of the ledger. `secret` = [`node_secret`].
    pub(crate) fn of_row(settings: &Settings, row: NodeRow, secret: &str) -> Self {
        let token_file = settings.interfaces.web.as_ref().and_then(|web| web.token_file.clone());
        Self { name: row.name, address: row.address, is_alive: row.alive, secret: secret.to_owned(), token_file }
    }

    /// The node that serves a machine; `None` = this one, or one that the ledger does not know.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn of_machine(
        settings: &Settings,
        ledger: &Ledger,
        machine: &MachineProfile,
    ) -> Result<Option<Self>, LedgerError> {
        if machine.of_node.is_empty() {
            return Ok(None);
        }
        let (row, secret) = (ledger.find_node(&machine.of_node).await?, node_secret(ledger).await?);
        Ok(row.map(|row| Self::of_row(settings, row, &secret)))
    }

    /// The other nodes that run.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn others(settings: &Settings, ledger: &Ledger) -> Result<Vec<Self>, LedgerError> {
        let secret = node_secret(ledger).await?;
        let rows = ledger.list_nodes().await?.into_iter().filter(|row| row.alive && row.name != settings.node.name);
        Ok(rows.map(|row| Self::of_row(settings, row, &secret)).collect())
    }

    /// What it has at an address, such as `/content/HASH`, in at most this time; `None` = it has none.
    ///
    /// # Errors
    /// It does not answer, or not so.
    pub fn get(&self, path: &str, within: Duration) -> Result<Option<Body>> {
        let answer = self.send(Request::get(path).body(())?, Some(within))?;
        match answer.status() {
            StatusCode::OK => Ok(Some(answer.into_body())),
            StatusCode::NOT_FOUND => Ok(None),
            StatusCode::UNAUTHORIZED => {
                bail!("{} asks for another token than that of web.token_file here", self.address)
            }
            status => bail!("{} answers {status}", self.address),
        }
    }

    /// Sends a request whose address is a path, as a node of the farm, and waits for the head of its answer. `within` limits both ways
    /// together; `None` = as long as something comes each half minute.
    ///
    /// # Errors
    /// It cannot be reached, does not answer, or refuses this node.
    pub fn send(&self, mut request: Request<impl AsSendBody>, within: Option<Duration>) -> Result<Response<Body>> {
        if self.address.is_empty() {
            bail!("its settings have no node.address");
        }
        let path = request.uri().path_and_query().map_or("/", |path| path.as_str());
        *request.uri_mut() = format!("{}{path}", self.address).parse().context("its node.address is no address")?;
        let headers = request.headers_mut();
        headers.insert(NODE_HEADER, HeaderValue::from_str(&self.secret)?);
        // Nodes of this version ask for no token of each other: a file that cannot be read is none.
        if let Some(Ok(token)) = self.token_file.as_deref().map(access::read_secret) {
            headers.insert(header::AUTHORIZATION, HeaderValue::from_str(&format!("Bearer {token}"))?);
        }
        let tls = TlsConfig::builder().root_certs(RootCerts::PlatformVerifier).build();
        let agent = ureq::Agent::config_builder()
            .timeout_connect(Some(ANSWER_TIMEOUT))
            .timeout_await_100(Some(ANSWER_TIMEOUT))
            .timeout_per_write(Some(SILENCE_TIMEOUT))
            .timeout_per_read(Some(SILENCE_TIMEOUT))
            .timeout_recv_response(Some(within.map_or(WORK_TIMEOUT, |within| within.min(ANSWER_TIMEOUT))))
            .timeout_global(within)
            .http_status_as_error(false)
            .max_redirects(0)
            .tls_config(tls)
            .user_agent(concat!("nestd/", env!("CARGO_PKG_VERSION")))
            .build()
            .new_agent();
        agent.run(request).with_context(|| format!("{} does not answer", self.address))
    }
}

/// Whether a request failed before any of it was sent.
pub fn was_not_sent(failure: &anyhow::Error) -> bool {
    let refused = |error: &std::io::Error| error.kind() == std::io::ErrorKind::ConnectionRefused;
    match failure.downcast_ref::<ureq::Error>() {
        Some(ureq::Error::HostNotFound | ureq::Error::ConnectionFailed) => true,
        Some(ureq::Error::Timeout(Timeout::Connect | Timeout::Resolve)) => true,
        Some(ureq::Error::Io(error)) => refused(error),
        _ => false,
    }
}
