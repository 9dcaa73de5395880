//! A web server on loopback that receives messages and answers with given status codes.
#![allow(dead_code)] // no test program uses all of it

use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;

/// One received request.
#[derive(Debug, Clone)]
pub struct ReceivedRequest {
    /// Names in lower case, and values.
    pub headers: Vec<(String, String)>,
    /// The body as received.
    pub body: String,
    /// The status code of the answer; 0 = no answer.
    pub answered: u16,
}

impl ReceivedRequest {
    pub fn header(&self, name: &str) -> &str {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str()).unwrap_or_default()
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap()
    }
}

#[derive(Default)]
struct WebhookState {
    received: Vec<ReceivedRequest>,
    /// The next status codes, last first; then 200.
    answers: Vec<u16>,
}

/// The server; it runs until the test ends.
#[derive(Clone)]
pub struct TestWebhook {
    inner: Arc<Mutex<WebhookState>>,
    pub url: String,
}

impl TestWebhook {
    /// A server that answers with these status codes in order, and then with 200. 0 = no answer.
    pub fn with_answers(answers: &[u16]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/hook", listener.local_addr().unwrap());
        let answers = answers.iter().rev().copied().collect();
        let hook = Self { inner: Arc::new(Mutex::new(WebhookState { received: Vec::new(), answers })), url };
        let inner = hook.inner.clone();
        thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let inner = inner.clone();
                thread::spawn(move || handle_request(stream, &inner));
            }
        });
        hook
    }

    pub fn received(&self) -> Vec<ReceivedRequest> {
        self.inner.lock().unwrap().received.clone()
    }

    /// The messages that were answered with success.
    pub fn delivered(&self) -> Vec<Value> {
        self.received().iter().filter(|received| received.answered == 200).map(ReceivedRequest::json).collect()
    }

    pub fn set_answers(&self, answers: &[u16]) {
        self.inner.lock().unwrap().answers = answers.iter().rev().copied().collect();
    }

    /// Waits until `count` messages were answered with success.
    pub fn wait_for_delivered(&self, count: usize) -> Vec<Value> {
        let began = Instant::now();
        loop {
            let delivered = self.delivered();
            if delivered.len() >= count {
                return delivered;
            }
            assert!(began.elapsed() < Duration::from_secs(40), "only {delivered:#?}, of {:#?}", self.received());
            thread::sleep(Duration::from_millis(20));
        }
    }
}

fn handle_request(mut stream: TcpStream, inner: &Mutex<WebhookState>) {
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
        inner.received.push(ReceivedRequest { headers, body, answered });
        answered
    };
    if answered == 0 {
        thread::sleep(Duration::from_secs(60));
    }
    let _ = write!(stream, "HTTP/1.1 {answered} Said\r\ncontent-length: 0\r\nconnection: close\r\n\r\n");
}
