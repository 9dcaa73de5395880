//! Originals on other nodes of the farm: a part that was moved to a machine of this node, or is printed again here, may have its
//! original in the store or in an archive of another node.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    io::Read,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, bail};
use intake::{ContentStore, PutContents};
use ledger::{Ledger, NodeRow};
use settings::{MachineProfile, Settings};

use super::node_client::{NodeClient, node_secret};
use crate::records::build_record::archive_folder;

/// A file of 2 GB takes less than this over a slow network.
const TRANSFER_TIMEOUT: Duration = Duration::from_secs(600);

/// Bytes of a file that are received at once.
const CHUNK_BYTES: usize = 1 << 16;

/// Folder of the second copies in the state directory.
pub(crate) const COPIES_DIR: &str = "copies";

/// Second copies of the files of other nodes' parts.
pub(crate) fn second_copies(state_dir: &Path) -> ContentStore {
    ContentStore::from_dir(state_dir.join(COPIES_DIR))
}

/// Removes the files that are not needed and were stored longer ago than `keep`.
///
/// # Errors
/// The folder cannot be read or changed.
pub(crate) fn remove_unneeded(files: &ContentStore, keep: Duration, is_needed: impl Fn(&str) -> bool) -> Result<()> {
    for hash in files.list_contents()?.into_keys().filter(|hash| !is_needed(hash)) {
        let stored_at = files.file_path(&hash)?.metadata()?.modified()?;
        if stored_at.elapsed().is_ok_and(|age| age > keep) {
            files.remove_content(&hash)?;
        }
    }
    Ok(())
}

/// The other nodes of the farm, as far as originals can be asked for there.
#[derive(Debug, Clone)]
pub(crate) struct OtherNodes {
    /// Second copies on this node.
    copies: ContentStore,
    nodes: Vec<NodeClient>,
    /// Nodes that did not answer, with the reason: they are not asked for the next file.
    silent: RefCell<BTreeMap<String, String>>,
}

impl OtherNodes {
    /// Those that the ledger knows.
    pub(crate) async fn of_ledger(settings: &Settings, ledger: &Ledger) -> Result<Self> {
        let rows = if ledger.file().is_some() { Vec::new() } else { ledger.list_nodes().await? };
        Ok(Self::from_rows(settings, rows, &node_secret(ledger).await?))
    }

    /// Those of these nodes that are others.
    pub(crate) fn from_rows(settings: &Settings, rows: Vec<NodeRow>, secret: &str) -> Self {
        let others = rows.into_iter().filter(|row| row.name != settings.node.name);
        Self {
            copies: second_copies(&settings.state_dir),
            nodes: others.map(|row| NodeClient::of_row(settings, row, secret)).collect(),
            silent: RefCell::default(),
        }
    }

    /// Copies the file with this hash from a second copy on this node, or from another node, into the store. `false` = no node has it that
    /// runs: one that is gone may never come back.
    ///
    /// A node that runs, and may have it, does not answer.
    pub(crate) fn fetch_into_store(&self, store: &ContentStore, hash: &str) -> Result<bool> {
        if self.copies.verify_hash(hash).is_ok() {
            store.store_file(&self.copies.file_path(hash)?)?;
            return Ok(true);
        }
        self.fetch_from_any(hash, &|source| Ok(store.store_received(source, hash)?))
    }

    /// Copies the file with this hash, which was put on another node, to those that were put here. `false` = no node has it that runs.
    ///
    /// # Errors
    /// A node that runs, and may have it, does not answer.
    pub(crate) fn fetch_put(&self, contents: &PutContents, hash: &str) -> Result<bool> {
        self.fetch_from_any(hash, &|source| {
            let mut arriving = contents.begin_content(rand::random(), 0, u64::MAX)?;
            let mut chunk = vec![0; CHUNK_BYTES];
            loop {
                match source.read(&mut chunk)? {
                    0 => break,
                    bytes => arriving.write_chunk(&chunk[..bytes])?,
                }
            }
            arriving.finish_content(Some(hash))?;
            Ok(())
        })
    }

    fn fetch_from_any(&self, hash: &str, keep: &dyn Fn(&mut dyn Read) -> Result<()>) -> Result<bool> {
        let mut unknown = Vec::new();
        for node in &self.nodes {
            let known = self.silent.borrow().get(&node.name).cloned();
            let answer = known.map_or_else(|| fetch_from(node, hash, keep), |why| bail!("{why}"));
            match answer {
                Ok(true) => return Ok(true),
                Ok(false) => {}
                Err(failure) => {
                    let why = format!("{failure:#}");
                    if node.is_alive {
                        unknown.push(format!("the node {}, which may have the original: {why}", node.name));
                    }
                    self.silent.borrow_mut().insert(node.name.clone(), why);
                }
            }
        }
        if unknown.is_empty() { Ok(false) } else { bail!("{}", unknown.join("; ")) }
    }

