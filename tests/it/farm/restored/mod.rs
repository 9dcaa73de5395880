//! A ledger or files that are not what they were: backups, rot, folders that come back.

pub mod decisions;
pub mod deep;
pub mod lost_ledger;
pub mod restore;
pub mod restored_orders;
pub mod returned;
pub mod rot;
