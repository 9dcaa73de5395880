//! A web server on loopback that hears messages, and answers as it is told to.
#![allow(dead_code)] // no test that has this file needs all of it

use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;

/// What one request said.
#[derive(Debug, Clone)]
pub struct Heard {
    /// Names in small letters, and values.
    pub headers: Vec<(String, String)>,
    /// The body as it came.
    pub body: String,
    /// What was answered; 0 = nothing.
    pub answered: u16,
}

impl Heard {
    pub fn header(&self, name: &str) -> &str {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str()).unwrap_or_default()
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap()
    }
}

#[derive(Default)]
struct Inner {
    heard: Vec<Heard>,
    /// What is answered next; then 200.
    answers: Vec<u16>,
}

/// The server; it hears until the test ends.
#[derive(Clone)]
pub struct Hook {
    inner: Arc<Mutex<Inner>>,
    pub url: String,
}

impl Hook {
    /// A server that answers so, one after the other, and then with 200. 0 = it never answers.
    pub fn answering(answers: &[u16]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/hook", listener.local_addr().unwrap());
        let answers = answers.iter().rev().copied().collect();
        let hook = Self { inner: Arc::new(Mutex::new(Inner { heard: Vec::new(), answers })), url };
        let inner = hook.inner.clone();
        thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let inner = inner.clone();
                thread::spawn(move || hear(stream, &inner));
            }
        });
        hook
    }

    pub fn heard(&self) -> Vec<Heard> {
        self.inner.lock().unwrap().heard.clone()
    }

    /// The messages that were answered with success.
    pub fn told(&self) -> Vec<Value> {
        self.heard().iter().filter(|heard| heard.answered == 200).map(Heard::json).collect()
    }

    pub fn answer(&self, answers: &[u16]) {
        self.inner.lock().unwrap().answers = answers.iter().rev().copied().collect();
    }

    /// Waits until so many messages were answered with success.
    pub fn wait_for(&self, count: usize) -> Vec<Value> {
        let began = Instant::now();
        loop {
            let told = self.told();
            if told.len() >= count {
                return told;
            }
            assert!(began.elapsed() < Duration::from_secs(40), "only {told:#?}, of {:#?}", self.heard());
            thread::sleep(Duration::from_millis(20));
        }
    }
}

fn hear(mut stream: TcpStream, inner: &Mutex<Inner>) {
    let mut bytes = Vec::new();
    let mut chunk = [0; 4096];
    let (head, length) = loop {
        let read = stream.read(&mut chunk).unwrap_or(0);
        if read == 0 {
            return;
        }
        bytes.extend_from_slice(&chunk[..read]);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Some((head, _)) = text.split_once("\r\n\r\n") {
            let length =
                head.lines().find_map(|line| line.to_lowercase().strip_prefix("content-length: ")?.parse().ok());
            break (head.to_owned(), length.unwrap_or(0));
        }
    };
    while bytes.len() < head.len() + 4 + length {
        let read = stream.read(&mut chunk).unwrap_or(0);
        bytes.extend_from_slice(&chunk[..read]);
    }
    let body = String::from_utf8(bytes[head.len() + 4..].to_vec()).unwrap();
    let of = |line: &str| line.split_once(": ").map(|(name, value)| (name.to_lowercase(), value.to_owned()));
    let headers = head.lines().skip(1).filter_map(of).collect();
    let answered = {
        let mut inner = inner.lock().unwrap();
        let answered = inner.answers.pop().unwrap_or(200);
        inner.heard.push(Heard { headers, body, answered });
        answered
    };
    if answered == 0 {
        thread::sleep(Duration::from_secs(60));
    }
    let _ = write!(stream, "HTTP/1.1 {answered} Said\r\ncontent-length: 0\r\nconnection: close\r\n\r\n");
}
