//! Mends a mesh, and says what was done and how far it may be off.

use glam::DVec3;
use thiserror::Error;

use super::{
    crossing::has_crossing,
    edges::{EdgeUses, is_balanced},
    fill::{FLAT, Filling, area, edge_lengths, fill_rim, normal},
    orient::{Facing, find_facing},
    rims::{Rim, find_rims},
    tidy::kept_triangles,
};
use crate::{Mesh, mesh::weld::weld_open_edges};

/// A larger mesh is not mended: it would take too much memory.
const MAX_TRIANGLES: usize = 4_000_000;
/// Corners of the rim of one hole.
const MAX_RIM: usize = 160;
/// Open edges of all holes.
const MAX_OPEN: usize = 20_000;
/// Steps of closing all holes, and of looking which pieces lie in which: seconds of work.
const MAX_STEPS: usize = 200_000_000;
/// Corners of open edges that are nearer than this are one, where the surface cannot be closed otherwise, mm: half a thin layer.
const WELD_MM: f64 = 0.02;
/// A hole as narrow as this is a crack: closing it changes nothing that is printed, mm.
const CRACK_MM: f64 = 0.02;
/// The most that a hole may take of the surface of its piece: what is larger may be an opening that is meant.
const MAX_HOLE_SHARE: f64 = 0.15;
/// Where the surface bends by less than this, it goes on across the rim of a hole, radians.
const GOES_ON: f64 = 0.7;
/// The surface goes on across at least this share of the rim of a hole that is flat, or closed by one triangle: a hole with sharp edges all
/// around may be meant.
const MIN_SMOOTH_SHARE: f64 = 0.3;
/// The same where the surface bends, by at most this, radians.
const MIN_SMOOTH_BENT: f64 = 0.6;
const BENT: f64 = 0.35;
/// Corners of the rim of a hole that one triangle closes. Where it takes two, a corner may be lost that was raised.
const PLAIN_RIM: usize = 3;
/// The most that a hole may be wide where the surface bends, as a share of the root of the area of its piece.
const MAX_BENT_SHARE: f64 = 0.1;
/// What is not known of the volume below all holes, as a share of it.
const MAX_DOUBT_SHARE: f64 = 0.005;
/// What may hang on a piece that is left out, as a share of its surface.
const MAX_LEFT_OUT_SHARE: f64 = 0.1;
/// More than this share of a piece inside another one faces the other way: nobody knows whether it is a cavity.
const MAX_TURNED_INSIDE: f64 = 0.25;
/// Least volume of a piece, as a share of the power 1.5 of its area: below it is a sheet.
const MIN_THICKNESS: f64 = 1e-5;

/// What was done to mend a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct MendMeasures {
    /// Holes that were closed.
    pub holes: usize,
    /// The largest distance across one of them, mm.
    pub widest_hole_mm: f64,
    /// Triangles that close them.
    pub added: usize,
    /// Triangles that were turned.
    pub turned: usize,
    /// Triangles that were left out.
    pub left_out: usize,
    /// Corners that were joined with others.
    pub joined: usize,
    /// Volume before, mm3; of a surface that is not closed it depends on where one counts from.
    pub volume_before_mm3: f64,
    /// Volume afterwards, mm3.
    pub volume_after_mm3: f64,
    /// No point of the mended surface is farther than this from the surface before, mm.
    pub deviation_mm: f64,
}

/// A mended mesh.
#[derive(Debug, Clone)]
pub struct MendedMesh {
    /// Closed, facing outwards.
    pub mesh: Mesh,
    /// What was done.
    pub measures: MendMeasures,
    /// The triangles that were added or turned, to be shown.
    pub mended: Vec<[DVec3; 3]>,
}

/// Why a mesh is not mended.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MendError {
    /// There is nothing to mend.
    #[error("it is closed")]
    Closed,
    /// It is too large, or has too many holes.
    #[error("it has too many triangles or holes")]
    TooLarge,
    /// Edges of more than two triangles that are left.
    #[error("which triangles belong together is not known where more than two meet in an edge")]
    Ambiguous,
    /// A Moebius band or a Klein bottle.
    #[error("a piece of it has one side only")]
    OneSided,
    /// A hole is too large.
    #[error("a hole {0:.1} mm wide is too large to know what was there")]
    LargeHole(f64),
    /// A hole with sharp edges all around.
    #[error("an opening {0:.1} mm wide has sharp edges all around and may be meant")]
    Opening(f64),
    /// A hole cannot be closed without crossing what is there.
    #[error("what would close its holes would cross its surface")]
    Crossing,
    /// The surface bends around its holes.
    #[error("the surface bends too much around its holes to know what was there")]
    Doubt,
    /// A piece without a volume.
    #[error("a piece of it is a sheet without a volume")]
    Sheet,
    /// A piece inside another one of which many triangles face either way.
    #[error("whether a piece inside another is a cavity is not known")]
    Cavity,
}

