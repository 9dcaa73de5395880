//! Settings of the dashboard: where it listens and what it may do.

use std::{
    fmt,
    net::{IpAddr, SocketAddr},
    path::PathBuf,
};

use access::Role;
use serde::Serialize;

use super::inputs::WebInputs;
use crate::reading::validator::ConfigValidator;

/// Where the dashboard listens.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum ListenAddress {
    /// An address of this server.
    Tcp(SocketAddr),
    /// A Unix socket. Everyone who may open the file has access.
    Unix(PathBuf),
    /// A socket that systemd opened (socket activation).
    Systemd,
}

/// The dashboard's settings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WebSettings {
    /// Where it listens.
    pub listen: ListenAddress,
    /// File with the bearer token that every request must carry; `None` = no token is required.
    pub token_file: Option<PathBuf>,
    /// File with the tokens of clients that have names and roles; `None` = there are none.
    pub tokens_file: Option<PathBuf>,
    /// Whether people have to sign in also while there are none.
    pub sign_in: bool,
    /// What requests may that come without a token and from nobody who is signed in; `None` = nothing.
    pub without_token: Option<Role>,
    /// Requests per second that a client may send for long.
    pub client_requests_per_sec: f64,
    /// Requests that a client may send at once.
    pub client_burst: u32,
    /// Bytes of files that a client may have under way.
    pub client_bytes: u64,
    /// Additional host names that browsers may use besides those of this machine, for instance behind a reverse proxy.
    pub hosts: Vec<String>,
    /// Whether pages may send commands (flush, pause, resume, retry, cancel). Otherwise they are read-only.
    pub orders: bool,
    /// Header in which a reverse proxy names the user, in lower case; `None` = nobody does.
    pub user_header: Option<String>,
    /// Addresses of the proxies that are believed; none = whatever runs on this server.
    pub user_header_from: Vec<IpAddr>,
}

impl fmt::Display for ListenAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "http://{address}/"),
            Self::Unix(path) => write!(f, "the socket {}", path.display()),
            Self::Systemd => f.write_str("the socket that systemd opened"),
        }
    }
}

/// Validates the dashboard's settings. `None` if it is off. Reports problems.
pub(crate) fn validate_web(inputs: &WebInputs, validator: &mut ConfigValidator) -> Option<WebSettings> {
    let listen = match inputs.listen.as_str() {
        "off" => return None,
        "systemd" => ListenAddress::Systemd,
        other => match (other.strip_prefix("unix:"), other.parse()) {
            (Some(path), _) if path.starts_with('/') => ListenAddress::Unix(path.into()),
            (None, Ok(address)) => ListenAddress::Tcp(address),
            _ => {
                let text = format!("web.listen = \"{}\" is no address", other.escape_debug());
                let remedy = "write \"127.0.0.1:7878\", \"unix:/run/nestd/web.sock\", \"systemd\" or \"off\"";
                validator.report_problem("web.listen", text, remedy);
                return None;
            }
        },
    };
    if let ListenAddress::Tcp(address) = listen
        && !address.ip().is_loopback()
        && inputs.token_file.0.is_none()
        && inputs.tokens_file.0.is_none()
        && !inputs.sign_in
    {
        let text = format!(
            "web.listen = \"{address}\" is open to other machines, and there is no web.token_file or web.tokens_file, and \
             web.sign_in is not set"
        );
        let remedy = "listen on 127.0.0.1 behind a reverse proxy, have people sign in (sign_in = true), or name a file with a token of \
                      16 letters or more";
        validator.report_problem("web.listen", text, remedy);
    }
    Some(WebSettings {
        user_header: validate_user_header(inputs, &listen, validator),
        user_header_from: validate_proxies(inputs, validator),
        sign_in: inputs.sign_in,
        listen,
        token_file: inputs.token_file.0.clone(),
        tokens_file: inputs.tokens_file.0.clone(),
        without_token: validate_without_token(inputs, validator),
        client_requests_per_sec: validate_rate(inputs, validator),
        client_burst: inputs.client_burst.max(1),
        client_bytes: inputs.client_bytes,
        hosts: inputs.hosts.clone(),
        orders: inputs.orders,
    })
}

/// A rate of 0 would answer nobody.
fn validate_rate(inputs: &WebInputs, validator: &mut ConfigValidator) -> f64 {
    let rate = inputs.client_requests_per_sec;
    if !(0.1..=1e6).contains(&rate) {
        let text = format!("web.client_requests_per_sec = {rate} is no rate");
        validator.report_problem("web.client_requests_per_sec", text, "write 0.1 to 1000000");
        return 1.0;
    }
    rate
}

/// Whoever can connect has no token.
fn validate_without_token(inputs: &WebInputs, validator: &mut ConfigValidator) -> Option<Role> {
    match inputs.without_token.as_str() {
        "nothing" => None,
        "read" => Some(Role::Read),
        "order" => Some(Role::Order),
        other => {
            let text = format!("web.without_token = \"{}\" is no role for it", other.escape_debug());
            validator.report_problem("web.without_token", text, "write \"nothing\", \"read\" or \"order\"");
            None
        }
    }
}

/// The addresses of proxies.
fn validate_proxies(inputs: &WebInputs, validator: &mut ConfigValidator) -> Vec<IpAddr> {
    let mut addresses = Vec::new();
    for text in &inputs.user_header_from {
        match text.parse::<IpAddr>() {
            Ok(address) => addresses.push(address.to_canonical()),
            Err(_) => {
                let problem = format!("web.user_header_from = \"{}\" is no address", text.escape_debug());
                validator.report_problem("web.user_header_from", problem, "write addresses, [\"10.0.0.5\"]");
            }
        }
    }
    addresses
}

/// A name in a header is believed from programs of this server, or from the proxies that are named.
fn validate_user_header(inputs: &WebInputs, listen: &ListenAddress, validator: &mut ConfigValidator) -> Option<String> {
    let header = inputs.user_header.0.as_ref()?;
    let is_name = !header.is_empty() && header.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
    if !is_name {
        let text = format!("web.user_header = \"{}\" is no name of a header", header.escape_debug());
        validator.report_problem("web.user_header", text, "write \"X-Remote-User\", or \"off\"");
    }
    if let ListenAddress::Tcp(address) = listen
        && !address.ip().is_loopback()
        && inputs.user_header_from.is_empty()
    {
        let text = format!(
            "web.user_header is set, web.listen = \"{address}\", and no address of web.user_header_from is believed"
        );
        let remedy = "listen on 127.0.0.1 behind the reverse proxy that sets the header, or name its address in web.user_header_from";
        validator.report_problem("web.user_header", text, remedy);
    }
    is_name.then(|| header.to_ascii_lowercase())
}
