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
        .with_context(|| format!("posting to {}", webhook.url))?;
    let status = answer.status();
    ensure!(status.is_success(), "{} answers {status}", webhook.url);
    Ok(())
}