impl Mesh {
    /// This mesh closed and facing outwards, if there is one certain way to read it. The same mesh is always mended the same way.
    ///
    /// # Errors
    /// It is closed, or it is not certain what was meant.
    pub fn mended(&self) -> Result<MendedMesh, MendError> {
        if self.defects().is_closed() {
            return Err(MendError::Closed);
        }
        if self.triangles().len() > MAX_TRIANGLES {
            return Err(MendError::TooLarge);
        }
        let as_it_is = Repair::new(self, self.vertices().to_vec(), self.triangles().to_vec()).mend();
        as_it_is.or_else(|why| {
            let (vertices, triangles) = weld_open_edges(self.vertices(), self.triangles().to_vec(), WELD_MM);
            let joined = self.vertices().len() - vertices.len();
            if joined == 0 {
                return Err(why);
            }
            let mut repair = Repair::new(self, vertices, triangles);
            repair.measures.joined = joined;
            let mut mended = repair.mend().map_err(|_| why)?;
            mended.measures.deviation_mm += WELD_MM; // What fills its holes is measured from their rims, which have moved.
            Ok(mended)
        })
    }
}

/// A surface while it is mended.
struct Repair {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Whether a triangle was turned.
    is_turned: Vec<bool>,
    measures: MendMeasures,
}

/// A hole with what closes it.
struct ClosedHole {
    rim: Rim,
    filling: Filling,
    piece: usize,
    width_mm: f64,
    /// Lengths of the edges of its rim, mm, and their sum.
    edges_mm: Vec<f64>,
    perimeter_mm: f64,
}

impl Repair {
    fn new(mesh: &Mesh, vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let measures = MendMeasures {
            volume_before_mm3: mesh.volume_mm3(),
            left_out: mesh.triangles().len() - triangles.len(),
            ..MendMeasures::default()
        };
        Self { vertices, triangles, is_turned: Vec::new(), measures }
    }

