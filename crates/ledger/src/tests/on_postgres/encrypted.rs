//! A server on a network is reached over TLS.

use std::time::{Duration, Instant};

use super::*;
use crate::postgres_cluster::PostgresCluster;

#[tokio::test]
async fn a_server_is_reached_over_tls_and_one_that_is_not_trusted_or_not_encrypted_is_refused() {
    let server = PostgresCluster::start();
    let database = server.make_database(None).await;
    let (port, certificate) = server.encrypt();
    let address =
        |options: &str| LedgerAddress::parse(&format!("postgres://nestd@localhost:{port}/{database}?{options}"), None);
    let trusted = address(&format!("sslmode=verify-full&sslrootcert={}", certificate.display()));
    let deadline = Instant::now() + Duration::from_secs(30);
    let ledger = loop {
        match Ledger::open(&trusted).await {
            Ok(ledger) => break ledger,
            Err(error) => assert!(Instant::now() < deadline, "{error}"),
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    };
    let is_encrypted = sql::query_scalar("SELECT ssl FROM pg_stat_ssl WHERE pid = pg_backend_pid()");
    let is_encrypted: bool = is_encrypted.fetch_one(ledger.reader().unwrap()).await.unwrap();
    assert!(is_encrypted);
    waiting(&ledger, "a", 1).await;
    ledger.close().await;
    let error = async |options| Ledger::open(&address(options)).await.unwrap_err().to_string();
    let untrusted = error("sslmode=verify-full").await;
    assert!(untrusted.contains("certificate"), "{untrusted}");
    let plain = error("sslmode=disable").await;
    assert!(plain.contains("no encryption"), "{plain}");
}
