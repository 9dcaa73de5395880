//! Build items that touch, pass through each other or lie in one place: parts of an assembly, or copies that somebody only
//! stacked. As parts of their own they would be placed anywhere, so a person is asked. Boxes first, then the triangles.

use std::{
    cell::OnceCell,
    collections::{BTreeSet, HashMap},
};

use glam::{DQuat, DVec3};
use solids::{Bounds, ClearanceTree, Pose};

use super::slicer_project::listed;
use crate::{PartFileSolid, format_count};

/// Items that were arranged to be printed as parts of their own keep a greater distance; parts of a mechanism that is
/// printed as a whole do not.
const NEAR_MM: f64 = 0.5;
/// Items nearer to each other than this lie in the same place.
const SAME_PLACE_MM: f64 = 1e-6;
/// Pairs of boxes that are compared; for more items the question is asked unseen.
const MAX_BOX_PAIRS: u64 = 50_000_000;
/// Pairs of items whose triangles are compared.
const MAX_EXACT_PAIRS: u64 = 100_000;

/// A build item of a solid.
struct BoxedItem {
    solid: usize,
    place: DVec3,
    bounds: Bounds,
}

/// What was found of the items of each solid.
struct ContactSearch<'a> {
    solids: &'a [PartFileSolid],
    trees: Vec<OnceCell<ClearanceTree>>,
    /// Names of the solids that the items of each solid touch.
    touched: Vec<BTreeSet<usize>>,
}

/// Asks of each solid with items that touch others or lie in one place. `places` are those of its items, mm.
pub(super) fn ask_about_contacts(solids: &mut [PartFileSolid], places: &[Vec<DVec3>]) {
    if places.iter().map(Vec::len).sum::<usize>() < 2 {
        return;
    }
    let mut search = ContactSearch {
        solids,
        trees: solids.iter().map(|_| OnceCell::new()).collect(),
        touched: vec![BTreeSet::new(); solids.len()],
    };
    let is_whole = search.find_contacts(&sorted_items(solids, places));
    let touched = search.touched;
    let questions: Vec<String> = (0..solids.len())
        .map(|solid| {
            let stacked = count_by_place(&places[solid]).into_values().map(|(_, count)| count).max().unwrap_or(0);
            let names: BTreeSet<String> = touched[solid].iter().map(|&other| shown(solids, solid, other)).collect();
            let mut found = Vec::new();
            if stacked > 1 {
                let all = format_count(places[solid].len(), "build item lies", "build items lie");
                found.push(format!("{stacked} of its {all} in one place"));
            }
            if !names.is_empty() {
                found.push(format!("in the file it touches or passes through {}", listed(&names)));
            } else if !is_whole && found.is_empty() {
                found.push("the file has too many build items to see whether they touch".to_owned());
            }
            found.join(", and ")
        })
        .collect();
    for (solid, found) in solids.iter_mut().zip(questions).filter(|(_, found)| !found.is_empty()) {
        solid.question = Some(format!(
            "{found}, and each item would be a part of its own, placed anywhere (items that belong together must be \
             dropped joined, as one object or as STL)"
        ));
    }
}

/// The name of a solid for a question about another one.
fn shown(solids: &[PartFileSolid], of: usize, other: usize) -> String {
    if of == other { "another copy of itself".to_owned() } else { format!("\"{}\"", solids[other].name) }
}

/// The number of items in each place.
fn count_by_place(places: &[DVec3]) -> HashMap<[i64; 3], (DVec3, usize)> {
    let mut counts = HashMap::new();
    for &place in places {
        let steps = place.to_array().map(|mm| (mm / SAME_PLACE_MM).round() as i64);
        counts.entry(steps).or_insert((place, 0)).1 += 1;
    }
    counts
}

/// All items, of those in one place one, along the axis over which they are spread the most, and this axis.
fn sorted_items(solids: &[PartFileSolid], places: &[Vec<DVec3>]) -> (Vec<BoxedItem>, usize) {
    let mut items = Vec::new();
    for (solid, places) in places.iter().enumerate() {
        let bounds = solids[solid].mesh.bounds();
        items.extend(count_by_place(places).into_values().map(|(place, _)| BoxedItem {
            solid,
            place,
            bounds: Bounds { min: bounds.min + place, max: bounds.max + place },
        }));
    }
    let spread = Bounds::from_points(items.iter().map(|item| item.bounds.center())).size();
    let axis = (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b])).unwrap_or(0);
    items.sort_by(|a, b| a.bounds.min[axis].total_cmp(&b.bounds.min[axis]));
    (items, axis)
}

impl ContactSearch<'_> {
    /// Finds which solids touch. Returns whether all pairs were compared.
    fn find_contacts(&mut self, (items, axis): &(Vec<BoxedItem>, usize)) -> bool {
        let (mut box_pairs, mut exact_pairs) = (0, 0);
        for (at, one) in items.iter().enumerate() {
            let reach = one.bounds.max[*axis] + NEAR_MM;
            for other in items[at + 1..].iter().take_while(|other| other.bounds.min[*axis] <= reach) {
                box_pairs += 1;
                if box_pairs > MAX_BOX_PAIRS || exact_pairs > MAX_EXACT_PAIRS {
                    return false;
                }
                let is_known = self.touched[one.solid].contains(&other.solid);
                if is_known || one.bounds.distance(&other.bounds) >= NEAR_MM {
                    continue;
                }
                exact_pairs += 1;
                if self.is_contact(one, other) {
                    self.touched[one.solid].insert(other.solid);
                    self.touched[other.solid].insert(one.solid);
                }
            }
        }
        true
    }

    /// Whether two items come nearer than parts of their own would, or one lies inside the other.
    fn is_contact(&self, one: &BoxedItem, other: &BoxedItem) -> bool {
        let tree = |solid: usize| self.trees[solid].get_or_init(|| ClearanceTree::new(self.solids[solid].mesh.clone()));
        let (first, second) = (tree(one.solid), tree(other.solid));
        let pose12 = Pose::new(DQuat::IDENTITY, other.place - one.place);
        first.is_closer_than(second, &pose12, NEAR_MM)
            || first.contains_part(second, &pose12)
            || second.contains_part(first, &pose12.inverse())
    }
}
