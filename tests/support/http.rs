//! Requests to a dashboard on a Unix socket, as a program sends them.

use std::{
    io::{Read, Write},
    os::unix::net::UnixStream,
    path::Path,
    time::Duration,
};

use serde_json::Value;

/// What the daemon answered.
#[derive(Debug, Clone, PartialEq)]
pub struct HttpAnswer {
    pub status: u16,
    /// The head, in lower case.
    pub head: String,
    pub body: String,
}

impl HttpAnswer {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The value of a header.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
    }
}

/// Sends a request; `None` = the daemon ended before it answered. `words` = method and path, and headers, one a line.
pub fn send_request(socket: &Path, words: &str, body: &[u8]) -> Option<HttpAnswer> {
    let mut stream = open_request(socket, words, body.len())?;
    // The daemon may answer, and close, before it has read all.
    _ = stream.write_all(body);
    read_answer(stream)
}

/// Sends the head of a request with a body of `bytes` bytes, which is to follow.
pub fn open_request(socket: &Path, words: &str, bytes: usize) -> Option<UnixStream> {
    let (first, headers) = words.split_once('\n').unwrap_or((words, ""));
    let headers: String = headers.lines().map(|line| format!("{}\r\n", line.trim())).collect();
    let mut stream = UnixStream::connect(socket).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let head =
        format!("{first} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {bytes}\r\n{headers}\r\n");
    stream.write_all(head.as_bytes()).ok()?;
    Some(stream)
}

pub fn read_answer(mut stream: UnixStream) -> Option<HttpAnswer> {
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (head, body) = text.split_once("\r\n\r\n")?;
    let status = head.split(' ').nth(1)?.parse().ok()?;
    Some(HttpAnswer { status, head: head.replace("\r\n", "\n").to_lowercase(), body: body.to_owned() })
}
