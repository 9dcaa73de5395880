//! Converts samples to pixels: colours of bodies, contour lines between them, and the mean of a pixel's samples.

use glam::Vec3;
use serde::Deserialize;

use super::raster::{DepthCanvas, NOTHING};

/// Tags below `FIRST_BODY` are fixed colours; body tags are `FIRST_BODY + (body << 8 | brightness)`.
pub(super) const TAG_FLOOR: u32 = 0;
pub(super) const TAG_WIRE: u32 = 1;
/// The line at the build's height, and the caption.
pub(super) const TAG_INK: u32 = 2;
/// Where a surface is not closed.
pub(super) const TAG_FAULT: u32 = 3;
const FIRST_BODY: u32 = 256;
/// Bodies beyond this number reuse the numbers from the start.
const MAX_BODIES: usize = 1 << 16;

/// The ground on which a picture is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureScheme {
    /// Paper, and pages in light colours.
    #[default]
    Light,
    /// Pages in dark colours.
    Dark,
}

/// The fixed colours of a scheme. The grounds are those of the pages (`--ground` and `--card` of the dashboard's style sheet).
pub(crate) struct FixedColours {
    pub(super) background: Vec3,
    pub(super) floor: Vec3,
    wire: Vec3,
    ink: Vec3,
    fault: Vec3,
}

/// Colours on a light ground.
pub(super) const LIGHT_COLOURS: FixedColours = FixedColours {
    background: Vec3::new(250.0, 250.0, 248.0),
    floor: Vec3::new(226.0, 229.0, 233.0),
    wire: Vec3::new(120.0, 128.0, 140.0),
    ink: Vec3::new(27.0, 31.0, 36.0),
    fault: Vec3::new(210.0, 26.0, 26.0),
};
/// Colours on a dark ground.
const DARK_COLOURS: FixedColours = FixedColours {
    background: Vec3::new(29.0, 33.0, 38.0),
    floor: Vec3::new(50.0, 56.0, 63.0),
    wire: Vec3::new(139.0, 150.0, 161.0),
    ink: Vec3::new(232.0, 234.0, 237.0),
    fault: Vec3::new(255.0, 74.0, 62.0),
};
/// Brightness of the contour lines between bodies.
const CONTOUR: f32 = 0.5;
/// Share of the background colour in the farthest body.
const HAZE: f32 = 0.28;

/// The colours of Okabe and Ito, which colour-blind people can tell apart; the same as in the 3D view
/// (`web/view/view.js`).
const COLOURS: [[u8; 3]; 7] = [
    [0x00, 0x72, 0xb2],
    [0xe6, 0x9f, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0x56, 0xb4, 0xe9],
    [0xd5, 0x5e, 0x00],
    [0xf0, 0xe4, 0x42],
];

/// The colour of a kind of parts. Beyond the list, the same colours are used lighter, then darker.
pub(super) fn kind_colour(kind: usize) -> Vec3 {
    let plain = Vec3::from_array(COLOURS[kind % COLOURS.len()].map(f32::from));
    match kind / COLOURS.len() % 3 {
        0 => plain,
        1 => plain.lerp(Vec3::splat(255.0), 0.45),
        _ => 0.62 * plain,
    }
}

/// The tag of a body's sample; brightness 0 to 1.
pub(super) fn body_tag(body: usize, brightness: f64) -> u32 {
    FIRST_BODY + (((body % MAX_BODIES) as u32) << 8) + (255.0 * brightness.clamp(0.0, 1.0)) as u32
}

/// The body to which a tag belongs.
pub(super) fn body_of(tag: u32) -> Option<usize> {
    (tag >= FIRST_BODY && tag != NOTHING).then(|| (tag >> 8) as usize - 1)
}

/// Bodies and edges have colours in steps of this, of 255: pixels that look alike become equal, which halves the file.
const COLOUR_STEP: f32 = 8.0;

