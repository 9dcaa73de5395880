//! Tests of pictures, by their pixels.

use glam::DQuat;

use super::*;
use crate::picture::shade::{LIGHT_COLOURS, body_of};

const VOLUME: DVec3 = DVec3::splat(100.0);

/// Decoded RGB of a PNG.
struct DecodedPicture {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl DecodedPicture {
    fn count(&self, fits: impl Fn(Vec3) -> bool) -> usize {
        self.pixels.iter().filter(|rgb| fits(Vec3::from_array(rgb.map(f32::from)))).count()
    }

    fn exactly(&self, colour: Vec3) -> usize {
        self.count(|pixel| pixel == colour)
    }

    /// Pixels of a hue, of any brightness.
    fn like(&self, kind: usize) -> usize {
        let direction = |c: Vec3| (c - Vec3::splat(c.element_sum() / 3.0)).normalize_or_zero();
        let wanted = direction(kind_colour(kind));
        self.count(|pixel| pixel.max_element() - pixel.min_element() > 40.0 && direction(pixel).dot(wanted) > 0.99)
    }
}

fn decode(bytes: &[u8]) -> DecodedPicture {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let pixels = pixels.as_chunks::<3>().0.to_vec();
    DecodedPicture { width: info.width, height: info.height, pixels }
}

/// Pixels of lines and letters, not of a body.
fn is_grey(pixel: Vec3) -> bool {
    pixel.max_element() - pixel.min_element() < 25.0
}

fn at(mesh: &Mesh, kind: usize, x: f64, y: f64, z: f64) -> PictureBody<'_> {
    PictureBody { mesh, pose: Pose::new(DQuat::IDENTITY, DVec3::new(x, y, z)), kind }
}

#[test]
fn a_body_covers_the_floor_and_leaves_the_corners_empty() {
    let mesh = sample_parts::cuboid(DVec3::splat(60.0));
    let picture = |bodies: &[PictureBody]| decode(&draw_picture(bodies, VOLUME, Viewpoint::Iso, (120, 90)));
    let (empty, filled) = (picture(&[]), picture(&[at(&mesh, 0, 20.0, 20.0, 0.0)]));
    assert_eq!((filled.width, filled.height, filled.pixels.len()), (120, 90, 120 * 90));
    assert_eq!(filled.pixels[0].map(f32::from), LIGHT_COLOURS.background.to_array());
    let (before, after) = (empty.exactly(LIGHT_COLOURS.floor), filled.exactly(LIGHT_COLOURS.floor));
    assert!(after + 200 < before, "{after} of {before}");
}

#[test]
fn every_view_has_the_size_asked_the_frame_and_the_body() {
    let mesh = sample_parts::cuboid(DVec3::splat(60.0));
    for viewpoint in [Viewpoint::Iso, Viewpoint::Top, Viewpoint::Front] {
        for size in [(320, 200), (200, 320), (1, 1), (7, 300)] {
            let drawn = decode(&draw_picture(&[at(&mesh, 2, 20.0, 20.0, 0.0)], VOLUME, viewpoint, size));
            assert_eq!((drawn.width, drawn.height), size);
            if size.0 >= 200 {
                let wire = drawn.count(|pixel| is_grey(pixel) && pixel.max_element() < 205.0);
                assert!(wire > 600, "{viewpoint:?} {size:?}: the frame has {wire} pixels");
                let body = drawn.like(2);
                assert!(body > 2000, "{viewpoint:?} {size:?}: the body has {body} pixels");
            }
        }
    }
}

#[test]
fn a_picture_for_dark_pages_has_a_dark_ground_and_the_same_body() {
    let mesh = sample_parts::cuboid(DVec3::splat(60.0));
    let bodies = [at(&mesh, 0, 20.0, 20.0, 0.0)];
    let on = |scheme| decode(&draw_picture_on(scheme, &bodies, VOLUME, Viewpoint::Iso, (160, 120)));
    let (light, dark) = (on(PictureScheme::Light), on(PictureScheme::Dark));
    assert!(light.pixels[0].iter().all(|c| *c > 200) && dark.pixels[0].iter().all(|c| *c < 60), "{:?}", dark.pixels[0]);
    let bright = dark.count(|pixel| is_grey(pixel) && pixel.min_element() > 180.0);
    assert!(bright > 20, "the caption is legible: {bright} pixels");
    assert!(dark.like(0) > 500, "{} pixels of the body", dark.like(0));
}

