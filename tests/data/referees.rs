//! External readers read nestd's builds without a warning: `NESTD_REFEREE` is a Python with lib3mf, trimesh and lxml, `NESTD_SLICER` a
//! PrusaSlicer; the schemas are in the data folder.

use std::{fs::File, process::Command, sync::Arc};

use build_file::{
    Arrangement, BuildFile, BuildFileHeading, BuildFileItem, BuildFileObject, BuildFileRules, DeliveryKind, ReadLimits,
    cross_check, cross_check_stl, read_build, write_build, write_placement_table,
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

fn build(instances: DeliveryKind, arrangement: Arrangement) -> BuildFile {
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
        delivery: instances,
        arrangement,
        thumbnail_png: Some(png),
    }
}

pub fn other_readers_read_our_builds_without_a_warning() {
    let [python, data] = ["NESTD_REFEREE", "NESTD_DATA"].map(|name| std::env::var_os(name).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let schema = std::path::Path::new(&data).join("xsd/all.xsd");
    for instances in [DeliveryKind::Shared, DeliveryKind::Expanded] {
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

/// The copies as another program finds them: `low x y z high x y z volume` of each, one a line.
const COPIES: &str = r#"
import csv, io, sys, zipfile
import lib3mf, numpy, trimesh
kind, file = sys.argv[1], sys.argv[2]
def tell(mesh):
    assert mesh.is_watertight and mesh.volume > 0
    print(*mesh.bounds[0], *mesh.bounds[1], mesh.volume)
def models(file):
    model = lib3mf.Wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(file)
    assert reader.GetWarningCount() == 0
    items = model.GetBuildItems()
    while items.MoveNext():
        item = items.GetCurrent()
        resource = item.GetObjectResource()
        place = numpy.array([list(row) for row in item.GetObjectTransform().Fields]).T
        mesh = model.GetMeshObjectByID(resource.GetResourceID())
        corners = numpy.array([list(v.Coordinates) for v in mesh.GetVertices()])
        faces = [list(t.Indices) for t in mesh.GetTriangleIndices()]
        yield trimesh.Trimesh(corners @ place[:, :3].T + place[:, 3], faces, process=False), place
if kind in ("shared", "expanded"):
    for mesh, place in models(file):
        assert kind == "shared" or (place == numpy.eye(3, 4)).all(), "each copy is in its place"
        tell(mesh)
    if kind == "expanded":
        # A reader of transforms and one without find the same.
        found = trimesh.load(file)
        assert len(found.geometry) == sum(1 for _ in models(file))
elif kind == "stl":
    for body in trimesh.load(file).split():
        tell(body)
else:
    package = zipfile.ZipFile(file)
    assert package.testzip() is None
    for row in csv.DictReader(io.TextIOWrapper(package.open("placements.csv"), "utf-8")):
        mesh = trimesh.load(io.BytesIO(package.read(row["file"])), file_type="stl")
        place = trimesh.transformations.quaternion_matrix([float(row["quaternion_" + n]) for n in "wxyz"])
        place[:3, 3] = [float(row[f"position_{n}_mm"]) for n in "xyz"]
        mesh.apply_transform(place)
        tell(mesh)
"#;

/// The same build as each kind: its file in a folder.
fn deliveries(folder: &std::path::Path) -> Vec<(BuildFile, std::path::PathBuf)> {
    let written = DeliveryKind::ALL.map(|kind| {
        let build = build(kind, Arrangement::Items);
        let file = folder.join(format!("{}{}", kind.name(), kind.ending()));
        write_build(&build, File::create(&file).unwrap()).unwrap();
        if kind == DeliveryKind::Stl {
            write_placement_table(&build, File::create(folder.join("stl.placements.csv")).unwrap()).unwrap();
        }
        assert_eq!(read_build(&file, &ReadLimits::default()).unwrap().len(), build.items.len());
        cross_check_stl(&file, &build, &ReadLimits::default()).unwrap();
        (build, file)
    });
    written.to_vec()
}

/// The bounds of each copy, mm, in the order of their lowest corners.
fn sorted(mut copies: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    copies.sort_by(|a, b| a.partial_cmp(b).unwrap());
    copies
}

pub fn other_programs_find_every_copy_of_each_kind_of_delivery_in_its_place() {
    let python = std::env::var_os("NESTD_REFEREE").unwrap();
    let dir = tempfile::tempdir().unwrap();
    for (build, file) in deliveries(dir.path()) {
        let kind = build.delivery.name();
        let out = Command::new(&python).args(["-c", COPIES, kind]).arg(&file).output().unwrap();
        assert!(out.status.success(), "{kind}: {}", String::from_utf8_lossy(&out.stderr));
        let text = String::from_utf8(out.stdout).unwrap();
        let found = text.lines().map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect();
        let told = build.items.iter().map(|item| {
            let mesh = &build.objects[item.object].mesh;
            let at = mesh.bounds_at(&item.pose);
            [at.min.to_array().as_slice(), &at.max.to_array(), &[mesh.volume_mm3()]].concat()
        });
        let (found, told) = (sorted(found), sorted(told.collect()));
        assert_eq!(found.len(), told.len(), "{kind}: {text}");
        for (found, told) in found.iter().zip(&told) {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-3 * (1.0 + b.abs() / 100.0);
            assert!(found.len() == 7 && found.iter().zip(told).all(near), "{kind}: {found:?} {told:?}");
        }
    }
}

pub fn a_slicer_opens_each_kind_of_delivery() {
    let slicer = std::env::var_os("NESTD_SLICER").unwrap();
    let dir = tempfile::tempdir().unwrap();
    for (build, file) in deliveries(dir.path()) {
        let kind = build.delivery;
        // A slicer opens the STL files of a package one by one.
        let files = if kind == DeliveryKind::Parts { unpack(&file, dir.path()) } else { vec![file] };
        let mut parts = 0;
        for file in files {
            let out =
                Command::new(&slicer).args(["--info", "--dont-arrange"]).arg(&file).env("HOME", dir.path()).output();
            let out = out.unwrap();
            let text = format!("{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
            assert!(out.status.success() && !text.contains("rror"), "{kind:?}: {text}");
            let counted = text.lines().filter_map(|line| line.strip_prefix("number_of_parts = "));
            parts += counted.map(|number| number.trim().parse::<usize>().unwrap()).sum::<usize>();
            assert!(
                !text.lines().any(|line| line.starts_with("open_edges") || line == "manifold = no"),
                "{kind:?}: {text}"
            );
        }
        let told = if kind == DeliveryKind::Parts { build.objects.len() } else { build.items.len() };
        assert_eq!(parts, told, "{kind:?}");
    }
}

fn unpack(package: &std::path::Path, folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let mut package = zip::ZipArchive::new(File::open(package).unwrap()).unwrap();
    let names: Vec<String> = package.file_names().filter(|name| name.ends_with(".stl")).map(str::to_owned).collect();
    names
        .iter()
        .map(|name| {
            let file = folder.join(name);
            std::io::copy(&mut package.by_name(name).unwrap(), &mut File::create(&file).unwrap()).unwrap();
            file
        })
        .collect()
}
