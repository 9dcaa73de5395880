//! The picture of a build: shaded bodies in the build volume's wire box with the height, as a PNG. The same bodies give the
//! same bytes.

use glam::{DVec3, Vec2, Vec3};
use solids::{Mesh, Pose};

use super::{
    lettering,
    raster::{Canvas, View},
    shade::{TAG_FLOOR, TAG_INK, TAG_WIRE, body_tag, colour, resolve},
};

/// Samples that a picture may have while it is drawn, about: small ones are smoothed more.
const SAMPLES: usize = 8 << 20;
/// Samples per pixel along each axis: at least, at most.
const FINE: (usize, usize) = (2, 4);
/// Looks at each sample at most, on average, while bodies are drawn: those after are drawn as boxes.
const MOST_LOOKS: usize = 100;
/// Direction to the light, from the upper left behind the eye.
const LIGHT: DVec3 = DVec3::new(-0.35, -0.75, 1.0);
/// Share of the picture that stays free on each side.
const MARGIN: f64 = 0.03;
/// Height of digits as a share of the picture's height, and in pixels at least and at most.
const DIGITS: (f64, f64, f64) = (0.028, 12.0, 48.0);
/// Digits that are lower cannot be read, pixels.
const LEAST_DIGITS: f32 = 6.0;
/// Least height of a picture with something written in it, pixels.
const LEAST_WRITTEN: usize = 90;

/// Where a build is looked at from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Viewpoint {
    /// From in front of the machine, a little to its right and above.
    #[default]
    Iso,
    /// From above; the machine's front is at the bottom.
    Top,
    /// From the front.
    Front,
}

impl Viewpoint {
    /// Where the eye looks, and what is up in the picture.
    fn directions(self) -> (DVec3, DVec3) {
        match self {
            Self::Iso => (DVec3::new(-0.55, 1.0, -0.62), DVec3::Z),
            Self::Top => (-DVec3::Z, DVec3::Y),
            Self::Front => (DVec3::Y, DVec3::Z),
        }
    }
}

/// A body in a picture.
#[derive(Debug, Clone, Copy)]
pub struct Drawn<'a> {
    /// In mm, in its own frame.
    pub mesh: &'a Mesh,
    /// Mesh frame -> machine frame, mm.
    pub pose: Pose,
    /// Bodies of one kind (the copies of a part) have one colour.
    pub kind: usize,
}

/// Draws bodies that stand in a build volume from the origin to `volume_mm`: each kind in a colour of its own, the volume's
/// edges, a dashed line around the top of the highest body, and how high that is. `size` is width and height, pixels, at
/// least 1. The answer is a PNG.
pub fn picture(bodies: &[Drawn], volume_mm: DVec3, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
    let (width, height) = (size.0.max(1) as usize, size.1.max(1) as usize);
    let fine = (SAMPLES / (width * height)).isqrt().clamp(FINE.0, FINE.1);
    let top_mm = bodies.iter().map(|b| b.mesh.bounds_at(&b.pose).max.z).fold(0.0, f64::max);
    let has_line = viewpoint != Viewpoint::Top;
    let caption = Caption::new(&height_in_words(top_mm, volume_mm.z), has_line, (width, height), fine);
    let mut canvas = Canvas::new(width * fine, height * fine);
    let corners: Vec<DVec3> = (0..8).map(|c| corner(c, volume_mm)).collect();
    let (forward, up) = viewpoint.directions();
    let free = canvas.height - caption.as_ref().map_or(0, |caption| caption.strip);
    let view = View::fit(forward, up, &corners, canvas.width, free, MARGIN);
    draw_floor(&mut canvas, &view, volume_mm);
    let mut left = MOST_LOOKS * canvas.width * canvas.height;
    for (index, body) in bodies.iter().enumerate() {
        draw_body(&mut canvas, &view, forward, body, index, &mut left);
    }
    draw_wires(&mut canvas, &view, volume_mm, fine);
    if top_mm > 0.0 && has_line {
        draw_height(&mut canvas, &view, volume_mm.with_z(top_mm), fine);
    }
    if let Some(caption) = caption.filter(|_| top_mm > 0.0) {
        caption.draw(&mut canvas, fine);
    }
    let colours: Vec<Vec3> = bodies.iter().map(|body| colour(body.kind)).collect();
    encode(&resolve(&canvas, &colours, fine), width, height)
}

/// "84.0 mm of 300 mm".
fn height_in_words(top_mm: f64, volume_z_mm: f64) -> String {
    format!("{top_mm:.1} mm of {volume_z_mm:.0} mm")
}

/// What is written below the picture; all lengths in samples.
struct Caption {
    text: String,
    digits: f32,
    /// Length of the piece of the height line before the text, and of the gap after it; 0 = without.
    sign: f32,
    gap: f32,
    /// Height of what is kept free for it.
    strip: usize,
}

