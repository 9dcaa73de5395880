//! Where a ledger may stand: on a local disk. SQLite's locks and its shared memory do not hold over a network.

use std::path::Path;

use super::{LedgerError, error::Result};

/// `statfs` magics of file systems on which SQLite must not run.
const NETWORK: [(u32, &str); 9] = [
    (0x0000_6969, "NFS"),
    (0xfe53_4d42, "SMB2"),
    (0xff53_4d42, "CIFS"),
    (0x0000_517b, "SMB"),
    (0x6573_5546, "FUSE"),
    (0x0102_1997, "9P"),
    (0x5346_414f, "AFS"),
    (0x00c3_6400, "Ceph"),
    (0x0bd0_0bd0, "Lustre"),
];

/// The folder of a file; "." for a bare name.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Refuses a ledger on a network file system.
pub fn refuse_network(path: &Path) -> Result<()> {
    let found = rustix::fs::statfs(folder(path))
        .map_err(|error| LedgerError::Folder { path: path.to_owned(), source: error.into() })?;
    // The field is signed or wider on some machines; the magic is its low 32 bits.
    match network_name(found.f_type as u32) {
        Some(kind) => Err(LedgerError::NetworkFileSystem { path: path.to_owned(), kind }),
        None => Ok(()),
    }
}

fn network_name(magic: u32) -> Option<&'static str> {
    NETWORK.iter().find(|(known, _)| *known == magic).map(|&(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn network_file_systems_are_known_by_their_magic() {
        assert_eq!(network_name(0x6969), Some("NFS"));
        assert_eq!(network_name(0xff53_4d42_u64 as u32), Some("CIFS"));
        assert_eq!(network_name(0xef53), None, "ext4 is a local disk");
    }

    #[test]
    fn a_bare_name_stands_in_the_current_folder() {
        assert_eq!(folder(Path::new("nestd.db")), Path::new("."));
        assert_eq!(folder(Path::new("/state/nestd.db")), Path::new("/state"));
        assert!(refuse_network(Path::new("/nowhere/at/all/nestd.db")).is_err());
    }
}
