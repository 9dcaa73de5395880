//! Several daemons, and a ledger on a server.

mod any_node;
mod at_rest;
mod change_lock;
pub mod failover;
pub mod machines_move;
pub mod nodes_on_postgres;
pub mod on_postgres;
pub mod one_farm;
pub mod share;
pub mod silent_link;
pub mod test_node;
