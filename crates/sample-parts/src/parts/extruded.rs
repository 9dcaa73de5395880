//! Parts of constant or stepped thickness: plates, gears, clips, hinges.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use solids::Mesh;

use crate::making::{
    layers::{extrude_layers, extrude_prism},
    outline::{PlanarOutline, arc, circle, rectangle, rounded_rectangle, stroke_path},
};

/// Levels from 0 to `height` in `n` equal slabs.
fn equal_levels(height: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| height * i as f64 / n as f64).collect()
}

/// A box of 12 triangles from the origin, mm. Too simple for a sample, but useful for tests.
pub fn cuboid(size_mm: DVec3) -> Mesh {
    extrude_prism(PlanarOutline::new(rectangle(DVec2::ZERO, size_mm.truncate())), &[0.0, size_mm.z]).into_mesh()
}

/// A flat mounting bracket with rounded corners and a screw hole near each end, mm.
pub fn bracket(length_mm: f64, width_mm: f64, thickness_mm: f64, hole_mm: f64) -> Mesh {
    let (size, middle) = (DVec2::new(length_mm, width_mm), width_mm / 2.0);
    let mut plate = PlanarOutline::new(rounded_rectangle(DVec2::ZERO, size, width_mm / 4.0, 12));
    for x in [middle, length_mm - middle] {
        plate = plate.with_hole(circle(DVec2::new(x, middle), hole_mm / 2.0, 32, 0.0));
    }
    extrude_prism(plate, &equal_levels(thickness_mm, 2)).into_mesh()
}

/// An angle bracket of two legs with `ribs` concave gussets between them, mm.
pub fn ribbed_bracket(leg_mm: f64, width_mm: f64, thickness_mm: f64, ribs: usize) -> Mesh {
    let (t, a, reach) = (thickness_mm, leg_mm, 0.8 * leg_mm);
    let (inner, low, high) = (DVec2::splat(t), DVec2::new(reach, t), DVec2::new(t, reach));
    // Concave: the arc's centre lies outside the rib.
    let hollow = arc(DVec2::splat(reach), reach - t, 1.5 * PI, PI, 32);
    let angle =
        [DVec2::ZERO, DVec2::new(a, 0.0), DVec2::new(a, t), low, inner, high, DVec2::new(t, a), DVec2::new(0.0, a)];
    let mut rib = vec![inner, low];
    rib.extend(&hollow[1..hollow.len() - 1]);
    rib.push(high);
    // Ribs keep a gap of at least half a thickness.
    let ribs = ribs.min(((width_mm - t) / (1.5 * t)) as usize + 1).max(2);
    let pitch = (width_mm - t) / (ribs - 1) as f64;
    let levels: Vec<f64> = (0..ribs).flat_map(|i| [pitch * i as f64, pitch * i as f64 + t]).collect();
    let regions = [PlanarOutline::new(angle.to_vec()), PlanarOutline::new(rib)];
    extrude_layers(&regions, &levels, |region, slab| region == 0 || slab % 2 == 0, |_, _| true).into_mesh()
}

/// A spur gear with a bore and a keyway, mm; module = pitch diameter / teeth.
pub fn spur_gear(teeth: usize, module_mm: f64, width_mm: f64, bore_mm: f64) -> Mesh {
    let pitch_radius = module_mm * teeth as f64 / 2.0;
    let (root, tip) = (pitch_radius - 1.25 * module_mm, pitch_radius + module_mm);
    // Half widths of a tooth as shares of the pitch, from root to tip: close to a 20 degree involute.
    let flank = [(0.0, 0.40), (0.28, 0.325), (0.55, 0.25), (0.8, 0.175), (1.0, 0.115)];
    let tooth = |i: usize| {
        let point = move |side: f64, (rise, half): (f64, f64)| {
            let turn = (i as f64 + side * half) / teeth as f64;
            (root + rise * (tip - root)) * DVec2::from_angle(TAU * turn)
        };
        flank.into_iter().map(move |f| point(-1.0, f)).chain(flank.into_iter().rev().map(move |f| point(1.0, f)))
    };
    let outer: Vec<DVec2> = (0..teeth).flat_map(tooth).collect();
    let bore = bore_mm / 2.0;
    let key = bore / 3.0;
    let start = (key / bore).asin();
    let mut hole = arc(DVec2::ZERO, bore, start, TAU - start, 40);
    hole.extend([DVec2::new(1.25 * bore, -key), DVec2::new(1.25 * bore, key)]);
    extrude_prism(PlanarOutline::new(outer).with_hole(hole), &equal_levels(width_mm, 2)).into_mesh()
}

/// A plate of hexagonal cells in a frame, mm; `cell_mm` is the pitch, `wall_mm` the wall between two cells.
pub fn honeycomb(columns: usize, rows: usize, cell_mm: f64, wall_mm: f64, height_mm: f64) -> Mesh {
    let row_pitch = cell_mm * 0.75f64.sqrt();
    let radius = (cell_mm - wall_mm) / 3.0f64.sqrt();
    let size =
        DVec2::new(cell_mm * (columns as f64 + 0.5), row_pitch * (rows - 1) as f64 + 2.0 * radius) + 2.0 * wall_mm;
    let mut plate = PlanarOutline::new(rectangle(DVec2::ZERO, size));
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let x = wall_mm + cell_mm * (column as f64 + if row % 2 == 0 { 0.5 } else { 1.0 });
        let y = wall_mm + radius + row_pitch * row as f64;
        plate = plate.with_hole(circle(DVec2::new(x, y), radius, 6, 0.25));
    }
    extrude_prism(plate, &[0.0, height_mm]).into_mesh()
}

