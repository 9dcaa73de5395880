//! Reads a dropped 3MF as parts with copies: one part per distinct object and linear part of its transform.

use std::{collections::HashMap, path::Path};

use glam::{DAffine3, DMat3};

use super::{
    FileReadError, LengthUnit, PartFileContents, PartFileSolid, ReadLimits,
    document::{ModelDocument, ObjectKey},
    escape_invisible,
    flatten::{ComponentFlattener, FlattenedObject},
    format_count,
    model::ModelItem,
    solid,
};

/// Transforms count as equal if their linear parts agree to this many steps per unit: files print 6 to 17 digits.
const STEPS: f64 = 1e9;

type ItemGroupKey = (ObjectKey, [i64; 9]);

/// Build items that differ only by a translation.
struct ItemGroup {
    key: ObjectKey,
    linear: DMat3,
    copies: u32,
    part_number: Option<String>,
}

/// The unit that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AskedUnit {
    /// By a person, who knows better than the file.
    Ticket(LengthUnit),
    /// By the package that the file is in, which it must not contradict.
    Manifest(LengthUnit),
}

impl AskedUnit {
    pub(super) fn unit(self) -> LengthUnit {
        match self {
            Self::Ticket(unit) | Self::Manifest(unit) => unit,
        }
    }
}

/// Reads a dropped package. `stem` names unnamed objects; `asked_unit` overrides the file's unit.
pub(super) fn read_threemf_parts(
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
    let mut flattener = ComponentFlattener::new(&document, limits);
    let many = groups.len() > 1;
    let mut solids = Vec::with_capacity(groups.len());
    for group in groups {
        let object = document.object(group.key);
        let own = object.name.as_deref().or(group.part_number.as_deref()).map(str::trim).filter(|n| !n.is_empty());
        let name = match own {
            Some(name) => escape_invisible(name),
            None if many => format!("{stem} {}", group.key.id()),
            None => stem.to_owned(),
        };
        let flat = flattener.flatten_object(group.key, DAffine3::from_mat3(group.linear), unit.mm_per_unit())?;
        solids.push(part_from_flat(name, flat, group.copies, unit)?);
    }
    Ok(PartFileContents { solids, warnings })
}

fn part_from_flat(
    name: String,
    flat: FlattenedObject,
    copies: u32,
    unit: LengthUnit,
) -> Result<PartFileSolid, FileReadError> {
    let mut solid = solid::check_solid(name, flat.vertices, flat.triangles, copies, unit)?;
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
        helpers += u32::from(!document.object(key).is_part);
        if !item.printable || !document.object(key).is_part {
            continue;
        }
        let linear = item.reference.transform.matrix3;
        let steps = linear.to_cols_array().map(|x| (x * STEPS).round() as i64);
        let at = *found.entry((key, steps)).or_insert_with(|| {
            groups.push(empty_group(item, key, linear));
            groups.len() - 1
        });
        groups[at].copies += 1;
    }
    if unprintable > 0 {
        warnings.push(format!(
            "{} as not printable and left out",
            format_count(unprintable, "build item is marked", "build items are marked")
        ));
    }
    if helpers > 0 {
        warnings.push(format!(
            "{}, not parts, and left out",
            format_count(
                helpers,
                "build item is supports or another helper",
                "build items are supports or other helpers"
            )
        ));
    }
    if groups.is_empty() {
        return Err(FileReadError::invalid_threemf("none of its build items is a part to print"));
    }
    Ok(groups)
}

fn empty_group(item: &ModelItem, key: ObjectKey, linear: DMat3) -> ItemGroup {
    ItemGroup { key, linear, copies: 0, part_number: item.part_number.clone() }
}
