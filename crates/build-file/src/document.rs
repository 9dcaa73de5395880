//! A whole 3MF package: the model part that it starts from and those that it names.

use std::collections::{BTreeSet, HashMap};

use super::{
    Limits, ReadError, counted,
    model::{Body, Budget, ModelPart, Object, Reference},
    model_parse,
    package::Package,
};

/// Names an object throughout the package.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct ObjectKey {
    part: usize,
    id: u32,
}

/// A whole package: the part that it starts from and those that it names.
#[derive(Debug)]
pub(super) struct Document {
    parts: Vec<ModelPart>,
    /// Lower-case path -> part.
    paths: HashMap<String, usize>,
    /// What a person should know about the package.
    pub(super) warnings: Vec<String>,
}

impl Document {
    /// Reads the starting part and every part that items and components name.
    pub(super) fn read(file: &std::path::Path, limits: &Limits) -> Result<Self, ReadError> {
        let mut package = Package::open(file, limits)?;
        let mut budget = Budget::new(limits);
        let (start, starts) = package.start_part()?;
        let mut document = Self { parts: Vec::new(), paths: HashMap::new(), warnings: Vec::new() };
        if starts > 1 {
            document.warnings.push(format!("the package names {starts} 3D models to start from; only {start} is read"));
        }
        let mut wanted = vec![start];
        while let Some(path) = wanted.pop() {
            let key = path_key(&path);
            if document.paths.contains_key(&key) {
                continue;
            }
            let part = package.parse(&path, |xml| model_parse::model(xml, &mut budget))?;
            wanted.extend(named_paths(&part));
            document.paths.insert(key, document.parts.len());
            document.parts.push(part);
        }
        if budget.odd_metadata > 0 {
            let odd = counted(budget.odd_metadata, "metadata entry breaks", "metadata entries break");
            let why = "the rules of 3MF (a name that is double, missing or not declared): ignored";
            document.warnings.push(format!("{odd} {why}"));
        }
        let unit = document.start().unit;
        if document.parts.iter().any(|part| part.unit != unit && !part.objects.is_empty()) {
            return Err(ReadError::threemf("its model parts are in different units"));
        }
        Ok(document)
    }

    /// The part that the package starts from; its build is the build.
    pub(super) fn start(&self) -> &ModelPart {
        &self.parts[0]
    }

    /// The object that a reference in the part of `from` names.
    pub(super) fn key(&self, reference: &Reference, from: Option<ObjectKey>) -> Result<ObjectKey, ReadError> {
        let part = match &reference.path {
            Some(path) => self.paths.get(&path_key(path)).copied().unwrap_or(0),
            None => from.map_or(0, |key| key.part),
        };
        let key = ObjectKey { part, id: reference.object };
        if !self.parts[part].objects.contains_key(&key.id) {
            return Err(ReadError::threemf(format!("there is no object {}", key.id)));
        }
        Ok(key)
    }

    /// An object by a key that [`Document::key`] gave.
    pub(super) fn object(&self, key: ObjectKey) -> &Object {
        &self.parts[key.part].objects[&key.id]
    }
}

impl ObjectKey {
    pub(super) fn id(self) -> u32 {
        self.id
    }
}

fn path_key(path: &str) -> String {
    path.trim_start_matches('/').to_ascii_lowercase()
}

fn named_paths(part: &ModelPart) -> Vec<String> {
    let components = part.objects.values().flat_map(|object| match &object.body {
        Body::Components(components) => components.as_slice(),
        Body::Mesh { .. } => &[],
    });
    let items = part.items.iter().map(|item| &item.reference);
    let paths: BTreeSet<String> = components.chain(items).filter_map(|r| r.path.clone()).collect();
    paths.into_iter().collect()
}
