//! Parses the XML of one model part into a [`ModelPart`]. Elements that do not affect the shape are ignored.

use std::io::BufRead;

use glam::{DAffine3, DMat3, DVec3};

use super::{
    model::{
        CountedElement, ModelBudget, ModelItem, ModelMetadata, ModelObject, ModelPart, ObjectBody, ObjectKind,
        ObjectReference,
    },
    model_head::{ModelXmlReader, open_model, parse_metadata},
    plain_lists::{plain_triangle, plain_vertex},
    slicer_project::is_helper_mesh,
    xml::DocumentStep,
    xml_names::{CORE, ElementTag, NESTD, PRODUCTION, SLICE, XmlNamespace},
};
use crate::{FileReadError, LengthUnit, common::decimal::parse_decimal};

/// Extensions that a file may require: they do not change the triangles, or their effect is marked per object.
const KNOWN_EXTENSIONS: [&str; 9] = [
    CORE,
    PRODUCTION,
    SLICE,
    NESTD,
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07",
    "http://schemas.3mf.io/3dmanufacturing/productionalternatives/2021/04",
];

/// Reads a whole model part.
pub(super) fn parse_model<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
) -> Result<ModelPart, FileReadError> {
    open_model(xml)?;
    let mut part = ModelPart { unit: parse_unit(xml)?, ..ModelPart::default() };
    check_required_extensions(xml)?;
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Metadata) => parse_metadata(xml, budget, &mut part.metadata)?,
            DocumentStep::Open(ElementTag::Resources) => parse_resources(xml, budget, &mut part)?,
            DocumentStep::Open(ElementTag::Build) => parse_build(xml, budget, &mut part.items)?,
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => break,
            _ => {}
        }
    }
    // Reading to the end verifies the entry's checksum.
    while xml.next_step()? != DocumentStep::End {}
    Ok(part)
}

fn parse_unit<R: BufRead>(xml: &ModelXmlReader<R>) -> Result<LengthUnit, FileReadError> {
    match xml.plain_attribute("unit") {
        None => Ok(LengthUnit::Millimeter),
        Some(name) => match name.trim() {
            "micron" => Ok(LengthUnit::Micron),
            "millimeter" => Ok(LengthUnit::Millimeter),
            "centimeter" => Ok(LengthUnit::Centimeter),
            "inch" => Ok(LengthUnit::Inch),
            "foot" => Ok(LengthUnit::Foot),
            "meter" => Ok(LengthUnit::Meter),
            other => Err(xml.invalid_document(&format!("its unit {other:?} is not a unit of 3MF"))),
        },
    }
}

fn check_required_extensions<R: BufRead>(xml: &ModelXmlReader<R>) -> Result<(), FileReadError> {
    for prefix in xml.plain_attribute("requiredextensions").unwrap_or("").split_whitespace() {
        let Some(namespace) = xml.namespace_uri(prefix) else {
            return Err(
                xml.invalid_document(&format!("it requires the extension `{prefix}`, which it does not declare"))
            );
        };
        if !KNOWN_EXTENSIONS.contains(&namespace.as_str()) {
            let what = if namespace.contains("securecontent") { "encrypted content" } else { "an extension" };
            return Err(FileReadError::Unsupported {
                what: format!("the file requires {what} that is not supported: {namespace}"),
                remedy: "Export the part as plain 3MF (core specification) or as STL.",
            });
        }
    }
    Ok(())
}

fn parse_metadata_group<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
) -> Result<ModelMetadata, FileReadError> {
    let mut group = ModelMetadata::default();
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Metadata) => parse_metadata(xml, budget, &mut group)?,
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(group),
            _ => {}
        }
    }
}

fn parse_resources<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    part: &mut ModelPart,
) -> Result<(), FileReadError> {
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Object) => {
                let id = parse_index(xml, "id")?;
                budget.take_amount(CountedElement::Objects, 1)?;
                let object = parse_object(xml, budget, id)?;
                if part.objects.insert(id, object).is_some() {
                    return Err(xml.invalid_document(&format!("it has two objects {id}")));
                }
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(()),
            _ => {}
        }
    }
}

