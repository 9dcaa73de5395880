//! Checks the location of a ledger: it must be on a local disk. SQLite's locks and its shared memory do not work over a
//! network.

use std::{io, path::Path};

use crate::{LedgerError, base::error::Result};

/// `statfs` magic numbers of network file systems, on which SQLite must not run.
const NETWORK_FILE_SYSTEMS: [(u32, &str); 9] = [
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

/// Parent folder of a file; "." for a name without a folder.
pub fn parent_folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Refuses a ledger on a network file system.
pub fn refuse_network_location(path: &Path) -> Result<()> {
    let found = find_network_file_system(parent_folder(path))
        .map_err(|source| LedgerError::Folder { path: path.to_owned(), source })?;
    match found {
        Some(kind) => Err(LedgerError::NetworkFileSystem { path: path.to_owned(), kind }),
        None => Ok(()),
    }
}

/// The kind of network file system that a folder is on; `None` = a local disk.
pub fn find_network_file_system(folder: &Path) -> io::Result<Option<&'static str>> {
    // The field is signed or wider on some platforms; the magic number is its low 32 bits.
    Ok(network_file_system(rustix::fs::statfs(folder)?.f_type as u32))
}

fn network_file_system(magic: u32) -> Option<&'static str> {
    NETWORK_FILE_SYSTEMS.iter().find(|(known, _)| *known == magic).map(|&(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn network_file_systems_are_known_by_their_magic() {
        assert_eq!(network_file_system(0x6969), Some("NFS"));
        assert_eq!(network_file_system(0xff53_4d42_u64 as u32), Some("CIFS"));
        assert_eq!(network_file_system(0xef53), None, "ext4 is a local disk");
    }

    #[test]
    fn a_bare_name_stands_in_the_current_folder() {
        assert_eq!(parent_folder(Path::new("nestd.db")), Path::new("."));
        assert_eq!(parent_folder(Path::new("/state/nestd.db")), Path::new("/state"));
        assert!(refuse_network_location(Path::new("/nowhere/at/all/nestd.db")).is_err());
    }
}
