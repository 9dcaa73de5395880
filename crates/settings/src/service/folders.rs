//! Resolves the folders of a farm.
//!
//! Rules: `root` is relative to the working directory (as `--root` is), every other folder is relative to the root, and
//! the folder of a machine is the farm's folder plus the machine's name. An absolute path is used as it is.

use std::path::{Component, Path, PathBuf};

use ledger::LedgerAddress;

use super::inputs::{FarmFolders, FarmInputs};
use crate::{MachineFolders, machine::profile_inputs::ProfileFolders};

/// Returns the root. `asked` (`--root`) takes precedence over the file.
pub(crate) fn farm_root(inputs: &FarmInputs, asked: Option<&Path>) -> PathBuf {
    let root = asked.unwrap_or(&inputs.root);
    normalize_path(&std::path::absolute(root).unwrap_or_else(|_| root.to_owned()))
}

/// Returns the folders of a machine.
pub(crate) fn machine_folders(root: &Path, farm: &FarmFolders, own: &ProfileFolders, name: &str) -> MachineFolders {
    let folder = |own: &Option<PathBuf>, farm: &Path| match own {
        Some(exact) if !exact.as_os_str().is_empty() => path_below(root, exact),
        _ => path_below(root, farm).join(name),
    };
    MachineFolders {
        inbox: folder(&own.inbox, &farm.inbox),
        queue: folder(&own.queue, &farm.queue),
        error: folder(&own.error, &farm.error),
        archive: folder(&own.archive, &farm.archive),
    }
}

/// Resolves `path` relative to `base`, without `.` and `..`.
pub(crate) fn path_below(base: &Path, path: &Path) -> PathBuf {
    normalize_path(&base.join(path))
}

/// Returns where the ledger is: on a server, or in a file relative to the state directory.
pub(crate) fn ledger_address(folders: &FarmFolders, connections: u32, state_dir: &Path) -> LedgerAddress {
    let server = folders
        .ledger
        .to_str()
        .and_then(|text| LedgerAddress::parse_server(text, folders.ledger_password_file.0.as_deref()));
    let server = server.map(|server| server.with_connections(connections));
    server.unwrap_or_else(|| LedgerAddress::File(path_below(state_dir, &folders.ledger)))
}

/// Removes `.` and `..`, so two spellings of a folder are equal. Links are not resolved; `nestd check` does that.
fn normalize_path(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for step in path.components() {
        match step {
            Component::CurDir => {}
            Component::ParentDir => {
                tidy.pop();
            }
            other => tidy.push(other),
        }
    }
    tidy
}
