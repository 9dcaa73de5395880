use std::{convert::Infallible, net::SocketAddr};

use axum::{
    Router,
    body::Bytes,
    middleware,
    response::sse::{Event, KeepAlive, Sse},
    routing::{get, post},
};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream},
    time::timeout,
};

use super::*;
use crate::web::doors::request_stage::buffer_then_answer;

const SHORT: ConnectionTimeouts =
    ConnectionTimeouts { request: Duration::from_millis(300), idle: Duration::from_millis(900) };
const SLOW: Duration = Duration::from_millis(1500);
const LONG: usize = 64 << 20;

/// A server that accepts at most `most` connections.
async fn serve(most: usize) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let slow = || async {
        sleep(SLOW).await;
        "slow"
    };
    let silent = || async { Sse::new(tokio_stream::pending::<Result<Event, Infallible>>()).keep_alive(often()) };
    let routes = Router::new()
        .route("/", get(|| async { "quick" }))
        .route("/slow", get(slow))
        .route("/long", get(|| async { vec![b'x'; LONG] }))
        .route("/stream", get(silent))
        .route("/order", post(|body: String| async move { body }))
        .route("/api/v1/content", post(move |_: Bytes| slow()))
        .layer(middleware::from_fn(buffer_then_answer))
        .into_make_service_with_connect_info::<RequestInProgress>();
    tokio::spawn(async move { axum::serve(LimitedListener::new(listener, most, SHORT), routes).await });
    address
}

fn often() -> KeepAlive {
    KeepAlive::new().interval(Duration::from_millis(200))
}

async fn says(address: SocketAddr, text: &str) -> TcpStream {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(text.as_bytes()).await.unwrap();
    stream
}

async fn asks(address: SocketAddr, path: &str) -> TcpStream {
    says(address, &format!("GET {path} HTTP/1.1\r\nhost: localhost\r\n\r\n")).await
}

/// Reads until the wanted text has arrived; `None` = the connection was closed before.
async fn reads(stream: &mut TcpStream, wanted: &str) -> Option<()> {
    let mut seen = Vec::new();
    let mut buffer = [0; 1024];
    while !String::from_utf8_lossy(&seen).contains(wanted) {
        let length = timeout(Duration::from_secs(20), stream.read(&mut buffer)).await.expect("it says something");
        match length.unwrap_or(0) {
            0 => return None,
            length => seen.extend_from_slice(&buffer[..length]),
        }
    }
    Some(())
}

/// The time until the other side closes the connection.
async fn closes(stream: &mut TcpStream) -> Duration {
    let began = Instant::now();
    assert!(reads(stream, "what nobody says").await.is_none());
    began.elapsed()
}

#[tokio::test]
async fn a_request_that_does_not_come_as_a_whole_is_not_waited_for() {
    let address = serve(50).await;
    for begun in ["", "GET / HTTP/1.1\r\nhost: loc", "POST /order HTTP/1.1\r\nhost: a\r\ncontent-length: 9\r\n\r\nkey="]
    {
        let took = closes(&mut says(address, begun).await).await;
        assert!(took >= Duration::from_millis(200) && took < Duration::from_secs(10), "{begun:?}: {took:?}");
    }
}

#[tokio::test]
async fn a_head_that_comes_drop_by_drop_wins_no_time_also_after_an_answer() {
    let address = serve(50).await;
    for first in ["", "GET / HTTP/1.1\r\nhost: localhost\r\n\r\n"] {
        let mut stream = says(address, first).await;
        if !first.is_empty() {
            reads(&mut stream, "quick").await.expect("the answer");
        }
        let began = Instant::now();
        while stream.write_all(b"G").await.is_ok() {
            assert!(began.elapsed() < Duration::from_secs(10), "it is open for ever");
            sleep(Duration::from_millis(50)).await;
        }
    }
}

#[tokio::test]
async fn an_answer_that_takes_long_a_stream_and_a_slow_reader_outlive_what_is_silent() {
    let address = serve(50).await;
    let (mut slow, mut stream) = (asks(address, "/slow").await, asks(address, "/stream").await);
    let (mut long, mut stuck) = (asks(address, "/long").await, asks(address, "/long").await);
    let mut piece = vec![0; LONG / 10];
    for _ in 0..10 {
        sleep(Duration::from_millis(150)).await;
        long.read_exact(&mut piece).await.expect("slow, and moving");
    }
    reads(&mut slow, "slow").await.expect("an answer that takes longer than a request may");
    for _ in 0..10 {
        reads(&mut stream, ":").await.expect("the stream goes on");
    }
    let mut idle = asks(address, "/").await;
    reads(&mut idle, "quick").await.expect("the answer");
    assert!(closes(&mut idle).await >= Duration::from_millis(600), "a page may ask again for a while");
    let mut rest = Vec::new();
    let _ = stuck.read_to_end(&mut rest).await; // however it ends
    assert!(rest.len() < LONG, "who does not read is not waited for");
}

#[tokio::test]
async fn files_that_arrived_may_take_longer_to_be_answered_than_a_connection_may_be_silent() {
    let address = serve(50).await;
    let head = "POST /api/v1/content HTTP/1.1\r\nhost: localhost\r\n";
    let mut asked = says(address, &format!("{head}content-length: 4\r\n\r\nfile")).await;
    reads(&mut asked, "slow").await.expect("an answer that takes longer than an upload may be silent");
    let mut silent = says(address, &format!("{head}content-length: 9\r\n\r\nfile")).await;
    assert!(closes(&mut silent).await < Duration::from_secs(10), "the rest of a file is not waited for without end");
}

#[tokio::test]
async fn who_finds_no_place_is_answered_when_the_silent_ones_are_gone() {
    let address = serve(8).await;
    let mut silent = Vec::new();
    for _ in 0..40 {
        silent.push(says(address, "GET / HTTP/1.1\r\n").await);
    }
    let mut asked = asks(address, "/").await;
    let early = timeout(Duration::from_millis(50), reads(&mut asked, "quick")).await;
    assert!(early.is_err(), "no more than eight are in");
    timeout(Duration::from_secs(10), reads(&mut asked, "quick")).await.expect("in time").expect("an answer");
}
