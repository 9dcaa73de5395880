//! A dropped 3MF -> its parts: one per distinct object and linear part of its transform, with copies.

use std::{collections::HashMap, path::Path};

use glam::{DAffine3, DMat3};

use super::{
    Contents, Limits, ReadError, Solid, Unit, counted,
    document::{Document, ObjectKey},
    flatten::{Flat, Flattener},
    model::Item,
    solid, visible,
};

/// Transforms whose linear parts agree to so many steps per unit are the same: files print 6 to 17 digits.
const STEPS: f64 = 1e9;

type GroupKey = (ObjectKey, [i64; 9]);

/// Build items that differ by a translation only.
struct Group {
    key: ObjectKey,
    linear: DMat3,
    copies: u32,
    part_number: Option<String>,
}

/// Reads a dropped package. `stem` names what the file does not; `ticket_unit` wins over the file's own.
pub(super) fn read_dropped(
    file: &Path,
    stem: &str,
    ticket_unit: Option<Unit>,
    limits: &Limits,
) -> Result<Contents, ReadError> {
    let document = Document::read(file, limits)?;
    let file_unit = document.start().unit;
    let unit = ticket_unit.unwrap_or(file_unit);
    let mut warnings = document.warnings.clone();
    if unit != file_unit {
        warnings.push(format!("the ticket's unit {unit:?} is used instead of the file's {file_unit:?}"));
    }
    let groups = groups(&document, &mut warnings)?;
    let mut flattener = Flattener::new(&document, limits);
    let many = groups.len() > 1;
    let mut solids = Vec::with_capacity(groups.len());
    for group in groups {
        let object = document.object(group.key);
        let own = object.name.as_deref().or(group.part_number.as_deref()).map(str::trim).filter(|n| !n.is_empty());
        let name = match own {
            Some(name) => visible(name),
            None if many => format!("{stem} {}", group.key.id()),
            None => stem.to_owned(),
        };
        let flat = flattener.flatten(group.key, DAffine3::from_mat3(group.linear), unit.mm())?;
        solids.push(part(name, flat, group.copies, unit)?);
    }
    Ok(Contents { solids, warnings })
}

fn part(name: String, flat: Flat, copies: u32, unit: Unit) -> Result<Solid, ReadError> {
    let mut solid = solid::solid(name, flat.vertices, flat.triangles, copies, unit)?;
    if flat.sliced {
        solid.warnings.push(
            "the file gives this part as a stack of slices too, which is left out: its triangles may be a rough stand-in only"
                .to_owned(),
        );
    }
    Ok(solid)
}

/// Groups the build items that are parts, in the order of their first item.
fn groups(document: &Document, warnings: &mut Vec<String>) -> Result<Vec<Group>, ReadError> {
    let items = &document.start().items;
    if items.is_empty() {
        return Err(ReadError::threemf("it has no build items, so nothing to print"));
    }
    let mut found: HashMap<GroupKey, usize> = HashMap::new();
    let mut groups: Vec<Group> = Vec::new();
    let (mut unprintable, mut helpers) = (0, 0);
    for item in items {
        let key = document.key(&item.reference, None)?;
        unprintable += u32::from(!item.printable);
        helpers += u32::from(!document.object(key).is_part);
        if !item.printable || !document.object(key).is_part {
            continue;
        }
        let linear = item.reference.transform.matrix3;
        let steps = linear.to_cols_array().map(|x| (x * STEPS).round() as i64);
        let at = *found.entry((key, steps)).or_insert_with(|| {
            groups.push(group(item, key, linear));
            groups.len() - 1
        });
        groups[at].copies += 1;
    }
    if unprintable > 0 {
        warnings.push(format!(
            "{} as not printable and left out",
            counted(unprintable, "build item is marked", "build items are marked")
        ));
    }
    if helpers > 0 {
        warnings.push(format!(
            "{}, not parts, and left out",
            counted(helpers, "build item is supports or another helper", "build items are supports or other helpers")
        ));
    }
    if groups.is_empty() {
        return Err(ReadError::threemf("none of its build items is a part to print"));
    }
    Ok(groups)
}

fn group(item: &Item, key: ObjectKey, linear: DMat3) -> Group {
    Group { key, linear, copies: 0, part_number: item.part_number.clone() }
}
