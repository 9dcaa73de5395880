//! The farm as users see it: the real binary on real folders, with a real SQLite ledger and real inotify.

mod parts;
mod people;
mod restored;
mod servers;
