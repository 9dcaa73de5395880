//! The XML of one model part -> [`ModelPart`]. Everything that does not change the shape is passed over.

use std::io::BufRead;

use glam::{DAffine3, DMat3, DVec3};

use super::{
    ReadError, Unit,
    guard::Guard,
    model::{Body, Budget, Counted, Item, Metadata, ModelPart, Object, Reference},
    number::decimal,
    xml::{Space, Step, Tag, Xml},
};

/// Extensions that a file may require: they do not change the triangles, or what they change is told per object.
const KNOWN_EXTENSIONS: [&str; 9] = [
    super::xml::CORE,
    super::xml::PRODUCTION,
    super::xml::SLICE,
    super::xml::NESTD,
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
    "http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07",
    "http://schemas.3mf.io/3dmanufacturing/productionalternatives/2021/04",
];

type Input<R> = Xml<Guard<R>>;

/// Reads a whole model part.
pub(super) fn model<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget) -> Result<ModelPart, ReadError> {
    loop {
        match xml.step()? {
            Step::Open(Tag::Model) => break,
            Step::Open(_) | Step::End => return Err(xml.invalid("its root is no 3MF model")),
            _ => {}
        }
    }
    let mut part = ModelPart { unit: unit(xml)?, ..ModelPart::default() };
    required_extensions(xml)?;
    loop {
        match xml.step()? {
            Step::Open(Tag::Metadata) => metadata(xml, budget, &mut part.metadata)?,
            Step::Open(Tag::Resources) => resources(xml, budget, &mut part)?,
            Step::Open(Tag::Build) => build(xml, budget, &mut part.items)?,
            Step::Open(_) => xml.skip()?,
            Step::Close => break,
            _ => {}
        }
    }
    // Reading on to the end proves the entry's checksum.
    while xml.step()? != Step::End {}
    Ok(part)
}

fn unit<R: BufRead>(xml: &Input<R>) -> Result<Unit, ReadError> {
    match xml.plain("unit") {
        None => Ok(Unit::Millimeter),
        Some(name) => match name.trim() {
            "micron" => Ok(Unit::Micron),
            "millimeter" => Ok(Unit::Millimeter),
            "centimeter" => Ok(Unit::Centimeter),
            "inch" => Ok(Unit::Inch),
            "foot" => Ok(Unit::Foot),
            "meter" => Ok(Unit::Meter),
            other => Err(xml.invalid(&format!("its unit {other:?} is none of 3MF"))),
        },
    }
}

fn required_extensions<R: BufRead>(xml: &Input<R>) -> Result<(), ReadError> {
    for prefix in xml.plain("requiredextensions").unwrap_or("").split_whitespace() {
        let Some(namespace) = xml.namespace(prefix) else {
            return Err(xml.invalid(&format!("it requires the extension `{prefix}`, which it does not declare")));
        };
        if !KNOWN_EXTENSIONS.contains(&namespace.as_str()) {
            let what = if namespace.contains("securecontent") { "encrypted content" } else { "an extension" };
            return Err(ReadError::Unsupported {
                what: format!("the file requires {what} that is not supported: {namespace}"),
                remedy: "Export the part as plain 3MF (core specification) or as STL.",
            });
        }
    }
    Ok(())
}

/// A `<metadata>`; keeps names without a namespace and our own. Words for people do not change the shape: of two that have one
/// name the first counts, and one without a name or of a prefix that nobody declared is passed over. Our own decide what is
/// proved of a build, so that they stand there once.
fn metadata<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, into: &mut Metadata) -> Result<(), ReadError> {
    let Some(name) = xml.plain("name").map(str::to_owned) else {
        budget.odd_metadata += 1;
        return xml.skip();
    };
    let (space, local) = match name.split_once(':') {
        None => (Space::None, name.as_str()),
        Some((prefix, local)) => match xml.namespace(prefix) {
            Some(namespace) => (Space::of(&namespace), local),
            None => {
                budget.odd_metadata += 1;
                return xml.skip();
            }
        },
    };
    let value = xml.text_inside()?;
    if !matches!(space, Space::None | Space::Nestd) {
        return Ok(());
    }
    budget.take(Counted::MetadataBytes, (local.len() + value.len() + 64) as u64)?;
    // A well-formed group has each name once; a quick look back bounds the time that a hostile one costs.
    if into.0.len() < 100 && into.0.iter().any(|(s, n, _)| *s == space && n == local) {
        if space == Space::Nestd {
            return Err(xml.invalid(&format!("it has the metadata {name:?} twice")));
        }
        budget.odd_metadata += 1;
        return Ok(());
    }
    into.0.push((space, local.to_owned(), value));
    Ok(())
}

