//! Merges vertices at the same place, and finds the edges at which a surface does not close.

use std::collections::HashMap;

use glam::DVec3;

use crate::MeshDefects;

/// Places that differ by at most this plus [`NOISE_SHARE`] of the largest coordinate count as equal, mm.
const NOISE_MM: f64 = 1e-6;
/// Four units in the last place of a 32-bit float: STL files hold such coordinates.
const NOISE_SHARE: f64 = 4.8e-7;

/// Merges equal vertices; drops triangles that collapse and vertices that no triangle uses.
pub(super) fn weld_equal_vertices(vertices: &[DVec3], triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const UNSEEN: u32 = u32::MAX;
    let mut welder = VertexWelder::default();
    let mut welded = vec![UNSEEN; vertices.len()];
    let mut out = triangles;
    out.retain(|corners| !is_collapsed(corners.map(|v| vertices[v as usize])));
    for corner in out.iter_mut().flatten() {
        let known = &mut welded[*corner as usize];
        if *known == UNSEEN {
            *known = welder.vertex_index(vertices[*corner as usize]);
        }
        *corner = *known;
    }
    (welder.kept, out)
}

/// Whether two corners are the same. -0.0 equals 0.0, so both are merged; NaN was refused before.
fn is_collapsed([a, b, c]: [DVec3; 3]) -> bool {
    a == b || b == c || c == a
}

/// Triangles without common vertices, as STL files hold them, welded while they are read.
#[derive(Debug, Default)]
pub(crate) struct SoupWelder {
    welder: VertexWelder,
    triangles: Vec<[u32; 3]>,
}

impl SoupWelder {
    /// Makes room for so many triangles.
    pub(crate) fn reserve(&mut self, triangles: usize) {
        self.triangles.reserve_exact(triangles);
        // A closed surface has half as many vertices as triangles.
        self.welder.kept.reserve_exact(triangles / 2 + 2);
    }

    /// Adds a triangle of finite corners, unless it collapses.
    pub(super) fn add_triangle(&mut self, corners: [DVec3; 3]) {
        if !is_collapsed(corners) {
            self.triangles.push(corners.map(|corner| self.welder.vertex_index(corner)));
        }
    }

    /// The vertices and the triangles.
    pub(super) fn into_welded(self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        (self.welder.kept, self.triangles)
    }
}

/// Numbers different places in the order of their first occurrence. An open-addressing hash table of indices: a third
/// of the time and memory of a map that stores the places a second time.
#[derive(Debug, Default)]
struct VertexWelder {
    kept: Vec<DVec3>,
    /// Index + 1 of a kept vertex, 0 if free; the length is a power of two.
    slots: Vec<u32>,
}

impl VertexWelder {
    fn vertex_index(&mut self, place: DVec3) -> u32 {
        if 2 * self.kept.len() >= self.slots.len() {
            self.grow_slots();
        }
        let slot = self.find_slot(place);
        if self.slots[slot] == 0 {
            self.kept.push(place);
            self.slots[slot] = self.kept.len() as u32;
        }
        self.slots[slot] - 1
    }

    /// The slot of a place, or the free slot for it.
    fn find_slot(&self, place: DVec3) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash_position(place) as usize & mask;
        while self.slots[slot] != 0 && self.kept[self.slots[slot] as usize - 1] != place {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow_slots(&mut self) {
        self.slots = vec![0; (4 * self.kept.len()).next_power_of_two().max(64)];
        for index in 0..self.kept.len() {
            let slot = self.find_slot(self.kept[index]);
            self.slots[slot] = index as u32 + 1;
        }
    }
}

/// Mixes the bits of three coordinates; adding zero makes -0.0 and 0.0 the same.
fn hash_position(place: DVec3) -> u64 {
    let fold = |state: u64, bits: u64| {
        let wide = u128::from(state ^ bits) * 0x9e37_79b9_7f4a_7c15;
        (wide >> 64) as u64 ^ wide as u64
    };
    (place + DVec3::ZERO).to_array().into_iter().map(f64::to_bits).fold(0x2545_f491_4f6c_dd1d, fold)
}

/// How far places may differ that differ only by the rounding of 32-bit coordinates, as exporters write them, mm.
pub(super) fn noise_of(vertices: &[DVec3]) -> f64 {
    NOISE_MM + NOISE_SHARE * vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max)
}

