//! A second reader for builds of STL files: `stl_io` reads the triangles, and a table is read without the types of ours. Each corner of
//! each copy is compared with the place where it should be.

use std::{
    collections::HashMap,
    fs::File,
    io::{BufReader, Cursor, Read, Seek},
    path::Path,
};

use glam::DVec3;
use zip::ZipArchive;

use crate::{BuildFile, BuildFileItem, DeliveryKind, FileReadError, ReadLimits};

/// Compares a written build of STL files with what should have been written: each copy has its triangles, and no corner is farther from its
/// place than rounding to 32-bit numbers moves it. Only for files that [`read_build`](crate::read_build) has accepted.
pub fn cross_check_stl(file: &Path, build: &BuildFile, limits: &ReadLimits) -> Result<(), FileReadError> {
    let most_mm = build.delivery.rounding_mm(build.rules.volume_mm);
    match build.delivery {
        DeliveryKind::Stl => {
            let mut opened = BufReader::with_capacity(1 << 16, File::open(file)?);
            let mut facets = read_facets(&mut opened)?;
            for (number, item) in (1..).zip(&build.items) {
                compare_copy((number, item), build, most_mm, &mut facets)?;
            }
            match facets.next() {
                None => Ok(()),
                Some(_) => Err(disagree("it has more triangles".to_owned())),
            }
        }
        DeliveryKind::Parts => PartsPackage::open(file, limits)?.compare(build, most_mm),
        DeliveryKind::Shared | DeliveryKind::Expanded => Ok(()),
    }
}

fn disagree(reason: String) -> FileReadError {
    FileReadError::invalid_stl(format!("a second reader disagrees: {reason}"))
}

/// The corners of the triangles of an STL, in its frame.
fn read_facets<R: Read + Seek>(
    stl: &mut R,
) -> Result<impl Iterator<Item = std::io::Result<[DVec3; 3]>>, FileReadError> {
    let reader = stl_io::create_stl_reader(stl)?;
    Ok(reader.map(|triangle| {
        Ok(triangle?.vertices.map(|corner| DVec3::new(corner[0].into(), corner[1].into(), corner[2].into())))
    }))
}

/// Compares the next triangles, in the machine's frame, with those of a copy.
fn compare_copy(
    (number, item): (usize, &BuildFileItem),
    build: &BuildFile,
    most_mm: f64,
    facets: &mut impl Iterator<Item = std::io::Result<[DVec3; 3]>>,
) -> Result<(), FileReadError> {
    let object = &build.objects[item.object];
    for triangle in 0..object.mesh.triangles().len() {
        let told = object.mesh.corners(triangle).map(|corner| item.pose.transform_point(corner));
        let Some(found) = facets.next().transpose()? else {
            return Err(disagree(format!("placement {number} ({}) has too few triangles", object.name)));
        };
        let off_mm = told.iter().zip(found).map(|(told, found)| told.distance(found)).fold(0.0, f64::max);
        if off_mm.is_nan() || off_mm > most_mm {
            return Err(disagree(format!("placement {number} ({}) is {off_mm} mm off", object.name)));
        }
    }
    Ok(())
}

/// A package of STL files with their table.
struct PartsPackage {
    archive: ZipArchive<BufReader<File>>,
    most_bytes: u64,
}

impl PartsPackage {
    fn open(file: &Path, limits: &ReadLimits) -> Result<Self, FileReadError> {
        let archive =
            ZipArchive::new(BufReader::new(File::open(file)?)).map_err(|error| disagree(error.to_string()))?;
        Ok(Self { archive, most_bytes: limits.max_unpacked_bytes })
    }

    fn entry(&mut self, name: &str) -> Result<Vec<u8>, FileReadError> {
        let entry = self.archive.by_name(name).map_err(|error| disagree(format!("{name:?}: {error}")))?;
        let mut bytes = Vec::new();
        entry.take(self.most_bytes).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn compare(&mut self, build: &BuildFile, most_mm: f64) -> Result<(), FileReadError> {
        let table = self.entry("placements.csv")?;
        let mut table = csv::Reader::from_reader(table.as_slice());
        let rows: Vec<HashMap<String, String>> =
            table.deserialize().collect::<Result<_, _>>().map_err(|error| disagree(error.to_string()))?;
        if rows.len() != build.items.len() {
            return Err(disagree(format!("{} rows instead of {}", rows.len(), build.items.len())));
        }
        let mut stls: HashMap<String, Vec<u8>> = HashMap::new();
        for ((number, item), row) in (1..).zip(&build.items).zip(&rows) {
            let name = row.get("file").cloned().unwrap_or_default();
            if !stls.contains_key(&name) {
                stls.insert(name.clone(), self.entry(&name)?);
            }
            let mut stl = Cursor::new(stls.get(&name).map(Vec::as_slice).unwrap_or_default());
            let moved = row_transform(row).ok_or_else(|| disagree(format!("row {number} has no place")))?;
            let mut facets = read_facets(&mut stl)?.map(|corners| corners.map(|corners| corners.map(&moved)));
            compare_copy((number, item), build, most_mm, &mut facets)?;
            if facets.next().is_some() {
                return Err(disagree(format!("{name:?} has more triangles")));
            }
        }
        Ok(())
    }
}

/// Turns a point by the quaternion of a row, then moves it, by the formula of the rotation matrix.
fn row_transform(row: &HashMap<String, String>) -> Option<impl Fn(DVec3) -> DVec3> {
    let number = |column: &str| row.get(column)?.parse::<f64>().ok();
    let [w, x, y, z] =
        [number("quaternion_w")?, number("quaternion_x")?, number("quaternion_y")?, number("quaternion_z")?];
    let at = DVec3::new(number("position_x_mm")?, number("position_y_mm")?, number("position_z_mm")?);
    Some(move |p: DVec3| {
        let rows = [
            DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
            DVec3::new(2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
            DVec3::new(2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
        ];
        at + DVec3::from_array(rows.map(|row| row.dot(p)))
    })
}