fn metadata_group<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget) -> Result<Metadata, ReadError> {
    let mut group = Metadata::default();
    loop {
        match xml.step()? {
            Step::Open(Tag::Metadata) => metadata(xml, budget, &mut group)?,
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(group),
            _ => {}
        }
    }
}

fn resources<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, part: &mut ModelPart) -> Result<(), ReadError> {
    loop {
        match xml.step()? {
            Step::Open(Tag::Object) => {
                let id = index(xml, "id")?;
                budget.take(Counted::Objects, 1)?;
                let object = object(xml, budget, id)?;
                if part.objects.insert(id, object).is_some() {
                    return Err(xml.invalid(&format!("it has two objects {id}")));
                }
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(()),
            _ => {}
        }
    }
}

fn object<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, id: u32) -> Result<Object, ReadError> {
    let is_part = match xml.plain("type").unwrap_or("model") {
        "model" | "solidsupport" => true,
        "support" | "surface" | "other" => false,
        other => return Err(xml.invalid(&format!("object {id} is of the type {other:?}, which 3MF does not know"))),
    };
    let mut object = Object {
        name: xml.plain("name").map(str::to_owned),
        part_number: xml.plain("partnumber").map(str::to_owned),
        is_part,
        body: Body::Components(Vec::new()),
        sliced: xml.attribute(Space::Slice, "slicestackid").is_some(),
        lattice: false,
        metadata: Metadata::default(),
    };
    let bytes = object.name.as_ref().map_or(0, String::len) + object.part_number.as_ref().map_or(0, String::len);
    budget.take(Counted::MetadataBytes, bytes as u64)?;
    let mut bodies = 0;
    loop {
        match xml.step()? {
            Step::Open(Tag::Mesh) => {
                (object.body, object.lattice) = mesh(xml, budget, id)?;
                bodies += 1;
            }
            Step::Open(Tag::Components) => {
                object.body = Body::Components(components(xml, budget)?);
                bodies += 1;
            }
            Step::Open(Tag::MetadataGroup) => object.metadata = metadata_group(xml, budget)?,
            Step::Open(_) => xml.skip()?,
            Step::Close => break,
            _ => {}
        }
    }
    if bodies > 1 {
        return Err(xml.invalid(&format!("object {id} has more than one mesh or list of components")));
    }
    Ok(object)
}

/// A mesh, and whether it has beams.
fn mesh<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, id: u32) -> Result<(Body, bool), ReadError> {
    let (mut vertices, mut triangles, mut lattice) = (Vec::new(), Vec::new(), false);
    loop {
        match xml.step()? {
            Step::Open(Tag::Vertices) => read_vertices(xml, budget, &mut vertices)?,
            Step::Open(Tag::Triangles) => read_triangles(xml, budget, &mut triangles)?,
            Step::Open(Tag::BeamLattice) => {
                lattice = true;
                xml.skip()?;
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => break,
            _ => {}
        }
    }
    let beyond = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= vertices.len());
    if let Some(bad) = triangles.iter().position(beyond) {
        let (count, names) = (vertices.len(), triangles[bad]);
        return Err(xml.invalid(&format!("triangle {bad} of object {id} names {names:?} of {count} vertices")));
    }
    Ok((Body::Mesh { vertices, triangles }, lattice))
}

