//! Counts the shells of a surface: triangles that share a vertex belong to the same shell.

use super::Mesh;

impl Mesh {
    /// Number of shells: pieces of the surface that share no vertex. Time grows with the triangles.
    pub fn shell_count(&self) -> usize {
        let mut above: Vec<u32> = (0..self.vertices().len() as u32).collect();
        for &[a, b, c] in self.triangles() {
            let top = find_root(&mut above, a);
            for other in [b, c] {
                let other = find_root(&mut above, other);
                above[other as usize] = top;
            }
        }
        above.iter().enumerate().filter(|&(vertex, &above)| vertex as u32 == above).count()
    }
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