/// Merges vertices that exact equality left separate: those on defective edges that differ by at most `noise_mm`. Vertices of sound
/// edges do not move.
pub(crate) fn weld_open_edges(
    vertices: &[DVec3],
    triangles: Vec<[u32; 3]>,
    noise_mm: f64,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut loose = vec![false; vertices.len()];
    edge_defects(&triangles, vertices.len(), |a, b| {
        loose[a as usize] = true;
        loose[b as usize] = true;
    });
    let mut mended = vertices.to_vec();
    // The cells are as wide as the noise: a neighbour within it is in one of the 27 surrounding cells.
    let cell = |place: DVec3| (place / noise_mm).floor().as_i64vec3();
    let mut kept: HashMap<glam::I64Vec3, Vec<u32>> = HashMap::new();
    for vertex in (0..vertices.len()).filter(|&v| loose[v]) {
        let place = vertices[vertex];
        let home = cell(place);
        let around = (-1..2).flat_map(|x| (-1..2).flat_map(move |y| (-1..2).map(move |z| glam::I64Vec3::new(x, y, z))));
        let near = around
            .filter_map(|offset| kept.get(&(home + offset)))
            .flatten()
            .find(|&&other| vertices[other as usize].distance(place) <= noise_mm);
        match near {
            Some(&other) => mended[vertex] = vertices[other as usize],
            None => kept.entry(home).or_default().push(vertex as u32),
        }
    }
    weld_equal_vertices(&mended, triangles)
}

/// Counts edges that are not used exactly once in each direction. An edge used twice in each direction (two solids that
/// touch along it) still encloses a volume and is not a defect. `bad` is called with the two vertices of each defective
/// edge.
pub(super) fn edge_defects(triangles: &[[u32; 3]], vertices: usize, mut bad: impl FnMut(u32, u32)) -> MeshDefects {
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    // A counting sort by the lower vertex leaves a handful of edges in each bucket.
    let mut ends = vec![0_usize; vertices + 1];
    edges().for_each(|(a, b)| ends[a.min(b) as usize + 1] += 1);
    for vertex in 0..vertices {
        ends[vertex + 1] += ends[vertex];
    }
    let mut sorted = vec![0_u64; 3 * triangles.len()];
    for (a, b) in edges() {
        let next = &mut ends[a.min(b) as usize];
        sorted[*next] = u64::from(a.max(b)) << 1 | u64::from(a < b);
        *next += 1;
    }
    let mut defects = MeshDefects::default();
    let mut start = 0;
    for (vertex, &end) in ends[..vertices].iter().enumerate() {
        let bucket = &mut sorted[start..end];
        bucket.sort_unstable();
        for edge in bucket.chunk_by(|x, y| x >> 1 == y >> 1) {
            let forward = edge.iter().filter(|&e| e & 1 == 1).count();
            if 2 * forward != edge.len() {
                bad(vertex as u32, (edge[0] >> 1) as u32);
            }
            match (edge.len(), 2 * forward == edge.len()) {
                (_, true) => {}
                (1, _) => defects.open_edges += 1,
                (2, _) => defects.inconsistent_edges += 1,
                _ => defects.non_manifold_edges += 1,
            }
        }
        start = end;
    }
    defects
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_places_keep_the_number_of_their_first_coming() {
        let many: Vec<DVec3> = (0..1000).map(|i| DVec3::new(f64::from(i % 250), 0.0, -0.0)).collect();
        let mut welder = VertexWelder::default();
        let indices: Vec<u32> = many.iter().map(|&place| welder.vertex_index(place)).collect();
        assert!((0..1000).all(|i| indices[i] == i as u32 % 250));
    }
}
