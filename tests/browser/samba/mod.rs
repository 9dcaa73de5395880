//! The hot folder behind a real Samba server, as the clients of a shop use it: each file is taken once and whole, by the bytes
//! that the client sent, the row in the ledger and what was printed. Needs `smbd` and `smbclient`.

mod cases;
mod proxy;
mod server;
mod shop;

pub use cases::CASES;
pub use server::missing;

use crate::support::{self, grid};