fn parse_object<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    id: u32,
) -> Result<ModelObject, FileReadError> {
    let kind = match xml.plain_attribute("type").unwrap_or("model") {
        "model" => ObjectKind::Part,
        "support" | "solidsupport" | "surface" => ObjectKind::Support,
        "other" => ObjectKind::Other,
        other => {
            return Err(xml.invalid_document(&format!("object {id} is of the type {other:?}, which 3MF does not know")));
        }
    };
    let mut object = ModelObject {
        name: xml.plain_attribute("name").map(str::to_owned),
        part_number: xml.plain_attribute("partnumber").map(str::to_owned),
        kind,
        body: ObjectBody::Components(Vec::new()),
        sliced: xml.attribute_value(XmlNamespace::Slice, "slicestackid").is_some(),
        lattice: false,
        metadata: ModelMetadata::default(),
    };
    let bytes = object.name.as_ref().map_or(0, String::len) + object.part_number.as_ref().map_or(0, String::len);
    budget.take_amount(CountedElement::MetadataBytes, bytes as u64)?;
    let mut bodies = 0;
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Mesh) => {
                (object.body, object.lattice) = parse_mesh(xml, budget, id)?;
                bodies += 1;
            }
            DocumentStep::Open(ElementTag::Components) => {
                object.body = ObjectBody::Components(parse_components(xml, budget)?);
                bodies += 1;
            }
            DocumentStep::Open(ElementTag::MetadataGroup) => {
                object.metadata = parse_metadata_group(xml, budget)?;
                if object.kind == ObjectKind::Part && is_helper_mesh(&object.metadata) {
                    object.kind = ObjectKind::Support;
                }
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => break,
            _ => {}
        }
    }
    if bodies > 1 {
        return Err(xml.invalid_document(&format!("object {id} has more than one mesh or list of components")));
    }
    Ok(object)
}

/// Parses a mesh. Returns whether it has beams, too.
fn parse_mesh<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    id: u32,
) -> Result<(ObjectBody, bool), FileReadError> {
    let (mut vertices, mut triangles, mut lattice) = (Vec::new(), Vec::new(), false);
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Vertices) => parse_vertices(xml, budget, &mut vertices)?,
            DocumentStep::Open(ElementTag::Triangles) => parse_triangles(xml, budget, &mut triangles)?,
            DocumentStep::Open(ElementTag::BeamLattice) => {
                lattice = true;
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => break,
            _ => {}
        }
    }
    let beyond = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= vertices.len());
    if let Some(bad) = triangles.iter().position(beyond) {
        let (count, names) = (vertices.len(), triangles[bad]);
        return Err(xml.invalid_document(&format!("triangle {bad} of object {id} names {names:?} of {count} vertices")));
    }
    Ok((ObjectBody::Mesh { vertices, triangles }, lattice))
}

fn parse_vertices<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    into: &mut Vec<DVec3>,
) -> Result<(), FileReadError> {
    loop {
        xml.take_plain_elements(plain_vertex, |corner| {
            budget.take_amount(CountedElement::Vertices, 1)?;
            into.push(corner);
            Ok(())
        })?;
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Vertex) => {
                budget.take_amount(CountedElement::Vertices, 1)?;
                into.push(DVec3::new(
                    parse_coordinate(xml, "x")?,
                    parse_coordinate(xml, "y")?,
                    parse_coordinate(xml, "z")?,
                ));
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(()),
            _ => {}
        }
    }
}

fn parse_triangles<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    into: &mut Vec<[u32; 3]>,
) -> Result<(), FileReadError> {
    loop {
        xml.take_plain_elements(plain_triangle, |corners| {
            budget.take_amount(CountedElement::Triangles, 1)?;
            into.push(corners);
            Ok(())
        })?;
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Triangle) => {
                budget.take_amount(CountedElement::Triangles, 1)?;
                into.push([parse_index(xml, "v1")?, parse_index(xml, "v2")?, parse_index(xml, "v3")?]);
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(()),
            _ => {}
        }
    }
}

