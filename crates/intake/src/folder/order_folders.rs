//! Order folders of one scan. A folder is one order: what lies in it, above it and below it is copied in one go, so its
//! state is joined from all of these. Folders side by side do not wait for each other.

use std::{collections::HashMap, path::Path};

/// States of folders, joined from those of their entries.
#[derive(Debug)]
pub(crate) struct FolderStates<'a, S> {
    /// The folders with entries of their own, each with its depth below the hot folder.
    own: HashMap<&'a Path, (usize, S)>,
}

impl<S> Default for FolderStates<'_, S> {
    fn default() -> Self {
        Self { own: HashMap::new() }
    }
}

impl<'a, S: Copy> FolderStates<'a, S> {
    /// Adds an entry of a folder, `depth` levels below the hot folder (1 = right in it).
    pub fn add(&mut self, folder: &'a Path, depth: usize, state: S, join: impl Fn(S, S) -> S) {
        self.own.entry(folder).and_modify(|(_, own)| *own = join(*own, state)).or_insert((depth, state));
    }

    /// Joins the states of each folder with those of the folders above and below it.
    pub fn into_joined(self, join: impl Fn(S, S) -> S) -> HashMap<&'a Path, S> {
        let mut below: HashMap<&Path, S> = HashMap::new();
        for (&folder, &(depth, state)) in &self.own {
            for above in folder.ancestors().take(depth) {
                below.entry(above).and_modify(|own| *own = join(*own, state)).or_insert(state);
            }
        }
        let of_folder = |(&folder, &(depth, state)): (&&'a Path, &(usize, S))| {
            let above = folder.ancestors().take(depth).skip(1).filter_map(|above| self.own.get(above));
            let state = above.fold(below.get(folder).copied().unwrap_or(state), |all, &(_, own)| join(all, own));
            (folder, state)
        };
        self.own.iter().map(of_folder).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_waits_for_what_is_above_and_below_it_and_not_for_its_neighbours() {
        let mut states = FolderStates::default();
        for (folder, depth, since) in
            [("in/k", 1, 1), ("in/k/a", 2, 5), ("in/k/a", 2, 2), ("in/k/b/c", 3, 9), ("in/m/a", 2, 7)]
        {
            states.add(Path::new(folder), depth, since, i32::max);
        }
        let joined = states.into_joined(i32::max);
        for (folder, since) in [("in/k", 9), ("in/k/a", 5), ("in/k/b/c", 9), ("in/m/a", 7)] {
            assert_eq!(joined[Path::new(folder)], since, "{folder}");
        }
        assert_eq!(joined.len(), 4);
    }
}
