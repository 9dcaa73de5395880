//! Reads a dropped 3MF as parts with copies: one part per distinct object and linear part of its transform.

use std::{collections::HashMap, path::Path};

use glam::{DAffine3, DMat3, DVec3};

use super::{
    document::{ModelDocument, ObjectKey},
    flatten::{ComponentFlattener, FlattenedObject},
    item_contact,
    model::{ModelItem, ObjectKind},
    slicer_project::listed,
};
use crate::{
    FileReadError, LengthUnit, PartFileContents, PartFileSolid, ReadLimits, common::solid, escape_invisible,
    format_count,
};

/// Transforms count as equal if their linear parts agree to this many steps per unit: files print 6 to 17 digits.
const STEPS: f64 = 1e9;

type ItemGroupKey = (ObjectKey, [i64; 9]);

/// Build items that differ only by a translation.
struct ItemGroup {
    key: ObjectKey,
    linear: DMat3,
    /// Translations of its items, in the file's unit.
    places: Vec<DVec3>,
    part_number: Option<String>,
}

/// The unit that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AskedUnit {
    /// By a person, who knows better than the file.
    Ticket(LengthUnit),
    /// By the package that the file is in, which it must not contradict.
    Manifest(LengthUnit),
}

impl AskedUnit {
    pub(crate) fn unit(self) -> LengthUnit {
        match self {
            Self::Ticket(unit) | Self::Manifest(unit) => unit,
        }
    }
}

/// Reads a dropped package. `stem` names unnamed objects; `asked_unit` overrides the file's unit.
pub(crate) fn read_threemf_parts(
    file: &Path,
    stem: &str,
    asked_unit: Option<AskedUnit>,
    limits: &ReadLimits,
) -> Result<PartFileContents, FileReadError> {
    let document = ModelDocument::read_package(file, limits)?;
    let file_unit = document.start_part().unit;
    let unit = asked_unit.map_or(file_unit, AskedUnit::unit);
    let mut warnings = document.warnings.clone();
    if let Some(AskedUnit::Manifest(unit)) = asked_unit.filter(|_| unit != file_unit) {
        let what = format!("its unit is {file_unit:?}, and the manifest says {unit:?}");
        let remedy = "Say the same unit in both, or drop the package with a ticket that says the unit.";
        return Err(FileReadError::Unsupported { what, remedy });
    }
    if unit != file_unit {
        warnings.push(format!("the ticket's unit {unit:?} is used instead of the file's {file_unit:?}"));
    }
    let groups = group_items(&document, &mut warnings)?;
    warnings.extend(plates_warning(&document)?);
    let mut flattener = ComponentFlattener::new(&document, limits);
    let many = groups.len() > 1;
    let mut solids = Vec::with_capacity(groups.len());
    let mut places = Vec::with_capacity(groups.len());
    for group in groups {
        let own = [document.object_name(group.key), group.part_number.as_deref().unwrap_or_default().trim()];
        let name = match own.into_iter().find(|name| !name.is_empty()) {
            Some(name) => escape_invisible(name),
            None if many => format!("{stem} {}", group.key.id()),
            None => stem.to_owned(),
        };
        let flat = flattener.flatten_object(group.key, DAffine3::from_mat3(group.linear), unit.mm_per_unit())?;
        solids.push(part_from_flat(name, flat, group.places.len() as u32, unit)?);
        places.push(group.places.into_iter().map(|place| place * unit.mm_per_unit()).collect());
    }
    item_contact::ask_about_contacts(&mut solids, &places);
    Ok(PartFileContents { solids, warnings })
}

/// Tells of the plates of a slicer's project.
fn plates_warning(document: &ModelDocument) -> Result<Option<String>, FileReadError> {
    let items = &document.start_part().items;
    let keys = items.iter().map(|item| document.resolve_reference(&item.reference, None));
    let keys: HashMap<u32, ObjectKey> = keys.map(|key| key.map(|key| (key.id(), key))).collect::<Result<_, _>>()?;
    let objects: Vec<u32> = items.iter().map(|item| item.reference.object).collect();
    let shown = |object: u32| match keys.get(&object).map_or("", |&key| document.object_name(key)) {
        "" => format!("object {object}"),
        name => escape_invisible(name),
    };
    Ok(document.project.plates_warning(&objects, shown))
}

fn part_from_flat(
    name: String,
    flat: FlattenedObject,
    copies: u32,
    unit: LengthUnit,
) -> Result<PartFileSolid, FileReadError> {
    if flat.triangles.is_empty() && !flat.left_out.is_empty() {
        let left_out = listed(&flat.left_out);
        return Err(FileReadError::Unsupported {
            what: format!("\"{name}\" has no model volume, only {left_out}"),
            remedy: "Make the volume that is to be printed a part in the slicer, and export it again.",
        });
    }
    let mut solid = solid::check_solid(name, flat.vertices, flat.triangles, copies, unit)?;
    solid.coordinate_step_mm = flat.coordinate_step_mm;
    if !flat.left_out.is_empty() {
        solid.warnings.push(format!("left out, as no model volume: {}", listed(&flat.left_out)));
    }
    if flat.sliced {
        solid.warnings.push(
            "the file also has this part as a slice stack, which is ignored: its triangles may be only an approximation"
                .to_owned(),
        );
    }
    Ok(solid)
}

/// Groups the build items that are parts, in the order of their first item.
fn group_items(document: &ModelDocument, warnings: &mut Vec<String>) -> Result<Vec<ItemGroup>, FileReadError> {
    let items = &document.start_part().items;
    if items.is_empty() {
        return Err(FileReadError::invalid_threemf("it has no build items, so nothing to print"));
    }
    let mut found: HashMap<ItemGroupKey, usize> = HashMap::new();
    let mut groups: Vec<ItemGroup> = Vec::new();
    let (mut unprintable, mut helpers) = (0, 0);
    for item in items {
        let key = document.resolve_reference(&item.reference, None)?;
        unprintable += u32::from(!item.printable);
        let is_part = document.object(key).kind == ObjectKind::Part;
        helpers += u32::from(!is_part);
        if !item.printable || !is_part {
            continue;
        }
        let linear = item.reference.transform.matrix3;
        let steps = linear.to_cols_array().map(|x| (x * STEPS).round() as i64);
        let at = *found.entry((key, steps)).or_insert_with(|| {
            groups.push(empty_group(item, key, linear));
            groups.len() - 1
        });
        groups[at].places.push(item.reference.transform.translation);
    }
    if unprintable > 0 {
        warnings.push(format_count(
            unprintable,
            "build item is marked as not printable and left out",
            "build items are marked as not printable and left out",
        ));
    }
    if helpers > 0 {
        warnings.push(format_count(
            helpers,
            "build item is supports or another helper, not parts, and left out",
            "build items are supports or other helpers, not parts, and left out",
        ));
    }
    if groups.is_empty() {
        return Err(FileReadError::invalid_threemf("none of its build items is a part to print"));
    }
    Ok(groups)
}

fn empty_group(item: &ModelItem, key: ObjectKey, linear: DMat3) -> ItemGroup {
    ItemGroup { key, linear, places: Vec::new(), part_number: item.part_number.clone() }
}
