//! What a model part of a 3MF package says, as it says it: objects, components and build items in the file's own unit. `BuildItem` of the
//! build file is our own word; `Item` here is the `<item>` of 3MF.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use super::{Limits, ReadError, Unit, xml::Space};

/// Metadata without a namespace or under our own.
#[derive(Debug, Clone, Default)]
pub(super) struct Metadata(pub(super) Vec<(Space, String, String)>);

impl Metadata {
    /// The value of a name under our own namespace.
    pub(super) fn nestd(&self, name: &str) -> Option<String> {
        self.of(Space::Nestd, name)
    }

    /// The value of one of the specification's nine names.
    pub(super) fn plain(&self, name: &str) -> Option<String> {
        self.of(Space::None, name)
    }

    fn of(&self, space: Space, name: &str) -> Option<String> {
        self.0.iter().find(|(s, n, _)| *s == space && n == name).map(|(_, _, value)| value.clone())
    }
}

/// What an object is made of.
#[derive(Debug, Clone)]
pub(super) enum Body {
    Mesh { vertices: Vec<DVec3>, triangles: Vec<[u32; 3]> },
    Components(Vec<Reference>),
}

/// An object at a place: a component or a build item.
#[derive(Debug, Clone)]
pub(super) struct Reference {
    /// Another model part of the package (production extension).
    pub(super) path: Option<String>,
    pub(super) object: u32,
    pub(super) transform: DAffine3,
}

#[derive(Debug, Clone)]
pub(super) struct Object {
    pub(super) name: Option<String>,
    pub(super) part_number: Option<String>,
    /// Whether it is printed: `model` and `solidsupport`.
    pub(super) is_part: bool,
    pub(super) body: Body,
    /// Its true shape is in a slice stack.
    pub(super) sliced: bool,
    /// Its true shape is in beams.
    pub(super) lattice: bool,
    pub(super) metadata: Metadata,
}

#[derive(Debug, Clone)]
pub(super) struct Item {
    pub(super) reference: Reference,
    pub(super) part_number: Option<String>,
    /// Slicers mark what is not to be printed.
    pub(super) printable: bool,
    pub(super) metadata: Metadata,
}

/// One model part of the package.
#[derive(Debug, Default)]
pub(super) struct ModelPart {
    pub(super) unit: Unit,
    pub(super) objects: HashMap<u32, Object>,
    pub(super) items: Vec<Item>,
    pub(super) metadata: Metadata,
}

/// What may still be read of each kind.
#[derive(Debug)]
pub(super) struct Budget {
    limits: Limits,
    left: [u64; 6],
    /// Metadata that breaks a rule and is passed over.
    pub(super) odd_metadata: u32,
}

/// Things that are counted.
#[derive(Debug, Clone, Copy)]
pub(super) enum Counted {
    Triangles,
    Vertices,
    Objects,
    Components,
    Items,
    MetadataBytes,
}

impl Budget {
    /// Metadata of all objects and items together; a name and a hash per instance is a quarter of it.
    const METADATA_BYTES_PER_INSTANCE: u64 = 1024;

    pub(super) fn new(limits: &Limits) -> Self {
        let mut budget = Self { limits: limits.clone(), left: [0; 6], odd_metadata: 0 };
        use Counted::*;
        for counted in [Triangles, Vertices, Objects, Components, Items, MetadataBytes] {
            budget.left[counted as usize] = budget.limit(counted);
        }
        budget
    }

    fn limit(&self, counted: Counted) -> u64 {
        match counted {
            Counted::Triangles => self.limits.max_triangles,
            Counted::Vertices => self.limits.max_triangles.saturating_mul(3),
            Counted::Objects | Counted::Components | Counted::Items => self.limits.max_instances,
            Counted::MetadataBytes => self.limits.max_instances.saturating_mul(Self::METADATA_BYTES_PER_INSTANCE),
        }
    }

    pub(super) fn take(&mut self, counted: Counted, amount: u64) -> Result<(), ReadError> {
        let left = &mut self.left[counted as usize];
        match left.checked_sub(amount) {
            Some(rest) => *left = rest,
            None => return Err(self.passed(counted)),
        }
        Ok(())
    }

    fn passed(&self, counted: Counted) -> ReadError {
        let (what, key) = match counted {
            Counted::Triangles => ("it has too many triangles", "max_triangles"),
            Counted::Vertices => ("it has too many vertices", "max_triangles"),
            Counted::Objects => ("it has too many objects", "max_instances"),
            Counted::Components => ("it has too many components", "max_instances"),
            Counted::Items => ("it has too many build items", "max_instances"),
            Counted::MetadataBytes => ("its metadata has too many bytes", "max_instances"),
        };
        ReadError::TooLarge { what: what.to_owned(), limit: self.limit(counted), key }
    }
}
