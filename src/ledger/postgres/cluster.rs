//! A private PostgreSQL server for tests: in a temporary folder, reachable through a socket in it alone, stopped when the
//! test program ends, however it ends.

use std::{
    os::unix::{fs::chown, process::CommandExt},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        OnceLock,
        atomic::{AtomicU32, Ordering},
    },
    time::{Duration, Instant},
};

use sqlx::{AssertSqlSafe, Connection, PgConnection, postgres::PgConnectOptions};
use tokio::sync::Mutex;

use crate::ledger::Ledger;

/// The user that the server runs as when the tests run as root, which it refuses.
const ORDINARY_USER: u32 = 65534;
/// The database that each test's database is a copy of.
const TEMPLATE: &str = "template_of_tests";

/// A running server.
pub struct PostgresCluster {
    folder: PathBuf,
    /// It stops when its input closes.
    _server: Child,
    databases: AtomicU32,
    is_template_there: Mutex<bool>,
}

/// The folder with the programs of the newest PostgreSQL on this computer, if there is one.
pub fn find_programs() -> Option<PathBuf> {
    let versions = std::fs::read_dir("/usr/lib/postgresql").ok()?;
    let programs = versions.filter_map(|entry| Some(entry.ok()?.path().join("bin")));
    programs.filter(|folder| folder.join("initdb").exists()).max()
}

/// The server of this test program, started by the first test that asks for it.
pub fn shared() -> &'static PostgresCluster {
    static SHARED: OnceLock<PostgresCluster> = OnceLock::new();
    SHARED.get_or_init(|| PostgresCluster::start(&find_programs().expect("PostgreSQL is installed")))
}

impl PostgresCluster {
    fn start(programs: &Path) -> Self {
        let folder = tempfile::Builder::new().prefix("nestd-postgres-").tempdir().expect("a folder can be made").keep();
        let is_root = rustix::process::getuid().is_root();
        if is_root {
            chown(&folder, Some(ORDINARY_USER), Some(ORDINARY_USER)).expect("the folder can be given away");
        }
        let as_ordinary_user = |program: &mut Command| {
            if is_root {
                program.uid(ORDINARY_USER).gid(ORDINARY_USER);
            }
            program.current_dir("/").stdout(Stdio::null()).stderr(Stdio::null());
        };
        let data = folder.join("data");
        let mut initdb = Command::new(programs.join("initdb"));
        as_ordinary_user(
            initdb.args(["--no-sync", "--auth=trust", "--username=nestd", "--encoding=UTF8", "-D"]).arg(&data),
        );
        assert!(initdb.status().expect("initdb runs").success(), "initdb failed");
        let mut server = Command::new("/bin/sh");
        server.arg("-c").arg("\"$0\" \"$@\" & server=$!; read _; kill -QUIT $server; wait; rm -rf \"$FOLDER\"");
        server.arg(programs.join("postgres")).arg("-D").arg(&data).arg("-k").arg(&folder);
        server.args(["-c", "listen_addresses=", "-c", "fsync=off", "-c", "max_connections=400"]);
        as_ordinary_user(server.env("FOLDER", &folder).stdin(Stdio::piped()).process_group(0));
        let server = server.spawn().expect("the server starts");
        Self { folder, _server: server, databases: AtomicU32::new(0), is_template_there: Mutex::new(false) }
    }

    fn options(&self, database: &str) -> PgConnectOptions {
        PgConnectOptions::new_without_pgpass().socket(&self.folder).username("nestd").database(database)
    }

    async fn connect(&self, database: &str) -> PgConnection {
        let deadline = Instant::now() + Duration::from_secs(60);
        loop {
            match PgConnection::connect_with(&self.options(database)).await {
                Ok(connection) => return connection,
                Err(error) => assert!(Instant::now() < deadline, "{error}"),
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    /// Makes a database with an empty ledger, and opens it.
    pub async fn open_ledger(&self) -> Ledger {
        let name = format!("test_{}", self.databases.fetch_add(1, Ordering::SeqCst));
        let create = format!("CREATE DATABASE {name} TEMPLATE {TEMPLATE}");
        // A connection belongs to the runtime of one test.
        let mut admin = self.connect("postgres").await;
        let mut is_template_there = self.is_template_there.lock().await;
        if !*is_template_there {
            let create = format!("CREATE DATABASE {TEMPLATE}");
            sqlx::query(AssertSqlSafe(create)).execute(&mut admin).await.expect("a database can be made");
            Ledger::open_postgres(self.options(TEMPLATE)).await.expect("it can be migrated").close().await;
            *is_template_there = true;
        }
        sqlx::query(AssertSqlSafe(create)).execute(&mut admin).await.expect("a database can be made");
        Ledger::open_postgres(self.options(&name)).await.expect("it can be opened")
    }
}