    fn mend(mut self) -> Result<MendedMesh, MendError> {
        self.tidy()?;
        let areas: Vec<f64> = (0..self.triangles.len()).map(|at| area(self.corners(at))).collect();
        let mut facing = find_facing(&self.triangles, &areas).ok_or(MendError::OneSided)?;
        self.is_turned = facing.is_turned.clone();
        (0..self.triangles.len()).filter(|&at| facing.is_turned[at]).for_each(|at| self.triangles[at].swap(1, 2));
        let first_new = self.triangles.len();
        let holes = self.close_holes(&facing)?;
        let mut is_changed: Vec<bool> = facing.turned_share.iter().map(|&share| share > 0.0).collect();
        for hole in &holes {
            is_changed[hole.piece] = true;
            facing.piece_of.extend(vec![hole.piece; hole.filling.triangles.len()]);
        }
        self.turn_outwards(&facing, &is_changed)?;
        self.ensure_volumes(&facing, &is_changed, &holes)?;
        match has_crossing(&self.vertices, &self.triangles, first_new..self.triangles.len()) {
            Some(false) => self.finish(first_new),
            Some(true) => Err(MendError::Crossing),
            None => Err(MendError::TooLarge),
        }
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Leaves out what says nothing about the solid, if it is little.
    fn tidy(&mut self) -> Result<(), MendError> {
        let kept = kept_triangles(&self.triangles);
        let all: f64 = (0..kept.len()).map(|at| area(self.corners(at))).sum();
        let left_out: f64 = (0..kept.len()).filter(|&at| !kept[at]).map(|at| area(self.corners(at))).sum();
        let mut keeps = kept.iter();
        self.triangles.retain(|_| *keeps.next().unwrap_or(&true));
        self.measures.left_out += kept.len() - self.triangles.len();
        if left_out > MAX_LEFT_OUT_SHARE * all { Err(MendError::Sheet) } else { Ok(()) }
    }

    /// Closes all holes of a surface whose pieces face one way each.
    fn close_holes(&mut self, facing: &Facing) -> Result<Vec<ClosedHole>, MendError> {
        let uses = EdgeUses::of(&self.triangles);
        if uses.edges().any(|uses| uses.len() > 1 && !is_balanced(uses)) {
            return Err(MendError::Ambiguous);
        }
        if uses.edges().filter(|uses| uses.len() == 1).count() > MAX_OPEN {
            return Err(MendError::TooLarge);
        }
        let rims = find_rims(&uses).ok_or(MendError::Ambiguous)?;
        if rims.iter().map(|rim| rim.corners.len().pow(3)).sum::<usize>() > MAX_STEPS {
            return Err(MendError::TooLarge);
        }
        let areas = self.piece_areas(facing);
        let mut holes = Vec::new();
        for rim in rims {
            let piece = facing.piece_of[rim.beside[0]];
            let hole = self.close_hole(rim, piece, &uses)?;
            hole.ensure_small(areas[piece])?;
            let measures = &mut self.measures;
            measures.holes += 1;
            measures.added += hole.filling.triangles.len();
            measures.widest_hole_mm = measures.widest_hole_mm.max(hole.width_mm);
            measures.deviation_mm = measures.deviation_mm.max(hole.filling.deviation_mm);
            holes.push(hole);
        }
        for hole in &holes {
            let corners = &hole.rim.corners;
            self.triangles.extend(hole.filling.triangles.iter().map(|places| places.map(|place| corners[place])));
        }
        self.is_turned.resize(self.triangles.len(), false);
        Ok(holes)
    }

    fn close_hole(&self, rim: Rim, piece: usize, uses: &EdgeUses) -> Result<ClosedHole, MendError> {
        let places: Vec<DVec3> = rim.corners.iter().map(|&corner| self.vertices[corner as usize]).collect();
        let across = places.iter().flat_map(|one| places.iter().map(|other| one.distance_squared(*other)));
        let width_mm = across.fold(0.0, f64::max).sqrt();
        if places.len() > MAX_RIM {
            return Err(MendError::LargeHole(width_mm));
        }
        // What has two corners, or the same ones as a triangle that is there, is no hole but the edge of a sheet.
        let beside = self.triangles[rim.beside[0]];
        if places.len() < 3 || places.len() == 3 && rim.corners.iter().all(|corner| beside.contains(corner)) {
            return Err(MendError::Sheet);
        }
        let normals: Vec<DVec3> = rim.beside.iter().map(|&triangle| normal(self.corners(triangle))).collect();
        let is_taken = |one: usize, other: usize| uses.has(rim.corners[one], rim.corners[other]);
        let filling = fill_rim(&places, &normals, is_taken).ok_or(MendError::Crossing)?;
        let edges_mm = edge_lengths(&places);
        Ok(ClosedHole { perimeter_mm: edges_mm.iter().sum(), edges_mm, rim, filling, piece, width_mm })
    }

    /// Turns pieces that were mended and face inwards, except cavities.
    fn turn_outwards(&mut self, facing: &Facing, is_changed: &[bool]) -> Result<(), MendError> {
        let volumes = self.piece_volumes(facing);
        if is_changed.iter().filter(|&&changed| changed).count() * self.triangles.len() > MAX_STEPS {
            return Err(MendError::TooLarge);
        }
        for piece in (0..is_changed.len()).filter(|&piece| is_changed[piece]) {
            let is_inside = is_changed.len() > 1 && self.is_inside_another(facing, piece);
            if is_inside && facing.turned_share[piece] > MAX_TURNED_INSIDE {
                return Err(MendError::Cavity);
            }
            if !is_inside && volumes[piece] < 0.0 {
                for at in (0..self.triangles.len()).filter(|&at| facing.piece_of[at] == piece) {
                    self.triangles[at].swap(1, 2);
                    self.is_turned[at] = !self.is_turned[at];
                }
            }
        }
        Ok(())
    }

    /// Area of each piece, mm2.
    fn piece_areas(&self, facing: &Facing) -> Vec<f64> {
        let mut areas = vec![0.0; facing.turned_share.len()];
        (0..self.triangles.len()).for_each(|at| areas[facing.piece_of[at]] += area(self.corners(at)));
        areas
    }

    /// Signed volume of each piece, mm3.
    fn piece_volumes(&self, facing: &Facing) -> Vec<f64> {
        let mut volumes = vec![0.0; facing.turned_share.len()];
        let mut origins: Vec<Option<DVec3>> = vec![None; volumes.len()];
        for at in 0..self.triangles.len() {
            let piece = facing.piece_of[at];
            let corners = self.corners(at);
            let origin = *origins[piece].get_or_insert(corners[0]);
            let [a, b, c] = corners.map(|corner| corner - origin);
            volumes[piece] += a.dot(b.cross(c)) / 6.0;
        }
        volumes
    }

    /// Whether a piece lies inside the others, by their winding number about one of its corners: the sum of the solid angles (A. Van
    /// Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30, 1983).
    fn is_inside_another(&self, facing: &Facing, piece: usize) -> bool {
        let Some(own) = (0..self.triangles.len()).find(|&at| facing.piece_of[at] == piece) else { return false };
        let point = self.corners(own)[0];
        let solid_angle = |at: usize| {
            let [a, b, c] = self.corners(at).map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(below)
        };
        let others = (0..self.triangles.len()).filter(|&at| facing.piece_of[at] != piece);
        let winding = others.map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI);
        winding.abs() > 0.5
    }

