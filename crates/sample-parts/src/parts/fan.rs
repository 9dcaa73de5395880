//! An axial fan in one piece: a square frame, a hub and twisted blades that join both. The walls at the blades are
//! built by hand, so that the whole is one shell.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use solids::Mesh;

use crate::making::{
    layers::extrude_layers,
    outline::{PlanarOutline, circle, rounded_rectangle},
    surface::SurfaceBuilder,
};

/// Angular steps from one blade to the next.
const STEPS_PER_BLADE: usize = 12;
/// Number of these steps that a blade covers.
const BLADE_STEPS: usize = 9;
/// Number of radial segments of a blade between hub and frame.
const RADIAL_STEPS: usize = 6;

/// Dimensions that the pieces share, mm.
struct FanDimensions {
    size: f64,
    height: f64,
    blades: usize,
    hub_radius: f64,
    tube_radius: f64,
}

/// An axial fan, mm: edge of the square frame, height along the axis, number of blades.
pub fn axial_fan(size_mm: f64, height_mm: f64, blades: usize) -> Mesh {
    let fan = FanDimensions {
        size: size_mm,
        height: height_mm,
        blades,
        hub_radius: 0.19 * size_mm,
        tube_radius: 0.455 * size_mm,
    };
    let mut surface = fan.frame_surface();
    surface.append_surface(fan.hub_surface());
    for cell in 0..fan.angular_steps() {
        fan.add_walls(&mut surface, cell);
    }
    for blade in 0..blades {
        fan.add_blade(&mut surface, blade * STEPS_PER_BLADE);
    }
    surface.into_mesh()
}

impl FanDimensions {
    fn angular_steps(&self) -> usize {
        self.blades * STEPS_PER_BLADE
    }

    /// Tube with a flange at both ends and four screw holes; the inner wall is left open.
    fn frame_surface(&self) -> SurfaceBuilder {
        let (half, corner) = (self.size / 2.0, 0.06 * self.size);
        let ring = |radius: f64| circle(DVec2::ZERO, radius, self.angular_steps(), 0.0);
        let outer = 0.478 * self.size;
        let square = rounded_rectangle(DVec2::splat(-half), DVec2::splat(half), corner, 6);
        let mut flange = PlanarOutline::new(square).with_hole(ring(outer));
        for turn in [0.125, 0.375, 0.625, 0.875] {
            let center = 0.595 * self.size * DVec2::from_angle(TAU * turn);
            flange = flange.with_hole(circle(center, 0.03 * self.size, 20, 0.0));
        }
        let tube = PlanarOutline::new(ring(outer)).with_hole(ring(self.tube_radius));
        let thick = 0.17 * self.height;
        let levels = [0.0, thick, self.height - thick, self.height];
        let inner = 0.5 * (outer + self.tube_radius);
        let walled = |a: DVec2, b: DVec2| a.length().min(b.length()) > inner;
        extrude_layers(&[tube, flange], &levels, |region, slab| region == 0 || slab != 1, walled)
    }

    /// A cup, open at the bottom; the outer wall is left open.
    fn hub_surface(&self) -> SurfaceBuilder {
        let inner = 0.8 * self.hub_radius;
        let ring = |radius: f64| circle(DVec2::ZERO, radius, self.angular_steps(), 0.0);
        let regions =
            [PlanarOutline::new(ring(inner)), PlanarOutline::new(ring(self.hub_radius)).with_hole(ring(inner))];
        let levels = [0.0, 0.85 * self.height, self.height];
        let between = 0.5 * (inner + self.hub_radius);
        extrude_layers(&regions, &levels, |region, slab| region == 1 || slab == 1, |a, _| a.length() < between)
    }

    /// A point of the fan by angular step, radius and height.
    fn point_at(&self, step: usize, radius: f64, z: f64) -> DVec3 {
        // The same computation as in `circle`, so that corners weld.
        let turn = (step % self.angular_steps()) as f64 / self.angular_steps() as f64;
        (radius * DVec2::from_angle(TAU * turn)).extend(z)
    }

    /// Lower and upper height of a blade after `along` of its steps, at a radius; the tip is flatter than the root.
    fn blade_heights(&self, along: usize, radius: f64) -> (f64, f64) {
        let share = along as f64 / BLADE_STEPS as f64;
        let outward = (radius - self.hub_radius) / (self.tube_radius - self.hub_radius);
        let rise = (0.68 - 0.22 * outward) * self.height;
        let thick = self.height * (0.05 + 0.16 * share * (1.0 - share));
        let middle = 0.5 * self.height + rise * (share - 0.5);
        (middle - thick / 2.0, middle + thick / 2.0)
    }

    /// Heights at which a column of a wall has corners: both ends, and a blade's root where a blade begins or ends.
    fn wall_heights(&self, step: usize, radius: f64) -> Vec<f64> {
        let along = step % STEPS_PER_BLADE;
        match along {
            0 | BLADE_STEPS => {
                let (low, high) = self.blade_heights(along, radius);
                vec![0.0, low, high, self.height]
            }
            _ => vec![0.0, self.height],
        }
    }

    /// Adds one angular step of the hub's outer and the tube's inner wall, around the blade's root.
    fn add_walls(&self, surface: &mut SurfaceBuilder, step: usize) {
        let along = step % STEPS_PER_BLADE;
        for (radius, outward) in [(self.hub_radius, true), (self.tube_radius, false)] {
            let mut strip = |here: &[f64], next: &[f64]| {
                let here: Vec<DVec3> = here.iter().map(|&z| self.point_at(step, radius, z)).collect();
                let next: Vec<DVec3> = next.iter().map(|&z| self.point_at(step + 1, radius, z)).collect();
                if outward { surface.add_strip(&here, &next) } else { surface.add_strip(&next, &here) }
            };
            if along < BLADE_STEPS {
                let (here, next) = (self.blade_heights(along, radius), self.blade_heights(along + 1, radius));
                strip(&[0.0, here.0], &[0.0, next.0]);
                strip(&[here.1, self.height], &[next.1, self.height]);
            } else {
                strip(&self.wall_heights(step, radius), &self.wall_heights(step + 1, radius));
            }
        }
    }

    /// Adds both sides and both edges of the blade that begins at an angular step.
    fn add_blade(&self, surface: &mut SurfaceBuilder, first: usize) {
        let radius = |q: usize| match q {
            0 => self.hub_radius,
            RADIAL_STEPS => self.tube_radius,
            _ => self.hub_radius + (self.tube_radius - self.hub_radius) * q as f64 / RADIAL_STEPS as f64,
        };
        let at = |along: usize, q: usize, upper: bool| {
            let (low, high) = self.blade_heights(along, radius(q));
            self.point_at(first + along, radius(q), if upper { high } else { low })
        };
        for q in 0..RADIAL_STEPS {
            for i in 0..BLADE_STEPS {
                surface.add_quad(at(i, q, true), at(i, q + 1, true), at(i + 1, q + 1, true), at(i + 1, q, true));
                surface.add_quad(at(i, q, false), at(i + 1, q, false), at(i + 1, q + 1, false), at(i, q + 1, false));
            }
            let end = BLADE_STEPS;
            surface.add_quad(at(0, q, false), at(0, q + 1, false), at(0, q + 1, true), at(0, q, true));
            surface.add_quad(at(end, q + 1, false), at(end, q, false), at(end, q, true), at(end, q + 1, true));
        }
    }
}
