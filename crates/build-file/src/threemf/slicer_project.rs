//! What a slicer writes beside the model of its project (`Metadata/*.config`): names, plates, and which volumes of an
//! object are no model volumes. PrusaSlicer and SuperSlicer name ranges of an object's triangles (`volume`), Bambu Studio
//! and OrcaSlicer its components (`part`). The model itself holds all of them as solids. Cura writes into the model instead what a mesh
//! of it is for ([`is_helper_mesh`]).

use std::{
    collections::{BTreeSet, HashMap},
    io::BufRead,
    ops::Range,
};

use super::{
    model::{CountedElement, ModelBudget, ModelMetadata},
    package::PackageReader,
    unpack_guard::UnpackGuard,
    xml::{DocumentStep, XmlReader},
    xml_names::ElementTag,
};
use crate::{FileReadError, escape_invisible};

/// Whether an entry of a package holds settings of objects: `Slic3r_PE_model.config`, as PrusaSlicer calls it, and others of the same
/// kind by the programs made of it; Bambu Studio's `model_settings.config`.
fn is_settings(path: &str) -> bool {
    let name = path.strip_prefix("metadata/");
    name.is_some_and(|name| name.ends_with("_model.config") || name == "model_settings.config")
}

/// More plates or names are not listed.
const MAX_LISTED: usize = 20;
/// No object of a project has more volumes.
const MAX_VOLUMES: usize = 1000;

/// Settings of Cura that make of a mesh no shape, but a place with other settings, or one without supports.
const HELPER_MESHES: [&str; 4] = ["infill_mesh", "cutting_mesh", "anti_overhang_mesh", "support_mesh"];

/// Whether metadata of an object say that its mesh only helps to print others, as Cura writes it (`cura:infill_mesh` = True).
pub(super) fn is_helper_mesh(metadata: &ModelMetadata) -> bool {
    let is_true = |value: &str| matches!(value.trim(), "1") || value.trim().eq_ignore_ascii_case("true");
    HELPER_MESHES.iter().any(|name| metadata.slicer_value(name).is_some_and(is_true))
}

type SettingsReader<R> = XmlReader<UnpackGuard<R>>;

/// What a volume of an object is for.
#[derive(Debug, Clone, PartialEq, Eq)]
enum VolumeKind {
    Model,
    /// To be cut out of the model volumes.
    Negative,
    /// Changes settings where it is, no shape; with what it is called.
    Helper(&'static str),
    Unknown(String),
}

impl VolumeKind {
    fn from_word(word: &str) -> Self {
        match word {
            "ModelPart" | "normal_part" | "0" => Self::Model,
            "NegativeVolume" | "negative_part" => Self::Negative,
            "ParameterModifier" | "modifier_part" | "1" => Self::Helper("modifier"),
            "SupportBlocker" | "support_blocker" => Self::Helper("support blocker"),
            "SupportEnforcer" | "support_enforcer" => Self::Helper("support enforcer"),
            other => Self::Unknown(other.to_owned()),
        }
    }
}

/// Which triangles of an object a volume consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum VolumePlace {
    /// Those of its mesh from the first to the last.
    Triangles(u32, u32),
    /// Those of the component that refers to this object.
    Component(u32),
}

/// A volume of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ProjectVolume {
    place: VolumePlace,
    kind: VolumeKind,
    name: String,
}

impl ProjectVolume {
    /// Whether it is a model volume. Of what is left out, `left_out` takes the name.
    pub(super) fn is_model(&self, object: &str, left_out: &mut BTreeSet<String>) -> Result<bool, FileReadError> {
        let name = match self.name.as_str() {
            "" => String::new(),
            name => format!(" \"{}\"", escape_invisible(name)),
        };
        match &self.kind {
            VolumeKind::Model => Ok(true),
            VolumeKind::Helper(called) => {
                left_out.insert(format!("{called}{name}"));
                Ok(false)
            }
            VolumeKind::Negative => Err(FileReadError::Unsupported {
                what: format!("{object} has the negative volume{name}: it is to be cut out, and nestd does not cut"),
                remedy: "Cut it out in the slicer (mesh boolean; its export of the object as STL cuts, too), look at the \
                         result, and drop that.",
            }),
            VolumeKind::Unknown(word) => Err(FileReadError::Unsupported {
                what: format!("{object} has the volume{name} of the kind {word:?}, which nestd does not know"),
                remedy: "Export what is to be printed from the slicer as STL, and drop that.",
            }),
        }
    }
}

#[derive(Debug, Default)]
struct ProjectObject {
    name: String,
    volumes: Vec<ProjectVolume>,
}

#[derive(Debug, Default)]
struct ProjectPlate {
    number: String,
    name: String,
    /// Objects, each with the number of its build item among those of the object.
    instances: Vec<(u32, u32)>,
}

