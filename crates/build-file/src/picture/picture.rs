//! Draws the picture of a build as a PNG: shaded bodies in the wire box of the build volume, with the build height. The
//! same bodies give the same bytes.

use glam::{DVec3, Vec2, Vec3};
use solids::{Mesh, Pose};

use super::{
    lettering,
    raster::{DepthCanvas, OrthographicView},
    shade::{PictureScheme, TAG_FAULT, TAG_FLOOR, TAG_INK, TAG_WIRE, body_tag, kind_colour, resolve_pixels},
};

/// Approximate greatest number of samples of a picture: small pictures get more samples per pixel.
const SAMPLES: usize = 8 << 20;
/// Least and greatest number of samples per pixel along each axis.
const SAMPLES_PER_PIXEL: (usize, usize) = (2, 4);
/// Greatest mean number of depth tests per sample while bodies are drawn; later bodies are drawn as boxes.
const MAX_LOOKS_PER_SAMPLE: usize = 100;
/// Direction to the light: from the upper left behind the viewer.
const LIGHT: DVec3 = DVec3::new(-0.35, -0.75, 1.0);
/// Share of the picture that stays empty on each side.
const MARGIN: f64 = 0.03;
/// Digit height: share of the picture's height, least and greatest number of pixels.
const DIGIT_HEIGHT: (f64, f64, f64) = (0.028, 12.0, 48.0);
/// Thickness of the edges at which a surface is not closed, pixels.
const FAULT_PIXELS: usize = 2;
/// Brightness of the inside of a surface that is not closed.
const INSIDE: f64 = 0.22;
/// Digits below this height are unreadable, pixels.
const MIN_DIGIT_PIXELS: f32 = 6.0;
/// Least height of a picture with a caption, pixels.
const MIN_CAPTION_PIXELS: usize = 90;

/// Direction from which a build is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Viewpoint {
    /// From the front, slightly from the right and from above.
    #[default]
    Iso,
    /// From above; the machine's front is at the bottom.
    Top,
    /// From the front.
    Front,
}

impl Viewpoint {
    /// The view direction, and the direction that is up in the picture.
    fn view_directions(self) -> (DVec3, DVec3) {
        match self {
            Self::Iso => (DVec3::new(-0.55, 1.0, -0.62), DVec3::Z),
            Self::Top => (-DVec3::Z, DVec3::Y),
            Self::Front => (DVec3::Y, DVec3::Z),
        }
    }
}

/// A body in a picture.
#[derive(Debug, Clone, Copy)]
pub struct PictureBody<'a> {
    /// In mm, in its own frame.
    pub mesh: &'a Mesh,
    /// Mesh frame -> machine frame, mm.
    pub pose: Pose,
    /// Bodies of one kind (the copies of a part) have the same colour.
    pub kind: usize,
}

/// Draws bodies in a build volume that reaches from the origin to `volume_mm`: each kind in its own colour, the
/// volume's edges, a dashed line around the top of the highest body, and the build height. `size` is width and height
/// in pixels, at least 1. Returns a PNG.
pub fn draw_picture(bodies: &[PictureBody], volume_mm: DVec3, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
    draw_picture_on(PictureScheme::Light, bodies, volume_mm, viewpoint, size)
}

/// As [`draw_picture`], on a given ground.
pub fn draw_picture_on(
    scheme: PictureScheme,
    bodies: &[PictureBody],
    volume_mm: DVec3,
    viewpoint: Viewpoint,
    size: (u32, u32),
) -> Vec<u8> {
    let (width, height, fine) = sample_size(size);
    let top_mm = bodies.iter().map(|b| b.mesh.bounds_at(&b.pose).max.z).fold(0.0, f64::max);
    let has_line = viewpoint != Viewpoint::Top;
    let caption = HeightCaption::new(&height_in_words(top_mm, volume_mm.z), has_line, (width, height), fine);
    let mut canvas = DepthCanvas::new(width * fine, height * fine);
    let corners: Vec<DVec3> = (0..8).map(|c| box_corner(c, volume_mm)).collect();
    let (forward, up) = viewpoint.view_directions();
    let free = canvas.height - caption.as_ref().map_or(0, |caption| caption.strip);
    let view = OrthographicView::fit_points(forward, up, &corners, canvas.width, free, MARGIN);
    draw_floor(&mut canvas, &view, volume_mm);
    let mut left = MAX_LOOKS_PER_SAMPLE * canvas.width * canvas.height;
    for (index, body) in bodies.iter().enumerate() {
        draw_body(&mut canvas, &view, forward, body, index, &mut left);
    }
    draw_volume_edges(&mut canvas, &view, volume_mm, fine);
    if top_mm > 0.0 && has_line {
        draw_height_line(&mut canvas, &view, volume_mm.with_z(top_mm), fine);
    }
    if let Some(caption) = caption.filter(|_| top_mm > 0.0) {
        caption.draw_caption(&mut canvas, fine);
    }
    let colours: Vec<Vec3> = bodies.iter().map(|body| kind_colour(body.kind)).collect();
    encode_png(&resolve_pixels(&canvas, &colours, scheme, fine), width, height)
}

