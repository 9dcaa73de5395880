//! The picture of a build: shaded bodies in the build volume's wire box, as a PNG. The same bodies give the same bytes.

use glam::{DVec3, Vec3};

use super::raster::{Canvas, NOTHING, View};
use crate::geometry::{Mesh, Pose};

/// Samples per pixel along each axis; four samples smooth an edge well enough.
const SUPERSAMPLING: usize = 2;
/// The eye stands in front of the machine, a little to its right and above.
const FORWARD: DVec3 = DVec3::new(-0.55, 1.0, -0.62);
/// Direction to the light, from the upper left behind the eye.
const LIGHT: DVec3 = DVec3::new(-0.35, -0.75, 1.0);
/// Share of the picture that stays free on each side.
const MARGIN: f64 = 0.03;
const BACKGROUND: Vec3 = Vec3::new(250.0, 250.0, 248.0);
const FLOOR: Vec3 = Vec3::new(226.0, 229.0, 233.0);
const WIRE: Vec3 = Vec3::new(120.0, 128.0, 140.0);
/// Brightness of the lines that set one body off against the next.
const CONTOUR: f32 = 0.45;
/// The line around the build at its height.
const HEIGHT_LINE: Vec3 = Vec3::new(214.0, 84.0, 60.0);

/// Tags below are colours of their own; body tags are `FIRST_BODY + (body << 8 | brightness)`.
const TAG_FLOOR: u32 = 0;
const TAG_WIRE: u32 = 1;
const TAG_HEIGHT: u32 = 2;
const FIRST_BODY: u32 = 256;
/// Bodies beyond so many take the colours from the start again.
const MAX_COLOURS: usize = 1 << 16;

/// Draws bodies that stand in a build volume from the origin to `volume_mm`: each body in a colour of its own, the
/// volume's edges, and a line around the top of the highest body. `width` and `height` are pixels, at least 1.
/// The answer is a PNG.
pub fn picture(bodies: &[(&Mesh, Pose)], volume_mm: DVec3, width: u32, height: u32) -> Vec<u8> {
    let (width, height) = (width.max(1) as usize, height.max(1) as usize);
    let mut canvas = Canvas::new(width * SUPERSAMPLING, height * SUPERSAMPLING);
    let corners: Vec<DVec3> = (0..8).map(|c| corner(c, volume_mm)).collect();
    let view = View::fit(FORWARD, &corners, canvas.width, canvas.height, MARGIN);
    draw_floor(&mut canvas, &view, volume_mm);
    let mut top_mm = 0.0;
    for (index, (mesh, pose)) in bodies.iter().enumerate() {
        top_mm = draw_body(&mut canvas, &view, mesh, pose, index).max(top_mm);
    }
    draw_wires(&mut canvas, &view, volume_mm, top_mm);
    encode(&resolve(&canvas), width, height)
}

/// Corner `index` (bits x, y, z) of a box from the origin.
fn corner(index: usize, size: DVec3) -> DVec3 {
    let side = |bit: usize, length: f64| if index >> bit & 1 == 1 { length } else { 0.0 };
    DVec3::new(side(0, size.x), side(1, size.y), side(2, size.z))
}

fn draw_floor(canvas: &mut Canvas, view: &View, volume_mm: DVec3) {
    // A hair below, so that faces that stand on the floor win.
    let [a, b, c, d] = [0, 1, 3, 2].map(|c| view.project(corner(c, volume_mm) - DVec3::Z * 0.05));
    canvas.triangle([a, b, c], TAG_FLOOR);
    canvas.triangle([a, c, d], TAG_FLOOR);
}

/// Draws a body and returns its top, mm.
fn draw_body(canvas: &mut Canvas, view: &View, mesh: &Mesh, pose: &Pose, index: usize) -> f64 {
    let light = LIGHT.normalize();
    let placed: Vec<DVec3> = mesh.vertices().iter().map(|&v| pose.point(v)).collect();
    let projected: Vec<Vec3> = placed.iter().map(|&p| view.project(p)).collect();
    let tag = FIRST_BODY + (((index % MAX_COLOURS) as u32) << 8);
    for corners in mesh.triangles() {
        let [a, b, c] = corners.map(|v| placed[v as usize]);
        let normal = (b - a).cross(c - a);
        // What faces away is hidden by what faces the eye.
        if normal.dot(FORWARD) < 0.0 {
            let lit = normal.normalize_or_zero().dot(light);
            // Half-Lambert: also what the light misses keeps its shape.
            let brightness = 0.34 + 0.66 * (0.5 + 0.5 * lit).powi(2);
            canvas.triangle(corners.map(|v| projected[v as usize]), tag + (255.0 * brightness) as u32);
        }
    }
    placed.iter().map(|p| p.z).fold(0.0, f64::max)
}

/// The volume's twelve edges and the line at the build's height.
fn draw_wires(canvas: &mut Canvas, view: &View, volume_mm: DVec3, top_mm: f64) {
    let edges = |size: DVec3, at: &mut dyn FnMut(usize, usize, Vec3, Vec3)| {
        for from in 0..8usize {
            for to in [1, 2, 4].map(|bit| from | bit).into_iter().filter(|&to| to != from) {
                at(from, to, view.project(corner(from, size)), view.project(corner(to, size)));
            }
        }
    };
    if top_mm > 0.0 {
        let mut line = |from, to, a, b| {
            if from & to & 4 == 4 {
                canvas.line(a, b, SUPERSAMPLING, 0.02, TAG_HEIGHT);
            }
        };
        edges(volume_mm.with_z(top_mm), &mut line);
    }
    edges(volume_mm, &mut |_, _, a, b| canvas.line(a, b, SUPERSAMPLING, 0.01, TAG_WIRE));
}