/// A springy C with flared lips, mm: a clip for pipes of `pipe_mm`.
pub fn clip(pipe_mm: f64, thickness_mm: f64, width_mm: f64) -> Mesh {
    let radius = (pipe_mm + thickness_mm) / 2.0;
    let open = 0.9;
    let mut path = arc(DVec2::ZERO, radius, open, TAU - open, 56);
    let lip = |end: DVec2, side: f64| end + DVec2::new(0.45, side * 0.35) * radius;
    path.insert(0, lip(path[0], 1.0));
    path.push(lip(path[path.len() - 1], -1.0));
    extrude_prism(stroke_path(&path, thickness_mm), &equal_levels(width_mm, 3)).into_mesh()
}

/// One leaf of a hinge with `knuckles` eyes and gaps for the eyes of the other leaf, mm.
pub fn hinge(length_mm: f64, leaf_mm: f64, eye_mm: f64, pin_mm: f64, knuckles: usize) -> Mesh {
    let (radius, thick) = (eye_mm / 2.0, 0.4 * eye_mm);
    let open = (thick / eye_mm).asin();
    let eye = arc(DVec2::ZERO, radius, open, TAU - open, 48);
    let (top, bottom) = (eye[0], eye[eye.len() - 1]);
    // The other leaf's eyes rotate in front of this leaf's edge.
    let edge = 1.12 * radius;
    let neck = vec![bottom, DVec2::new(edge, bottom.y), DVec2::new(edge, top.y), top];
    let end = edge + leaf_mm;
    let leaf = vec![neck[1], DVec2::new(end, bottom.y), DVec2::new(end, top.y), neck[2]];
    let regions = [
        PlanarOutline::new(eye).with_hole(circle(DVec2::ZERO, pin_mm / 2.0, 36, 0.0)),
        PlanarOutline::new(neck),
        PlanarOutline::new(leaf),
    ];
    let levels = equal_levels(length_mm, 2 * knuckles);
    extrude_layers(&regions, &levels, |region, slab| region == 2 || slab % 2 == 0, |_, _| true).into_mesh()
}

/// A long hat rail with slots along its web, mm.
pub fn rail(length_mm: f64, width_mm: f64, height_mm: f64, wall_mm: f64) -> Mesh {
    let (web, flange) = (0.36 * width_mm, 0.5 * width_mm);
    let slot = 0.09 * width_mm;
    // Half a hat from the slot's edge outwards; the other half mirrors it.
    let path = [
        DVec2::new(slot, 0.0),
        DVec2::new(web, 0.0),
        DVec2::new(web, height_mm - wall_mm),
        DVec2::new(flange, height_mm - wall_mm),
    ];
    let right = stroke_path(&path, wall_mm);
    let left = PlanarOutline::new(right.outer.iter().map(|p| DVec2::new(-p.x, p.y)).collect());
    let half = wall_mm / 2.0;
    let bridge = PlanarOutline::new(rectangle(DVec2::new(-slot, -half), DVec2::new(slot, half)));
    let slots = ((length_mm / (4.0 * slot)) as usize).max(2);
    let levels = equal_levels(length_mm, 2 * slots + 1);
    extrude_layers(&[left, bridge, right], &levels, |region, slab| region != 1 || slab % 2 == 0, |_, _| true)
        .into_mesh()
}

/// A wheel with flat spokes between hub and rim and a bore, mm; rim and spokes are `bar_mm` thick.
pub fn wheel(diameter_mm: f64, width_mm: f64, bar_mm: f64, spokes: usize) -> Mesh {
    let (outer, hub) = (diameter_mm / 2.0, 1.6 * bar_mm);
    let inner = outer - bar_mm;
    let mut disk = PlanarOutline::new(circle(DVec2::ZERO, outer, 96, 0.0));
    for spoke in 0..spokes {
        let from = TAU * spoke as f64 / spokes as f64;
        // Spokes have parallel edges.
        let side = |radius: f64| (bar_mm / 2.0 / radius).asin();
        let to = from + TAU / spokes as f64;
        let mut gap = arc(DVec2::ZERO, inner, from + side(inner), to - side(inner), 24);
        gap.extend(arc(DVec2::ZERO, hub, to - side(hub), from + side(hub), 6));
        disk = disk.with_hole(gap);
    }
    extrude_prism(disk.with_hole(circle(DVec2::ZERO, 0.8 * bar_mm, 24, 0.0)), &equal_levels(width_mm, 2)).into_mesh()
}

/// A rectangular frame of bars `bar_mm` wide with `panes` openings, mm.
pub fn frame(length_mm: f64, width_mm: f64, bar_mm: f64, thickness_mm: f64, panes: usize) -> Mesh {
    let mut plate = PlanarOutline::new(rectangle(DVec2::ZERO, DVec2::new(length_mm, width_mm)));
    let pitch = (length_mm - bar_mm) / panes as f64;
    for pane in 0..panes {
        let low = DVec2::new(bar_mm + pitch * pane as f64, bar_mm);
        plate = plate.with_hole(rectangle(low, low + DVec2::new(pitch - bar_mm, width_mm - 2.0 * bar_mm)));
    }
    extrude_prism(plate, &equal_levels(thickness_mm, 2)).into_mesh()
}
