//! Another node of the farm, as it is asked over HTTP: for the files that lie there, for what it sees in its queue folders, and for
//! whatever a page or program wants of its machines. All nodes have the same token.

use std::{path::PathBuf, time::Duration};

use anyhow::{Context, Result, bail};
use ledger::{Ledger, LedgerError, NodeRow};
use settings::{MachineProfile, Settings};
use ureq::{
    AsSendBody, Body,
    http::{HeaderValue, Request, Response, StatusCode, header},
    tls::{RootCerts, TlsConfig},
};

/// A node without an answer for this long is asked again later.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);

/// Another node.
#[derive(Debug, Clone)]
pub struct NodeClient {
    /// Its name.
    pub name: String,
    /// Where its pages are; "" = its settings have no `node.address`.
    address: String,
    /// Whether it runs, by its heartbeats.
    pub is_alive: bool,
    token_file: Option<PathBuf>,
}

impl NodeClient {
    /// The node of a row of the ledger.
    pub(crate) fn of_row(settings: &Settings, row: NodeRow) -> Self {
        let token_file = settings.interfaces.web.as_ref().and_then(|web| web.token_file.clone());
        Self { name: row.name, address: row.address, is_alive: row.alive, token_file }
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
        let row = ledger.find_node(&machine.of_node).await?;
        Ok(row.map(|row| Self::of_row(settings, row)))
    }

    /// The other nodes that run.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn others(settings: &Settings, ledger: &Ledger) -> Result<Vec<Self>, LedgerError> {
        if ledger.file().is_some() {
            return Ok(Vec::new());
        }
        let rows = ledger.list_nodes().await?.into_iter().filter(|row| row.alive && row.name != settings.node.name);
        Ok(rows.map(|row| Self::of_row(settings, row)).collect())
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
            status => bail!("{} answers {status}", self.address),
        }
    }

    /// Sends a request whose address is a path, as the farm's own, and waits for the head of its answer. `within` limits both ways together;
    /// `None` = as long as bytes come.
    ///
    /// # Errors
    /// It cannot be reached, does not answer, or has another token.
    pub fn send(&self, mut request: Request<impl AsSendBody>, within: Option<Duration>) -> Result<Response<Body>> {
        if self.address.is_empty() {
            bail!("its settings have no node.address");
        }
        let path = request.uri().path_and_query().map_or("/", |path| path.as_str());
        *request.uri_mut() = format!("{}{path}", self.address).parse().context("its node.address is no address")?;
        if let Some(file) = &self.token_file {
            let token = HeaderValue::from_str(&format!("Bearer {}", access::read_secret(file)?))?;
            request.headers_mut().insert(header::AUTHORIZATION, token);
        }
        let tls = TlsConfig::builder().root_certs(RootCerts::PlatformVerifier).build();
        let agent = ureq::Agent::config_builder()
            .timeout_connect(Some(ANSWER_TIMEOUT))
            .timeout_recv_response(within.map(|within| within.min(ANSWER_TIMEOUT)))
            .timeout_global(within)
            .http_status_as_error(false)
            .max_redirects(0)
            .tls_config(tls)
            .user_agent(concat!("nestd/", env!("CARGO_PKG_VERSION")))
            .build()
            .new_agent();
        let answer = agent.run(request).with_context(|| format!("{} does not answer", self.address))?;
        if answer.status() == StatusCode::UNAUTHORIZED {
            bail!("{} asks for another token: give all nodes the same web.token_file", self.address);
        }
        Ok(answer)
    }
}
