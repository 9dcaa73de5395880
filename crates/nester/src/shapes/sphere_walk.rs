//! The walk through a tree of spheres that finds the points near another part. Four spheres or points are looked up in
//! the distance grid at once; what is found, and in which order, is what a walk from sphere to sphere finds.

use glam::{Vec3, Vec4};

use super::{
    bounding_sphere::BoundingSphere,
    distance_field::DistanceField,
    point_block::{BLOCK_POINTS, BlockMotion, PointBlock},
};

/// Greatest depth of a tree. Trees that halve their points have at most 11 levels for 10,000 points.
const MAX_DEPTH: usize = 30;

/// What is in a sphere: points, or two smaller spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SphereContent {
    /// The first block of the points, or the pair of smaller spheres.
    at: u32,
    /// Number of points; 0 for a pair.
    points: u32,
}

/// The two spheres in a larger one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpherePair {
    x: [f32; 2],
    y: [f32; 2],
    z: [f32; 2],
    radius: [f32; 2],
    contents: [SphereContent; 2],
}

/// A sphere that is near, whose content is still to be visited.
#[derive(Clone, Copy)]
struct OpenSphere {
    content: SphereContent,
    /// Of a pair: bit 0 and bit 1 tell which of the two is near.
    near: u32,
}

/// A tree of spheres, arranged for the walk.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SphereWalk {
    pairs: Vec<SpherePair>,
    blocks: Vec<PointBlock>,
    root: (Vec3, f32, SphereContent),
}

impl SphereWalk {
    /// Arranges spheres in depth-first order; `None` if they do not form a tree in which every sphere holds points or two
    /// spheres.
    pub(crate) fn new(spheres: &[BoundingSphere], points: &[Vec3]) -> Option<Self> {
        let root = SphereContent { at: 0, points: 0 };
        let first = spheres.first()?;
        let mut walk = Self { pairs: Vec::new(), blocks: Vec::new(), root: (first.center, first.radius, root) };
        walk.root.2 = walk.add_content(spheres, points, 0, MAX_DEPTH)?;
        (first.next_sibling as usize == spheres.len()).then_some(walk)
    }

    fn add_content(
        &mut self,
        spheres: &[BoundingSphere],
        points: &[Vec3],
        at: usize,
        levels: usize,
    ) -> Option<SphereContent> {
        let sphere = &spheres[at];
        let end = sphere.next_sibling as usize;
        if sphere.count > 0 {
            let first = sphere.first as usize;
            let content = SphereContent { at: self.blocks.len() as u32, points: sphere.count };
            let own = points.get(first..first + sphere.count as usize)?;
            self.blocks.extend(own.chunks(BLOCK_POINTS).map(PointBlock::from_points));
            return (end == at + 1).then_some(content);
        }
        let one = spheres.get(at + 1)?;
        let middle = one.next_sibling as usize;
        let two = spheres.get(middle)?;
        if levels == 0 || middle >= end || two.next_sibling as usize != end {
            return None;
        }
        let pair = self.pairs.len();
        let unknown = SphereContent { at: 0, points: 0 };
        self.pairs.push(SpherePair {
            x: [one.center.x, two.center.x],
            y: [one.center.y, two.center.y],
            z: [one.center.z, two.center.z],
            radius: [one.radius, two.radius],
            contents: [unknown; 2],
        });
        let content1 = self.add_content(spheres, points, at + 1, levels - 1)?;
        let content2 = self.add_content(spheres, points, middle, levels - 1)?;
        self.pairs[pair].contents = [content1, content2];
        Some(SphereContent { at: pair as u32, points: 0 })
    }

    /// Calls `visit` with every point whose distance by `field` is below `reach`, in spheres that come so near too: the
    /// point, where `motion` carries it into the field's frame, and its distance, mm.
    #[inline]
    pub(crate) fn visit_near_points(
        &self,
        field: &DistanceField,
        motion: &BlockMotion,
        reach: f32,
        mut visit: impl FnMut(Vec3, Vec3, f32),
    ) {
        let (center, radius, content) = self.root;
        if field.distance(motion.move_point(center)) >= reach + radius {
            return;
        }
        // One sphere waits at each level, beside the two that were opened last.
        let mut open = [OpenSphere { content, near: 0 }; MAX_DEPTH + 2];
        let mut count = 1;
        if content.points == 0 {
            open[0].near = self.near_spheres(field, motion, reach, [content.at; 2]) & 3;
            count = usize::from(open[0].near > 0);
        }
        while count > 0 {
            count -= 1;
            let OpenSphere { content, near } = open[count];
            if content.points > 0 {
                self.visit_points(content, field, motion, reach, &mut visit);
                continue;
            }
            let [one, two] = self.pairs[content.at as usize].contents;
            let (is_near1, is_near2) = (near & 1 != 0, near & 2 != 0);
            let (opens1, opens2) = (is_near1 && one.points == 0, is_near2 && two.points == 0);
            let (mut near1, mut near2) = (u32::from(is_near1), u32::from(is_near2));
            if opens1 || opens2 {
                let pairs = [if opens1 { one.at } else { two.at }, if opens2 { two.at } else { one.at }];
                let found = self.near_spheres(field, motion, reach, pairs);
                near1 = if opens1 { found & 3 } else { near1 };
                near2 = if opens2 { found >> 2 } else { near2 };
            }
            open[count] = OpenSphere { content: two, near: near2 };
            count += usize::from(near2 > 0);
            open[count] = OpenSphere { content: one, near: near1 };
            count += usize::from(near1 > 0);
        }
    }

