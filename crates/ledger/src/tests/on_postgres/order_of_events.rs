//! A reader that remembers the number of the last event that it has seen, as the deliveries and the pages do, must see every
//! event. PostgreSQL gives out numbers before the commit: without a lock, a change that began first and ends last
//! brings an event whose number such a reader has passed already.

use std::time::Duration;

use super::*;

/// What a reader that remembers the last number sees.
#[derive(Default)]
struct EventReader {
    seen: Vec<i64>,
}

impl EventReader {
    async fn look(&mut self, ledger: &Ledger) {
        let last = self.seen.last().copied().unwrap_or(0);
        let news = sql::query_scalar::<i64>("SELECT id FROM event WHERE id > $1 ORDER BY id").bind(last);
        self.seen.extend(news.fetch_all(ledger.reader().unwrap()).await.unwrap());
    }
}

#[tokio::test]
async fn a_change_that_begins_first_and_ends_last_hides_no_event() {
    let server = fresh_on_server().await;
    let mut reader = EventReader::default();
    let mut slow = server.begin_change().await.unwrap();
    slow.write_event(EventKind::Paused, "slow", None, None, "").await.unwrap();
    let other = server.clone();
    let quick = tokio::spawn(async move { other.write_event(EventKind::Paused, "quick", None, None, "").await });
    tokio::time::sleep(Duration::from_millis(400)).await;
    reader.look(&server).await;
    slow.commit().await.unwrap();
    quick.await.unwrap().unwrap();
    reader.look(&server).await;
    assert_eq!(reader.seen.len(), 2, "the events {:?} were seen", reader.seen);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_reader_sees_every_event_of_many_writers() {
    const WRITERS: usize = 6;
    const EVENTS: usize = 40;
    let server = fresh_on_server().await;
    let writers: Vec<_> = (0..WRITERS)
        .map(|writer| {
            let ledger = server.clone();
            tokio::spawn(async move {
                for n in 0..EVENTS {
                    ledger.write_event(EventKind::Resumed, &format!("{writer}-{n}"), None, None, "").await.unwrap();
                }
            })
        })
        .collect();
    let mut reader = EventReader::default();
    while !writers.iter().all(|writer| writer.is_finished()) {
        reader.look(&server).await;
    }
    reader.look(&server).await;
    assert_eq!(reader.seen.len(), WRITERS * EVENTS, "some events were passed over");
}
