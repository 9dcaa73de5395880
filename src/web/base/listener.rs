//! The socket on which the dashboard listens.

use std::{
    os::unix::{fs::FileTypeExt, net::UnixStream},
    path::Path,
};

use anyhow::{Context, Result, bail, ensure};
use settings::ListenAddress;
use tokio::net::{TcpListener, UnixListener};

/// Removes the socket file of a daemon that no longer runs. Fails when another process still listens on it.
fn remove_stale_socket(path: &Path) -> Result<()> {
    if !std::fs::symlink_metadata(path).is_ok_and(|meta| meta.file_type().is_socket()) {
        return Ok(());
    }
    ensure!(UnixStream::connect(path).is_err(), "somebody else listens there");
    Ok(std::fs::remove_file(path)?)
}

/// A bound listening socket.
pub(crate) enum DashboardListener {
    Tcp(TcpListener),
    Unix(UnixListener),
}

impl DashboardListener {
    pub(crate) async fn bind_socket(listen: &ListenAddress) -> Result<Self> {
        let cannot = || format!("listening on {listen}");
        match listen {
            ListenAddress::Tcp(address) => TcpListener::bind(address).await.map(Self::Tcp).with_context(cannot),
            ListenAddress::Unix(path) => {
                remove_stale_socket(path).with_context(cannot)?;
                UnixListener::bind(path).map(Self::Unix).with_context(cannot)
            }
            ListenAddress::Systemd => Self::from_systemd().with_context(cannot),
        }
    }

    /// Requires a token when the socket can be reached from other machines, no matter who opened the socket.
    pub(crate) fn require_token(&self, has_tokens: bool) -> Result<()> {
        let Self::Tcp(listener) = self else { return Ok(()) };
        let address = listener.local_addr()?;
        ensure!(
            has_tokens || address.ip().is_loopback(),
            "{address} can be reached from other machines: have people sign in (web.sign_in = true), set web.tokens_file or web.token_file, or listen to this machine only"
        );
        Ok(())
    }

    fn from_systemd() -> Result<Self> {
        let mut sockets = listenfd::ListenFd::from_env();
        if let Ok(Some(socket)) = sockets.take_tcp_listener(0) {
            socket.set_nonblocking(true)?;
            return Ok(Self::Tcp(TcpListener::from_std(socket)?));
        }
        if let Ok(Some(socket)) = sockets.take_unix_listener(0) {
            socket.set_nonblocking(true)?;
            return Ok(Self::Unix(UnixListener::from_std(socket)?));
        }
        bail!("systemd passed no socket: start nestd by its socket unit")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn whoever_opened_the_socket_other_machines_ask_only_with_a_token() {
        for (address, reachable) in [("127.0.0.1:0", false), ("[::1]:0", false), ("0.0.0.0:0", true)] {
            let Ok(listener) = TcpListener::bind(address).await else { continue };
            let listener = DashboardListener::Tcp(listener);
            assert_eq!(listener.require_token(false).is_err(), reachable, "{address}");
            assert!(listener.require_token(true).is_ok());
        }
    }

    #[tokio::test]
    async fn a_socket_that_answers_is_left_and_one_that_is_left_over_goes() {
        let folder = tempfile::tempdir().unwrap();
        let listen = ListenAddress::Unix(folder.path().join("web.sock"));
        let first = DashboardListener::bind_socket(&listen).await.unwrap();
        let refused = DashboardListener::bind_socket(&listen).await.map(drop).unwrap_err();
        assert!(format!("{refused:#}").contains("somebody else"), "{refused:#}");
        drop(first);
        assert!(DashboardListener::bind_socket(&listen).await.is_ok());
    }
}
