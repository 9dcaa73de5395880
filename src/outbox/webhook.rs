//! Delivery to a webhook: the message is posted as JSON with a signature, so that the receiver can refuse forged and
//! replayed messages.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use hmac::{Hmac, KeyInit, Mac};
use settings::WebhookSettings;
use sha2::Sha256;
use ureq::tls::{RootCerts, TlsConfig};

use super::EventMessage;

/// Header names.
const SIGNATURE: &str = "Nestd-Signature";
const ID: &str = "Nestd-Id";
const EVENT: &str = "Nestd-Event";

/// The value of the signature header: the time in seconds since 1970, and HMAC-SHA256 in hex of that time, a dot and
/// the body.
pub fn sign_body(secret: &str, at_secs: i64, body: &str) -> String {
    // HMAC accepts a key of any length.
    let mac = Hmac::<Sha256>::new_from_slice(secret.as_bytes()).map(|mac| {
        let mac = mac.chain_update(at_secs.to_string()).chain_update(".").chain_update(body);
        mac.finalize().into_bytes()
    });
    let hex: String = mac.unwrap_or_default().iter().map(|byte| format!("{byte:02x}")).collect();
    format!("t={at_secs},v1={hex}")
}

/// Posts a message. It counts as delivered only if a success status arrives in time.
pub(super) fn post_message(webhook: &WebhookSettings, timeout: Duration, message: &EventMessage) -> Result<()> {
    // Read at each request, so that a new key needs no restart.
    let secret = access::read_secret(&webhook.secret_file)?;
    let now = jiff::Timestamp::now().as_second();
    let tls = TlsConfig::builder().root_certs(RootCerts::PlatformVerifier).build();
    let agent = ureq::Agent::config_builder()
        .timeout_global(Some(timeout))
        .http_status_as_error(false)
        // A redirect would lead to a receiver that is not configured.
        .max_redirects(0)
        .tls_config(tls)
        .user_agent(concat!("nestd/", env!("CARGO_PKG_VERSION")))
        .build()
        .new_agent();
    let answer = agent
        .post(&webhook.url)
        .header("Content-Type", "application/json")
        .header(ID, &message.id)
        .header(EVENT, message.kind.word())
        .header(SIGNATURE, sign_body(&secret, now, &message.body))
        .send(&message.body)
        .with_context(|| format!("posting to {}", redact_url(&webhook.url)))?;
    let status = answer.status();
    ensure!(status.is_success(), "{} answers {status}", redact_url(&webhook.url));
    Ok(())
}

/// Scheme and host of a URL. The rest of it often contains a secret.
fn redact_url(url: &str) -> String {
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let host = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    format!("{scheme}://{host}")
}

#[cfg(test)]
mod tests {
    use super::redact_url;

    #[test]
    fn a_reported_address_contains_no_password() {
        assert_eq!(
            redact_url("https://me:word@hooks.example.com:8443/services/T0/B1/secret?key=x"),
            "https://hooks.example.com:8443"
        );
        assert_eq!(redact_url("http://[::1]:80"), "http://[::1]:80");
        assert_eq!(redact_url("https://a.example?token=x@y"), "https://a.example");
    }
}
