//! Folders and files as inodes, so that operations can be left out and the rest still means what it meant.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// A folder or file.
#[derive(Debug, Clone)]
enum Node {
    Dir(BTreeMap<OsString, usize>),
    File(Vec<u8>),
}

/// A tree of inodes; 0 is the root.
#[derive(Debug, Clone)]
pub struct Tree {
    nodes: Vec<Node>,
}

/// What an operation does.
#[derive(Debug, Clone)]
pub enum What {
    /// A new file or folder gets a name.
    Put { dir: usize, name: OsString, node: usize, is_dir: bool },
    /// A name moves.
    Move { from: usize, from_name: OsString, to: usize, to_name: OsString, node: usize },
    /// A further name.
    Link { dir: usize, name: OsString, node: usize },
    /// A name goes.
    Remove { dir: usize, name: OsString },
    /// Contents are written.
    Write { node: usize, offset: u64, data: Vec<u8> },
    /// A file gets another length.
    Truncate { node: usize, bytes: u64 },
    /// fsync of a file or folder.
    Sync { node: usize },
}

/// A recorded operation.
#[derive(Debug, Clone)]
pub struct Op {
    pub what: What,
    /// On SQLite's files.
    pub is_of_ledger: bool,
    /// For people.
    pub path: PathBuf,
}

impl Op {
    pub fn is_sync(&self) -> bool {
        matches!(self.what, What::Sync { .. })
    }

    /// Whether a later operation makes this one durable.
    pub fn is_durable_after(&self, later: &Op) -> bool {
        let What::Sync { node: synced } = later.what else { return false };
        match &self.what {
            What::Put { dir, .. } | What::Link { dir, .. } | What::Remove { dir, .. } => *dir == synced,
            What::Move { to, .. } => *to == synced,
            What::Write { node, .. } | What::Truncate { node, .. } => *node == synced,
            What::Sync { .. } => true,
        }
    }

    /// Whether it writes on in the file that another one wrote into.
    pub fn fills_on(&self, before: &Op) -> bool {
        let written = |op: &Op| if let What::Write { node, .. } = op.what { Some(node) } else { None };
        written(self).is_some() && written(self) == written(before)
    }

    pub fn in_words(&self) -> String {
        let verb = match &self.what {
            What::Put { is_dir: true, .. } => "mkdir",
            What::Put { .. } => "create",
            What::Move { .. } => "rename to",
            What::Link { .. } => "link",
            What::Remove { .. } => "remove",
            What::Write { .. } => "write",
            What::Truncate { .. } => "truncate",
            What::Sync { .. } => "fsync",
        };
        format!("{verb} {}", self.path.display())
    }
}

impl Tree {
    /// What lies in a folder.
    pub fn read(root: &Path, is_wanted: &dyn Fn(&Path) -> bool) -> Self {
        let mut tree = Self { nodes: vec![Node::Dir(BTreeMap::new())] };
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
                self.nodes.push(Node::Dir(BTreeMap::new()));
                self.read_into(node, &path, root, is_wanted);
            } else {
                self.nodes.push(Node::File(fs::read(&path).unwrap()));
            }
            self.dir(dir).unwrap().insert(name, node);
        }
    }

    fn dir(&mut self, node: usize) -> Option<&mut BTreeMap<OsString, usize>> {
        match self.nodes.get_mut(node) {
            Some(Node::Dir(names)) => Some(names),
            _ => None,
        }
    }

    /// The inode of a path.
    pub fn find(&self, path: &Path) -> Option<usize> {
        path.iter().try_fold(0, |node, name| match &self.nodes[node] {
            Node::Dir(names) => names.get(name).copied(),
            Node::File(_) => None,
        })
    }

    /// The number that the next inode gets.
    pub fn next(&self) -> usize {
        self.nodes.len()
    }

    /// Numbers are given whether or not the name is missing.
    pub fn allocate(&mut self, op: &Op) {
        if let What::Put { node, is_dir, .. } = op.what {
            assert_eq!(node, self.nodes.len());
            self.nodes.push(if is_dir { Node::Dir(BTreeMap::new()) } else { Node::File(Vec::new()) });
        }
    }

    /// Does an operation; one on what is not there does nothing.
    pub fn apply(&mut self, op: &Op) {
        match &op.what {
            What::Put { dir, name, node, .. } | What::Link { dir, name, node } => {
                if let Some(names) = self.dir(*dir) {
                    names.insert(name.clone(), *node);
                }
            }
            What::Move { from, from_name, to, to_name, node } => {
                if let Some(names) = self.dir(*from)
                    && names.get(from_name) == Some(node)
                {
                    names.remove(from_name);
                }
                if let Some(names) = self.dir(*to) {
                    names.insert(to_name.clone(), *node);
                }
            }
            What::Remove { dir, name } => {
                if let Some(names) = self.dir(*dir) {
                    names.remove(name);
                }
            }
            What::Write { node, offset, data } => {
                if let Node::File(bytes) = &mut self.nodes[*node] {
                    let end = *offset as usize + data.len();
                    bytes.resize(bytes.len().max(end), 0);
                    bytes[*offset as usize..end].copy_from_slice(data);
                }
            }
            What::Truncate { node, bytes: length } => {
                if let Node::File(bytes) = &mut self.nodes[*node] {
                    bytes.resize(*length as usize, 0);
                }
            }
            What::Sync { .. } => {}
        }
    }

    /// Makes the tree in a folder.
    pub fn write(&self, root: &Path) {
        self.write_node(0, root);
    }

    fn write_node(&self, node: usize, at: &Path) {
        match &self.nodes[node] {
            Node::File(bytes) => fs::write(at, bytes).unwrap(),
            Node::Dir(names) => {
                fs::create_dir_all(at).unwrap();
                for (name, node) in names {
                    self.write_node(*node, &at.join(name));
                }
            }
        }
    }
}