    /// No piece that was mended is a sheet, and what is not known below the holes is little.
    fn ensure_volumes(&self, facing: &Facing, is_changed: &[bool], holes: &[ClosedHole]) -> Result<(), MendError> {
        let (volumes, areas) = (self.piece_volumes(facing), self.piece_areas(facing));
        for piece in (0..volumes.len()).filter(|&piece| is_changed[piece]) {
            let volume = volumes[piece].abs();
            if volume <= MIN_THICKNESS * f64::powf(areas[piece], 1.5) {
                return Err(MendError::Sheet);
            }
            let of_piece = holes.iter().filter(|hole| hole.piece == piece);
            if of_piece.map(ClosedHole::doubt_mm3).sum::<f64>() > MAX_DOUBT_SHARE * volume {
                return Err(MendError::Doubt);
            }
        }
        Ok(())
    }

    fn finish(mut self, first_new: usize) -> Result<MendedMesh, MendError> {
        let is_shown = |at: &usize| *at >= first_new || self.is_turned[*at];
        let mended = (0..self.triangles.len()).filter(is_shown).map(|at| self.corners(at)).collect();
        self.measures.turned = self.is_turned[..first_new].iter().filter(|&&turned| turned).count();
        let count = self.triangles.len();
        let mesh = Mesh::new(self.vertices, self.triangles).map_err(|_| MendError::Sheet)?;
        let defects = mesh.defects();
        if !defects.is_closed() || defects.inverted || mesh.triangles().len() != count {
            return Err(MendError::Ambiguous);
        }
        self.measures.volume_after_mm3 = mesh.volume_mm3();
        Ok(MendedMesh { mesh, measures: self.measures, mended })
    }
}

impl ClosedHole {
    /// Twice the area over the perimeter: the radius of a round hole, half the width of a long one, mm.
    fn reach_mm(&self) -> f64 {
        if self.perimeter_mm > 0.0 { 2.0 * self.filling.area_mm2 / self.perimeter_mm } else { 0.0 }
    }

    /// The share of the rim across which the surface bends by no more than this, and the mean bend there.
    fn smooth_rim(&self, most: f64) -> (f64, f64) {
        let smooth = self.filling.bends.iter().zip(&self.edges_mm).filter(|&(&bend, _)| bend <= most);
        let (length, bent) =
            smooth.fold((0.0, 0.0), |(length, bent), (bend, edge)| (length + edge, bent + bend * edge));
        (length / self.perimeter_mm.max(f64::MIN_POSITIVE), if length > 0.0 { bent / length } else { 0.0 })
    }

    /// What is not known below the hole, mm3: the cap of a ball that bends as the surface does at the rim.
    fn doubt_mm3(&self) -> f64 {
        let reach = self.reach_mm();
        if reach <= CRACK_MM {
            0.0
        } else {
            self.filling.area_mm2 * reach * (0.5 * self.smooth_rim(GOES_ON).1).tan() / 2.0
        }
    }

    /// `piece_mm2` is the surface of its piece without it.
    fn ensure_small(&self, piece_mm2: f64) -> Result<(), MendError> {
        if self.reach_mm() <= CRACK_MM {
            return Ok(());
        }
        if self.filling.area_mm2 > MAX_HOLE_SHARE * piece_mm2 {
            return Err(MendError::LargeHole(self.width_mm));
        }
        let is_flat = self.filling.is_flat && self.smooth_rim(FLAT).0 >= MIN_SMOOTH_SHARE;
        let is_plain = self.rim.corners.len() <= PLAIN_RIM && self.smooth_rim(GOES_ON).0 >= MIN_SMOOTH_SHARE;
        match () {
            () if is_flat || is_plain => Ok(()),
            () if self.smooth_rim(BENT).0 < MIN_SMOOTH_BENT => Err(MendError::Opening(self.width_mm)),
            () if self.width_mm > MAX_BENT_SHARE * piece_mm2.sqrt() => Err(MendError::LargeHole(self.width_mm)),
            () => Ok(()),
        }
    }
}
