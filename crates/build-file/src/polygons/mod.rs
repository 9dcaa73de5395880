//! OBJ and PLY: formats whose faces may have any number of corners.

pub(super) mod obj_read;
pub(super) mod ply_read;

use glam::DVec3;

use crate::{FileReadError, LengthUnit, ReadLimits, common::solid::WeldedSurface};

/// A corner may turn the wrong way by this share of its edges: numbers in text are rounded.
const FLAT: f64 = 1e-9;

/// The faces of a file, as triangles.
struct PolygonSurface<'l> {
    surface: WeldedSurface,
    faces: u64,
    triangles: u64,
    limits: &'l ReadLimits,
}

impl<'l> PolygonSurface<'l> {
    fn new(format: &'static str, unit: LengthUnit, limits: &'l ReadLimits) -> Self {
        Self { surface: WeldedSurface::new(format, unit, 0), faces: 0, triangles: 0, limits }
    }

    /// Adds a face of three corners or more.
    fn add_face(&mut self, corners: &[DVec3]) -> Result<(), FileReadError> {
        self.faces += 1;
        self.triangles += (corners.len() as u64).saturating_sub(2);
        if self.triangles > self.limits.max_triangles {
            return Err(too_many_triangles(self.limits));
        }
        let Some(first) = fan_start(corners) else {
            return Err(FileReadError::Unsupported {
                what: format!("face {} has {} corners, and no corner sees all of it", self.faces, corners.len()),
                remedy: "Export the part once more with triangles only, or as STL or 3MF.",
            });
        };
        for at in 1..corners.len().saturating_sub(1) {
            let corner = |steps: usize| corners[(first + steps) % corners.len()];
            self.surface.add_triangle([corner(0), corner(at), corner(at + 1)]);
        }
        Ok(())
    }
}

fn too_many_triangles(limits: &ReadLimits) -> FileReadError {
    let what = "it has too many triangles".to_owned();
    FileReadError::TooLarge { what, limit: limits.max_triangles, key: "max_triangles" }
}

/// The first corner from which triangles to all other edges cover the face and nothing else; `None` = there is none.
fn fan_start(corners: &[DVec3]) -> Option<usize> {
    let count = corners.len();
    let around = |first: usize, at: usize| corners[(first + at) % count] - corners[first];
    let areas =
        |first: usize| (1..count.saturating_sub(1)).map(move |at| around(first, at).cross(around(first, at + 1)));
    let whole: DVec3 = areas(0).sum();
    let size = whole.length();
    (0..count).find(|&first| count == 3 || areas(first).all(|area| area.dot(whole) >= -FLAT * size * size))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(corners: &[[f64; 2]]) -> Option<usize> {
        fan_start(&corners.iter().map(|&[x, y]| DVec3::new(x, y, 5.0)).collect::<Vec<_>>())
    }

    #[test]
    fn a_fan_begins_where_it_covers_its_face_and_nothing_else() {
        assert_eq!(start(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]), Some(0));
        // An arrow head: only its inner corner and its tip see all of it.
        let arrow = [[0.0, 0.0], [4.0, 4.0], [0.0, 1.0], [-4.0, 4.0]];
        assert_eq!(start(&arrow), Some(0));
        assert_eq!(start(&[arrow[1], arrow[2], arrow[3], arrow[0]]), Some(1));
        // A U: no corner sees both of its arms.
        let u = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [4.0, 6.0], [4.0, 2.0], [2.0, 2.0], [2.0, 6.0], [0.0, 6.0]];
        assert_eq!(start(&u), None);
    }
}
