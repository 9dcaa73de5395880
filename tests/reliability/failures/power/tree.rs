//! Folders and files as inodes, so that operations can be left out without changing the meaning of the others.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// A folder or file.
#[derive(Debug, Clone)]
enum TreeNode {
    Dir(BTreeMap<OsString, usize>),
    File(Vec<u8>),
}

/// A tree of inodes; 0 is the root.
#[derive(Debug, Clone)]
pub struct InodeTree {
    nodes: Vec<TreeNode>,
}

/// The kind of an operation.
#[derive(Debug, Clone)]
pub enum OperationKind {
    /// A new file or folder gets a name.
    Put { dir: usize, name: OsString, node: usize, is_dir: bool },
    /// A file or folder is renamed.
    Move { from: usize, from_name: OsString, to: usize, to_name: OsString, node: usize },
    /// A hard link is made.
    Link { dir: usize, name: OsString, node: usize },
    /// A name is removed.
    Remove { dir: usize, name: OsString },
    /// Bytes are written.
    Write { node: usize, offset: u64, data: Vec<u8> },
    /// The length of a file changes.
    Truncate { node: usize, bytes: u64 },
    /// fsync of a file or folder.
    Sync { node: usize },
}

/// A recorded operation.
#[derive(Debug, Clone)]
pub struct FileOperation {
    pub what: OperationKind,
    /// Whether it is on SQLite's files.
    pub is_of_ledger: bool,
    /// A description for people.
    pub path: PathBuf,
}

impl FileOperation {
    pub fn is_sync(&self) -> bool {
        matches!(self.what, OperationKind::Sync { .. })
    }

    /// Whether a later operation makes this one durable.
    pub fn is_durable_after(&self, later: &FileOperation) -> bool {
        let OperationKind::Sync { node: synced } = later.what else { return false };
        match &self.what {
            OperationKind::Put { dir, .. } | OperationKind::Link { dir, .. } | OperationKind::Remove { dir, .. } => {
                *dir == synced
            }
            OperationKind::Move { to, .. } => *to == synced,
            OperationKind::Write { node, .. } | OperationKind::Truncate { node, .. } => *node == synced,
            OperationKind::Sync { .. } => true,
        }
    }

    /// Whether it continues a write to the same file.
    pub fn continues_write(&self, before: &FileOperation) -> bool {
        let written =
            |op: &FileOperation| if let OperationKind::Write { node, .. } = op.what { Some(node) } else { None };
        written(self).is_some() && written(self) == written(before)
    }

    pub fn in_words(&self) -> String {
        let verb = match &self.what {
            OperationKind::Put { is_dir: true, .. } => "mkdir",
            OperationKind::Put { .. } => "create",
            OperationKind::Move { .. } => "rename to",
            OperationKind::Link { .. } => "link",
            OperationKind::Remove { .. } => "remove",
            OperationKind::Write { .. } => "write",
            OperationKind::Truncate { .. } => "truncate",
            OperationKind::Sync { .. } => "fsync",
        };
        format!("{verb} {}", self.path.display())
    }
}

impl InodeTree {
    /// Reads a folder.
    pub fn read(root: &Path, is_wanted: &dyn Fn(&Path) -> bool) -> Self {
        let mut tree = Self { nodes: vec![TreeNode::Dir(BTreeMap::new())] };
        tree.read_into(0, root, root, is_wanted);
        tree
    }

    fn read_into(&mut self, dir: usize, at: &Path, root: &Path, is_wanted: &dyn Fn(&Path) -> bool) {
        for entry in fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if !is_wanted(path.strip_prefix(root).unwrap()) {
                continue;
            }
            let node = self.nodes.len();
            let name = path.file_name().unwrap().to_owned();
            if path.is_dir() {
                self.nodes.push(TreeNode::Dir(BTreeMap::new()));
                self.read_into(node, &path, root, is_wanted);
            } else {
                self.nodes.push(TreeNode::File(fs::read(&path).unwrap()));
            }
            self.dir(dir).unwrap().insert(name, node);
        }
    }

    fn dir(&mut self, node: usize) -> Option<&mut BTreeMap<OsString, usize>> {
        match self.nodes.get_mut(node) {
            Some(TreeNode::Dir(names)) => Some(names),
            _ => None,
        }
    }

    /// The inode of a path.
    pub fn find(&self, path: &Path) -> Option<usize> {
        path.iter().try_fold(0, |node, name| match &self.nodes[node] {
            TreeNode::Dir(names) => names.get(name).copied(),
            TreeNode::File(_) => None,
        })
    }

    /// The number that the next inode gets.
    pub fn next(&self) -> usize {
        self.nodes.len()
    }

    /// Assigns inode numbers, also for operations that are left out.
    pub fn allocate(&mut self, op: &FileOperation) {
        if let OperationKind::Put { node, is_dir, .. } = op.what {
            assert_eq!(node, self.nodes.len());
            self.nodes.push(if is_dir { TreeNode::Dir(BTreeMap::new()) } else { TreeNode::File(Vec::new()) });
        }
    }

    /// Applies an operation; one on a missing file does nothing.
    pub fn apply(&mut self, op: &FileOperation) {
        match &op.what {
            OperationKind::Put { dir, name, node, .. } | OperationKind::Link { dir, name, node } => {
                if let Some(names) = self.dir(*dir) {
                    names.insert(name.clone(), *node);
                }
            }
            OperationKind::Move { from, from_name, to, to_name, node } => {
                if let Some(names) = self.dir(*from)
                    && names.get(from_name) == Some(node)
                {
                    names.remove(from_name);
                }
                if let Some(names) = self.dir(*to) {
                    names.insert(to_name.clone(), *node);
                }
            }
            OperationKind::Remove { dir, name } => {
                if let Some(names) = self.dir(*dir) {
                    names.remove(name);
                }
            }
            OperationKind::Write { node, offset, data } => {
                if let TreeNode::File(bytes) = &mut self.nodes[*node] {
                    let end = *offset as usize + data.len();
                    bytes.resize(bytes.len().max(end), 0);
                    bytes[*offset as usize..end].copy_from_slice(data);
                }
            }
            OperationKind::Truncate { node, bytes: length } => {
                if let TreeNode::File(bytes) = &mut self.nodes[*node] {
                    bytes.resize(*length as usize, 0);
                }
            }
            OperationKind::Sync { .. } => {}
        }
    }

    /// Writes the tree to a folder on disk.
    pub fn write(&self, root: &Path) {
        self.write_node(0, root);
    }

    fn write_node(&self, node: usize, at: &Path) {
        match &self.nodes[node] {
            TreeNode::File(bytes) => fs::write(at, bytes).unwrap(),
            TreeNode::Dir(names) => {
                fs::create_dir_all(at).unwrap();
                for (name, node) in names {
                    self.write_node(*node, &at.join(name));
                }
            }
        }
    }
}
