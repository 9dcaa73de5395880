//! Writes the whole build as one binary STL, like the source paper.

use std::io::Write;

use glam::DVec3;
use solids::{Mesh, Pose};
use stl_io::{Normal, Triangle, Vertex};

use crate::FileWriteError;

/// Writes placed meshes as one binary STL in mm.
pub fn write_stl<'a>(
    placed: impl Iterator<Item = (&'a Mesh, &'a Pose)>,
    mut out: impl Write,
) -> Result<(), FileWriteError> {
    let placed: Vec<(&Mesh, &Pose)> = placed.collect();
    let left: usize = placed.iter().map(|(mesh, _)| mesh.triangles().len()).sum();
    if left == 0 {
        return Err(FileWriteError::Build("it contains no placements".to_owned()));
    }
    if u32::try_from(left).is_err() {
        return Err(FileWriteError::Build(format!("{left} triangles are more than an STL file can count")));
    }
    let triangles = placed.into_iter().flat_map(|(mesh, pose)| {
        (0..mesh.triangles().len()).map(move |t| stl_facet(mesh.corners(t).map(|corner| pose.transform_point(corner))))
    });
    stl_io::write_stl(&mut out, CountedTriangles { triangles, left })?;
    out.flush()?;
    Ok(())
}

fn stl_facet([a, b, c]: [DVec3; 3]) -> Triangle {
    let single = |v: DVec3| v.as_vec3().to_array();
    let normal = (b - a).cross(c - a).normalize_or_zero();
    Triangle { normal: Normal::new(single(normal)), vertices: [a, b, c].map(|v| Vertex::new(single(v))) }
}

/// An iterator with a known length, since the format writes the count first.
struct CountedTriangles<I> {
    triangles: I,
    left: usize,
}

impl<I: Iterator<Item = Triangle>> Iterator for CountedTriangles<I> {
    type Item = Triangle;

    fn next(&mut self) -> Option<Triangle> {
        self.left = self.left.saturating_sub(1);
        self.triangles.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl<I: Iterator<Item = Triangle>> ExactSizeIterator for CountedTriangles<I> {}
