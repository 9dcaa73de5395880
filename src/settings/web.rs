//! Where the dashboard listens and what it may do.

use std::{fmt, net::SocketAddr, path::PathBuf};

use serde::Serialize;

use super::{inputs::WebInputs, judge::Judge};

/// Where the dashboard listens.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum Listen {
    /// An address of this server.
    Tcp(SocketAddr),
    /// A Unix socket; who may open the file may look.
    Unix(PathBuf),
    /// A socket that systemd opened (socket activation).
    Systemd,
}

/// The dashboard's settings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Web {
    /// Where it listens.
    pub listen: Listen,
    /// The file that holds the bearer token which every request must carry; `None` = none is asked for.
    pub token_file: Option<PathBuf>,
    /// Names under which browsers may ask besides those of this machine, as behind a reverse proxy.
    pub hosts: Vec<String>,
    /// Whether pages may give orders (flush, pause, resume, retry, cancel); else they only show.
    pub orders: bool,
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "http://{address}/"),
            Self::Unix(path) => write!(f, "the socket {}", path.display()),
            Self::Systemd => f.write_str("the socket that systemd opened"),
        }
    }
}

/// The dashboard's settings; `None` when it is off. What makes no sense is objected to.
pub(super) fn web(inputs: &WebInputs, judge: &mut Judge) -> Option<Web> {
    let listen = match inputs.listen.as_str() {
        "off" => return None,
        "systemd" => Listen::Systemd,
        other => match (other.strip_prefix("unix:"), other.parse()) {
            (Some(path), _) if path.starts_with('/') => Listen::Unix(path.into()),
            (None, Ok(address)) => Listen::Tcp(address),
            _ => {
                let text = format!("web.listen = \"{}\" is no address", other.escape_debug());
                let remedy = "write \"127.0.0.1:7878\", \"unix:/run/nestd/web.sock\", \"systemd\" or \"off\"";
                judge.object("web.listen", text, remedy);
                return None;
            }
        },
    };
    if let Listen::Tcp(address) = listen
        && !address.ip().is_loopback()
        && inputs.token_file.0.is_none()
    {
        let text = format!("web.listen = \"{address}\" is open to other machines, and there is no web.token_file");
        let remedy = "listen on 127.0.0.1 behind a reverse proxy, or name a file with a token of 16 letters or more";
        judge.object("web.listen", text, remedy);
    }
    Some(Web { listen, token_file: inputs.token_file.0.clone(), hosts: inputs.hosts.clone(), orders: inputs.orders })
}
