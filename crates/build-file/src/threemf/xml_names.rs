//! Names of elements and namespaces that the readers know.

/// This project's namespace, for metadata that 3MF does not define.
pub(crate) const NESTD: &str = "https://nestd.org/2026/build";
pub(crate) const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
pub(crate) const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
/// 3MF before 1.0; meshes, components and items are as in the core.
const CORE_2013: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01";
pub(super) const SLICE: &str = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07";
const LATTICE: &str = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02";
/// Settings in a project of Cura.
const CURA: &str = "http://software.ultimaker.com/xml/cura/3mf/2015/10";
const RELATIONSHIPS: &str = "http://schemas.openxmlformats.org/package/2006/relationships";

/// The namespaces that the reader knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum XmlNamespace {
    /// No prefix, no default.
    None,
    Core,
    Production,
    Slice,
    Lattice,
    Relationships,
    Nestd,
    Cura,
    Other,
}

impl XmlNamespace {
    pub(super) fn from_uri(uri: &str) -> Self {
        match uri {
            CORE | CORE_2013 => Self::Core,
            PRODUCTION => Self::Production,
            SLICE => Self::Slice,
            LATTICE => Self::Lattice,
            RELATIONSHIPS => Self::Relationships,
            NESTD => Self::Nestd,
            CURA => Self::Cura,
            _ => Self::Other,
        }
    }
}

/// The elements that the reader knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ElementTag {
    Model,
    Metadata,
    MetadataGroup,
    Resources,
    Object,
    Mesh,
    Vertices,
    Vertex,
    Triangles,
    Triangle,
    Components,
    Component,
    Build,
    Item,
    BeamLattice,
    Relationship,
    /// The settings of a slicer's project: an object.
    ConfigObject,
    /// A volume of the object: a range of its triangles.
    ConfigVolume,
    /// A volume of the object: one of its components.
    ConfigPart,
    /// A plate with the objects that stand on it.
    ConfigPlate,
    /// An object on the plate.
    ConfigInstance,
    /// A key with its value.
    ConfigEntry,
    /// Anything else, to be skipped.
    Other,
}

impl ElementTag {
    pub(super) fn from_name(space: XmlNamespace, local: &str) -> Self {
        match (space, local) {
            (XmlNamespace::Core, "vertex") => Self::Vertex,
            (XmlNamespace::Core, "triangle") => Self::Triangle,
            (XmlNamespace::Core, "model") => Self::Model,
            (XmlNamespace::Core, "metadata") => Self::Metadata,
            (XmlNamespace::Core, "metadatagroup") => Self::MetadataGroup,
            (XmlNamespace::Core, "resources") => Self::Resources,
            (XmlNamespace::Core, "object") => Self::Object,
            (XmlNamespace::Core, "mesh") => Self::Mesh,
            (XmlNamespace::Core, "vertices") => Self::Vertices,
            (XmlNamespace::Core, "triangles") => Self::Triangles,
            (XmlNamespace::Core, "components") => Self::Components,
            (XmlNamespace::Core, "component") => Self::Component,
            (XmlNamespace::Core, "build") => Self::Build,
            (XmlNamespace::Core, "item") => Self::Item,
            (XmlNamespace::Lattice, "beamlattice") => Self::BeamLattice,
            (XmlNamespace::Relationships, "Relationship") => Self::Relationship,
            (XmlNamespace::None, "object") => Self::ConfigObject,
            (XmlNamespace::None, "volume") => Self::ConfigVolume,
            (XmlNamespace::None, "part") => Self::ConfigPart,
            (XmlNamespace::None, "plate") => Self::ConfigPlate,
            (XmlNamespace::None, "model_instance") => Self::ConfigInstance,
            (XmlNamespace::None, "metadata") => Self::ConfigEntry,
            _ => Self::Other,
        }
    }
}
