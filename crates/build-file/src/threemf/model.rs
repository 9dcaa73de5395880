//! The contents of one model part of a 3MF package: objects, components and build items in the file's own unit.
//! `BuildFileItem` is this project's item of a build file; `Item` here is the `<item>` element of 3MF.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use super::xml_names::XmlNamespace;
use crate::{FileReadError, LengthUnit, ReadLimits};

/// Metadata without a namespace, and in the namespaces of this project and of Cura.
#[derive(Debug, Clone, Default)]
pub(crate) struct ModelMetadata(pub(crate) Vec<(XmlNamespace, String, String)>);

impl ModelMetadata {
    /// The value of a name in this project's namespace.
    pub(crate) fn nestd_value(&self, name: &str) -> Option<String> {
        self.value_in(XmlNamespace::Nestd, name)
    }

    /// The value of one of the nine names of the specification.
    pub(crate) fn standard_value(&self, name: &str) -> Option<String> {
        self.value_in(XmlNamespace::None, name)
    }

    /// The value of a setting of Cura, which its older versions wrote without a namespace.
    pub(crate) fn slicer_value(&self, name: &str) -> Option<&str> {
        let is_it = |(space, known, _): &&(XmlNamespace, String, String)| {
            matches!(space, XmlNamespace::Cura | XmlNamespace::None) && known == name
        };
        self.0.iter().find(is_it).map(|(_, _, value)| value.as_str())
    }

    fn value_in(&self, space: XmlNamespace, name: &str) -> Option<String> {
        self.0.iter().find(|(s, n, _)| *s == space && n == name).map(|(_, _, value)| value.clone())
    }
}

/// The contents of an object.
#[derive(Debug, Clone)]
pub(crate) enum ObjectBody {
    Mesh { vertices: Vec<DVec3>, triangles: Vec<[u32; 3]> },
    Components(Vec<ObjectReference>),
}

/// A reference to an object with a transform: a component or a build item.
#[derive(Debug, Clone)]
pub(crate) struct ObjectReference {
    /// Another model part of the package (production extension).
    pub(crate) path: Option<String>,
    pub(crate) object: u32,
    pub(crate) transform: DAffine3,
}

/// What an object is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ObjectKind {
    /// It is printed: `model`.
    Part,
    /// It helps to print a part: `support`, `solidsupport`, `surface`, and what Cura calls a mesh with other settings.
    Support,
    /// It must not be printed, and the model does not say what it is for: `other`.
    Other,
}

#[derive(Debug, Clone)]
pub(crate) struct ModelObject {
    pub(crate) name: Option<String>,
    pub(crate) part_number: Option<String>,
    pub(crate) kind: ObjectKind,
    pub(crate) body: ObjectBody,
    /// Its true shape is in a slice stack.
    pub(super) sliced: bool,
    /// Its true shape is in beams.
    pub(super) lattice: bool,
    pub(crate) metadata: ModelMetadata,
}

#[derive(Debug, Clone)]
pub(crate) struct ModelItem {
    pub(crate) reference: ObjectReference,
    pub(crate) part_number: Option<String>,
    /// False if a slicer marked the item as not to be printed.
    pub(crate) printable: bool,
    pub(crate) metadata: ModelMetadata,
}

/// One model part of the package.
#[derive(Debug, Default)]
pub(crate) struct ModelPart {
    pub(crate) unit: LengthUnit,
    pub(crate) objects: HashMap<u32, ModelObject>,
    pub(crate) items: Vec<ModelItem>,
    pub(crate) metadata: ModelMetadata,
}

/// The remaining budget of each kind of element.
#[derive(Debug)]
pub(crate) struct ModelBudget {
    limits: ReadLimits,
    left: [u64; 6],
    /// Number of ignored metadata entries that break a rule.
    pub(super) odd_metadata: u32,
}

/// Kinds of elements that are counted.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CountedElement {
    Triangles,
    Vertices,
    Objects,
    Components,
    Items,
    MetadataBytes,
}

impl ModelBudget {
    /// Metadata bytes per instance, of all objects and items together. A name and a hash per instance take a quarter of
    /// it.
    const METADATA_BYTES_PER_INSTANCE: u64 = 1024;

    pub(crate) fn new(limits: &ReadLimits) -> Self {
        let mut budget = Self { limits: limits.clone(), left: [0; 6], odd_metadata: 0 };
        use CountedElement::*;
        for counted in [Triangles, Vertices, Objects, Components, Items, MetadataBytes] {
            budget.left[counted as usize] = budget.limit(counted);
        }
        budget
    }

    fn limit(&self, counted: CountedElement) -> u64 {
        match counted {
            CountedElement::Triangles => self.limits.max_triangles,
            CountedElement::Vertices => self.limits.max_triangles.saturating_mul(3),
            CountedElement::Objects | CountedElement::Components | CountedElement::Items => self.limits.max_instances,
            CountedElement::MetadataBytes => {
                self.limits.max_instances.saturating_mul(Self::METADATA_BYTES_PER_INSTANCE)
            }
        }
    }

    pub(super) fn take_amount(&mut self, counted: CountedElement, amount: u64) -> Result<(), FileReadError> {
        let left = &mut self.left[counted as usize];
        match left.checked_sub(amount) {
            Some(rest) => *left = rest,
            None => return Err(self.limit_error(counted)),
        }
        Ok(())
    }

    fn limit_error(&self, counted: CountedElement) -> FileReadError {
        let (what, key) = match counted {
            CountedElement::Triangles => ("it has too many triangles", "max_triangles"),
            CountedElement::Vertices => ("it has too many vertices", "max_triangles"),
            CountedElement::Objects => ("it has too many objects", "max_instances"),
            CountedElement::Components => ("it has too many components", "max_instances"),
            CountedElement::Items => ("it has too many build items", "max_instances"),
            CountedElement::MetadataBytes => ("its metadata has too many bytes", "max_instances"),
        };
        FileReadError::TooLarge { what: what.to_owned(), limit: self.limit(counted), key }
    }
}
