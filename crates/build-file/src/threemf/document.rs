//! A whole 3MF package: the start part and the model parts that it refers to.

use std::collections::{BTreeSet, HashMap};

use super::{
    model::{ModelBudget, ModelMetadata, ModelObject, ModelPart, ObjectBody, ObjectReference},
    model_head, model_parse,
    package::PackageReader,
    slicer_project::SlicerProject,
};
use crate::{FileReadError, ReadLimits, escape_invisible, format_count};

/// Identifies an object within the package.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct ObjectKey {
    part: usize,
    id: u32,
}

/// A whole package: the start part and the model parts that it refers to.
#[derive(Debug)]
pub(crate) struct ModelDocument {
    parts: Vec<ModelPart>,
    /// Lower-case path -> part.
    paths: HashMap<String, usize>,
    /// What a slicer says of the objects of the start part.
    pub(super) project: SlicerProject,
    /// Warnings about the package, for people.
    pub(crate) warnings: Vec<String>,
}

impl ModelDocument {
    /// Reads the start part and every part that items and components refer to.
    pub(crate) fn read_package(file: &std::path::Path, limits: &ReadLimits) -> Result<Self, FileReadError> {
        let mut package = PackageReader::open(file, limits)?;
        let mut budget = ModelBudget::new(limits);
        let (start, starts) = package.start_part_path()?;
        let project = SlicerProject::read_package(&mut package, &mut budget)?;
        let mut document = Self { parts: Vec::new(), paths: HashMap::new(), project, warnings: Vec::new() };
        if starts > 1 {
            document.warnings.push(format!("the package names {starts} 3D models to start from; only {start} is read"));
        }
        let mut wanted = vec![start];
        while let Some(path) = wanted.pop() {
            let key = path_key(&path);
            if document.paths.contains_key(&key) {
                continue;
            }
            let part = package.parse_entry(&path, |xml| model_parse::parse_model(xml, &mut budget))?;
            wanted.extend(referenced_paths(&part));
            document.paths.insert(key, document.parts.len());
            document.parts.push(part);
        }
        if budget.odd_metadata > 0 {
            let odd = format_count(budget.odd_metadata, "metadata entry breaks", "metadata entries break");
            let why = "the rules of 3MF (a name that is duplicate, missing or undeclared): ignored";
            document.warnings.push(format!("{odd} {why}"));
        }
        let unit = document.start_part().unit;
        if document.parts.iter().any(|part| part.unit != unit && !part.objects.is_empty()) {
            return Err(FileReadError::invalid_threemf("its model parts are in different units"));
        }
        Ok(document)
    }

    /// The start part of the package; its build is the build of the package.
    pub(crate) fn start_part(&self) -> &ModelPart {
        &self.parts[0]
    }

    /// The object that a reference, found in the part of `from`, refers to.
    pub(crate) fn resolve_reference(
        &self,
        reference: &ObjectReference,
        from: Option<ObjectKey>,
    ) -> Result<ObjectKey, FileReadError> {
        let part = match &reference.path {
            Some(path) => self.paths.get(&path_key(path)).copied().unwrap_or(0),
            None => from.map_or(0, |key| key.part),
        };
        let key = ObjectKey { part, id: reference.object };
        if !self.parts[part].objects.contains_key(&key.id) {
            return Err(FileReadError::invalid_threemf(format!("there is no object {}", key.id)));
        }
        Ok(key)
    }

    /// The name of an object, as the model or the slicer's project has it; empty = none.
    pub(super) fn object_name(&self, key: ObjectKey) -> &str {
        let own = self.object(key).name.as_deref().unwrap_or_default().trim();
        let in_project = if key.is_in_start_part() { self.project.object_name(key.id).trim() } else { "" };
        if own.is_empty() { in_project } else { own }
    }

    /// An object for people.
    pub(super) fn shown_object(&self, key: ObjectKey) -> String {
        match self.object_name(key) {
            "" => format!("object {}", key.id),
            name => format!("\"{}\"", escape_invisible(name)),
        }
    }

    /// Returns the object of a key from [`ModelDocument::key`].
    pub(crate) fn object(&self, key: ObjectKey) -> &ModelObject {
        &self.parts[key.part].objects[&key.id]
    }
}

impl ObjectKey {
    /// Whether it is in the start part, whose objects a slicer's project describes.
    pub(super) fn is_in_start_part(self) -> bool {
        self.part == 0
    }

    pub(crate) fn id(self) -> u32 {
        self.id
    }
}

fn path_key(path: &str) -> String {
    path.trim_start_matches('/').to_ascii_lowercase()
}

fn referenced_paths(part: &ModelPart) -> Vec<String> {
    let components = part.objects.values().flat_map(|object| match &object.body {
        ObjectBody::Components(components) => components.as_slice(),
        ObjectBody::Mesh { .. } => &[],
    });
    let items = part.items.iter().map(|item| &item.reference);
    let paths: BTreeSet<String> = components.chain(items).filter_map(|r| r.path.clone()).collect();
    paths.into_iter().collect()
}

/// The metadata of a package that stand before everything else. What follows them may be damaged.
pub(crate) fn read_leading_metadata(
    file: &std::path::Path,
    limits: &ReadLimits,
) -> Result<ModelMetadata, FileReadError> {
    let mut package = PackageReader::open(file, limits)?;
    let mut budget = ModelBudget::new(limits);
    let (start, _) = package.start_part_path()?;
    package.parse_entry(&start, |xml| model_head::parse_leading_metadata(xml, &mut budget))
}
