//! Reads a CAMSPEC package as parts: one for each line of its manifest. `camspec` reads the document.

use std::{collections::HashMap, io::Write, path::Path};

use crate::{
    FileReadError, PartFileContents, PartFileSolid, ReadLimits,
    common::camspec::{CamspecLine, parse_camspec},
    escape_invisible,
    threemf::package::PackageReader,
};

/// Names of the document: as its schema and its examples have it, and as its documentation does.
const DOCUMENTS: [&str; 2] = ["camspec.json", ".camspec.json"];
/// A longer document is not read.
const MAX_DOCUMENT_BYTES: u64 = 16 << 20;
/// Folder of the models.
const MODELS: &str = "models/";

/// Reads a part of the package: its path on the disk, its name, and its line.
type ModelReader<'r> = dyn FnMut(&Path, &str, &CamspecLine) -> Result<PartFileContents, FileReadError> + 'r;

/// Reads a dropped package. `read_model` reads a model that was unpacked.
pub(super) fn read_camspec_parts(
    file: &Path,
    limits: &ReadLimits,
    read_model: &mut ModelReader<'_>,
) -> Result<PartFileContents, FileReadError> {
    let mut package = PackageReader::open(file, limits)?;
    let documents = package.entries_named(&DOCUMENTS);
    let [document] = &documents[..] else {
        let reason = match &documents[..] {
            [] => "there is no camspec.json in the package".to_owned(),
            several => format!("it holds several documents: {}", escape_invisible(&several.join(", "))),
        };
        return Err(FileReadError::Invalid { format: "CAMSPEC", reason });
    };
    let mut text = Vec::new();
    package.unpack_entry(document, MAX_DOCUMENT_BYTES, &mut text)?;
    let text = String::from_utf8(text)
        .map_err(|_| FileReadError::Invalid { format: "CAMSPEC", reason: format!("{document} is not UTF-8") })?;
    let folder = document.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
    let (mut contents, mut known) = (PartFileContents { solids: Vec::new(), warnings: Vec::new() }, HashMap::new());
    for line in parse_camspec(&text)? {
        if line.copies == 0 {
            let text = format!("of the model {} no copies are wanted, as the package says", line.request.reference);
            contents.warnings.push(text);
            continue;
        }
        let key = (line.file.clone(), line.unit);
        let read = match known.get(&key) {
            Some(read) => read,
            None => known.entry(key).or_insert(read_packed_model(&mut package, &folder, &line, read_model)?),
        };
        take_solids(&mut contents, read, &line);
        check_totals(&contents, limits)?;
    }
    match contents.solids.is_empty() {
        true => {
            Err(FileReadError::Invalid { format: "CAMSPEC", reason: "it asks for no copy of any model".to_owned() })
        }
        false => Ok(contents),
    }
}

/// Unpacks a model, and reads it.
fn read_packed_model(
    package: &mut PackageReader,
    folder: &str,
    line: &CamspecLine,
    read_model: &mut ModelReader<'_>,
) -> Result<PartFileContents, FileReadError> {
    let plain = line.file.trim_start_matches("./").trim_start_matches('/');
    let (below, beside) = (format!("{folder}{MODELS}{plain}"), format!("{folder}{plain}"));
    let entry = package.find_entry(&[&below, &beside]).ok_or_else(|| FileReadError::Invalid {
        format: "CAMSPEC",
        reason: format!("the package holds no file {:?}, which its manifest names", line.file),
    })?;
    let mut unpacked = tempfile::NamedTempFile::new()?;
    package.unpack_entry(&entry, u64::MAX, unpacked.as_file_mut())?;
    unpacked.as_file_mut().flush()?;
    let named = |what: String| format!("{}: {what}", escape_invisible(&line.file));
    read_model(unpacked.path(), &entry, line).map_err(|error| match error {
        FileReadError::Unknown { what, remedy } => FileReadError::Unknown { what: named(what), remedy },
        FileReadError::Truncated(what) => FileReadError::Truncated(named(what)),
        FileReadError::Invalid { format, reason } => FileReadError::Invalid { format, reason: named(reason) },
        FileReadError::Unsupported { what, remedy } => FileReadError::Unsupported { what: named(what), remedy },
        other => other,
    })
}

/// Adds the parts of a model with what its line says.
fn take_solids(contents: &mut PartFileContents, read: &PartFileContents, line: &CamspecLine) {
    let many = read.solids.len() > 1;
    for solid in &read.solids {
        let name = match (line.name.as_str(), many) {
            ("", _) => solid.name.clone(),
            (name, false) => name.to_owned(),
            (name, true) => format!("{name} {}", solid.name),
        };
        let copies = solid.copies.saturating_mul(line.copies);
        let request = Some(Box::new(line.request.clone()));
        contents.solids.push(PartFileSolid { name, copies, request, ..solid.clone() });
    }
    for warning in &read.warnings {
        let warning = format!("{}: {warning}", escape_invisible(&line.file));
        if !contents.warnings.contains(&warning) {
            contents.warnings.push(warning);
        }
    }
}