/// Draws one body as large as it fits, as it lies in its own frame, seen as [`Viewpoint::Iso`], in the colour of a kind. Of a surface that
/// is not closed the inside shows, too, and the edges at which it is open are drawn over all, in red, as are those of the triangles `marked`. `size` is width and height in
/// pixels, at least 1. Returns a PNG.
pub fn draw_part(mesh: &Mesh, marked: &[[DVec3; 3]], kind: usize, scheme: PictureScheme, size: (u32, u32)) -> Vec<u8> {
    let (width, height, fine) = sample_size(size);
    let mut canvas = DepthCanvas::new(width * fine, height * fine);
    let bounds = mesh.bounds();
    let corners: Vec<DVec3> = (0..8).map(|c| bounds.min + box_corner(c, bounds.size())).collect();
    let (forward, up) = Viewpoint::Iso.view_directions();
    let view = OrthographicView::fit_points(forward, up, &corners, canvas.width, canvas.height, MARGIN);
    let body = PictureBody { mesh, pose: Pose::IDENTITY, kind };
    let mut left = MAX_LOOKS_PER_SAMPLE * canvas.width * canvas.height;
    draw_body(&mut canvas, &view, forward, &body, 0, &mut left);
    let thick = FAULT_PIXELS * fine;
    let faulty = mesh.faulty_edges().into_iter().map(|edge| edge.map(|at| mesh.vertices()[at as usize]));
    let marked = marked.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    for edge in faulty.chain(marked) {
        let [from, to] = edge.map(|place| view.project_point(place).with_z(f32::MIN));
        canvas.draw_line(from, to, thick, 0.0, TAG_FAULT);
    }
    encode_png(&resolve_pixels(&canvas, &[kind_colour(kind)], scheme, fine), width, height)
}

/// Width and height of a picture in pixels, at least 1, and samples along the edge of a pixel.
fn sample_size(size: (u32, u32)) -> (usize, usize, usize) {
    let (width, height) = (size.0.max(1) as usize, size.1.max(1) as usize);
    let fine = (SAMPLES / (width * height)).isqrt().clamp(SAMPLES_PER_PIXEL.0, SAMPLES_PER_PIXEL.1);
    (width, height, fine)
}

