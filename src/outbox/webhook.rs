//! The webhook: a message is posted as JSON, signed so that the receiver knows that it is ours and not an old one said again.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use ureq::tls::{RootCerts, TlsConfig};

use super::Message;
use crate::{access, settings::Webhook};

/// Names of the headers.
const SIGNATURE: &str = "Nestd-Signature";
const ID: &str = "Nestd-Id";
const EVENT: &str = "Nestd-Event";

/// The header that signs a body: the time in seconds since 1970, and HMAC-SHA256, in hex, of that time, a dot and the body.
pub fn signature(secret: &str, at_secs: i64, body: &str) -> String {
    // HMAC takes a key of any length.
    let mac = Hmac::<Sha256>::new_from_slice(secret.as_bytes()).map(|mac| {
        let mac = mac.chain_update(at_secs.to_string()).chain_update(".").chain_update(body);
        mac.finalize().into_bytes()
    });
    let hex: String = mac.unwrap_or_default().iter().map(|byte| format!("{byte:02x}")).collect();
    format!("t={at_secs},v1={hex}")
}

/// Posts a message; whatever is not answered with success in time has not been told.
pub(super) fn post(webhook: &Webhook, timeout: Duration, message: &Message) -> Result<()> {
    // Read each time, so that a new key needs no restart.
    let secret = access::read_secret(&webhook.secret_file)?;
    let now = jiff::Timestamp::now().as_second();
    let tls = TlsConfig::builder().root_certs(RootCerts::PlatformVerifier).build();
    let agent = ureq::Agent::config_builder()
        .timeout_global(Some(timeout))
        .http_status_as_error(false)
        // A redirect is not the receiver that was configured.
        .max_redirects(0)
        .tls_config(tls)
        .user_agent(concat!("nestd/", env!("CARGO_PKG_VERSION")))
        .build()
        .new_agent();
    let answer = agent
        .post(&webhook.url)
        .header("Content-Type", "application/json")
        .header(ID, &message.id)
        .header(EVENT, message.kind)
        .header(SIGNATURE, signature(&secret, now, &message.body))
        .send(&message.body)
        .with_context(|| format!("posting to {}", place(&webhook.url)))?;
    let status = answer.status();
    ensure!(status.is_success(), "{} answers {status}", place(&webhook.url));
    Ok(())
}

/// Scheme and host of an address: the rest of it is often as good as a password.
fn place(url: &str) -> String {
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let host = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    format!("{scheme}://{host}")
}

#[cfg(test)]
mod tests {
    use super::place;

    #[test]
    fn what_is_told_of_an_address_holds_no_password() {
        assert_eq!(
            place("https://me:word@hooks.example.com:8443/services/T0/B1/secret?key=x"),
            "https://hooks.example.com:8443"
        );
        assert_eq!(place("http://[::1]:80"), "http://[::1]:80");
        assert_eq!(place("https://a.example?token=x@y"), "https://a.example");
    }
}