/// A package is one dropped file: its lines together may ask for what one file may ask for.
fn check_totals(contents: &PartFileContents, limits: &ReadLimits) -> Result<(), FileReadError> {
    let total = |count: fn(&PartFileSolid) -> u64| contents.solids.iter().map(count).sum::<u64>();
    let totals = [
        (total(|solid| u64::from(solid.copies)), "copies", limits.max_copies, "max_copies"),
        (total(|solid| solid.mesh.triangles().len() as u64), "triangles", limits.max_triangles, "max_triangles"),
    ];
    match totals.into_iter().find(|(total, _, limit, _)| total > limit) {
        None => Ok(()),
        Some((_, what, limit, key)) => Err(FileReadError::TooLarge {
            what: format!("its lines have more than {limit} {what} together"),
            limit,
            key,
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::{fs, path::PathBuf};

    use serde_json::json;
    use zip::{ZipWriter, write::SimpleFileOptions};

    use super::*;
    use crate::{LengthUnit, read_part_file, write_stl};

    /// A package of these entries.
    fn package(folder: &Path, entries: &[(&str, &[u8])]) -> PathBuf {
        let path = folder.join("brandt.camspec");
        let mut zip = ZipWriter::new(fs::File::create(&path).unwrap());
        for (name, bytes) in entries {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        path
    }

    fn read(path: &Path, unit: Option<LengthUnit>) -> Result<PartFileContents, FileReadError> {
        read_part_file(path, "brandt.camspec", unit, LengthUnit::Inch, &ReadLimits::for_testing())
    }

    fn block_stl() -> Vec<u8> {
        let mut bytes = Vec::new();
        let (mesh, pose) = (sample_parts::cuboid(glam::DVec3::new(10.0, 20.0, 30.0)), solids::Pose::IDENTITY);
        write_stl(std::iter::once((&mesh, &pose)), &mut bytes).unwrap();
        bytes
    }

    fn document(lines: serde_json::Value) -> Vec<u8> {
        json!({"version": "1.0.0", "manifest": lines, "constraints": [], "globalConstraints": []})
            .to_string()
            .into_bytes()
    }

    fn line(id: &str, file: &str, quantity: u32, units: &str) -> serde_json::Value {
        json!({"id": id, "file": file, "quantity": quantity, "units": units})
    }

    #[test]
    fn each_line_is_a_part_with_its_id_its_copies_and_its_unit_wherever_the_document_lies() {
        let (dir, stl) = (tempfile::tempdir().unwrap(), block_stl());
        let lines =
            json!([line("a", "block.stl", 5, "MM"), line("b", "block.stl", 3, "CM"), line("c", "BLOCK.STL", 0, "MM")]);
        let document = document(lines);
        let places: [(&str, &str); 3] = [
            ("camspec.json", "models/block.stl"),
            (".camspec.json", "block.stl"),
            ("Export/Camspec.json", "Export/models/Block.STL"),
        ];
        for (at, model) in places {
            let path = package(dir.path(), &[(model, stl.as_slice()), (at, document.as_slice())]);
            let contents = read(&path, None).unwrap();
            let read_lines: Vec<(&str, u32, f64)> = contents
                .solids
                .iter()
                .map(|solid| {
                    (solid.request.as_ref().unwrap().reference.as_str(), solid.copies, solid.mesh.bounds().size().z)
                })
                .collect();
            assert_eq!(read_lines.len(), 2, "{at}");
            assert_eq!((read_lines[0].0, read_lines[0].1, read_lines[1].0, read_lines[1].1), ("a", 5, "b", 3));
            assert!((read_lines[0].2 - 30.0).abs() < 1e-4 && (read_lines[1].2 - 300.0).abs() < 1e-3, "{read_lines:?}");
            assert!(
                contents.warnings.iter().any(|warning| warning.contains("of the model c no copies")),
                "{contents:?}"
            );
        }
        let path = package(dir.path(), &[("models/block.stl", stl.as_slice()), ("camspec.json", document.as_slice())]);
        let said = read(&path, Some(LengthUnit::Millimeter)).unwrap();
        assert!((said.solids[1].mesh.bounds().size().z - 30.0).abs() < 1e-4, "a ticket says the unit");
    }

    #[test]
    fn what_is_not_clear_in_a_package_is_refused() {
        let (dir, stl) = (tempfile::tempdir().unwrap(), block_stl());
        let document = document(json!([line("a", "block.stl", 5, "MM")]));
        let refused = |entries: &[(&str, &[u8])]| read(&package(dir.path(), entries), None).unwrap_err().to_string();
        for [one, other] in [["a/camspec.json", "b/camspec.json"], ["camspec.json", ".camspec.json"]] {
            let text =
                refused(&[("models/block.stl", &stl), ("a/block.stl", &stl), (one, &document), (other, &document)]);
            assert!(text.contains("several documents") && text.contains(one) && text.contains(other), "{text}");
        }
        let elsewhere = [("left/block.stl", &stl[..]), ("right/block.stl", &stl), ("camspec.json", &document)];
        assert!(refused(&elsewhere).contains("no file \"block.stl\""));
    }

    #[test]
    fn a_model_that_contradicts_its_line_is_refused_unless_a_ticket_says_the_unit() {
        let dir = tempfile::tempdir().unwrap();
        let xml = |unit: &str| {
            format!(
                r#"<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1"
                type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/><vertex x="0" y="9" z="0"/>
                <vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>
                <triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh></object></resources><build>
                <item objectid="1"/></build></model>"#
            )
        };
        let rels = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship
            Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
        let document = document(json!([line("a", "block.3mf", 1, "MM")]));
        let read_in = |unit: &str, ticket: Option<LengthUnit>| {
            let model =
                package(dir.path(), &[("_rels/.rels", rels.as_bytes()), ("3D/3dmodel.model", xml(unit).as_bytes())]);
            let model = fs::read(model).unwrap();
            read(&package(dir.path(), &[("models/block.3mf", &model), ("camspec.json", &document)]), ticket)
        };
        assert_eq!(read_in("millimeter", None).unwrap().solids[0].mesh.bounds().size().z, 9.0);
        let text = read_in("inch", None).unwrap_err().to_string();
        assert!(text.contains("block.3mf: its unit is Inch, and the manifest says Millimeter"), "{text}");
        assert_eq!(read_in("inch", Some(LengthUnit::Centimeter)).unwrap().solids[0].mesh.bounds().size().z, 90.0);
    }

    #[test]
    fn the_lines_of_a_package_ask_for_no_more_than_one_file_may() {
        let (dir, stl) = (tempfile::tempdir().unwrap(), block_stl());
        let limits = ReadLimits { max_copies: 10, max_triangles: 30, ..ReadLimits::for_testing() };
        let read = |lines: serde_json::Value| {
            let document = document(lines);
            let path = package(dir.path(), &[("models/block.stl", &stl), ("camspec.json", &document)]);
            read_part_file(&path, "brandt.camspec", None, LengthUnit::Millimeter, &limits)
        };
        let both =
            |one: u32, other: u32| json!([line("a", "block.stl", one, "MM"), line("b", "block.stl", other, "MM")]);
        assert_eq!(read(both(5, 5)).unwrap().solids.len(), 2, "24 triangles, 10 copies");
        let error = read(both(5, 6)).unwrap_err();
        assert!(matches!(error, FileReadError::TooLarge { key: "max_copies", .. }), "{error}");
        let three =
            json!([line("a", "block.stl", 1, "MM"), line("b", "block.stl", 1, "MM"), line("c", "block.stl", 1, "MM")]);
        let error = read(three).unwrap_err();
        assert!(matches!(error, FileReadError::TooLarge { key: "max_triangles", .. }), "{error}");
        let mut wide: serde_json::Value = serde_json::from_slice(&document(both(1, 1))).unwrap();
        wide["globalConstraints"] = json!([{"type": "MIN_PART_DISTANCE", "value": {"distance": 1e308, "units": "FT"}}]);
        let wide = wide.to_string().into_bytes();
        let path = package(dir.path(), &[("models/block.stl", &stl), ("camspec.json", &wide)]);
        let error = crate::read_part_file(&path, "w.camspec", None, LengthUnit::Millimeter, &limits).unwrap_err();
        assert!(error.to_string().contains("100 mm at most"), "{error}");
    }

    #[test]
    fn a_package_that_cannot_be_made_as_a_whole_is_refused_with_the_file_that_it_is_about() {
        let (dir, stl) = (tempfile::tempdir().unwrap(), block_stl());
        let with = |lines: serde_json::Value, entries: &[(&str, &[u8])]| {
            let document = document(lines);
            let all = [entries, &[("camspec.json", document.as_slice())]].concat();
            let error = read(&package(dir.path(), &all), None).unwrap_err();
            assert!(!error.remedy().is_empty());
            error.to_string()
        };
        let [models, cad] =
            [[("models/block.stl", stl.as_slice())], [("models/part.step", b"ISO-10303-21;\nHEADER;".as_slice())]];
        let text = with(json!([line("a", "gone.stl", 1, "MM")]), &models);
        assert!(text.contains("no file \"gone.stl\""), "{text}");
        let text = with(json!([line("a", "part.step", 1, "MM")]), &cad);
        assert!(text.contains("part.step: it is a STEP file"), "{text}");
        let text = with(json!([line("a", "block.stl", 0, "MM")]), &models);
        assert!(text.contains("no copy of any model"), "{text}");
        let text = with(json!([line("a", "../block.stl", 1, "MM")]), &models);
        assert!(text.contains("no file"), "{text}");
        let error = read(&package(dir.path(), &models), None).unwrap_err().to_string();
        assert!(error.contains("no camspec.json"), "{error}");
        let cut = stl[..stl.len() - 60].to_vec();
        let text = with(json!([line("a", "block.stl", 1, "MM")]), &[("models/block.stl", cut.as_slice())]);
        assert!(text.contains("block.stl: "), "{text}");
    }
}
