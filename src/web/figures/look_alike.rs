//! Parts of a build that an eye confuses: nearly the same size and volume, such as the left and the right one of a pair.

use std::collections::BTreeMap;

use farm::CakePart;
use language::say;
use nester::LookMeasures;

/// The parts that look like others, by number, with the names of those others and of their orders.
pub(crate) fn look_alikes(parts: &[CakePart]) -> BTreeMap<i64, Vec<String>> {
    let measured: Vec<_> =
        parts.iter().filter_map(|part| Some((part, LookMeasures::of_mesh(part.mesh.as_ref()?)))).collect();
    let name = |part: &CakePart| match part.order.as_str() {
        "" => part.name.clone(),
        order => say!("name-of-order", name = &part.name, order = order),
    };
    let others = |(part, measures): &(&CakePart, LookMeasures)| {
        let alike = measured.iter().filter(|(other, m)| other.part != part.part && measures.looks_like(m));
        (part.part, alike.map(|(other, _)| name(other)).collect::<Vec<_>>())
    };
    measured.iter().map(others).filter(|(_, names)| !names.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;

    #[test]
    fn parts_of_nearly_one_size_look_alike_however_they_lie_and_others_do_not() {
        let part = |number: i64, size: [f64; 3]| CakePart {
            reference: String::new(),
            finish: String::new(),
            part: number,
            name: format!("{number}.stl"),
            order: if number == 2 { "kit".to_owned() } else { String::new() },
            due: String::new(),
            note: String::new(),
            mesh: Some(Arc::new(sample_parts::cuboid(DVec3::from_array(size)))),
            copies: Vec::new(),
        };
        let parts =
            [part(1, [40.0, 20.0, 5.0]), part(2, [5.1, 40.5, 20.2]), part(3, [40.0, 24.0, 5.0]), part(4, [9.0; 3])];
        let found = look_alikes(&parts);
        assert_eq!(found.keys().copied().collect::<Vec<_>>(), [1, 2]);
        assert_eq!((found[&1].join(""), found[&2].join("")), ("2.stl (order kit)".to_owned(), "1.stl".to_owned()));
    }
}
