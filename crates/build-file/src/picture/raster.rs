//! A small z-buffer: flat triangles and lines in an orthographic view. The nearest sample wins; of equal ones the
//! first.

use glam::{DVec3, Vec2, Vec3};

/// Tag of a sample that shows nothing.
pub(super) const NOTHING: u32 = u32::MAX;

/// An orthographic view that fits given points into a canvas.
#[derive(Debug, Clone)]
pub(crate) struct OrthographicView {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    scale: f64,
    shift: (f64, f64),
}

impl OrthographicView {
    /// A view along `forward` (`up` points up in the picture) with all of `points` inside the upper `width` x `height`
    /// samples, less a margin given as a share of them.
    pub(super) fn fit_points(
        forward: DVec3,
        up: DVec3,
        points: &[DVec3],
        width: usize,
        height: usize,
        margin: f64,
    ) -> Self {
        let forward = forward.normalize();
        let right = forward.cross(up).normalize();
        let up = right.cross(forward);
        let span = |axis: DVec3| {
            let along = points.iter().map(|p| p.dot(axis));
            (along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((left, rightmost), (low, high)) = (span(right), span(up));
        let (width, height) = (width as f64, height as f64);
        let room = 1.0 - 2.0 * margin;
        let scale = (room * width / (rightmost - left).max(1e-9)).min(room * height / (high - low).max(1e-9));
        let shift = ((width - scale * (left + rightmost)) / 2.0, (height + scale * (low + high)) / 2.0);
        Self { right, up, forward, scale, shift }
    }

    /// Returns samples to the right, samples down, depth in mm.
    pub(super) fn project_point(&self, point: DVec3) -> Vec3 {
        let x = self.scale * point.dot(self.right) + self.shift.0;
        let y = self.shift.1 - self.scale * point.dot(self.up);
        Vec3::new(x as f32, y as f32, point.dot(self.forward) as f32)
    }
}

/// Depth and tag of every sample.
#[derive(Debug)]
pub(crate) struct DepthCanvas {
    pub(super) width: usize,
    pub(super) height: usize,
    depth: Vec<f32>,
    /// The tag of each sample: chosen by the caller, or [`NOTHING`].
    pub(super) tags: Vec<u32>,
}

impl DepthCanvas {
    /// An empty canvas of `width` x `height` samples.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let samples = width * height;
        Self { width, height, depth: vec![f32::INFINITY; samples], tags: vec![NOTHING; samples] }
    }

    fn put_sample(&mut self, at: usize, depth: f32, tag: u32) {
        if depth < self.depth[at] {
            self.depth[at] = depth;
            self.tags[at] = tag;
        }
    }

    /// Fills a projected triangle in either winding order. Returns the number of depth tests.
    pub(super) fn fill_triangle(&mut self, [a, mut b, mut c]: [Vec3; 3], tag: u32) -> usize {
        let mut area = (b - a).truncate().perp_dot((c - a).truncate());
        if area < 0.0 {
            std::mem::swap(&mut b, &mut c);
            area = -area;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Sample centres lie at halves.
        let first = |least: f32| (least - 0.5).ceil().max(0.0) as usize;
        let end = |most: f32, size: usize| ((most - 0.5).floor() + 1.0).clamp(0.0, size as f32) as usize;
        let (x0, x1) = (first(low.x), end(high.x, self.width));
        let (y0, y1) = (first(low.y), end(high.y, self.height));
        if area <= 0.0 || area.is_nan() || x0 >= x1 || y0 >= y1 {
            return 0;
        }
        let edge = |from: Vec3, to: Vec3| {
            let run = (to - from).truncate();
            let start = Vec2::new(x0 as f32 + 0.5, y0 as f32 + 0.5) - from.truncate();
            (run.perp_dot(start), -run.y, run.x)
        };
        let (ab, bc, ca) = (edge(a, b), edge(b, c), edge(c, a));
        for y in y0..y1 {
            let down = (y - y0) as f32;
            let mut weights = Vec3::new(bc.0 + down * bc.2, ca.0 + down * ca.2, ab.0 + down * ab.2);
            let step = Vec3::new(bc.1, ca.1, ab.1);
            for at in y * self.width + x0..y * self.width + x1 {
                if weights.min_element() >= 0.0 {
                    let depth = (weights.x * a.z + weights.y * b.z + weights.z * c.z) / area;
                    self.put_sample(at, depth, tag);
                }
                weights += step;
            }
        }
        (x1 - x0) * (y1 - y0)
    }

    /// Depth of every sample, mm; infinite where nothing is drawn.
    pub(super) fn depths(&self) -> impl Iterator<Item = f32> {
        self.depth.iter().copied()
    }

    /// Like [`DepthCanvas::line`], in dashes five times as long as thick.
    pub(super) fn draw_dashes(&mut self, from: Vec3, to: Vec3, thick: usize, nearer: f32, tag: u32) {
        let dashes = (((to - from).truncate().length() / (8.0 * thick as f32)).round()).max(1.0);
        for dash in 0..dashes as usize {
            let share = |part: f32| from.lerp(to, (dash as f32 + part) / dashes);
            self.draw_line(share(0.2), share(0.8), thick, nearer, tag);
        }
    }

    /// Draws a projected line with a round pen `thick` samples wide, moved `nearer` mm towards the viewer.
    pub(super) fn draw_line(&mut self, from: Vec3, to: Vec3, thick: usize, nearer: f32, tag: u32) {
        let steps = (to - from).truncate().abs().max_element().ceil().max(1.0) as usize;
        for step in 0..=steps {
            let p = from.lerp(to, step as f32 / steps as f32);
            let (radius, corner) = (0.5 * thick as f32, p.truncate() - (thick as f32 - 1.0) / 2.0);
            for (dx, dy) in (0..thick).flat_map(|dx| (0..thick).map(move |dy| (dx, dy))) {
                let (x, y) = (corner.x + dx as f32, corner.y + dy as f32);
                let is_round = thick < 3 || Vec2::new(x, y).distance(p.truncate()) <= radius;
                if is_round && x >= 0.0 && y >= 0.0 && (x as usize) < self.width && (y as usize) < self.height {
                    self.put_sample(y as usize * self.width + x as usize, p.z - nearer, tag);
                }
            }
        }
    }
}