/// The colour of a kind in pictures, as `#rrggbb`.
pub fn kind_colour_code(kind: usize) -> String {
    let [red, green, blue] = kind_colour(kind).to_array().map(|c| c.round().clamp(0.0, 255.0) as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// "84 / 300 mm", which is read in every language.
fn height_in_words(top_mm: f64, volume_z_mm: f64) -> String {
    format!("{top_mm:.0} / {volume_z_mm:.0} mm")
}

/// The caption below the picture; all lengths in samples.
struct HeightCaption {
    text: String,
    digits: f32,
    /// Length of the dash before the text, and of the gap after it; 0 = none.
    sign: f32,
    gap: f32,
    /// Height of the strip that is reserved for the caption.
    strip: usize,
}

impl HeightCaption {
    /// `None` if there is no room for it.
    fn new(text: &str, with_sign: bool, (width, height): (usize, usize), fine: usize) -> Option<Self> {
        let wanted = (DIGIT_HEIGHT.0 * height as f64).clamp(DIGIT_HEIGHT.1, DIGIT_HEIGHT.2) as f32 * fine as f32;
        let of = |digits: f32| {
            let (sign, gap) = if with_sign { (2.5 * digits, 0.7 * digits) } else { (0.0, 0.0) };
            Self { text: text.to_owned(), digits, sign, gap, strip: (2.2 * digits) as usize }
        };
        // A text that would be too wide is drawn smaller.
        let room = 0.94 * (width * fine) as f32 / of(wanted).total_width();
        let caption = of(wanted * room.min(1.0));
        (height >= MIN_CAPTION_PIXELS && caption.digits >= MIN_DIGIT_PIXELS * fine as f32).then_some(caption)
    }

    fn total_width(&self) -> f32 {
        self.sign + self.gap + lettering::text_width(&self.text, self.digits)
    }

    fn draw_caption(&self, canvas: &mut DepthCanvas, fine: usize) {
        let foot = canvas.height as f32 - 0.9 * self.digits;
        let left = 0.5 * (canvas.width as f32 - self.total_width());
        if self.sign > 0.0 {
            let middle = foot - 0.45 * self.digits;
            let (from, to) = (Vec2::new(left, middle), Vec2::new(left + self.sign, middle));
            canvas.draw_dashes(from.extend(f32::MIN), to.extend(f32::MIN), fine, 0.0, TAG_INK);
        }
        let start = Vec2::new(left + self.sign + self.gap, foot - self.digits);
        lettering::write_text(canvas, &self.text, start, self.digits, TAG_INK);
    }
}

/// Corner `index` (bits x, y, z) of a box from the origin.
fn box_corner(index: usize, size: DVec3) -> DVec3 {
    let side = |bit: usize, length: f64| if index >> bit & 1 == 1 { length } else { 0.0 };
    DVec3::new(side(0, size.x), side(1, size.y), side(2, size.z))
}

/// The twelve edges of a box from the origin, as pairs of corner numbers.
fn box_edges() -> impl Iterator<Item = (usize, usize)> {
    (0..8usize).flat_map(|from| [1, 2, 4].map(|bit| (from, from | bit))).filter(|(from, to)| from != to)
}

fn draw_floor(canvas: &mut DepthCanvas, view: &OrthographicView, volume_mm: DVec3) {
    // Slightly lower, so that faces on the floor win the depth test.
    let [a, b, c, d] = [0, 1, 3, 2].map(|c| view.project_point(box_corner(c, volume_mm) - DVec3::Z * 0.05));
    canvas.fill_triangle([a, b, c], TAG_FLOOR);
    canvas.fill_triangle([a, c, d], TAG_FLOOR);
}

/// Draws a body, or its bounding box once `left` samples are used up: very many large triangles would take minutes.
fn draw_body(
    canvas: &mut DepthCanvas,
    view: &OrthographicView,
    forward: DVec3,
    body: &PictureBody,
    index: usize,
    left: &mut usize,
) {
    let placed: Vec<DVec3> = body.mesh.vertices().iter().map(|&v| body.pose.transform_point(v)).collect();
    let projected: Vec<Vec3> = placed.iter().map(|&p| view.project_point(p)).collect();
    let inside = (!body.mesh.defects().is_closed()).then_some(INSIDE);
    for corners in body.mesh.triangles() {
        if *left == 0 {
            return draw_box(canvas, view, forward, body, index);
        }
        let seen = face_brightness(corners.map(|v| placed[v as usize]), forward).or(inside);
        if let Some(brightness) = seen {
            let looks = canvas.fill_triangle(corners.map(|v| projected[v as usize]), body_tag(index, brightness));
            *left = left.saturating_sub(looks);
        }
    }
}

fn draw_box(canvas: &mut DepthCanvas, view: &OrthographicView, forward: DVec3, body: &PictureBody, index: usize) {
    const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let bounds = body.mesh.bounds();
    for face in FACES {
        let [a, b, c, d] = face.map(|at| body.pose.transform_point(bounds.min + box_corner(at, bounds.size())));
        if let Some(brightness) = face_brightness([a, b, c], forward) {
            for half in [[a, b, c], [a, c, d]] {
                canvas.fill_triangle(half.map(|p| view.project_point(p)), body_tag(index, brightness));
            }
        }
    }
}

/// Brightness of a triangle; `None` when it faces away, since it is hidden by faces towards the viewer.
fn face_brightness([a, b, c]: [DVec3; 3], forward: DVec3) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let lit = normal.normalize_or_zero().dot(LIGHT.normalize());
    // Half-Lambert shading: unlit faces keep their shape.
    (normal.dot(forward) < 0.0).then_some(0.42 + 0.58 * (0.5 + 0.5 * lit).powi(2))
}

/// Draws the volume's twelve edges.
fn draw_volume_edges(canvas: &mut DepthCanvas, view: &OrthographicView, volume_mm: DVec3, thick: usize) {
    for (from, to) in box_edges() {
        let [from, to] = [from, to].map(|c| view.project_point(box_corner(c, volume_mm)));
        canvas.draw_line(from, to, thick, 0.01, TAG_WIRE);
    }
}

/// Draws the line around the volume at the build's height.
fn draw_height_line(canvas: &mut DepthCanvas, view: &OrthographicView, build_mm: DVec3, thick: usize) {
    for (from, to) in box_edges().filter(|(from, to)| from & to & 4 == 4) {
        let [from, to] = [from, to].map(|c| view.project_point(box_corner(c, build_mm)));
        canvas.draw_dashes(from, to, thick, 0.02, TAG_INK);
    }
}

/// Encodes 8-bit RGB as a PNG.
fn encode_png(rgb: &[u8], width: usize, height: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    // Areas of one colour compress best as they are.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().expect("writing to memory does not fail");
    writer.write_image_data(rgb).expect("there are as many bytes as the header says");
    writer.finish().expect("writing to memory does not fail");
    bytes
}

#[cfg(test)]
#[path = "picture_tests.rs"]
mod tests;
