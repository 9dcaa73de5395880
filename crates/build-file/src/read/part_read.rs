//! The entry point for dropped files: detects the format, then calls its reader.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use super::{
    camspec_read,
    sniff::{FileFormat, ForeignFormat, HEAD_BYTES, detect_format},
};
use crate::{
    FileReadError, LengthUnit, PartFileContents, ReadLimits,
    common::{camspec::is_camspec_name, unfinished::blame_unwritten_blocks},
    polygons::{obj_read::read_obj, ply_read::read_ply},
    stl::stl_read::{StlContents, read_ascii, read_binary},
    threemf::threemf_read::{self, AskedUnit},
};

/// Reads a dropped file. `name` is the name under which it was dropped (the store may use another name). The content
/// determines the format first, the name's extension second. `unit` comes from the ticket and overrides the unit of a
/// 3MF; `default_unit` is used for formats without a unit. Parts are never rescaled otherwise.
pub fn read_part_file(
    file: &Path,
    name: &str,
    unit: Option<LengthUnit>,
    default_unit: LengthUnit,
    limits: &ReadLimits,
) -> Result<PartFileContents, FileReadError> {
    read_file(file, name, unit.map(AskedUnit::Ticket), default_unit, limits)
}

impl PartFileContents {
    /// Reads a part file by its path: the extension helps to tell the format, and the name without it names a part that has no other.
    /// A file that states no unit is in millimetres, and the default [`ReadLimits`] apply: see [`read_part_file`] for others.
    ///
    /// # Errors
    /// As [`read_part_file`]. [`FileReadError::remedy`] says what a person can do.
    ///
    /// ```
    /// use build_file::PartFileContents;
    ///
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("bar.stl");
    /// # let bar = solids::Mesh::cuboid(glam::DVec3::new(80.0, 10.0, 5.0))?;
    /// # build_file::write_stl([(&bar, &solids::Pose::IDENTITY)].into_iter(), std::fs::File::create(&path)?)?;
    /// for solid in PartFileContents::read(&path)?.solids {
    ///     println!("{}: {:?} mm, {} copies", solid.name, solid.mesh.bounds().size(), solid.copies);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileReadError> {
        let path = path.as_ref();
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        read_part_file(path, &name, None, LengthUnit::Millimeter, &ReadLimits::default())
    }
}

fn read_file(
    file: &Path,
    name: &str,
    unit: Option<AskedUnit>,
    default_unit: LengthUnit,
    limits: &ReadLimits,
) -> Result<PartFileContents, FileReadError> {
    let mut opened = File::open(file)?;
    let len = opened.metadata()?.len();
    if len > limits.max_bytes {
        return Err(FileReadError::TooLarge {
            what: format!("it is {len} bytes long"),
            limit: limits.max_bytes,
            key: "max_bytes",
        });
    }
    let mut head = Vec::new();
    (&mut opened).take(HEAD_BYTES).read_to_end(&mut head)?;
    let stem = PathBuf::from(name).file_stem().map_or_else(|| name.to_owned(), |s| s.to_string_lossy().into_owned());
    // The unit of a format that states none.
    let plain_unit = unit.map_or(default_unit, AskedUnit::unit);
    let read = match detect_format(&head, len, name) {
        FileFormat::Package => threemf_read::read_threemf_parts(file, &stem, unit, limits),
        FileFormat::Camspec => return read_camspec(file, unit, limits),
        FileFormat::TextStl => {
            read_ascii(File::open(file)?, plain_unit, limits).and_then(|read| stl_contents(read, stem))
        }
        FileFormat::BinaryStl => {
            read_binary(opened, (&head, len), plain_unit, limits).and_then(|read| stl_contents(read, stem))
        }
        FileFormat::Obj => read_obj(File::open(file)?, stem, plain_unit, limits),
        FileFormat::Ply => read_ply(File::open(file)?, stem, plain_unit, limits),
        FileFormat::Other(ForeignFormat { what, remedy }) => Err(FileReadError::Unknown { what, remedy }),
    };
    let contents = read.map_err(|error| blame_unwritten_blocks(error, file))?;
    for solid in &contents.solids {
        let shells = solid.mesh.shell_count() as u64;
        if shells > limits.max_shells {
            let what = format!("{} consists of {shells} separate pieces", solid.name);
            return Err(FileReadError::TooLarge { what, limit: limits.max_shells, key: "max_shells" });
        }
    }
    Ok(contents)
}

/// Reads a CAMSPEC package. Its models are files of any other format.
fn read_camspec(file: &Path, unit: Option<AskedUnit>, limits: &ReadLimits) -> Result<PartFileContents, FileReadError> {
    camspec_read::read_camspec_parts(file, limits, &mut |model, name, line| {
        if is_camspec_name(name) {
            let remedy = "Unpack it, and drop the packages that are in it.";
            return Err(FileReadError::Unsupported { what: "it is a package in a package".to_owned(), remedy });
        }
        read_file(model, name, unit.or(Some(AskedUnit::Manifest(line.unit))), line.unit, limits)
    })
}

/// A whole STL file is one part, even with several `solid` blocks.
fn stl_contents(read: StlContents, name: String) -> Result<PartFileContents, FileReadError> {
    Ok(PartFileContents { solids: vec![read.surface.into_solid(name)?], warnings: read.warnings })
}
