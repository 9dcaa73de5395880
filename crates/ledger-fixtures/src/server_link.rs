//! The connection of a node to the database server, as a network that becomes slow, silent, or breaks. The reliability run uses this file, too.

use std::{
    io::{Read, Write},
    net::Shutdown,
    os::unix::net::{UnixListener, UnixStream},
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use tempfile::TempDir;

/// Name of the socket of a server in its folder.
const SOCKET: &str = ".s.PGSQL.5432";
/// While a link is silent, it looks this often whether it still is.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// How a link is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkState {
    Clear,
    /// Each portion of data is late by this.
    Slow(Duration),
    /// Connections stay, and nothing comes through.
    Silent,
    /// Nothing comes through the connections that are open, ever; new ones are clear.
    Forgotten,
    /// Connections break, and new ones are refused.
    Broken,
}

/// A link to a server.
pub struct ServerLink {
    folder: TempDir,
    shared: Arc<SharedLink>,
}

struct SharedLink {
    state: Mutex<LinkState>,
    streams: Mutex<Vec<UnixStream>>,
    /// So many streams are of connections that are forgotten.
    forgotten: AtomicUsize,
    server: PathBuf,
}

impl ServerLink {
    /// A clear link to the server with its socket in a folder.
    pub fn to_server(server: &Path) -> Self {
        let folder = TempDir::new().unwrap();
        let listener = UnixListener::bind(folder.path().join(SOCKET)).unwrap();
        let (state, streams, forgotten) = (Mutex::new(LinkState::Clear), Mutex::default(), AtomicUsize::default());
        let shared = Arc::new(SharedLink { state, streams, forgotten, server: server.join(SOCKET) });
        let accepting = shared.clone();
        std::thread::spawn(move || {
            for client in listener.incoming().flatten() {
                accepting.connect(client);
            }
        });
        Self { folder, shared }
    }

    /// The folder in which the link is the server.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Changes how the link is.
    pub fn set(&self, state: LinkState) {
        *self.shared.state.lock().unwrap() = state;
        if state == LinkState::Forgotten {
            self.shared.forgotten.store(self.shared.streams.lock().unwrap().len(), Ordering::Relaxed);
        }
        if state == LinkState::Broken {
            self.shared.forgotten.store(0, Ordering::Relaxed);
            for stream in self.shared.streams.lock().unwrap().drain(..) {
                // It may have ended.
                let _ = stream.shutdown(Shutdown::Both);
            }
        }
    }
}

impl SharedLink {
    fn state(&self) -> LinkState {
        *self.state.lock().unwrap()
    }

    /// Connects a client, unless the link is broken or the server is away.
    fn connect(self: &Arc<Self>, client: UnixStream) {
        if self.state() == LinkState::Broken {
            return;
        }
        let Ok(server) = UnixStream::connect(&self.server) else { return };
        let mut streams = self.streams.lock().unwrap();
        for (from, to) in [(&client, &server), (&server, &client)] {
            let (from, to, link) = (from.try_clone().unwrap(), to.try_clone().unwrap(), self.clone());
            let number = streams.len();
            std::thread::spawn(move || link.pass_on(number, from, to));
        }
        streams.extend([client, server]);
    }

    fn pass_on(&self, number: usize, mut from: UnixStream, mut to: UnixStream) {
        let mut portion = [0; 65_536];
        while let Ok(count @ 1..) = from.read(&mut portion) {
            if let LinkState::Slow(delay) = self.state() {
                std::thread::sleep(delay);
            }
            while self.state() == LinkState::Silent {
                std::thread::sleep(LOOK_AGAIN);
            }
            if number < self.forgotten.load(Ordering::Relaxed) {
                return; // both ends stay open
            }
            if to.write_all(&portion[..count]).is_err() {
                break;
            }
        }
        let _ = to.shutdown(Shutdown::Both);
    }
}
