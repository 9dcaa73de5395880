//! The shells of a surface: triangles that share a vertex belong to the same shell.

use crate::Mesh;

/// The shells of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct MeshShells {
    /// The shell of each vertex; empty where there is only one.
    shell_of: Vec<u32>,
    /// A vertex of each shell.
    first_vertices: Vec<u32>,
}

impl MeshShells {
    /// A vertex of each shell.
    pub fn first_vertices(&self) -> &[u32] {
        &self.first_vertices
    }

    /// The shell to which a vertex belongs.
    pub fn shell_of_vertex(&self, vertex: u32) -> usize {
        self.shell_of.get(vertex as usize).map_or(0, |&shell| shell as usize)
    }
}

impl Mesh {
    /// Number of shells: pieces of the surface that share no vertex. Time grows with the triangles.
    pub fn shell_count(&self) -> usize {
        let above = joined_vertices(self);
        above.iter().enumerate().filter(|&(vertex, &above)| vertex as u32 == above).count()
    }
}

/// Finds the shells of a mesh.
pub(crate) fn find_shells(mesh: &Mesh) -> MeshShells {
    let mut above = joined_vertices(mesh);
    let is_root = |&vertex: &u32| above[vertex as usize] == vertex;
    let first_vertices: Vec<u32> = (0..above.len() as u32).filter(is_root).collect();
    if first_vertices.len() == 1 {
        return MeshShells { shell_of: Vec::new(), first_vertices };
    }
    let number = |root: u32| first_vertices.partition_point(|&vertex| vertex < root) as u32;
    let shell_of = (0..above.len() as u32).map(|vertex| number(find_root(&mut above, vertex))).collect();
    MeshShells { shell_of, first_vertices }
}

/// For each vertex one above it in its shell; the topmost one of a shell is above itself.
fn joined_vertices(mesh: &Mesh) -> Vec<u32> {
    let mut above: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    for &[a, b, c] in mesh.triangles() {
        let top = find_root(&mut above, a);
        for other in [b, c] {
            let other = find_root(&mut above, other);
            above[other as usize] = top;
        }
    }
    above
}

/// The representative vertex of a piece (union-find with path halving).
fn find_root(above: &mut [u32], mut vertex: u32) -> u32 {
    while above[vertex as usize] != vertex {
        let higher = above[above[vertex as usize] as usize];
        above[vertex as usize] = higher;
        vertex = higher;
    }
    vertex
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn pieces_that_share_no_vertex_are_shells_of_their_own() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        for count in [1_u32, 2, 700] {
            let vertices = (0..count).flat_map(|n| corners.map(|c| c + DVec3::X * 3.0 * f64::from(n))).collect();
            let triangles = (0..count).flat_map(|n| faces.map(|face| face.map(|v| v + 4 * n))).collect();
            assert_eq!(Mesh::new(vertices, triangles).expect("is a solid").shell_count(), count as usize);
        }
    }
}
