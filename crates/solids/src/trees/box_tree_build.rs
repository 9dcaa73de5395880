//! Builds a tree of boxes over the triangles of a mesh: from the root downwards, each node divided where the surface area
//! heuristic is least over a few bins. Nothing is sorted, and a pass over a node's triangles measures both of its
//! children. Large nodes are built on several threads; the tree is the same for any number of them.

use glam::{DVec3, Vec3, Vec3A};

use super::node_box::{TreeNodeBox, TreeNodeLink};
use crate::{Bounds, Mesh, Pose};

/// Greatest number of triangles in a leaf: with fewer, testing boxes costs more than it saves.
pub(crate) const MAX_LEAF_TRIANGLES: usize = 4;
/// Number of bins along an axis, between which a node may be divided.
const BINS: usize = 16;
/// The same for nodes of at most [`FEW_TRIANGLES`], of which there are so many that their bins would cost the most.
const FEW_BINS: usize = 6;
/// Greatest number of triangles of a node with few bins.
const FEW_TRIANGLES: usize = 48;
/// With more triangles, a sample of them is used to choose a split.
const SPLIT_SAMPLE: usize = 2048;
/// Below this depth, nodes are halved by count, so that a traversal is never deeper than about twice 40.
const MAX_UNEVEN_DEPTH: usize = 24;
/// Nodes with fewer triangles are not worth a thread.
const MIN_TRIANGLES_PER_THREAD: usize = 20_000;

/// A tree without its triangles.
#[derive(Debug)]
pub(crate) struct BuiltTreeNodes {
    pub boxes: Vec<TreeNodeBox>,
    pub links: Vec<TreeNodeLink>,
    /// The mesh's triangles in the order of the leaves.
    pub order: Vec<u32>,
    /// The exact bounds in the frame of the boxes.
    pub bounds: Bounds,
}

/// Builds the nodes over a mesh on at most `threads` threads; `to_box` transforms the mesh to the tree's frame.
pub(super) fn build_nodes(mesh: &Mesh, to_box: &Pose, threads: usize) -> BuiltTreeNodes {
    assert!(2 * mesh.triangles().len() < TreeNodeLink::MAX_FIRST, "a mesh has at most 268 million triangles");
    let (rotation, shift) = (to_box.rotation_matrix(), to_box.translation);
    let mut bounds = Bounds::EMPTY;
    let mut whole = EntryExtent::EMPTY;
    let entry = |index: usize| {
        let [a, b, c] = mesh.corners(index).map(|corner| rotation * corner + shift);
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        bounds = Bounds { min: bounds.min.min(min), max: bounds.max.max(max) };
        let entry = TriangleEntry { min: rounded_down(min), max: rounded_up(max), index: index as u32 };
        whole.add_entry(&entry);
        entry
    };
    let mut entries: Vec<TriangleEntry> = (0..mesh.triangles().len()).map(entry).collect();
    let root = vec![whole.node_box()];
    let mut list = TreeNodeList { boxes: root, links: vec![TreeNodeLink::to_children(0)] };
    list.boxes.reserve(entries.len() * 3 / 4);
    list.links.reserve(entries.len() * 3 / 4);
    build_below(&mut list, 0, &mut entries, SubtreeTask { extent: whole, first: 0, depth: 0, threads });
    let order = entries.iter().map(|entry| entry.index).collect();
    list.boxes.shrink_to_fit();
    list.links.shrink_to_fit();
    BuiltTreeNodes { boxes: list.boxes, links: list.links, order, bounds }
}

fn rounded_down(v: DVec3) -> Vec3 {
    let down = |v: f64| if f64::from(v as f32) > v { (v as f32).next_down() } else { v as f32 };
    Vec3::new(down(v.x), down(v.y), down(v.z))
}

fn rounded_up(v: DVec3) -> Vec3 {
    -rounded_down(-v)
}

/// A triangle while the tree is built: its box, in the frame of the boxes.
#[derive(Debug, Clone, Copy)]
struct TriangleEntry {
    min: Vec3,
    max: Vec3,
    index: u32,
}

impl TriangleEntry {
    #[inline]
    fn corners(&self) -> (Vec3A, Vec3A) {
        (self.min.into(), self.max.into())
    }
}

/// The box around some entries, and the box around twice their middles.
#[derive(Debug, Clone, Copy)]
struct EntryExtent {
    min: Vec3A,
    max: Vec3A,
    least_sum: Vec3A,
    most_sum: Vec3A,
}