/// The settings of a project; empty for a package without them.
#[derive(Debug, Default)]
pub(crate) struct SlicerProject {
    objects: HashMap<u32, ProjectObject>,
    plates: Vec<ProjectPlate>,
}

impl SlicerProject {
    /// Reads all settings of objects in the package.
    pub(crate) fn read_package(package: &mut PackageReader, budget: &mut ModelBudget) -> Result<Self, FileReadError> {
        let mut project = Self::default();
        for entry in package.entries_that(is_settings) {
            package.parse_entry(&entry, |xml| project.parse_settings(xml, budget))?;
        }
        Ok(project)
    }

    /// The name of an object of the start part; empty = none.
    pub(super) fn object_name(&self, object: u32) -> &str {
        self.objects.get(&object).map_or("", |object| object.name.as_str())
    }

    /// The volume that a component of an object is; `at` counts the components. Two components may refer to the same
    /// object: volumes are in the same order.
    pub(super) fn volume_of_component(&self, object: u32, at: usize, component: u32) -> Option<&ProjectVolume> {
        let volumes = &self.objects.get(&object)?.volumes;
        let is_it = |volume: &&ProjectVolume| volume.place == VolumePlace::Component(component);
        let found = volumes.get(at).filter(is_it).or_else(|| {
            let helper = volumes.iter().filter(is_it).find(|volume| volume.kind != VolumeKind::Model);
            helper.or_else(|| volumes.iter().find(is_it))
        })?;
        Some(found)
    }

    /// The triangles of an object's mesh that are no model volumes, in order; ranges may overlap.
    pub(super) fn left_out_triangles(
        &self,
        (object, shown): (u32, &str),
        triangles: usize,
        left_out: &mut BTreeSet<String>,
    ) -> Result<Vec<Range<usize>>, FileReadError> {
        let mut ranges = Vec::new();
        for volume in self.objects.get(&object).map_or(&[][..], |object| &object.volumes) {
            let range = match volume.place {
                VolumePlace::Triangles(first, last) => first as usize..last as usize + 1,
                VolumePlace::Component(id) if id == object => 0..triangles,
                VolumePlace::Component(_) => continue,
            };
            if volume.is_model(shown, left_out)? {
                continue;
            }
            if range.is_empty() || range.end > triangles {
                let (first, last) = (range.start, range.end - 1);
                let reason = format!("a volume of {shown} is said to be triangles {first} to {last} of {triangles}");
                return Err(FileReadError::invalid_threemf(reason));
            }
            ranges.push(range);
        }
        ranges.sort_by_key(|range| range.start);
        Ok(ranges)
    }

    /// Tells of several plates, and of build items on none: a slicer prints one plate at a time. `items` are the objects of
    /// the build items, and `shown` their names.
    pub(super) fn plates_warning(&self, items: &[u32], shown: impl Fn(u32) -> String) -> Option<String> {
        if self.plates.is_empty() {
            return None;
        }
        let mut counts = HashMap::<u32, u32>::new();
        let instances = items.iter().map(|&object| {
            let count = counts.entry(object).or_insert(0);
            *count += 1;
            (object, *count - 1)
        });
        let on_plates: BTreeSet<_> = self.plates.iter().flat_map(|plate| &plate.instances).copied().collect();
        let beside: BTreeSet<String> =
            instances.filter(|instance| !on_plates.contains(instance)).map(|(object, _)| shown(object)).collect();
        let mut told: Vec<String> = (self.plates.iter().take(MAX_LISTED))
            .map(|plate| {
                let name = match plate.name.as_str() {
                    "" => String::new(),
                    name => format!(" \"{}\"", escape_invisible(name)),
                };
                let objects: BTreeSet<String> = plate.instances.iter().map(|&(object, _)| shown(object)).collect();
                format!("plate {}{name}: {}", plate.number, listed(&objects))
            })
            .collect();
        if !beside.is_empty() {
            told.push(format!("on no plate: {}", listed(&beside)));
        } else if self.plates.len() < 2 {
            return None;
        }
        let plates = crate::format_count(self.plates.len(), "plate", "plates");
        Some(format!("the project has {plates}, and all that is in it is taken ({})", told.join("; ")))
    }

    fn parse_settings<R: BufRead>(
        &mut self,
        xml: &mut SettingsReader<R>,
        budget: &mut ModelBudget,
    ) -> Result<(), FileReadError> {
        xml.allow_undeclared_prefixes();
        loop {
            match xml.next_step()? {
                DocumentStep::Open(ElementTag::ConfigObject) => {
                    let object = self.objects.entry(number(xml, "id")?).or_default();
                    parse_object(xml, budget, object)?;
                }
                DocumentStep::Open(ElementTag::ConfigPlate) => {
                    budget.take_amount(CountedElement::Items, 1)?;
                    self.plates.push(parse_plate(xml, budget)?);
                }
                DocumentStep::End => return Ok(()),
                _ => {}
            }
        }
    }
}

