//! The table of places: a row for each copy, with the STL that it is in, and how that one is turned and moved. It is in the ZIP of a
//! build of STL files, and beside a whole build as one STL, whose copies nothing else tells apart.

use std::{
    io::{Read, Write},
    sync::Arc,
};

use csv::StringRecord;
use glam::{DQuat, DVec3};
use solids::{Mesh, Pose};

use super::pick_map::{Column, write_columns};
use crate::{
    BuildFile, BuildFileItem, BuildFileObject, FileReadError, FileWriteError, OrderWords, PlacedMesh, csv_cell,
};

/// A copy in the table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacementTableRow {
    /// The STL with its mesh; "" = the whole build as one STL, in which the copy stands in its place.
    pub(super) file: String,
    /// How many triangles of the STL are its own. In a whole build the copies follow each other in the order of the rows.
    pub(super) triangles: u64,
    /// Where the origin of the STL is in the frame of the part's mesh, mm.
    pub(super) origin_mm: DVec3,
    /// The part's mesh -> machine frame, mm.
    pub(super) pose: Pose,
    /// Name of the object, and the farm's number of the part.
    pub(super) part: (String, Option<String>),
    /// What the file says of the copy.
    pub(super) copy: Option<u32>,
    pub(super) words: OrderWords,
    pub(super) source: (Option<String>, Option<String>),
    pub(super) clearance_mm: Option<f64>,
    pub(super) orientation: Option<String>,
    pub(super) tilts: Option<String>,
}

/// The columns. `position` and `quaternion` are of the STL: turn it about its origin, then move it.
const COLUMNS: [Column<PlacementTableRow>; 25] = [
    ("file", |row| csv_cell(&row.file)),
    ("copy", |row| shown(&row.copy)),
    ("order", |row| word(&row.words.order)),
    ("position_x_mm", |row| row.position_mm().x.to_string()),
    ("position_y_mm", |row| row.position_mm().y.to_string()),
    ("position_z_mm", |row| row.position_mm().z.to_string()),
    ("quaternion_w", |row| row.pose.rotation.w.to_string()),
    ("quaternion_x", |row| row.pose.rotation.x.to_string()),
    ("quaternion_y", |row| row.pose.rotation.y.to_string()),
    ("quaternion_z", |row| row.pose.rotation.z.to_string()),
    ("part", |row| csv_cell(&row.part.0)),
    ("part_number", |row| word(&row.part.1)),
    ("triangles", |row| row.triangles.to_string()),
    ("origin_x_mm", |row| row.origin_mm.x.to_string()),
    ("origin_y_mm", |row| row.origin_mm.y.to_string()),
    ("origin_z_mm", |row| row.origin_mm.z.to_string()),
    ("source", |row| word(&row.source.0)),
    ("source_hash", |row| word(&row.source.1)),
    ("due", |row| word(&row.words.due)),
    ("note", |row| word(&row.words.note)),
    ("reference", |row| word(&row.words.reference)),
    ("material", |row| word(&row.words.material)),
    ("clearance_mm", |row| shown(&row.clearance_mm)),
    ("orientation", |row| row.orientation.clone().unwrap_or_default()),
    ("tilts", |row| row.tilts.clone().unwrap_or_default()),
];

impl PlacementTableRow {
    /// The row of an item, whose STL has its origin there.
    pub(super) fn of_item(item: &BuildFileItem, object: &BuildFileObject, file: String, origin_mm: DVec3) -> Self {
        Self {
            file,
            triangles: object.mesh.triangles().len() as u64,
            origin_mm,
            pose: item.pose,
            part: (object.name.clone(), Some(object.part_number.clone())),
            copy: Some(item.copy),
            words: item.words.clone(),
            source: (Some(item.source_name.clone()), Some(item.source_hash.clone())),
            clearance_mm: item.clearance_mm,
            orientation: item.orientation.clone(),
            tilts: item.tilts.clone(),
        }
    }

    /// The copy, with the mesh of its part.
    pub(super) fn into_placed(self, mesh: Arc<Mesh>) -> PlacedMesh {
        PlacedMesh {
            name: self.part.0,
            mesh,
            pose: self.pose,
            part_number: self.part.1,
            copy: self.copy,
            words: self.words,
            source_name: self.source.0,
            source_hash: self.source.1,
            clearance_mm: self.clearance_mm,
            orientation: self.orientation,
            tilts: self.tilts,
        }
    }

    /// Where the origin of the STL is in the machine, mm.
    fn position_mm(&self) -> DVec3 {
        self.pose.transform_point(self.origin_mm)
    }
}

