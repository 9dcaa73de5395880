//! A Samba server for one test: configuration, port and state are in a temporary folder; an ordinary user runs it.

use std::{
    fs,
    net::{TcpListener, TcpStream},
    os::unix::{
        fs::{PermissionsExt, chown},
        process::CommandExt,
    },
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
};

use rustix::process::{Pid, Signal, geteuid, kill_process_group};
use tempfile::TempDir;

use super::support::wait_until;

const NOBODY: u32 = 65534;

/// The server, and what its clients need.
pub struct SambaServer {
    dir: TempDir,
    port: u16,
    smbd: Child,
}

/// The path of a program, also in folders that are only in root's `PATH`.
fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    folders.extend(["/usr/sbin", "/usr/local/sbin"].map(PathBuf::from));
    folders.into_iter().map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The reason why no server can run on this machine, if there is one.
pub fn missing() -> Option<String> {
    let missing: Vec<&str> = ["smbd", "smbclient"].into_iter().filter(|name| program(name).is_none()).collect();
    (!missing.is_empty()).then(|| format!("{} is not installed (apt-get install samba smbclient)", missing.join(", ")))
}

/// The user that runs the server: an ordinary user even if the tests run as root.
fn user() -> String {
    if geteuid().is_root() {
        return "nobody".to_owned();
    }
    let id = Command::new("id").arg("-un").output().unwrap();
    String::from_utf8(id.stdout).unwrap().trim().to_owned()
}

impl SambaServer {
    /// Serves `share` as `inbox`, to guests.
    pub fn start(share: &Path) -> Self {
        let dir = TempDir::new().unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let at = dir.path().display();
        let mut text = format!(
            "[global]\nserver role = standalone server\nbind interfaces only = yes\ninterfaces = 127.0.0.1\nsmb ports = {port}\n\
             map to guest = Bad User\nguest account = {}\nunix charset = UTF-8\nsmb2 max write = 65536\ndisable netbios = yes\n\
             load printers = no\nprinting = bsd\nprintcap name = /dev/null\ndisable spoolss = yes\nlog file = {at}/log\n",
            user()
        );
        for folder in ["private", "pid", "lock", "state", "cache", "ncalrpc"] {
            let key = if folder == "pid" { "pid directory".to_owned() } else { format!("{folder} dir") };
            text += &format!("{key} = {at}/{folder}\n");
            fs::create_dir(dir.path().join(folder)).unwrap();
        }
        text = text.replace("lock dir =", "lock directory =").replace("state dir =", "state directory =");
        text = text.replace("cache dir =", "cache directory =");
        text += &format!("[inbox]\npath = {}\nguest ok = yes\nread only = no\n", share.display());
        fs::write(dir.path().join("smb.conf"), text).unwrap();
        if geteuid().is_root() {
            let mine = fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().path());
            mine.chain([dir.path().to_owned()]).for_each(|path| chown(path, Some(NOBODY), Some(NOBODY)).unwrap());
        }
        let smbd = spawn(dir.path());
        let server = Self { dir, port, smbd };
        server.wait();
        server
    }

    pub fn port(&self) -> u16 {
        self.port
    }

    fn wait(&self) {
        wait_until("smbd listens", 30.0, || TcpStream::connect(("127.0.0.1", self.port)).is_ok());
    }

    /// Kills all its processes at once.
    pub fn kill(&mut self) {
        let group = Pid::from_raw(self.smbd.id() as i32).unwrap();
        let _ = kill_process_group(group, Signal::KILL);
        self.smbd.wait().unwrap();
    }

    pub fn restart(&mut self) {
        self.kill();
        self.smbd = spawn(self.dir.path());
        self.wait();
    }

    /// A client that connects to a port and runs commands.
    pub fn client(&self, port: u16, commands: &str) -> Command {
        let mut command = Command::new(program("smbclient").unwrap());
        command.arg("-s").arg(self.dir.path().join("smb.conf")).args(["-p", &port.to_string(), "-N", "-c", commands]);
        command.arg("//127.0.0.1/inbox").current_dir(self.dir.path());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs [`SambaServer::client`] over a good connection, to its end.
    pub fn run_client(&self, commands: &str) -> Output {
        self.client(self.port, commands).output().unwrap()
    }
}

fn spawn(dir: &Path) -> Child {
    let mut command = Command::new(program("smbd").unwrap());
    command.args(["-F", "--no-process-group", "-s"]).arg(dir.join("smb.conf")).arg("-l").arg(dir);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).process_group(0);
    if geteuid().is_root() {
        command.uid(NOBODY).gid(NOBODY);
    }
    command.spawn().unwrap()
}

/// Lets the server's user enter a folder and write there.
pub fn open_to_its_user(root: &Path, share: &Path) {
    for above in share.ancestors().skip(1).take_while(|above| above.starts_with(root)) {
        fs::set_permissions(above, fs::Permissions::from_mode(0o711)).unwrap();
    }
    fs::set_permissions(share, fs::Permissions::from_mode(0o777)).unwrap();
}

impl Drop for SambaServer {
    fn drop(&mut self) {
        self.kill();
    }
}