#[test]
fn a_part_alone_fills_its_picture_without_a_frame() {
    let mesh = sample_parts::ring(40.0, 28.0, 8.0);
    let drawn = decode(&draw_part(&mesh, &[], 3, PictureScheme::Light, (160, 120)));
    assert!(drawn.like(3) > 160 * 120 / 8, "{} pixels", drawn.like(3));
    let empty = drawn.exactly(LIGHT_COLOURS.background) + drawn.exactly(LIGHT_COLOURS.floor);
    assert!(empty > 160 * 120 / 8 && drawn.exactly(LIGHT_COLOURS.floor) == 0);
    assert_eq!((kind_colour_code(0).as_str(), kind_colour_code(3).as_str()), ("#0072b2", "#cc79a7"));
}

#[test]
fn copies_of_a_part_have_its_colour_and_other_parts_another() {
    let mesh = sample_parts::cuboid(DVec3::splat(25.0));
    let draw = |kinds: [usize; 3]| {
        let bodies: Vec<PictureBody> = (0..3).map(|n| at(&mesh, kinds[n], 30.0 * n as f64, 0.0, 0.0)).collect();
        decode(&draw_picture(&bodies, VOLUME, Viewpoint::Front, (400, 300)))
    };
    let (alike, mixed) = (draw([0, 0, 0]), draw([0, 3, 5]));
    assert!(mixed.like(0) > 1000 && mixed.like(3) > 1000 && mixed.like(5) > 1000);
    assert!(alike.like(0) > 2 * mixed.like(0) && alike.like(3) + alike.like(5) == 0);
}

#[test]
fn twenty_one_kinds_in_a_row_have_colours_of_their_own() {
    for (a, b) in (0..21).flat_map(|a| (0..a).map(move |b| (a, b))) {
        assert!(kind_colour(a).distance(kind_colour(b)) > 25.0, "{a} and {b}");
    }
}

#[test]
fn the_frame_is_hidden_where_a_body_is_before_it_only() {
    let wall = sample_parts::cuboid(DVec3::new(100.0, 1.0, 100.0));
    let wires = |bodies: &[PictureBody]| {
        let mut canvas = DepthCanvas::new(400, 300);
        let (forward, up) = Viewpoint::Iso.view_directions();
        let corners: Vec<DVec3> = (0..8).map(|c| box_corner(c, VOLUME)).collect();
        let view = OrthographicView::fit_points(forward, up, &corners, 400, 300, MARGIN);
        bodies.iter().for_each(|body| draw_body(&mut canvas, &view, forward, body, 0, &mut { usize::MAX }));
        draw_volume_edges(&mut canvas, &view, VOLUME, 1);
        canvas.tags.iter().filter(|&&tag| tag == TAG_WIRE).count()
    };
    let (all, seen) = (wires(&[]), wires(&[at(&wall, 0, 0.0, 50.0, 0.0)]));
    assert!(seen + 150 < all && 2 * seen > all, "{seen} of {all} samples of the frame");
}

#[test]
fn the_height_is_a_dashed_line_and_a_text() {
    let mesh = sample_parts::cuboid(DVec3::splat(40.0));
    let is_ink = |pixel: Vec3| is_grey(pixel) && pixel.max_element() < 110.0;
    let ink =
        |bodies: &[PictureBody]| decode(&draw_picture(bodies, VOLUME, Viewpoint::Front, (400, 300))).count(is_ink);
    assert_eq!(ink(&[]), 0, "an empty build has no height");
    assert!(ink(&[at(&mesh, 4, 10.0, 10.0, 0.0)]) > 150);
    assert_eq!(height_in_words(84.04, 300.0), "84 / 300 mm");
    let text = |letters: &str| lettering::text_width(letters, 12.0);
    assert!(text("84 / 300 mm") > 7.0 * text("8") && text("8") > text("/"));
    let drawn = |letters: &str| {
        let mut canvas = DepthCanvas::new(60, 40);
        lettering::write_text(&mut canvas, letters, Vec2::new(8.0, 8.0), 24.0, TAG_INK);
        canvas.tags
    };
    let letters = ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "/", "m", " "];
    for (a, b) in letters.iter().flat_map(|a| letters.iter().map(move |b| (a, b))).filter(|(a, b)| a != b) {
        assert_ne!(drawn(a), drawn(b), "{a} {b}");
    }
}

