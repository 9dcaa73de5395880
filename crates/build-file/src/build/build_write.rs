//! Writes meshes and poses as a build file: of a 3MF the package around the model. Its bytes depend on the build only.

use std::io::{BufWriter, Seek, Write};

use zip::{CompressionMethod, ZipWriter};

use super::{
    model_write::write_model,
    package_entry::{entry_options, package_error},
    parts_build::write_parts_build,
    stl_build::write_stl_build,
};
use crate::{BuildFile, DeliveryKind, FileWriteError};

/// An upper bound of the bytes of one vertex or triangle in XML.
const XML_BYTES: u64 = 96;

const CONTENT_TYPES: &str = concat!(
    r#"<?xml version="1.0" encoding="UTF-8"?>"#,
    r#"<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">"#,
    r#"<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>"#,
    r#"<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>"#,
    r#"<Default Extension="png" ContentType="image/png"/></Types>"#,
);
const RELATIONSHIPS_HEAD: &str = concat!(
    r#"<?xml version="1.0" encoding="UTF-8"?>"#,
    r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">"#,
    r#"<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>"#,
);
const THUMBNAIL_RELATIONSHIP: &str = concat!(
    r#"<Relationship Target="/Metadata/thumbnail.png" Id="rel1" "#,
    r#"Type="http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail"/>"#,
);

/// Writes a build as its kind of delivery says; the same build gives the same bytes. Beside a whole build as STL belongs the table of
/// [`write_placement_table`](crate::write_placement_table).
pub fn write_build(build: &BuildFile, out: impl Write + Seek) -> Result<(), FileWriteError> {
    check_build(build)?;
    match build.delivery {
        DeliveryKind::Shared | DeliveryKind::Expanded => write_package(build, out),
        DeliveryKind::Stl => write_stl_build(build, out),
        DeliveryKind::Parts => write_parts_build(build, BufWriter::with_capacity(1 << 16, out)),
    }
}

fn write_package(build: &BuildFile, out: impl Write + Seek) -> Result<(), FileWriteError> {
    let options = entry_options(build)?;
    let mut zip = ZipWriter::new(BufWriter::with_capacity(1 << 16, out));
    zip.start_file("[Content_Types].xml", options).map_err(package_error)?;
    zip.write_all(CONTENT_TYPES.as_bytes())?;
    zip.start_file("_rels/.rels", options).map_err(package_error)?;
    zip.write_all(RELATIONSHIPS_HEAD.as_bytes())?;
    if build.thumbnail_png.is_some() {
        zip.write_all(THUMBNAIL_RELATIONSHIP.as_bytes())?;
    }
    zip.write_all(b"</Relationships>")?;
    let huge = max_model_bytes(build) > u64::from(u32::MAX);
    zip.start_file("3D/3dmodel.model", options.large_file(huge)).map_err(package_error)?;
    let mut model = BufWriter::with_capacity(1 << 16, &mut zip);
    write_model(build, &mut model)?;
    model.flush()?;
    drop(model);
    if let Some(png) = &build.thumbnail_png {
        zip.start_file(
            "Metadata/thumbnail.png",
            options.compression_method(CompressionMethod::Stored).compression_level(None),
        )
        .map_err(package_error)?;
        zip.write_all(png)?;
    }
    zip.finish().map_err(package_error)?.flush()?;
    Ok(())
}

/// Checks for contents that would make the file wrong.
fn check_build(build: &BuildFile) -> Result<(), FileWriteError> {
    if build.items.is_empty() {
        return Err(FileWriteError::Build("it contains no placements".to_owned()));
    }
    for (number, item) in (1..).zip(&build.items) {
        if item.object >= build.objects.len() {
            return Err(FileWriteError::Build(format!(
                "item {number} refers to object {}, which does not exist",
                item.object
            )));
        }
        if !(item.pose.translation.is_finite() && item.pose.rotation.is_normalized()) {
            return Err(FileWriteError::Build(format!("item {number} has no rigid pose")));
        }
    }
    Ok(())
}

fn max_model_bytes(build: &BuildFile) -> u64 {
    let mesh_bytes = |object: usize| {
        let mesh = &build.objects[object].mesh;
        (mesh.vertices().len() + mesh.triangles().len()) as u64 * XML_BYTES
    };
    // The estimate assumes that every copy is written out; too much is harmless.
    build.items.iter().map(|item| 4096 + mesh_bytes(item.object)).sum()
}
