//! Limits of the readers: larger files are refused.

use serde::{Deserialize, Serialize};

/// Greatest sizes that a reader accepts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadLimits {
    /// Bytes of a dropped file.
    pub max_bytes: u64,
    /// Triangles of one part, counting every component instance.
    pub max_triangles: u64,
    /// Bytes that a 3MF package may unpack to.
    pub max_unpacked_bytes: u64,
    /// Entries of a 3MF package.
    pub max_entries: u64,
    /// Build items and component instances of one 3MF drop.
    pub max_instances: u64,
    /// How deep components may nest.
    pub max_depth: u32,
    /// Separate shells of one part.
    pub max_shells: u64,
    /// Copies that one dropped file may request, all its parts together.
    pub max_copies: u64,
    /// Memory of a separate process that reads a file after reading it has crashed the daemon before, bytes.
    pub read_memory_bytes: u64,
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self {
            max_bytes: 2 << 30,
            max_triangles: 20_000_000,
            max_unpacked_bytes: 4 << 30,
            max_entries: 10_000,
            max_instances: 100_000,
            max_depth: 16,
            max_shells: 10_000,
            max_copies: 10_000,
            read_memory_bytes: 4 << 30,
        }
    }
}

impl ReadLimits {
    /// Small limits that tests can reach.
    pub fn for_testing() -> Self {
        Self {
            max_bytes: 4 << 20,
            max_triangles: 50_000,
            max_unpacked_bytes: 8 << 20,
            max_entries: 50,
            max_instances: 200,
            max_depth: 4,
            max_shells: 100,
            max_copies: 500,
            read_memory_bytes: 512 << 20,
        }
    }
}