fn parse_components<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
) -> Result<Vec<ObjectReference>, FileReadError> {
    let mut components = Vec::new();
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Component) => {
                budget.take_amount(CountedElement::Components, 1)?;
                components.push(parse_reference(xml, "component", budget)?);
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(components),
            _ => {}
        }
    }
}

fn parse_build<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    items: &mut Vec<ModelItem>,
) -> Result<(), FileReadError> {
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Item) => {
                budget.take_amount(CountedElement::Items, 1)?;
                items.push(parse_item(xml, budget, items.len() + 1)?);
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(()),
            _ => {}
        }
    }
}

fn parse_item<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    number: usize,
) -> Result<ModelItem, FileReadError> {
    let reference = parse_reference(xml, &format!("build item {number}"), budget)?;
    let part_number = xml.plain_attribute("partnumber").map(str::to_owned);
    budget.take_amount(CountedElement::MetadataBytes, part_number.as_ref().map_or(0, String::len) as u64)?;
    let printable = xml.plain_attribute("printable").is_none_or(|value| !matches!(value.trim(), "0" | "false"));
    let mut item = ModelItem { reference, part_number, printable, metadata: ModelMetadata::default() };
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::MetadataGroup) => item.metadata = parse_metadata_group(xml, budget)?,
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(item),
            _ => {}
        }
    }
}

/// Parses `objectid`, `transform` and `p:path` of the open element.
fn parse_reference<R: BufRead>(
    xml: &ModelXmlReader<R>,
    what: &str,
    budget: &mut ModelBudget,
) -> Result<ObjectReference, FileReadError> {
    let transform = match xml.plain_attribute("transform") {
        None => DAffine3::IDENTITY,
        Some(text) => parse_transform(text).ok_or_else(|| {
            xml.invalid_document(&format!(
                "the transform of {what} is not 12 finite numbers: {:?}",
                shorten_value(text)
            ))
        })?,
    };
    let path = xml.attribute_value(XmlNamespace::Production, "path").map(str::to_owned);
    budget.take_amount(CountedElement::MetadataBytes, path.as_ref().map_or(0, String::len) as u64)?;
    Ok(ObjectReference { path, object: parse_index(xml, "objectid")?, transform })
}

/// Twelve numbers: the images of x, y and z, then the translation (3MF multiplies row vectors).
fn parse_transform(text: &str) -> Option<DAffine3> {
    let mut numbers = [0.0; 12];
    let mut words = text.split_ascii_whitespace();
    for number in &mut numbers {
        *number = parse_decimal(words.next()?.as_bytes())?;
    }
    let axis = |i: usize| DVec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
    let matrix = DMat3::from_cols(axis(0), axis(3), axis(6));
    words.next().is_none().then(|| DAffine3::from_mat3_translation(matrix, axis(9)))
}

fn parse_coordinate<R: BufRead>(xml: &ModelXmlReader<R>, name: &str) -> Result<f64, FileReadError> {
    let text = xml.plain_attribute(name).ok_or_else(|| xml.invalid_document(&format!("a vertex without {name}")))?;
    parse_decimal(text.trim().as_bytes()).ok_or_else(|| {
        xml.invalid_document(&format!("the coordinate {name}={:?} is no finite number", shorten_value(text)))
    })
}

fn parse_index<R: BufRead>(xml: &ModelXmlReader<R>, name: &str) -> Result<u32, FileReadError> {
    let text = xml.plain_attribute(name).ok_or_else(|| xml.invalid_document(&format!("an element without {name}")))?;
    let digits = text.trim();
    let number = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten();
    number.ok_or_else(|| xml.invalid_document(&format!("{name}={:?} is no index", shorten_value(text))))
}

/// Shortens a value for an error message.
fn shorten_value(text: &str) -> String {
    text.chars().take(80).collect()
}