impl EntryExtent {
    const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
        least_sum: Vec3A::INFINITY,
        most_sum: Vec3A::NEG_INFINITY,
    };

    #[inline]
    fn add_entry(&mut self, entry: &TriangleEntry) {
        let (min, max) = entry.corners();
        let sum = min + max;
        self.min = self.min.min(min);
        self.max = self.max.max(max);
        self.least_sum = self.least_sum.min(sum);
        self.most_sum = self.most_sum.max(sum);
    }

    fn of_entries(entries: &[TriangleEntry]) -> Self {
        let mut extent = Self::EMPTY;
        entries.iter().for_each(|entry| extent.add_entry(entry));
        extent
    }

    fn node_box(&self) -> TreeNodeBox {
        TreeNodeBox::between_corners(self.min, self.max)
    }

    /// Bins per length of twice the middles.
    fn bin_scale(&self, bins: usize) -> Vec3A {
        // A hair less, so that rounding never makes a bin too many.
        Vec3A::splat(bins as f32 * 0.999_999) / (self.most_sum - self.least_sum)
    }
}

/// Nodes under construction.
#[derive(Debug, Default)]
struct TreeNodeList {
    boxes: Vec<TreeNodeBox>,
    links: Vec<TreeNodeLink>,
}

/// What is known of a node when the nodes below it are built.
#[derive(Debug, Clone, Copy)]
struct SubtreeTask {
    extent: EntryExtent,
    /// Place of the first of its triangles in the tree's order.
    first: usize,
    depth: usize,
    threads: usize,
}

/// Builds all below node `at` of a list and links the node to it.
fn build_below(list: &mut TreeNodeList, at: usize, entries: &mut [TriangleEntry], task: SubtreeTask) {
    if entries.len() <= MAX_LEAF_TRIANGLES {
        list.links[at] = TreeNodeLink::to_triangles(task.first, entries.len());
        return;
    }
    let (middle, extents) = split_entries(entries, &task);
    let child = list.boxes.len();
    list.links[at] = TreeNodeLink::to_children(child);
    list.boxes.extend(extents.map(|extent| extent.node_box()));
    list.links.extend([TreeNodeLink::to_children(0); 2]);
    let (left, right) = entries.split_at_mut(middle);
    let (first, depth) = (task.first, task.depth + 1);
    let threads = if entries_are_many(left, right) { task.threads } else { 1 };
    let half = threads / 2;
    let task1 = SubtreeTask { extent: extents[0], first, depth, threads: threads - half };
    let task2 = SubtreeTask { extent: extents[1], first: first + middle, depth, threads: half.max(1) };
    if half == 0 {
        build_below(list, child, left, task1);
        build_below(list, child + 1, right, task2);
        return;
    }
    let mut lists = [extents[0], extents[1]]
        .map(|extent| TreeNodeList { boxes: vec![extent.node_box()], links: vec![TreeNodeLink::to_children(0)] });
    let [list1, list2] = &mut lists;
    std::thread::scope(|scope| {
        scope.spawn(|| build_below(list2, 0, right, task2));
        build_below(list1, 0, left, task1);
    });
    for (at, part) in lists.into_iter().enumerate() {
        // The first node of the part is there already.
        let shift = list.boxes.len() - 1;
        list.links[child + at] = part.links[0].shifted_by(shift);
        list.boxes.extend_from_slice(&part.boxes[1..]);
        list.links.extend(part.links[1..].iter().map(|link| link.shifted_by(shift)));
    }
}

fn entries_are_many(left: &[TriangleEntry], right: &[TriangleEntry]) -> bool {
    left.len().min(right.len()) >= MIN_TRIANGLES_PER_THREAD
}

/// Orders entries into two groups. Returns the size of the first, and the extents of both.
fn split_entries(entries: &mut [TriangleEntry], task: &SubtreeTask) -> (usize, [EntryExtent; 2]) {
    let extent = &task.extent;
    let best = if task.depth < MAX_UNEVEN_DEPTH { cheapest_plane(entries, extent) } else { None };
    if let Some((axis, plane)) = best {
        let bins = bin_count(entries);
        let (least, scale) = (extent.least_sum[axis], extent.bin_scale(bins)[axis]);
        let mut extents = [EntryExtent::EMPTY; 2];
        let mut middle = 0;
        for i in 0..entries.len() {
            let entry = entries[i];
            let is_left = bin_index(entry.min[axis] + entry.max[axis], least, scale, bins) < plane;
            extents[usize::from(!is_left)].add_entry(&entry);
            if is_left {
                entries.swap(i, middle);
                middle += 1;
            }
        }
        return (middle, extents);
    }
    let axis = Vec3::from(extent.most_sum - extent.least_sum).max_position();
    let middle = entries.len() / 2;
    let place = |entry: &TriangleEntry| entry.min[axis] + entry.max[axis];
    entries.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)));
    let (left, right) = entries.split_at(middle);
    (middle, [EntryExtent::of_entries(left), EntryExtent::of_entries(right)])
}

fn bin_count(entries: &[TriangleEntry]) -> usize {
    if entries.len() <= FEW_TRIANGLES { FEW_BINS } else { BINS }
}

