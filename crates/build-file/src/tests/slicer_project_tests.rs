//! Projects as PrusaSlicer, SuperSlicer, Bambu Studio and OrcaSlicer write them: what is no model volume is never built.

use super::test_package::{boxes, model, read_package};
use crate::*;
use glam::DVec3;

/// The body of every project: 30 x 30 x 15 mm.
const BODY: [f64; 3] = [30.0, 30.0, 15.0];
/// The other volume of every project, which stands out of the body: 40 x 40 x 55 mm with it.
const OTHER: [f64; 3] = [40.0, 40.0, 55.0];

/// One object whose mesh holds all volumes, told apart by ranges of triangles.
fn prusa(config_name: &str, kind_entry: &str) -> Result<PartFileContents, FileReadError> {
    let config = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<config>
 <object id="1" instances_count="1">
  <metadata type="object" key="name" value="Bracket"/>
  <volume firstid="0" lastid="11">
   <metadata type="volume" key="name" value="Body"/>
   <metadata type="volume" key="volume_type" value="ModelPart"/>
   <mesh edges_fixed="0"/>
  </volume>
  <volume firstid="12" lastid="23">
   <metadata type="volume" key="name" value="Pocket"/>
   {kind_entry}
   <slic3rpe:text text="A" style_name="Arial"/>
   <metadata type="volume" key="matrix" value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/>
  </volume>
 </object>
</config>"#
    );
    let object = format!(r#"<object id="1" type="model">{}</object>"#, boxes(&[BODY, OTHER]));
    let start = model(&object, r#"<item objectid="1" printable="1"/>"#);
    read_package(&[("3D/3dmodel.model", &start), (config_name, &config)])
}

fn of_type(kind: &str) -> String {
    format!(r#"<metadata type="volume" key="volume_type" value="{kind}"/>"#)
}

/// An object of components in another model part, each of them an object with a subtype.
fn bambu(subtype: &str, plates: &str) -> Result<PartFileContents, FileReadError> {
    let config = format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<config>
  <object id="3">
    <metadata key="name" value="Bracket"/>
    <metadata face_count="24"/>
    <part id="1" subtype="normal_part"><metadata key="name" value="Body"/></part>
    <part id="2" subtype="{subtype}"><metadata key="name" value="Pocket"/><mesh_stat face_count="12"/></part>
  </object>
  {plates}
</config>"#
    );
    let object = |id: u32, size, kind: &str| format!(r#"<object id="{id}" type="{kind}">{}</object>"#, boxes(&[size]));
    let other_type = if subtype == "normal_part" { "model" } else { "other" };
    let parts = model(&(object(1, BODY, "model") + &object(2, OTHER, other_type)), "");
    let start = model(
        r#"<object id="3" type="model"><components><component p:path="/3D/Objects/object_1.model" objectid="1"/><component p:path="/3D/Objects/object_1.model" objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>"#,
        r#"<item objectid="3" printable="1"/><item objectid="3" transform="1 0 0 0 1 0 0 0 1 300 0 0" printable="1"/>"#,
    );
    read_package(&[
        ("3D/3dmodel.model", &start),
        ("3D/Objects/object_1.model", &parts),
        ("Metadata/model_settings.config", &config),
    ])
}

fn size_of(contents: &PartFileContents) -> DVec3 {
    contents.solids[0].mesh.bounds().size()
}

/// The kinds that are left out: as each slicer calls them, and as nestd does.
const LEFT_OUT: [(&str, &str, &str); 3] = [
    ("ParameterModifier", "modifier_part", "modifier \"Pocket\""),
    ("SupportBlocker", "support_blocker", "support blocker \"Pocket\""),
    ("SupportEnforcer", "support_enforcer", "support enforcer \"Pocket\""),
];

#[test]
fn modifiers_and_support_volumes_are_left_out_and_named() {
    for (volume_type, subtype, shown) in LEFT_OUT {
        for (slicer, read) in [
            ("PrusaSlicer", prusa("Metadata/Slic3r_PE_model.config", &of_type(volume_type))),
            ("SuperSlicer", prusa("Metadata/SuperSlicer_model.config", &of_type(volume_type))),
            ("a program made of it", prusa("Metadata/QIDI_PE_model.config", &of_type(volume_type))),
            ("a path from the root", prusa("/metadata/slic3r_pe_model.config", &of_type(volume_type))),
            ("a path of Windows", prusa("Metadata\\Slic3r_PE_model.config", &of_type(volume_type))),
            ("Bambu Studio", bambu(subtype, "")),
        ] {
            let contents = read.unwrap();
            assert_eq!(size_of(&contents), DVec3::from_array(BODY), "{slicer} {volume_type}");
            assert_eq!(contents.solids[0].mesh.triangles().len(), 12, "{slicer} {volume_type}");
            let warnings = contents.solids[0].warnings.join("\n");
            assert!(warnings.contains(shown), "{slicer} {volume_type}: {warnings}");
            assert_eq!(contents.solids[0].name, "Bracket", "{slicer}");
        }
    }
    let old =
        prusa("Metadata/Slic3r_PE_model.config", r#"<metadata type="volume" key="modifier" value="1"/>"#).unwrap();
    assert_eq!(size_of(&old), DVec3::from_array(BODY), "as before there were several types");
}

/// A project of Cura: the body, and a mesh with a setting that says what it is for.
fn cura(name: &str, value: &str) -> Result<PartFileContents, FileReadError> {
    let group = format!(
        r#"<metadatagroup><metadata name="{name}" preserve="true" type="xs:string">{value}</metadata></metadatagroup>"#
    );
    let objects = format!(
        r#"<object id="1" type="model">{}</object><object id="2" name="Pocket" type="model">{group}{}</object><object id="3" type="model"><components><component objectid="1"/><component objectid="2"/></components></object>"#,
        boxes(&[BODY]),
        boxes(&[OTHER])
    );
    let start = model(&objects, r#"<item objectid="3"/>"#).replacen(
        "<model ",
        r#"<model xmlns:cura="http://software.ultimaker.com/xml/cura/3mf/2015/10" "#,
        1,
    );
    read_package(&[("3D/3dmodel.model", &start)])
}

#[test]
fn the_meshes_of_cura_that_only_change_settings_are_left_out_and_named() {
    for name in ["infill_mesh", "cutting_mesh", "anti_overhang_mesh", "support_mesh"] {
        let contents = cura(&format!("cura:{name}"), "True").unwrap();
        assert_eq!(size_of(&contents), DVec3::from_array(BODY), "{name}");
        assert!(contents.solids[0].warnings.join("\n").contains("Pocket"), "{name}: {:?}", contents.solids[0].warnings);
    }
    assert_eq!(size_of(&cura("cura:infill_mesh", "False").unwrap()), DVec3::from_array(OTHER), "as any other mesh");
}

#[test]
fn a_negative_volume_refuses_the_file_by_that_word() {
    let prusa = prusa("Metadata/Slic3r_PE_model.config", &of_type("NegativeVolume"));
    for read in [prusa, bambu("negative_part", "")] {
        let error = read.unwrap_err();
        assert!(error.to_string().contains("negative volume \"Pocket\""), "{error}");
        assert!(error.to_string().contains("Bracket"), "{error}");
        assert!(error.remedy().contains("STL"), "{}", error.remedy());
    }
}

#[test]
fn a_kind_of_volume_that_is_not_known_refuses_the_file() {
    let prusa = prusa("Metadata/Slic3r_PE_model.config", &of_type("Lattice"));
    for read in [prusa, bambu("Lattice", "")] {
        assert!(read.unwrap_err().to_string().contains("\"Lattice\""));
    }
}

#[test]
fn model_volumes_are_one_part() {
    let both = [prusa("Metadata/Slic3r_PE_model.config", &of_type("ModelPart")), bambu("normal_part", "")];
    for contents in both.map(Result::unwrap) {
        assert_eq!(size_of(&contents), DVec3::from_array(OTHER));
        assert_eq!(contents.solids[0].mesh.triangles().len(), 24);
        assert_eq!(contents.solids[0].warnings, [""; 0]);
    }
}

#[test]
fn ranges_that_do_not_fit_the_mesh_are_refused() {
    let config = r#"<config><object id="1"><volume firstid="12" lastid="24"><metadata key="volume_type" value="ParameterModifier"/></volume></object></config>"#;
    let start = model(&format!(r#"<object id="1">{}</object>"#, boxes(&[BODY, OTHER])), r#"<item objectid="1"/>"#);
    let entries = [("3D/3dmodel.model", start.as_str()), ("Metadata/Slic3r_PE_model.config", config)];
    assert!(read_package(&entries).unwrap_err().to_string().contains("triangle"));
}

#[test]
fn an_object_without_a_model_volume_is_refused() {
    let config = r#"<config><object id="1"><volume firstid="0" lastid="23"><metadata key="volume_type" value="SupportBlocker"/></volume></object></config>"#;
    let start = model(&format!(r#"<object id="1">{}</object>"#, boxes(&[BODY, OTHER])), r#"<item objectid="1"/>"#);
    let entries = [("3D/3dmodel.model", start.as_str()), ("Metadata/Slic3r_PE_model.config", config)];
    let error = read_package(&entries).unwrap_err().to_string();
    assert!(error.contains("support blocker"), "{error}");
}

#[test]
fn components_that_are_no_model_objects_are_no_model_volumes() {
    let object = |kind: &str| {
        let inner = format!(r#"<object id="1" name="Body">{}</object>"#, boxes(&[BODY]))
            + &format!(r#"<object id="2" name="Pocket" type="{kind}">{}</object>"#, boxes(&[OTHER]));
        let components = r#"<object id="3" name="Bracket"><components><component objectid="1"/><component objectid="2"/></components></object>"#;
        read_package(&[("3D/3dmodel.model", &model(&(inner + components), r#"<item objectid="3"/>"#))])
    };
    let contents = object("support").unwrap();
    assert_eq!(size_of(&contents), DVec3::from_array(BODY));
    assert!(contents.solids[0].warnings.join("\n").contains("support \"Pocket\""));
    let error = object("other").unwrap_err().to_string();
    assert!(error.contains("\"Pocket\"") && error.contains("other"), "{error}");
}

#[test]
fn plates_are_told_with_their_names() {
    let plate = |id: u32, name: &str, instance: u32| {
        format!(
            r#"<plate><metadata key="plater_id" value="{id}"/><metadata key="plater_name" value="{name}"/><model_instance><metadata key="object_id" value="3"/><metadata key="instance_id" value="{instance}"/></model_instance></plate>"#
        )
    };
    let contents = bambu("normal_part", &(plate(1, "", 0) + &plate(2, "Lids", 1))).unwrap();
    assert_eq!(contents.solids[0].copies, 2);
    let told = contents.warnings.join("\n");
    assert!(told.contains("2 plates") && told.contains("plate 1: Bracket; plate 2 \"Lids\": Bracket"), "{told}");
    let one = bambu("normal_part", &plate(1, "", 0)).unwrap().warnings.join("\n");
    assert!(one.contains("on no plate"), "{one}");
}
