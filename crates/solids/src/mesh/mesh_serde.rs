//! Serialization of a mesh as vertices and triangles: `{ vertices = [[x, y, z], ..], triangles = [[a, b, c], ..] }`.
//! A mesh that is read passes the same checks as in `Mesh::new`. A written mesh is read back with the same vertices
//! in the same order.

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use crate::Mesh;

#[derive(Serialize)]
#[serde(rename = "Mesh")]
struct WrittenMesh<'a> {
    vertices: &'a [DVec3],
    triangles: &'a [[u32; 3]],
}

#[derive(Deserialize)]
#[serde(rename = "Mesh", deny_unknown_fields)]
struct ReadMesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Serialize for Mesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        WrittenMesh { vertices: self.vertices(), triangles: self.triangles() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Mesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = ReadMesh::deserialize(deserializer)?;
        Self::restored(read.vertices, read.triangles).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn came_back(mesh: &Mesh) -> Mesh {
        toml::from_str(&toml::to_string(mesh).expect("is written")).expect("is read")
    }

    #[test]
    fn a_mesh_comes_back_with_its_vertices_in_their_order() {
        // The second mesh is inside out. Its construction flips the triangles, so that their corners no longer have
        // the order in which the vertices were numbered.
        let corners = [DVec3::ZERO, DVec3::X / 3.0, DVec3::Y * 70.0, DVec3::Z * 1e-3].to_vec();
        for triangles in [[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], [[2, 0, 1], [1, 0, 3], [3, 0, 2], [2, 1, 3]]] {
            let mesh = Mesh::new(corners.clone(), triangles.to_vec()).expect("is a solid");
            let back = came_back(&mesh);
            assert_eq!((back.vertices(), back.triangles()), (mesh.vertices(), mesh.triangles()));
            assert_eq!(back.volume_mm3().to_bits(), mesh.volume_mm3().to_bits());
            assert_eq!(back.bounds(), mesh.bounds());
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused_and_what_needs_mending_is_mended() {
        let read = |text: &str| toml::from_str::<Mesh>(text).map_err(|error| error.to_string());
        let beyond = "vertices = [[0.0, 0.0, 0.0]]\ntriangles = [[0, 0, 7]]";
        assert!(read(beyond).is_err_and(|error| error.contains("names vertex 7")));
        let soup = "vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]\n\
                    triangles = [[0, 1, 2], [0, 3, 1], [4, 2, 3], [1, 3, 2]]";
        let mended = read(soup).expect("is a solid");
        assert!(mended.vertices().len() == 4 && mended.volume_mm3() > 0.0 && mended.defects().is_closed());
    }
}
