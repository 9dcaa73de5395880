//! A private PostgreSQL server for tests: in a temporary folder, reachable through a socket in it alone, stopped when the
//! test program ends, however it ends. The tests of the binary use this file, too.

use std::{
    io::Write,
    os::unix::{fs::chown, process::CommandExt},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        Mutex, OnceLock,
        atomic::{AtomicU32, Ordering},
    },
    time::{Duration, Instant},
};

use sqlx::{AssertSqlSafe, Connection, PgConnection};

/// The user that the server runs as when the tests run as root, which it refuses.
const ORDINARY_USER: u32 = 65534;

/// A running server.
pub struct PostgresCluster {
    folder: PathBuf,
    programs: PathBuf,
    /// They stop when their input closes.
    servers: Mutex<Vec<Child>>,
    databases: AtomicU32,
    /// Whether a commit waits for the disk. Tests need not.
    is_durable: bool,
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
    SHARED.get_or_init(PostgresCluster::start)
}

impl PostgresCluster {
    /// Makes a cluster and starts its server.
    pub fn start() -> Self {
        Self::start_with(false)
    }

    /// The same. `is_durable` = a commit waits for the disk, as in production.
    pub fn start_with(is_durable: bool) -> Self {
        let programs = find_programs().expect("PostgreSQL is installed");
        let folder = tempfile::Builder::new().prefix("nestd-postgres-").tempdir().expect("a folder can be made").keep();
        if rustix::process::getuid().is_root() {
            chown(&folder, Some(ORDINARY_USER), Some(ORDINARY_USER)).expect("the folder can be given away");
        }
        let cluster = Self { folder, programs, servers: Mutex::default(), databases: AtomicU32::new(0), is_durable };
        cluster.run("initdb", &["--no-sync", "--auth=trust", "--username=nestd", "--encoding=UTF8"]);
        cluster.configure("listen_addresses = ''");
        cluster.start_server();
        cluster
    }

    fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    /// Runs one of PostgreSQL's programs on the cluster.
    fn run(&self, program: &str, args: &[&str]) {
        let mut command = Command::new(self.programs.join(program));
        let status = as_ordinary_user(command.args(args).arg("-D").arg(self.data())).status();
        assert!(status.expect("the program runs").success(), "{program} failed");
    }

    /// Starts the server, also after [`PostgresCluster::stop_server`].
    pub fn start_server(&self) {
        let mut server = Command::new("/bin/sh");
        server.arg("-c").arg("\"$0\" \"$@\" & server=$!; read _; kill -QUIT $server; wait; rm -rf \"$FOLDER\"");
        server.arg(self.programs.join("postgres")).arg("-D").arg(self.data()).arg("-k").arg(&self.folder);
        server.args(["-c", "max_connections=400"]);
        server.args(["-c", if self.is_durable { "fsync=on" } else { "fsync=off" }]);
        as_ordinary_user(server.env("FOLDER", &self.folder).stdin(Stdio::piped()).process_group(0));
        self.servers.lock().expect("no test panicked here").push(server.spawn().expect("the server starts"));
    }

    /// Adds lines to the configuration, for the next start.
    fn configure(&self, lines: &str) {
        let file = std::fs::File::options().append(true).open(self.data().join("postgresql.conf"));
        writeln!(file.expect("it is there"), "{lines}").expect("it can be written");
    }

    /// Has the server listen on loopback, for TLS alone, with a certificate of its own for `localhost`. Returns port and certificate.
    pub fn encrypt(&self) -> (u16, PathBuf) {
        let free = std::net::TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr());
        let port = free.expect("a port is free").port();
        let [key, certificate] = ["server.key", "server.crt"].map(|name| self.data().join(name));
        let mut openssl = Command::new("openssl");
        openssl.args(["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]);
        openssl.args(["-addext", "subjectAltName=DNS:localhost", "-addext", "basicConstraints=critical,CA:FALSE"]);
        openssl.arg("-keyout").arg(&key).arg("-out").arg(&certificate).stderr(Stdio::null());
        assert!(as_ordinary_user(&mut openssl).status().expect("openssl is installed").success());
        self.stop_server();
        self.configure(&format!("listen_addresses = '127.0.0.1'\nport = {port}\nssl = on"));
        std::fs::write(self.data().join("pg_hba.conf"), "hostssl all all 127.0.0.1/32 trust\n")
            .expect("it can be written");
        self.start_server();
        (port, certificate)
    }

    /// Has the server ask a user for a password, once its configuration was read again.
    pub fn demand_password(&self, user: &str) {
        let rules = format!("local all {user} scram-sha-256\nlocal all all trust\n");
        std::fs::write(self.data().join("pg_hba.conf"), rules).expect("it can be written");
    }

    /// Stops the server, as an administrator would.
    pub fn stop_server(&self) {
        self.run("pg_ctl", &["stop", "-m", "fast", "-w"]);
    }

    /// Ends the server as a crash does: it recovers when it starts again.
    pub fn crash_server(&self) {
        self.run("pg_ctl", &["stop", "-m", "immediate", "-w"]);
    }

    /// Keeps a copy of the data as they are now, as a standby has them. The server is stopped and started for it.
    pub fn keep_standby(&self) {
        self.stop_server();
        let _ = std::fs::remove_dir_all(self.standby());
        self.copy_data(&self.data(), &self.standby());
        self.start_server();
    }

    /// Ends the server, and promotes the standby in its place: what was committed since is lost.
    pub fn promote_standby(&self) {
        self.crash_server();
        std::fs::remove_dir_all(self.data()).expect("the server has ended");
        self.copy_data(&self.standby(), &self.data());
        self.start_server();
    }

    fn standby(&self) -> PathBuf {
        self.folder.join("standby")
    }

    fn copy_data(&self, from: &Path, to: &Path) {
        let copied = as_ordinary_user(Command::new("cp").arg("-a").arg(from).arg(to)).status();
        assert!(copied.expect("cp runs").success(), "the data cannot be copied");
    }

    /// The address of a database.
    pub fn url(&self, database: &str) -> String {
        Self::url_in(&self.folder, database)
    }

    /// The address of a database on the server whose socket is in a folder.
    pub fn url_in(folder: &Path, database: &str) -> String {
        format!("postgres://nestd@localhost/{database}?host={}", folder.display())
    }

    /// The folder with the socket of the server.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Connects to a database, once the server answers.
    pub async fn connect(&self, database: &str) -> PgConnection {
        let deadline = Instant::now() + Duration::from_secs(60);
        loop {
            match PgConnection::connect(&self.url(database)).await {
                Ok(connection) => return connection,
                Err(error) => assert!(Instant::now() < deadline, "{error}"),
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    /// Makes an empty database, or a copy of another one. Returns its name.
    pub async fn make_database(&self, template: Option<&str>) -> String {
        let name = format!("test_{}", self.databases.fetch_add(1, Ordering::SeqCst));
        let create = format!("CREATE DATABASE {name} TEMPLATE {}", template.unwrap_or("template0"));
        // A connection belongs to the runtime of one test.
        let mut admin = self.connect("postgres").await;
        sqlx::query(AssertSqlSafe(create)).execute(&mut admin).await.expect("a database can be made");
        name
    }
}

fn as_ordinary_user(program: &mut Command) -> &mut Command {
    if rustix::process::getuid().is_root() {
        program.uid(ORDINARY_USER).gid(ORDINARY_USER);
    }
    program.current_dir(Path::new("/")).stdout(Stdio::null()).stderr(Stdio::null())
}