/// Averages `fine` x `fine` samples into each pixel's RGB. `colours` are those of the bodies.
pub(super) fn resolve_pixels(canvas: &DepthCanvas, colours: &[Vec3], scheme: PictureScheme, fine: usize) -> Vec<u8> {
    let (width, height) = (canvas.width / fine, canvas.height / fine);
    let fixed = match scheme {
        PictureScheme::Light => &LIGHT_COLOURS,
        PictureScheme::Dark => &DARK_COLOURS,
    };
    let shader =
        SampleShader { canvas, colours, fixed, haze: body_haze(canvas, colours.len()), reach: fine.div_ceil(2) };
    let mut pixels = Vec::with_capacity(3 * width * height);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mean = match shader.ground_of_pixel(x * fine, y * fine, fine) {
            Some(colour) => colour,
            None => {
                let samples = (0..fine).flat_map(|dy| (0..fine).map(move |dx| (dy, dx)));
                let sum: Vec3 = samples.map(|(dy, dx)| shader.sample_colour(x * fine + dx, y * fine + dy)).sum();
                sum / (fine * fine) as f32
            }
        };
        let is_fixed = [fixed.background, fixed.floor, fixed.wire, fixed.ink].contains(&mean);
        let mean = if is_fixed { mean } else { (mean / COLOUR_STEP).round() * COLOUR_STEP };
        pixels.extend(mean.to_array().map(|c| c.round().clamp(0.0, 255.0) as u8));
    }
    pixels
}

/// How hazy each body is: the farther away the middle of what is seen of it. One haze for a whole body leaves flat faces in one colour.
fn body_haze(canvas: &DepthCanvas, bodies: usize) -> Vec<f32> {
    let mut sums = vec![(0.0_f64, 0_u32); bodies.min(MAX_BODIES)];
    for (tag, depth) in canvas.tags.iter().zip(canvas.depths()) {
        if let Some(sum) = body_of(*tag).and_then(|body| sums.get_mut(body)) {
            *sum = (sum.0 + f64::from(depth), sum.1 + 1);
        }
    }
    let middle = |(sum, samples): &(f64, u32)| (*samples > 0).then(|| sum / f64::from(*samples));
    let middles: Vec<Option<f64>> = sums.iter().map(middle).collect();
    let seen = || middles.iter().flatten().copied();
    let (near, far) = (seen().fold(f64::INFINITY, f64::min), seen().fold(f64::NEG_INFINITY, f64::max));
    let haze = |depth: f64| HAZE * (((depth - near) / (far - near).max(1e-6)) as f32).clamp(0.0, 1.0);
    middles.iter().map(|depth| depth.map_or(0.0, haze)).collect()
}

struct SampleShader<'a> {
    canvas: &'a DepthCanvas,
    colours: &'a [Vec3],
    fixed: &'a FixedColours,
    /// Share of the background colour in each body.
    haze: Vec<f32>,
    /// Thickness of contours, samples.
    reach: usize,
}

impl SampleShader<'_> {
    /// The colour of a pixel that shows no body, and everywhere the same, as most do.
    fn ground_of_pixel(&self, x: usize, y: usize, fine: usize) -> Option<Vec3> {
        let row = |dy: usize| &self.canvas.tags[(y + dy) * self.canvas.width + x..][..fine];
        let tag = row(0)[0];
        let is_ground = body_of(tag).is_none() && (0..fine).all(|dy| row(dy).iter().all(|&other| other == tag));
        is_ground.then(|| self.sample_colour(x, y))
    }

    fn sample_colour(&self, x: usize, y: usize) -> Vec3 {
        let at = y * self.canvas.width + x;
        match self.canvas.tags[at] {
            NOTHING => self.fixed.background,
            TAG_FLOOR => self.fixed.floor,
            TAG_WIRE => self.fixed.wire,
            TAG_INK => self.fixed.ink,
            TAG_FAULT => self.fixed.fault,
            tag => self.body_colour(tag, x, y),
        }
    }

    fn body_colour(&self, tag: u32, x: usize, y: usize) -> Vec3 {
        let (at, width) = (y * self.canvas.width + x, self.canvas.width);
        let differs = |other: usize| body_of(self.canvas.tags[other]) != body_of(tag);
        let contour =
            (x >= self.reach && differs(at - self.reach)) || (y >= self.reach && differs(at - self.reach * width));
        let body = body_of(tag).unwrap_or(0);
        let plain = self.colours[body % self.colours.len().max(1)];
        let lit = plain * ((tag & 255) as f32 / 255.0) * if contour { CONTOUR } else { 1.0 };
        lit.lerp(self.fixed.background, self.haze.get(body).copied().unwrap_or(0.0))
    }
}