#[inline]
fn bin_index(sum: f32, least: f32, scale: f32, bins: usize) -> usize {
    (((sum - least) * scale) as usize).min(bins - 1)
}

/// The axis and bin border with the least cost by the surface area heuristic; `None` when all middles coincide.
fn cheapest_plane(entries: &[TriangleEntry], extent: &EntryExtent) -> Option<(usize, usize)> {
    let step = (entries.len() / SPLIT_SAMPLE).max(1);
    let count = bin_count(entries);
    let empty = (Vec3A::INFINITY, Vec3A::NEG_INFINITY, 0_u32);
    let mut all_bins = [[empty; BINS]; 3];
    let scale = extent.bin_scale(count);
    for entry in entries.iter().step_by(step) {
        let (min, max) = entry.corners();
        let at = (min + max - extent.least_sum) * scale;
        for axis in 0..3 {
            // An axis along which all middles coincide has no scale: its first bin takes all.
            let bin = &mut all_bins[axis][(at[axis] as usize).min(count - 1)];
            *bin = (bin.0.min(min), bin.1.max(max), bin.2 + 1);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for (axis, bins) in all_bins.iter().enumerate() {
        if extent.most_sum[axis] <= extent.least_sum[axis] {
            continue;
        }
        // The cost of what is left of each plane, then that of what is right of it.
        let mut costs = [f32::INFINITY; BINS];
        let mut below = empty;
        for plane in 1..count {
            below = join_counted_boxes(below, &bins[plane - 1]);
            costs[plane] = cost_of(&below);
        }
        let mut above = empty;
        for plane in (1..count).rev() {
            above = join_counted_boxes(above, &bins[plane]);
            let cost = costs[plane] + cost_of(&above);
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, plane));
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

/// A box, and the number of triangles in it.
type CountedBox = (Vec3A, Vec3A, u32);

#[inline]
fn join_counted_boxes(one: CountedBox, other: &CountedBox) -> CountedBox {
    (one.0.min(other.0), one.1.max(other.1), one.2 + other.2)
}

/// The surface area of a box times its triangles; no side of a plane may be empty.
#[inline]
fn cost_of(&(min, max, count): &CountedBox) -> f32 {
    let size = max - min;
    if count == 0 { f32::INFINITY } else { (size.x * size.y + size.y * size.z + size.z * size.x) * count as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Obb, fixtures::star};

    #[test]
    fn the_tree_is_the_same_for_any_number_of_threads_and_holds_each_triangle_once() {
        let mesh = star(7, |d| 20.0 + 3.0 * (5.0 * d.x).sin() * (4.0 * d.y).cos());
        let to_box = Obb::smallest_around(&mesh).pose.inverse();
        let one = build_nodes(&mesh, &to_box, 1);
        for threads in [2, 3, 8] {
            let many = build_nodes(&mesh, &to_box, threads);
            assert_eq!(many.order, one.order);
            assert!(many.links.iter().zip(&one.links).all(|(a, b)| format!("{a:?}") == format!("{b:?}")));
            assert!(many.boxes.iter().zip(&one.boxes).all(|(a, b)| a.center == b.center && a.half == b.half));
        }
        let mut seen = one.order.clone();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(at, &index)| at as u32 == index));
        let leaves = one.links.iter().filter(|link| link.is_leaf()).map(|link| link.triangle_range().len());
        assert_eq!(leaves.sum::<usize>(), mesh.triangles().len());
    }

    #[test]
    fn every_box_holds_the_triangles_below_it() {
        let mesh = star(4, |d| 1.0 / 3.0 + 0.1 * d.x.sin());
        let to_box = Pose { translation: DVec3::new(777.7, -0.1, 1e-3), ..Obb::smallest_around(&mesh).pose.inverse() };
        let tree = build_nodes(&mesh, &to_box, 1);
        let mut open = vec![(0, vec![])];
        while let Some((node, above)) = open.pop() {
            let above: Vec<usize> = above.into_iter().chain([node]).collect();
            let link = tree.links[node];
            if !link.is_leaf() {
                open.extend([0, 1].map(|child| (link.first_child() + child, above.clone())));
                continue;
            }
            for &index in &tree.order[link.triangle_range()] {
                for corner in mesh.corners(index as usize).map(|c| to_box.transform_point(c)) {
                    assert!((tree.bounds.min - corner).max(corner - tree.bounds.max).max_element() <= 1e-12);
                    for &node in &above {
                        let TreeNodeBox { center, half } = tree.boxes[node];
                        let slack = 1e-12; // of the transformation by a quaternion
                        assert!(((corner - center.as_dvec3()).abs() - half.as_dvec3()).max_element() <= slack);
                    }
                }
            }
        }
    }
}