/// Writes the table of a whole build as one STL, which [`write_build`](crate::write_build) writes.
pub fn write_placement_table(build: &BuildFile, out: impl Write) -> Result<(), FileWriteError> {
    let row = |item: &BuildFileItem| {
        PlacementTableRow::of_item(item, &build.objects[item.object], String::new(), DVec3::ZERO)
    };
    write_rows(build.items.iter().map(row), out)
}

/// Writes rows as CSV with a header.
pub(super) fn write_rows(rows: impl Iterator<Item = PlacementTableRow>, out: impl Write) -> Result<(), FileWriteError> {
    write_columns(COLUMNS, rows, out)
}

/// Reads at most `most` rows.
pub(super) fn read_rows(table: impl Read, most: u64) -> Result<Vec<PlacementTableRow>, FileReadError> {
    let mut csv = csv::Reader::from_reader(table);
    let header = csv.headers().map_err(|error| invalid(error.to_string()))?.clone();
    let mut rows = Vec::new();
    for record in csv.records() {
        if rows.len() as u64 >= most {
            let what = "its table has too many placements".to_owned();
            return Err(FileReadError::TooLarge { what, limit: most, key: "max_instances" });
        }
        let record = record.map_err(|error| invalid(error.to_string()))?;
        rows.push(Cells { header: &header, record: &record, number: rows.len() + 1 }.to_row()?);
    }
    Ok(rows)
}

/// A row that is being read.
struct Cells<'r> {
    header: &'r StringRecord,
    record: &'r StringRecord,
    number: usize,
}

impl Cells<'_> {
    fn to_row(&self) -> Result<PlacementTableRow, FileReadError> {
        let [x, y, z, w] = self.numbers(["quaternion_x", "quaternion_y", "quaternion_z", "quaternion_w"])?;
        let position_mm = self.vector(["position_x_mm", "position_y_mm", "position_z_mm"])?;
        let origin_mm = self.vector(["origin_x_mm", "origin_y_mm", "origin_z_mm"])?;
        let no_pose =
            |error: solids::PoseError| invalid(format!("row {} of the table has no pose: {error}", self.number));
        let turned = Pose::from_stored(DQuat::from_xyzw(x, y, z, w), position_mm).map_err(no_pose)?;
        let pose = match origin_mm == DVec3::ZERO {
            true => turned,
            false => Pose { translation: turned.transform_point(-origin_mm), ..turned },
        };
        Ok(PlacementTableRow {
            file: self.word("file").unwrap_or_default(),
            triangles: self.parsed("triangles")?,
            origin_mm,
            pose,
            part: (self.word("part").unwrap_or_default(), self.word("part_number")),
            copy: self.word("copy").and_then(|text| text.parse().ok()),
            words: OrderWords {
                order: self.word("order"),
                due: self.word("due"),
                note: self.word("note"),
                reference: self.word("reference"),
                material: self.word("material"),
            },
            source: (self.word("source"), self.word("source_hash")),
            clearance_mm: self.word("clearance_mm").and_then(|text| text.parse().ok()),
            orientation: self.word("orientation"),
            tilts: self.word("tilts"),
        })
    }

    fn word(&self, column: &str) -> Option<String> {
        let at = self.header.iter().position(|name| name == column)?;
        self.record.get(at).filter(|text| !text.is_empty()).map(str::to_owned)
    }

    fn parsed<T: std::str::FromStr>(&self, column: &str) -> Result<T, FileReadError> {
        let missing = || invalid(format!("row {} of the table has no {column}", self.number));
        self.word(column).and_then(|text| text.parse().ok()).ok_or_else(missing)
    }

    fn numbers(&self, columns: [&str; 4]) -> Result<[f64; 4], FileReadError> {
        let [a, b, c, d] = columns;
        Ok([self.parsed(a)?, self.parsed(b)?, self.parsed(c)?, self.parsed(d)?])
    }

    fn vector(&self, columns: [&str; 3]) -> Result<DVec3, FileReadError> {
        let [x, y, z] = columns;
        let vector = DVec3::new(self.parsed(x)?, self.parsed(y)?, self.parsed(z)?);
        let endless = || invalid(format!("row {} of the table has a number without an end", self.number));
        vector.is_finite().then_some(vector).ok_or_else(endless)
    }
}

fn invalid(reason: String) -> FileReadError {
    FileReadError::Invalid { format: "table of places", reason }
}

fn word(text: &Option<String>) -> String {
    csv_cell(text.as_deref().unwrap_or_default())
}

fn shown<T: ToString>(value: &Option<T>) -> String {
    value.as_ref().map(T::to_string).unwrap_or_default()
}
