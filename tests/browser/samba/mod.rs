//! The hot folder behind a real Samba server, with clients as in a workshop: each file is taken once and complete. The
//! tests compare the bytes that the client sent, the row in the ledger and the printed copies. They need `smbd` and
//! `smbclient`.

mod cases;
mod proxy;
mod server;
mod shop;

pub use cases::CASES;
pub use server::missing;

use crate::support::{self, grid};