    /// Tells with a bit for each of the spheres of two pairs whether it is near.
    #[inline(always)]
    fn near_spheres(&self, field: &DistanceField, motion: &BlockMotion, reach: f32, pairs: [u32; 2]) -> u32 {
        let [one, two] = pairs.map(|pair| &self.pairs[pair as usize]);
        let join = |one: [f32; 2], two: [f32; 2]| Vec4::new(one[0], one[1], two[0], two[1]);
        let centers = PointBlock { x: join(one.x, two.x), y: join(one.y, two.y), z: join(one.z, two.z) };
        let distances = field.distances(&motion.move_block(&centers));
        distances.cmplt(join(one.radius, two.radius) + reach).bitmask()
    }

    #[inline(always)]
    fn visit_points(
        &self,
        content: SphereContent,
        field: &DistanceField,
        motion: &BlockMotion,
        reach: f32,
        visit: &mut impl FnMut(Vec3, Vec3, f32),
    ) {
        let mut left = content.points;
        for block in &self.blocks[content.at as usize..] {
            let there = motion.move_block(block);
            let distances = field.block_distances(&there, reach);
            let own = (1 << left.min(BLOCK_POINTS as u32)) - 1;
            let mut near = distances.cmplt(Vec4::splat(reach)).bitmask() & own;
            while near > 0 {
                let lane = near.trailing_zeros() as usize;
                visit(block.point(lane), there.point(lane), distances[lane]);
                near &= near - 1;
            }
            if left <= BLOCK_POINTS as u32 {
                break;
            }
            left -= BLOCK_POINTS as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Mat3, Quat};
    use proptest::prelude::*;

    use super::*;
    use crate::{
        shapes::sphere_tree::{MeasuredSurface, SphereTree},
        tests::testing::{block, hollow},
    };

    /// The points that a walk from sphere to sphere finds, one after the other.
    fn found_singly(
        spheres: &[BoundingSphere],
        points: &[Vec3],
        near: impl Fn(Vec3, f32) -> Option<f32>,
    ) -> Vec<(Vec3, u32)> {
        let (mut found, mut at) = (Vec::new(), 0);
        while let Some(sphere) = spheres.get(at) {
            if near(sphere.center, sphere.radius).is_none() {
                at = sphere.next_sibling as usize;
                continue;
            }
            let own = &points[sphere.first as usize..][..sphere.count as usize];
            found.extend(own.iter().filter_map(|&p| Some((p, near(p, 0.0)?.to_bits()))));
            at += 1;
        }
        found
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_same_points_are_found_in_the_same_order_as_one_by_one(
            turn in proptest::array::uniform3(-3.0..3.0f32), shift in proptest::array::uniform3(-25.0..25.0f32),
            wanted in 1..400usize, reach in -0.5..4.0f32,
        ) {
            let body = block(DVec3::new(24.0, 10.0, 6.0));
            let tree = SphereTree::new(&MeasuredSurface::new(&body), DVec3::new(12.0, 5.0, 3.0), wanted);
            let field = DistanceField::new(&hollow(30.0, 1.0), DVec3::splat(15.0), 4.0, 8_000, &|| false).unwrap();
            let motion = BlockMotion::new(Mat3::from_quat(Quat::from_scaled_axis(turn.into())), shift.into());
            let near = |point: Vec3, radius: f32| {
                Some(field.distance(motion.move_point(point))).filter(|&distance| distance < reach + radius)
            };
            let mut found = Vec::new();
            tree.walk.visit_near_points(&field, &motion, reach, |point, there, distance| {
                assert_eq!(there, motion.move_point(point));
                found.push((point, distance.to_bits()));
            });
            prop_assert_eq!(found, found_singly(tree.spheres(), tree.points(), near));
        }
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let sphere = |next_sibling: u32, first: u32, count: u32| BoundingSphere {
            center: Vec3::ZERO,
            radius: 1.0,
            next_sibling,
            first,
            count,
        };
        let points = [Vec3::ZERO, Vec3::X];
        let pair = [sphere(3, 0, 0), sphere(2, 0, 1), sphere(3, 1, 1)];
        assert!(SphereWalk::new(&pair, &points).is_some());
        for (broken, why) in [
            (vec![], "nothing"),
            (vec![sphere(1, 0, 0)], "neither points nor spheres"),
            (vec![sphere(1, 1, 2)], "more points than there are"),
            (vec![sphere(2, 0, 0), sphere(2, 0, 1)], "one sphere in another"),
            (vec![pair[0], pair[1], sphere(4, 1, 1)], "reaches beyond its parent"),
            (vec![pair[0], pair[1], pair[2], sphere(4, 0, 1)], "two roots"),
        ] {
            assert!(SphereWalk::new(&broken, &points).is_none(), "{why}");
        }
        // A chain that is deeper than the walk can follow.
        let count = 80_u32;
        let chain = (0..count).flat_map(|level| {
            let leaf = 2 * level + 1;
            [sphere(2 * count + 1, 0, 0), sphere(leaf + 1, 0, 1)]
        });
        let chain: Vec<BoundingSphere> = chain.chain([sphere(2 * count + 1, 1, 1)]).collect();
        assert!(SphereWalk::new(&chain, &points).is_none());
    }
}
