//! Letters for pictures, drawn as pen strokes so that they are sharp at every size. Only the characters of "84.0 mm of
//! 300 mm".

use super::raster::DepthCanvas;
use glam::{Vec2, Vec3};

/// Height of a digit in units of the letter grid.
const DIGIT_HEIGHT: f32 = 12.0;
/// Points on each piece of a curve.
const CURVE_POINTS: usize = 8;

/// A pen stroke through points of the grid, x to the right, y down; a curve passes smoothly through them.
enum PenStroke {
    Line(&'static [(f32, f32)]),
    Curve(&'static [(f32, f32)]),
}

use PenStroke::{Curve, Line};

/// Letters: advance width and strokes.
const LETTERS: [(char, f32, &[PenStroke]); 12] = [
    ('0', 9.5, &[Curve(&[(4.0, 0.0), (7.0, 2.5), (7.0, 9.5), (4.0, 12.0), (1.0, 9.5), (1.0, 2.5), (4.0, 0.0)])]),
    ('1', 9.5, &[Line(&[(1.5, 2.5), (4.2, 0.0), (4.2, 12.0)])]),
    (
        '2',
        9.5,
        &[
            Curve(&[(1.0, 3.2), (2.0, 0.9), (4.0, 0.0), (6.3, 0.9), (6.8, 3.2), (5.5, 6.2), (1.0, 12.0)]),
            Line(&[(1.0, 12.0), (7.2, 12.0)]),
        ],
    ),
    (
        '3',
        9.5,
        &[
            Curve(&[(1.2, 1.6), (3.8, 0.0), (6.4, 1.2), (6.2, 4.4), (3.4, 5.7)]),
            Curve(&[(3.4, 5.7), (6.2, 6.6), (7.1, 9.0), (5.9, 11.3), (3.6, 12.0), (1.0, 10.5)]),
        ],
    ),
    ('4', 9.5, &[Line(&[(5.6, 12.0), (5.6, 0.0), (0.8, 8.6), (7.8, 8.6)])]),
    (
        '5',
        9.5,
        &[
            Line(&[(6.6, 0.0), (2.0, 0.0), (1.5, 5.3)]),
            Curve(&[(1.5, 5.3), (4.0, 4.4), (6.5, 5.5), (7.1, 8.2), (5.9, 11.2), (3.6, 12.0), (1.0, 10.8)]),
        ],
    ),
    (
        '6',
        9.5,
        &[Curve(&[
            (6.2, 0.4),
            (3.4, 2.2),
            (1.3, 6.2),
            (1.5, 10.2),
            (4.0, 12.0),
            (6.6, 10.5),
            (6.7, 7.0),
            (4.2, 5.2),
            (1.4, 7.2),
        ])],
    ),
    ('7', 9.5, &[Line(&[(1.0, 0.0), (7.0, 0.0), (3.0, 12.0)])]),
    (
        '8',
        9.5,
        &[
            Curve(&[(4.0, 0.0), (6.4, 1.2), (6.2, 4.4), (4.0, 5.6), (1.8, 4.4), (1.6, 1.2), (4.0, 0.0)]),
            Curve(&[(4.0, 5.6), (6.7, 7.0), (6.9, 10.3), (4.0, 12.0), (1.1, 10.3), (1.3, 7.0), (4.0, 5.6)]),
        ],
    ),
    (
        '9',
        9.5,
        &[Curve(&[
            (1.8, 11.6),
            (4.6, 9.8),
            (6.7, 5.8),
            (6.5, 1.8),
            (4.0, 0.0),
            (1.4, 1.5),
            (1.3, 5.0),
            (3.8, 6.8),
            (6.6, 4.8),
        ])],
    ),
    ('/', 7.0, &[Line(&[(5.6, 0.0), (1.2, 12.0)])]),
    (
        'm',
        12.0,
        &[
            Line(&[(1.0, 12.0), (1.0, 4.2)]),
            Curve(&[(1.0, 6.6), (2.8, 4.4), (4.8, 5.2), (5.2, 7.4), (5.2, 12.0)]),
            Curve(&[(5.2, 6.6), (7.0, 4.4), (9.0, 5.2), (9.4, 7.4), (9.4, 12.0)]),
        ],
    ),
];
/// Advance width of any other character, e.g. a space.
const SPACE_WIDTH: f32 = 5.0;

/// Advance width and strokes of a letter.
fn letter_strokes(c: char) -> (f32, &'static [PenStroke]) {
    LETTERS
        .iter()
        .find(|(known, ..)| *known == c)
        .map_or((SPACE_WIDTH, &[]), |&(_, advance, strokes)| (advance, strokes))
}

/// Width of a text whose digits are `tall` samples high, samples.
pub(super) fn text_width(text: &str, tall: f32) -> f32 {
    text.chars().map(|c| letter_strokes(c).0).sum::<f32>() * tall / DIGIT_HEIGHT
}

/// Draws a text in front of everything. The upper left corner of its first digit is at `at`, samples.
pub(super) fn write_text(canvas: &mut DepthCanvas, text: &str, mut at: Vec2, tall: f32, tag: u32) {
    let scale = tall / DIGIT_HEIGHT;
    let pen = (tall / 7.0).round().max(1.0) as usize;
    for c in text.chars() {
        let (advance, strokes) = letter_strokes(c);
        for stroke in strokes {
            let points = match stroke {
                Line(points) => points.iter().map(|&p| Vec2::from(p)).collect(),
                Curve(points) => smooth(points),
            };
            let placed: Vec<Vec3> = points.iter().map(|&p| (at + scale * p).extend(f32::MIN)).collect();
            placed.windows(2).for_each(|run| canvas.draw_line(run[0], run[1], pen, 0.0, tag));
        }
        at.x += scale * advance;
    }
}

/// A Catmull-Rom curve through the points.
fn smooth(points: &[(f32, f32)]) -> Vec<Vec2> {
    let closed = points.first() == points.last();
    let last = points.len() - 1;
    let point = |at: isize| {
        let at = match at {
            _ if at < 0 && closed => last - 1,
            _ if at as usize > last && closed && at > 0 => 1,
            _ => at.clamp(0, last as isize) as usize,
        };
        Vec2::from(points[at])
    };
    let mut curve = vec![point(0)];
    for piece in 0..last as isize {
        let [a, b, c, d] = [-1, 0, 1, 2].map(|k| point(piece + k));
        curve.extend((1..=CURVE_POINTS).map(|step| {
            let t = step as f32 / CURVE_POINTS as f32;
            let bend = (2.0 * a - 5.0 * b + 4.0 * c - d) * t + (3.0 * b - a - 3.0 * c + d) * (t * t);
            0.5 * (2.0 * b + (c - a) * t + bend * t)
        }));
    }
    curve
}
