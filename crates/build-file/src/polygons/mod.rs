//! OBJ and PLY: formats whose faces may have any number of corners.

pub(super) mod obj_read;
pub(super) mod ply_read;

use earcut::{Earcut, deviation, utils3d::project3d_to_2d};
use glam::DVec3;

use crate::{FileReadError, LengthUnit, ReadLimits, common::solid::WeldedSurface};

/// A corner may turn the wrong way by this share of its edges: numbers in text are rounded.
const FLAT: f64 = 1e-9;
/// The areas of a face and of its triangles may differ by this share.
const ROUNDED: f64 = 1e-6;

/// Remedy for surfaces that are no faces, and for faces that are no surface.
const TRIANGLES_ONLY: &str = "Export the part once more with triangles only, or as STL or 3MF.";

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
            return Err(FileReadError::too_many_triangles(self.limits));
        }
        let Some(triangles) = triangles_of(corners) else {
            return Err(FileReadError::Unsupported {
                what: format!("face {} has {} corners, and they enclose no area", self.faces, corners.len()),
                remedy: TRIANGLES_ONLY,
            });
        };
        triangles.into_iter().for_each(|triangle| self.surface.add_triangle(triangle.map(|at| corners[at])));
        Ok(())
    }
}

/// Splits a face into triangles that have all its corners: a fan where one corner sees all of it, else by cutting ears. `None` = its
/// edges cross, or it is no area.
fn triangles_of(corners: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let count = corners.len();
    if let Some(first) = fan_start(corners) {
        return Some((1..count - 1).map(|at| [first, first + at, first + at + 1].map(|at| at % count)).collect());
    }
    let (mut flat, mut cut) = (Vec::new(), Vec::<u32>::new());
    let places: Vec<[f64; 3]> = corners.iter().map(|corner| corner.to_array()).collect();
    if !project3d_to_2d(&places, count, &mut flat) {
        return None;
    }
    Earcut::new().earcut(flat.iter().copied(), &[] as &[u32], &mut cut);
    let covers = deviation(flat.iter().copied(), &[] as &[u32], &cut) < ROUNDED;
    let whole: DVec3 = areas(corners, 0).sum();
    let as_wound = |triangle: &[u32]| {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|at| at as usize);
        let is_turned = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(whole) < 0.0;
        if is_turned { [a, c, b] } else { [a, b, c] }
    };
    (covers && cut.len() == 3 * (count - 2)).then(|| cut.chunks_exact(3).map(as_wound).collect())
}

/// The first corner from which triangles to all other edges cover the face and nothing else; `None` = there is none.
fn fan_start(corners: &[DVec3]) -> Option<usize> {
    let whole: DVec3 = areas(corners, 0).sum();
    let size = whole.length_squared();
    let is_right = |first: &usize| areas(corners, *first).all(|area| area.dot(whole) >= -FLAT * size);
    if corners.len() == 3 { Some(0) } else { (0..corners.len()).filter(|_| size > 0.0).find(is_right) }
}

/// Twice the areas of the triangles from a corner to the other edges, as vectors.
fn areas(corners: &[DVec3], first: usize) -> impl Iterator<Item = DVec3> {
    let around = move |at: usize| corners[(first + at) % corners.len()] - corners[first];
    (1..corners.len().saturating_sub(1)).map(move |at| around(at).cross(around(at + 1)))
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
        let corners = u.map(|[x, y]| DVec3::new(x, 2.0, y));
        for turned in [false, true] {
            let mut corners = corners;
            if turned {
                corners.reverse();
            }
            let whole: DVec3 = areas(&corners, 0).sum();
            let triangles = triangles_of(&corners).unwrap();
            let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]);
            assert!(triangles.len() == 6 && triangles.iter().all(|&triangle| area(triangle).dot(whole) > 0.0));
            assert!((triangles.iter().map(|&triangle| area(triangle)).sum::<DVec3>() - whole).length() < 1e-9);
        }
        let eight = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]];
        assert_eq!(triangles_of(&eight.map(|[x, y]| DVec3::new(x, y, 0.0))), None, "its edges cross");
    }
}
