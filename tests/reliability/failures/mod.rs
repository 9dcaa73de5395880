//! Failures of the machine and of other servers: kills, system calls that fail, lost power, rotten files, refused changes, ledgers that are
//! put back.

pub mod crash;
pub mod faults;
pub mod kill;
pub mod nodes;
pub mod pair;
pub mod power;
pub mod refused;
pub mod restore;
pub mod rot;