fn read_vertices<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, into: &mut Vec<DVec3>) -> Result<(), ReadError> {
    loop {
        match xml.step()? {
            Step::Open(Tag::Vertex) => {
                budget.take(Counted::Vertices, 1)?;
                into.push(DVec3::new(coordinate(xml, "x")?, coordinate(xml, "y")?, coordinate(xml, "z")?));
                xml.skip()?;
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(()),
            _ => {}
        }
    }
}

fn read_triangles<R: BufRead>(
    xml: &mut Input<R>,
    budget: &mut Budget,
    into: &mut Vec<[u32; 3]>,
) -> Result<(), ReadError> {
    loop {
        match xml.step()? {
            Step::Open(Tag::Triangle) => {
                budget.take(Counted::Triangles, 1)?;
                into.push([index(xml, "v1")?, index(xml, "v2")?, index(xml, "v3")?]);
                xml.skip()?;
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(()),
            _ => {}
        }
    }
}

fn components<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget) -> Result<Vec<Reference>, ReadError> {
    let mut components = Vec::new();
    loop {
        match xml.step()? {
            Step::Open(Tag::Component) => {
                budget.take(Counted::Components, 1)?;
                components.push(reference(xml, "component", budget)?);
                xml.skip()?;
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(components),
            _ => {}
        }
    }
}

fn build<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, items: &mut Vec<Item>) -> Result<(), ReadError> {
    loop {
        match xml.step()? {
            Step::Open(Tag::Item) => {
                budget.take(Counted::Items, 1)?;
                items.push(item(xml, budget, items.len() + 1)?);
            }
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(()),
            _ => {}
        }
    }
}

fn item<R: BufRead>(xml: &mut Input<R>, budget: &mut Budget, number: usize) -> Result<Item, ReadError> {
    let reference = reference(xml, &format!("build item {number}"), budget)?;
    let part_number = xml.plain("partnumber").map(str::to_owned);
    budget.take(Counted::MetadataBytes, part_number.as_ref().map_or(0, String::len) as u64)?;
    let printable = xml.plain("printable").is_none_or(|value| !matches!(value.trim(), "0" | "false"));
    let mut item = Item { reference, part_number, printable, metadata: Metadata::default() };
    loop {
        match xml.step()? {
            Step::Open(Tag::MetadataGroup) => item.metadata = metadata_group(xml, budget)?,
            Step::Open(_) => xml.skip()?,
            Step::Close => return Ok(item),
            _ => {}
        }
    }
}

/// `objectid`, `transform` and `p:path` of the open element.
fn reference<R: BufRead>(xml: &Input<R>, what: &str, budget: &mut Budget) -> Result<Reference, ReadError> {
    let transform = match xml.plain("transform") {
        None => DAffine3::IDENTITY,
        Some(text) => transform(text).ok_or_else(|| {
            xml.invalid(&format!("the transform of {what} is not 12 finite numbers: {:?}", shortened(text)))
        })?,
    };
    let path = xml.attribute(Space::Production, "path").map(str::to_owned);
    budget.take(Counted::MetadataBytes, path.as_ref().map_or(0, String::len) as u64)?;
    Ok(Reference { path, object: index(xml, "objectid")?, transform })
}

/// Twelve numbers: the images of x, y and z, then the translation (3MF multiplies row vectors).
fn transform(text: &str) -> Option<DAffine3> {
    let mut numbers = [0.0; 12];
    let mut words = text.split_ascii_whitespace();
    for number in &mut numbers {
        *number = decimal(words.next()?.as_bytes())?;
    }
    let axis = |i: usize| DVec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
    let matrix = DMat3::from_cols(axis(0), axis(3), axis(6));
    words.next().is_none().then(|| DAffine3::from_mat3_translation(matrix, axis(9)))
}

fn coordinate<R: BufRead>(xml: &Input<R>, name: &str) -> Result<f64, ReadError> {
    let text = xml.plain(name).ok_or_else(|| xml.invalid(&format!("a vertex without {name}")))?;
    decimal(text.trim().as_bytes())
        .ok_or_else(|| xml.invalid(&format!("the coordinate {name}={:?} is no finite number", shortened(text))))
}

fn index<R: BufRead>(xml: &Input<R>, name: &str) -> Result<u32, ReadError> {
    let text = xml.plain(name).ok_or_else(|| xml.invalid(&format!("an element without {name}")))?;
    let digits = text.trim();
    let number = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten();
    number.ok_or_else(|| xml.invalid(&format!("{name}={:?} is no index", shortened(text))))
}

/// Enough of a value for an error message.
fn shortened(text: &str) -> String {
    text.chars().take(80).collect()
}
