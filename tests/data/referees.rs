//! External readers read nestd's builds without a warning: `NESTD_REFEREE` is a Python with lib3mf, trimesh and lxml;
//! the schemas are in the data folder.

use std::{fs::File, process::Command, sync::Arc};

use build_file::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, InstanceSharing,
    ReadLimits, cross_check, read_build, write_build,
};
use glam::{DQuat, DVec3};
use solids::{Mesh, Pose};

/// Strict reading, schema, checksums, and the top of the build as the external reader places it.
const SCRIPT: &str = r#"
import io, sys, zipfile
import lib3mf, trimesh
from lxml import etree
file, schema, top = sys.argv[1], sys.argv[2], float(sys.argv[3])
model = lib3mf.Wrapper().CreateModel()
reader = model.QueryReader("3mf")
reader.SetStrictModeActive(True)
reader.ReadFromFile(file)
assert reader.GetWarningCount() == 0, [reader.GetWarning(i) for i in range(reader.GetWarningCount())]
assert model.HasPackageThumbnailAttachment()
meshes = model.GetMeshObjects()
while meshes.MoveNext():
    assert meshes.GetCurrentMeshObject().IsManifoldAndOriented()
box = model.GetOutbox()
assert abs(box.MaxCoordinate[2] - top) < 1e-3, (box.MaxCoordinate[2], top)
package = zipfile.ZipFile(file)
assert package.testzip() is None
xml = etree.parse(io.BytesIO(package.read("3D/3dmodel.model")))
etree.XMLSchema(etree.parse(schema)).assertValid(xml)
# trimesh names nodes by object, so that of several items of one object it keeps the last: what `expanded` is for.
if "Expanded-Items" in file:
    assert abs(trimesh.load(file).bounds[1][2] - top) < 1e-3
"#;

fn cuboid(size: DVec3) -> Arc<Mesh> {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * size;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Arc::new(Mesh::new((0..8).map(corner).collect(), triangles).unwrap())
}

fn build(instances: InstanceSharing, arrangement: Arrangement) -> BuildFile {
    let object = |name: &str, size: DVec3| BuildFileObject {
        name: name.to_owned(),
        mesh: cuboid(size),
        part_number: "7".to_owned(),
        content_hash: name.to_owned(),
    };
    let item = |object: usize, copy: u32| BuildFileItem {
        object,
        pose: Pose::new(
            DQuat::from_euler(glam::EulerRot::XYZ, 0.3 * f64::from(copy), 1.0, -2.0),
            DVec3::new(60.0 * f64::from(copy), 50.0 + 80.0 * object as f64, 40.0),
        ),
        words: build_file::OrderWords {
            reference: Some("550e8400-e29b-41d4-a716-446655440000".to_owned()),
            order: Some("Müller & Söhne <4711>".to_owned()),
            due: Some("2026-12-24".to_owned()),
            note: Some("nicht <strahlen>\n& nicht färben".to_owned()),
            material: Some("PA12".to_owned()),
        },
        copy,
        source_name: "Клипса 'für' \"☠\".stl".to_owned(),
        source_hash: "00".to_owned(),
        clearance_mm: None,
        orientation: Some("free".to_owned()),
        tilts: None,
    };
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[7]).unwrap();
    let items: Vec<BuildFileItem> = (1..5).flat_map(|copy| [item(0, copy), item(1, copy)]).collect();
    BuildFile {
        heading: BuildFileHeading {
            title: "mjf-5200 & 42".to_owned(),
            application: "nestd 0.1.0".to_owned(),
            created: "2026-11-20T04:49:00Z".to_owned(),
            machine: "mjf-5200".to_owned(),
            build_id: "42".to_owned(),
            seed: 1,
        },
        rules: BuildFileRules {
            volume_mm: DVec3::splat(400.0),
            keep_out: Vec::new(),
            margins_mm: DVec3::ZERO,
            clearance_mm: 1.0,
            clearance_z_extra_mm: 0.0,
            layer_mm: 0.1,
            layer_area_cap_mm2: None,
            interlock: "forbid".to_owned(),
        },
        height_mm: 90.0,
        density: 0.1,
        objects: vec![object("a & b", DVec3::new(10.0, 20.0, 30.0)), object("ü", DVec3::splat(1.0 / 3.0 + 9.0))],
        items,
        instances,
        arrangement,
        thumbnail_png: Some(png),
    }
}

pub fn other_readers_read_our_builds_without_a_warning() {
    let [python, data] = ["NESTD_REFEREE", "NESTD_DATA"].map(|name| std::env::var_os(name).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let schema = std::path::Path::new(&data).join("xsd/all.xsd");
    for instances in [InstanceSharing::Shared, InstanceSharing::Expanded] {
        for arrangement in [Arrangement::Items, Arrangement::Locked] {
            let build = build(instances, arrangement);
            let file = dir.path().join(format!("{instances:?}-{arrangement:?}.build.3mf"));
            write_build(&build, File::create(&file).unwrap()).unwrap();
            let placed = read_build(&file, &ReadLimits::default()).unwrap();
            cross_check(&file, &placed, &ReadLimits::default()).unwrap();
            let top = |item: &BuildFileItem| build.objects[item.object].mesh.bounds_at(&item.pose).max.z;
            let top = build.items.iter().map(top).fold(0.0, f64::max);
            let mut command = Command::new(&python);
            command.args(["-c", SCRIPT]).arg(&file).arg(&schema).arg(top.to_string());
            let out = command.output().unwrap();
            assert!(out.status.success(), "{}: {}", file.display(), String::from_utf8_lossy(&out.stderr));
            if let Some(keep) = std::env::var_os("NESTD_KEEP") {
                std::fs::copy(&file, std::path::Path::new(&keep).join(file.file_name().unwrap())).unwrap();
            }
        }
    }
}