#[test]
fn the_nearer_body_hides_the_farther_one_whatever_their_order() {
    let mesh = sample_parts::cuboid(DVec3::new(60.0, 20.0, 90.0));
    let draw = |order: [f64; 2]| {
        let mut canvas = DepthCanvas::new(100, 100);
        let (forward, up) = Viewpoint::Iso.view_directions();
        let view = OrthographicView::fit_points(forward, up, &[DVec3::ZERO, VOLUME], 100, 100, 0.0);
        for (index, y) in order.into_iter().enumerate() {
            draw_body(&mut canvas, &view, forward, &at(&mesh, 0, 20.0, y, 0.0), index, &mut { usize::MAX });
        }
        let count = |body: usize| canvas.tags.iter().filter(|&&tag| body_of(tag) == Some(body)).count();
        (count(0), count(1))
    };
    let (front_first, back_second) = draw([0.0, 70.0]);
    let (back_first, front_second) = draw([70.0, 0.0]);
    assert_eq!((front_first, back_second), (front_second, back_first));
    assert!(front_first > back_first);
}

#[test]
fn the_same_bodies_give_the_same_bytes() {
    let mesh = sample_parts::cuboid(DVec3::splat(60.0));
    let volume_mm = DVec3::new(100.0, 100.0, 200.0);
    let draw = || draw_picture(&[at(&mesh, 0, 20.0, 20.0, 3.0)], volume_mm, Viewpoint::Iso, (160, 120));
    assert_eq!(draw(), draw());
}

#[test]
fn a_body_outside_the_picture_does_no_harm() {
    let mesh = sample_parts::ring(40.0, 28.0, 8.0);
    let pose = Pose::new(DQuat::from_rotation_x(0.4), DVec3::splat(-500.0));
    let far = PictureBody { mesh: &mesh, pose, kind: 7 };
    assert!(!draw_picture(&[far], DVec3::splat(50.0), Viewpoint::Top, (64, 64)).is_empty());
}

/// Pixels of the edges at which a surface is open.
fn faults(mesh: &Mesh) -> usize {
    decode(&draw_part(mesh, &[], 0, PictureScheme::Light, (200, 150)))
        .count(|p| p.x > 180.0 && p.y < 90.0 && p.z < 90.0)
}

#[test]
fn the_open_edges_of_a_part_are_red_and_a_closed_part_has_none() {
    let closed = sample_parts::cuboid(DVec3::new(40.0, 30.0, 20.0));
    assert_eq!(faults(&closed), 0);
    let torn = Mesh::new(closed.vertices().to_vec(), closed.triangles()[2..].to_vec()).unwrap();
    assert!(torn.defects().open_edges > 0 && faults(&torn) > 40, "{}", faults(&torn));
}

#[test]
fn a_flat_face_has_one_colour_however_far_it_reaches() {
    let mesh = sample_parts::cuboid(DVec3::new(90.0, 80.0, 60.0));
    let colours = |picture: DecodedPicture| {
        let mut many = std::collections::HashMap::new();
        picture.pixels.iter().for_each(|pixel| *many.entry(*pixel).or_insert(0) += 1);
        let is_body = |rgb: &[u8; 3]| !is_grey(Vec3::from_array(rgb.map(f32::from)));
        // Edges are drawn smoothly: a few pixels have colours between those of two faces.
        many.into_iter().filter(|(rgb, count)| *count > 300 && is_body(rgb)).count()
    };
    assert_eq!(colours(decode(&draw_part(&mesh, &[], 0, PictureScheme::Light, (320, 240)))), 3, "three faces are seen");
    let bodies = [at(&mesh, 0, 5.0, 10.0, 0.0)];
    assert_eq!(colours(decode(&draw_picture(&bodies, VOLUME, Viewpoint::Iso, (320, 240)))), 3);
}