/// Names in one line; the first of very many.
pub(super) fn listed(names: &BTreeSet<String>) -> String {
    let mut text = names.iter().take(MAX_LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > MAX_LISTED {
        text.push_str(&format!(" and {} more", names.len() - MAX_LISTED));
    }
    text
}

fn parse_object<R: BufRead>(
    xml: &mut SettingsReader<R>,
    budget: &mut ModelBudget,
    object: &mut ProjectObject,
) -> Result<(), FileReadError> {
    loop {
        let place = match xml.next_step()? {
            DocumentStep::Open(ElementTag::ConfigEntry) => {
                let name = entry_value(xml, budget, "name")?;
                if let Some(name) = name.filter(|_| object.name.is_empty()) {
                    object.name = name;
                }
                xml.skip_element()?;
                continue;
            }
            DocumentStep::Open(ElementTag::ConfigVolume) => {
                VolumePlace::Triangles(number(xml, "firstid")?, number(xml, "lastid")?)
            }
            DocumentStep::Open(ElementTag::ConfigPart) => VolumePlace::Component(number(xml, "id")?),
            DocumentStep::Open(_) => {
                xml.skip_element()?;
                continue;
            }
            DocumentStep::Close => return Ok(()),
            _ => continue,
        };
        if object.volumes.len() == MAX_VOLUMES {
            return Err(xml.invalid_document(&format!("an object has more than {MAX_VOLUMES} volumes")));
        }
        budget.take_amount(CountedElement::Components, 1)?;
        let volume = parse_volume(xml, budget, place)?;
        if !object.volumes.contains(&volume) || matches!(place, VolumePlace::Component(_)) {
            object.volumes.push(volume);
        }
    }
}

fn parse_volume<R: BufRead>(
    xml: &mut SettingsReader<R>,
    budget: &mut ModelBudget,
    place: VolumePlace,
) -> Result<ProjectVolume, FileReadError> {
    let kind = xml.plain_attribute("subtype").map_or(VolumeKind::Model, VolumeKind::from_word);
    let mut volume = ProjectVolume { place, kind, name: String::new() };
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::ConfigEntry) => {
                if let Some(name) = entry_value(xml, budget, "name")? {
                    volume.name = name;
                }
                // The older word comes first, and the newer one overrides it.
                let kind = entry_value(xml, budget, "volume_type")?.or(entry_value(xml, budget, "modifier")?);
                if let Some(kind) = kind {
                    volume.kind = VolumeKind::from_word(&kind);
                }
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(volume),
            _ => {}
        }
    }
}

fn parse_plate<R: BufRead>(
    xml: &mut SettingsReader<R>,
    budget: &mut ModelBudget,
) -> Result<ProjectPlate, FileReadError> {
    let mut plate = ProjectPlate::default();
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::ConfigEntry) => {
                plate.number = entry_value(xml, budget, "plater_id")?.unwrap_or(plate.number);
                plate.name = entry_value(xml, budget, "plater_name")?.unwrap_or(plate.name);
                xml.skip_element()?;
            }
            DocumentStep::Open(ElementTag::ConfigInstance) => {
                budget.take_amount(CountedElement::Items, 1)?;
                plate.instances.extend(parse_instance(xml, budget)?);
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => return Ok(plate),
            _ => {}
        }
    }
}

/// An object on a plate, and the number of its build item; `None` if one of them is no number.
fn parse_instance<R: BufRead>(
    xml: &mut SettingsReader<R>,
    budget: &mut ModelBudget,
) -> Result<Option<(u32, u32)>, FileReadError> {
    let (mut object, mut instance) = (None, None);
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::ConfigEntry) => {
                object = entry_value(xml, budget, "object_id")?.or(object);
                instance = entry_value(xml, budget, "instance_id")?.or(instance);
                xml.skip_element()?;
            }
            DocumentStep::Open(_) => xml.skip_element()?,
            DocumentStep::Close => {
                let parsed = |text: Option<String>| text.and_then(|text| text.trim().parse().ok());
                return Ok(parsed(object).zip(parsed(instance)));
            }
            _ => {}
        }
    }
}

/// The value of the open entry, if this is its key.
fn entry_value<R: BufRead>(
    xml: &SettingsReader<R>,
    budget: &mut ModelBudget,
    key: &str,
) -> Result<Option<String>, FileReadError> {
    if xml.plain_attribute("key") != Some(key) {
        return Ok(None);
    }
    let value = xml.plain_attribute("value").unwrap_or_default().to_owned();
    budget.take_amount(CountedElement::MetadataBytes, value.len() as u64)?;
    Ok(Some(value))
}

/// A number in an attribute of the open element.
fn number<R: BufRead>(xml: &SettingsReader<R>, name: &str) -> Result<u32, FileReadError> {
    let text = xml.plain_attribute(name).unwrap_or_default();
    text.trim().parse().map_err(|_| xml.invalid_document(&format!("{name}={text:?} is no number")))
}