impl Caption {
    /// `None` where there is no room for it.
    fn new(text: &str, with_sign: bool, (width, height): (usize, usize), fine: usize) -> Option<Self> {
        let wanted = (DIGITS.0 * height as f64).clamp(DIGITS.1, DIGITS.2) as f32 * fine as f32;
        let of = |digits: f32| {
            let (sign, gap) = if with_sign { (2.5 * digits, 0.7 * digits) } else { (0.0, 0.0) };
            Self { text: text.to_owned(), digits, sign, gap, strip: (2.2 * digits) as usize }
        };
        // What would be too wide is written smaller.
        let room = 0.94 * (width * fine) as f32 / of(wanted).width();
        let caption = of(wanted * room.min(1.0));
        (height >= LEAST_WRITTEN && caption.digits >= LEAST_DIGITS * fine as f32).then_some(caption)
    }

    fn width(&self) -> f32 {
        self.sign + self.gap + lettering::width(&self.text, self.digits)
    }

    fn draw(&self, canvas: &mut Canvas, fine: usize) {
        let foot = canvas.height as f32 - 0.9 * self.digits;
        let left = 0.5 * (canvas.width as f32 - self.width());
        if self.sign > 0.0 {
            let middle = foot - 0.45 * self.digits;
            let (from, to) = (Vec2::new(left, middle), Vec2::new(left + self.sign, middle));
            canvas.dashes(from.extend(f32::MIN), to.extend(f32::MIN), fine, 0.0, TAG_INK);
        }
        let start = Vec2::new(left + self.sign + self.gap, foot - self.digits);
        lettering::write(canvas, &self.text, start, self.digits, TAG_INK);
    }
}

/// Corner `index` (bits x, y, z) of a box from the origin.
fn corner(index: usize, size: DVec3) -> DVec3 {
    let side = |bit: usize, length: f64| if index >> bit & 1 == 1 { length } else { 0.0 };
    DVec3::new(side(0, size.x), side(1, size.y), side(2, size.z))
}

/// The twelve edges of a box from the origin, as numbers of their corners.
fn edges() -> impl Iterator<Item = (usize, usize)> {
    (0..8usize).flat_map(|from| [1, 2, 4].map(|bit| (from, from | bit))).filter(|(from, to)| from != to)
}

fn draw_floor(canvas: &mut Canvas, view: &View, volume_mm: DVec3) {
    // A hair below, so that faces that stand on the floor win.
    let [a, b, c, d] = [0, 1, 3, 2].map(|c| view.project(corner(c, volume_mm) - DVec3::Z * 0.05));
    canvas.triangle([a, b, c], TAG_FLOOR);
    canvas.triangle([a, c, d], TAG_FLOOR);
}

/// Draws a body, or its box once `left` samples are used up: very many large triangles would take minutes.
fn draw_body(canvas: &mut Canvas, view: &View, forward: DVec3, body: &Drawn, index: usize, left: &mut usize) {
    let placed: Vec<DVec3> = body.mesh.vertices().iter().map(|&v| body.pose.point(v)).collect();
    let projected: Vec<Vec3> = placed.iter().map(|&p| view.project(p)).collect();
    for corners in body.mesh.triangles() {
        if *left == 0 {
            return draw_box(canvas, view, forward, body, index);
        }
        if let Some(brightness) = brightness(corners.map(|v| placed[v as usize]), forward) {
            let looks = canvas.triangle(corners.map(|v| projected[v as usize]), body_tag(index, brightness));
            *left = left.saturating_sub(looks);
        }
    }
}

fn draw_box(canvas: &mut Canvas, view: &View, forward: DVec3, body: &Drawn, index: usize) {
    const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let bounds = body.mesh.bounds();
    for face in FACES {
        let [a, b, c, d] = face.map(|at| body.pose.point(bounds.min + corner(at, bounds.size())));
        if let Some(brightness) = brightness([a, b, c], forward) {
            for half in [[a, b, c], [a, c, d]] {
                canvas.triangle(half.map(|p| view.project(p)), body_tag(index, brightness));
            }
        }
    }
}

/// How bright a triangle is; `None` when it faces away, for it is hidden by what faces the eye.
fn brightness([a, b, c]: [DVec3; 3], forward: DVec3) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let lit = normal.normalize_or_zero().dot(LIGHT.normalize());
    // Half-Lambert: also what the light misses keeps its shape.
    (normal.dot(forward) < 0.0).then_some(0.42 + 0.58 * (0.5 + 0.5 * lit).powi(2))
}

/// The volume's twelve edges.
fn draw_wires(canvas: &mut Canvas, view: &View, volume_mm: DVec3, thick: usize) {
    for (from, to) in edges() {
        let [from, to] = [from, to].map(|c| view.project(corner(c, volume_mm)));
        canvas.line(from, to, thick, 0.01, TAG_WIRE);
    }
}

/// The line around the volume at the build's height.
fn draw_height(canvas: &mut Canvas, view: &View, build_mm: DVec3, thick: usize) {
    for (from, to) in edges().filter(|(from, to)| from & to & 4 == 4) {
        let [from, to] = [from, to].map(|c| view.project(corner(c, build_mm)));
        canvas.dashes(from, to, thick, 0.02, TAG_INK);
    }
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
#[path = "picture_tests.rs"]
mod tests;