    /// Copies the file with this hash from a node into the store. `false` = it does not have it.
    ///
    /// # Errors
    /// It does not answer.
    pub(crate) fn fetch_from_node(&self, name: &str, store: &ContentStore, hash: &str) -> Result<bool> {
        let node = self.nodes.iter().find(|node| node.name == name);
        let node = node.with_context(|| format!("the ledger knows no node {name}"))?;
        fetch_from(node, hash, &|source| Ok(store.store_received(source, hash)?))
            .with_context(|| format!("the node {name}"))
    }
}

fn fetch_from(node: &NodeClient, hash: &str, keep: &dyn Fn(&mut dyn Read) -> Result<()>) -> Result<bool> {
    match node.get(&format!("/content/{hash}"), TRANSFER_TIMEOUT)? {
        Some(answer) => keep(&mut answer.into_reader()).map(|()| true),
        None => Ok(false),
    }
}

/// A file with this content that this node keeps, in its store, as a second copy, as it was put for an order, or in an archive of its
/// machines; `None` = none.
///
/// # Errors
/// The ledger cannot be read.
pub async fn find_kept_content(settings: &Settings, ledger: &Ledger, hash: &str) -> Result<Option<PathBuf>> {
    let store = ContentStore::from_dir(settings.state_dir.join("store"));
    let Ok(stored) = store.file_path(hash) else { return Ok(None) };
    let copies = second_copies(&settings.state_dir);
    let put = PutContents::of_farm(&settings.state_dir).path_of(hash);
    let archives = archive_folders(ledger, hash, |machine| settings.profiles.get(machine)).await?;
    let hash = hash.to_owned();
    let looked = tokio::task::spawn_blocking(move || match store.verify_hash(&hash) {
        Ok(()) => Some(stored),
        Err(_) if copies.verify_hash(&hash).is_ok() => copies.file_path(&hash).ok(),
        Err(_) if intake::hash_file(&put).is_ok_and(|found| found == hash) => Some(put),
        Err(_) => archives.iter().find_map(|folder| find_original(folder, &hash)),
    });
    Ok(looked.await?)
}

/// Brings a file here that was put on another node for an order; `false` = no node has it that runs.
///
/// # Errors
/// The ledger cannot be read, or a node that runs, and may have it, does not answer.
pub async fn fetch_put_content(settings: &Settings, ledger: &Ledger, hash: &str) -> Result<bool> {
    if ledger.file().is_some() {
        return Ok(false);
    }
    let (nodes, contents) = (OtherNodes::of_ledger(settings, ledger).await?, PutContents::of_farm(&settings.state_dir));
    let hash = hash.to_owned();
    tokio::task::spawn_blocking(move || nodes.fetch_put(&contents, &hash)).await?
}

/// The folders in the archives of known machines where the originals of builds with this content lie, newest first.
pub(crate) async fn archive_folders<'m>(
    ledger: &Ledger,
    hash: &str,
    machine_named: impl Fn(&str) -> Option<&'m MachineProfile>,
) -> Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for (machine, file_name) in ledger.build_files_with_content(hash).await? {
        folders.extend(machine_named(&machine).map(|profile| archive_folder(&profile.folders.archive, &file_name)));
    }
    Ok(folders)
}

/// The file with this content in a folder, as the archive folder of a build.
pub(crate) fn find_original(folder: &Path, hash: &str) -> Option<PathBuf> {
    let files = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    files.filter(|path| path.is_file()).find(|path| intake::hash_file(path).is_ok_and(|found| found == hash))
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn old_files_go_and_needed_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        let files = ContentStore::open(folder.path()).unwrap();
        let hour = Duration::from_secs(3600);
        let store = |name: &str, hours_ago: u32| {
            let bytes = name.repeat(100).into_bytes();
            let hash = blake3::hash(&bytes).to_hex().to_string();
            files.store_received(&mut &bytes[..], &hash).unwrap();
            let file = File::options().append(true).open(files.file_path(&hash).unwrap()).unwrap();
            file.set_modified(std::time::SystemTime::now() - hour * hours_ago).unwrap();
            hash
        };
        let [needed, old, young] = [("n", 99), ("o", 30), ("y", 2)].map(|(name, ago)| store(name, ago));
        remove_unneeded(&files, hour * 24, |hash| hash == needed).unwrap();
        let is_kept = |hash: &String| files.list_contents().unwrap().contains_key(hash);
        assert_eq!([&needed, &old, &young].map(is_kept), [true, false, true]);
    }
}