/// Averages the samples of each pixel into RGB.
fn resolve(canvas: &Canvas) -> Vec<u8> {
    let (width, height) = (canvas.width / SUPERSAMPLING, canvas.height / SUPERSAMPLING);
    let bodies = canvas.tags.iter().filter(|&&t| t >= FIRST_BODY && t != NOTHING).map(|t| (t >> 8) as usize).max();
    let colours: Vec<Vec3> = (0..bodies.unwrap_or(0)).map(body_colour).collect();
    let mut pixels = Vec::with_capacity(3 * width * height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut sum = Vec3::ZERO;
        for (dy, dx) in (0..SUPERSAMPLING).flat_map(|dy| (0..SUPERSAMPLING).map(move |dx| (dy, dx))) {
            sum += sample_colour(canvas, &colours, x * SUPERSAMPLING + dx, y * SUPERSAMPLING + dy);
        }
        let mean = sum / (SUPERSAMPLING * SUPERSAMPLING) as f32;
        pixels.extend(mean.to_array().map(|c| c.round().clamp(0.0, 255.0) as u8));
    }
    pixels
}

fn sample_colour(canvas: &Canvas, colours: &[Vec3], x: usize, y: usize) -> Vec3 {
    let at = y * canvas.width + x;
    match canvas.tags[at] {
        NOTHING => BACKGROUND,
        TAG_FLOOR => FLOOR,
        TAG_WIRE => WIRE,
        TAG_HEIGHT => HEIGHT_LINE,
        tag => {
            let brightness = (tag & 255) as f32 / 255.0;
            let differs = |other: usize| canvas.tags[other] >> 8 != tag >> 8;
            let contour = (x > 0 && differs(at - 1)) || (y > 0 && differs(at - canvas.width));
            colours[(tag >> 8) as usize - 1] * brightness * if contour { CONTOUR } else { 1.0 }
        }
    }
}

/// Friendly colours that neighbours in the list do not share: hues a golden angle apart, in three strengths.
fn body_colour(index: usize) -> Vec3 {
    let hue = 6.0 * (0.58 + index as f32 * 0.618_034).fract();
    let (saturation, value) = [(0.42, 255.0), (0.52, 238.0), (0.30, 248.0)][index % 3];
    let channel = |offset: f32| {
        let k = (offset + hue) % 6.0;
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0))
}

/// 8-bit RGB as a PNG.
fn encode(rgb: &[u8], width: usize, height: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().expect("writing to memory does not fail");
    writer.write_image_data(rgb).expect("there are as many bytes as the header says");
    writer.finish().expect("writing to memory does not fail");
    bytes
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::samples;

    /// Decoded RGB of a PNG.
    fn decode(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width, info.height, pixels)
    }

    fn box_at(z: f64) -> (Mesh, Pose) {
        let pose = Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 20.0, z));
        (samples::cuboid(DVec3::splat(60.0)), pose)
    }

    #[test]
    fn a_body_covers_the_floor_and_leaves_the_corners_empty() {
        let (mesh, pose) = box_at(0.0);
        let (width, height, pixels) = decode(&picture(&[(&mesh, pose)], DVec3::splat(100.0), 120, 90));
        assert_eq!((width, height), (120, 90));
        let is = |rgb: &[u8], colour: Vec3| rgb.iter().zip(colour.to_array()).all(|(&c, k)| f32::from(c) == k);
        assert!(is(&pixels[..3], BACKGROUND) && is(&pixels[pixels.len() - 3..], BACKGROUND));
        let counted = |colour| pixels.chunks(3).filter(|rgb| is(rgb, colour)).count();
        let empty = decode(&picture(&[], DVec3::splat(100.0), 120, 90)).2;
        let floor_before = empty.chunks(3).filter(|rgb| is(rgb, FLOOR)).count();
        assert!(counted(FLOOR) + 200 < floor_before, "{} of {floor_before}", counted(FLOOR));
    }

    #[test]
    fn the_nearer_body_hides_the_farther_one_whatever_their_order() {
        let (front, back) = (
            Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 0.0, 0.0)),
            Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 70.0, 0.0)),
        );
        let mesh = samples::cuboid(DVec3::new(60.0, 20.0, 90.0));
        let draw = |order: [Pose; 2]| {
            let mut canvas = Canvas::new(100, 100);
            let view = View::fit(FORWARD, &[DVec3::ZERO, DVec3::splat(100.0)], 100, 100, 0.0);
            order.iter().enumerate().for_each(|(i, pose)| _ = draw_body(&mut canvas, &view, &mesh, pose, i));
            let count = |body: u32| canvas.tags.iter().filter(|&&t| t != NOTHING && t >> 8 == body + 1).count();
            (count(0), count(1))
        };
        let (front_first, back_second) = draw([front, back]);
        let (back_first, front_second) = draw([back, front]);
        assert_eq!((front_first, back_second), (front_second, back_first));
        assert!(front_first > back_first);
    }

    #[test]
    fn the_same_bodies_give_the_same_bytes() {
        let (mesh, pose) = box_at(3.0);
        let draw = || picture(&[(&mesh, pose)], DVec3::new(100.0, 100.0, 200.0), 160, 120);
        assert_eq!(draw(), draw());
    }

    #[test]
    fn a_body_outside_the_picture_and_an_empty_build_do_no_harm() {
        let mesh = samples::ring(40.0, 28.0, 8.0);
        let far = Pose::new(DQuat::from_rotation_x(0.4), DVec3::splat(-500.0));
        assert!(!picture(&[(&mesh, far)], DVec3::splat(50.0), 64, 64).is_empty());
        assert!(!picture(&[], DVec3::splat(50.0), 1, 1).is_empty());
    }
}
