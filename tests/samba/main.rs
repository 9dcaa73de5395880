//! The hot folder behind a real Samba server, as the clients of a shop use it: each file is taken once and whole, by the bytes
//! that the client sent, the row in the ledger and what was printed. Needs `smbd` and `smbclient`; without them each test is
//! reported as ignored, with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test that cannot go on fails; this one is its own harness

mod cases;
mod proxy;
mod server;
mod shop;

#[path = "../grid/mod.rs"]
mod grid;
#[allow(dead_code)] // shared with other tests, not all of it is used here
#[path = "../farm/support.rs"]
mod support;

use std::{
    panic::catch_unwind,
    process::ExitCode,
    sync::Mutex,
    sync::atomic::{AtomicUsize, Ordering},
    time::Instant,
};

use cases::CASES;

/// They mostly wait.
const AT_ONCE: usize = 3;

fn main() -> ExitCode {
    let began = Instant::now();
    let args: Vec<String> = std::env::args().skip(1).collect();
    let filter = args.iter().find(|arg| !arg.starts_with('-')).cloned().unwrap_or_default();
    let wanted: Vec<_> = CASES.iter().filter(|(name, _)| name.contains(&filter)).collect();
    if args.iter().any(|arg| arg == "--list") {
        wanted.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    println!("\nrunning {} tests", wanted.len());
    let out = CASES.len() - wanted.len();
    if let Some(why) = server::missing() {
        wanted.iter().for_each(|(name, _)| println!("test {name} ... ignored, {why}"));
        println!("\ntest result: ok. 0 passed; 0 failed; {} ignored; 0 measured; {out} filtered out", wanted.len());
        return ExitCode::SUCCESS;
    }
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(0));
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some((name, case)) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let is_ok = catch_unwind(case).is_ok();
                    println!("test {name} ... {}", if is_ok { "ok" } else { "FAILED" });
                    *failed.lock().unwrap() += usize::from(!is_ok);
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap();
    println!(
        "\ntest result: {}. {} passed; {failed} failed; 0 ignored; 0 measured; {out} filtered out; finished in {:.2}s",
        if failed == 0 { "ok" } else { "FAILED" },
        wanted.len() - failed,
        began.elapsed().as_secs_f64()
    );
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
