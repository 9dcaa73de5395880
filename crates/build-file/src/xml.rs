//! XML as 3MF uses it: namespaces resolved, no DTD, no undeclared prefix, no attribute twice, bounded depth.

use std::{io::BufRead, ops::Range};

use quick_xml::{
    Reader,
    events::{BytesRef, BytesStart, Event},
    name::{NamespaceResolver, Prefix, QName, ResolveResult},
};

use super::{ReadError, guard::Guard};

/// Deeper XML is no 3MF.
const MAX_DEPTH: usize = 64;
/// An element of 3MF has a dozen; finding one twice compares each with each.
const MAX_ATTRIBUTES: usize = 64;

/// Our own namespace, for what 3MF has no words for.
pub(super) const NESTD: &str = "https://nestd.org/2026/build";
pub(super) const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
pub(super) const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
/// 3MF before 1.0; meshes, components and items are as in the core.
const CORE_2013: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01";
pub(super) const SLICE: &str = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07";
const LATTICE: &str = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02";
const RELATIONSHIPS: &str = "http://schemas.openxmlformats.org/package/2006/relationships";

/// The namespaces that mean something to us.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Space {
    /// No prefix, no default.
    None,
    Core,
    Production,
    Slice,
    Lattice,
    Relationships,
    Nestd,
    Other,
}

impl Space {
    pub(super) fn of(uri: &str) -> Self {
        match uri {
            CORE | CORE_2013 => Self::Core,
            PRODUCTION => Self::Production,
            SLICE => Self::Slice,
            LATTICE => Self::Lattice,
            RELATIONSHIPS => Self::Relationships,
            NESTD => Self::Nestd,
            _ => Self::Other,
        }
    }
}

/// The elements that mean something to us.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tag {
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
    /// Anything else, to be skipped.
    Other,
}

impl Tag {
    fn of(space: Space, local: &str) -> Self {
        match (space, local) {
            (Space::Core, "vertex") => Self::Vertex,
            (Space::Core, "triangle") => Self::Triangle,
            (Space::Core, "model") => Self::Model,
            (Space::Core, "metadata") => Self::Metadata,
            (Space::Core, "metadatagroup") => Self::MetadataGroup,
            (Space::Core, "resources") => Self::Resources,
            (Space::Core, "object") => Self::Object,
            (Space::Core, "mesh") => Self::Mesh,
            (Space::Core, "vertices") => Self::Vertices,
            (Space::Core, "triangles") => Self::Triangles,
            (Space::Core, "components") => Self::Components,
            (Space::Core, "component") => Self::Component,
            (Space::Core, "build") => Self::Build,
            (Space::Core, "item") => Self::Item,
            (Space::Lattice, "beamlattice") => Self::BeamLattice,
            (Space::Relationships, "Relationship") => Self::Relationship,
            _ => Self::Other,
        }
    }
}

/// One step through the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// An element opens; its attributes can be asked for until the next step.
    Open(Tag),
    /// The innermost open element closes.
    Close,
    /// Character data, in [`Xml::text`].
    Text,
    /// The document is over.
    End,
}

#[derive(Debug, Clone)]
struct Attribute {
    space: Space,
    name: Range<usize>,
    value: Range<usize>,
}

/// A reader of one document.
pub(super) struct Xml<R> {
    reader: Reader<R>,
    names: Names,
    buffer: Vec<u8>,
    /// Names and values of the open element's attributes, or character data.
    text: String,
    attributes: Vec<Attribute>,
    /// The open element was empty, so its close is the next step.
    empty: bool,
    path: String,
    seen_root: bool,
}

/// The namespaces in force. Most elements declare none, so that nothing is looked up for them.
struct Names {
    resolver: NamespaceResolver,
    /// For each open element, whether it declared namespaces, and the default one around it.
    open: Vec<(bool, Space)>,
    default: Space,
}

impl Names {
    fn enter(&mut self, start: &BytesStart<'_>) -> Result<(), String> {
        let declares = start.attributes_raw().contains("xmlns");
        self.open.push((declares, self.default));
        if declares {
            self.resolver.push(start).map_err(|error| error.to_string())?;
            self.default = self.space(None)?;
        }
        Ok(())
    }

    fn leave(&mut self) {
        if let Some((declared, default)) = self.open.pop()
            && declared
        {
            self.resolver.pop();
            self.default = default;
        }
    }

    fn space(&self, prefix: Option<Prefix<'_>>) -> Result<Space, String> {
        match self.resolver.resolve_prefix(prefix, true) {
            ResolveResult::Bound(namespace) => Ok(Space::of(namespace.0)),
            ResolveResult::Unbound => Ok(Space::None),
            ResolveResult::Unknown(prefix) => Err(format!("the prefix `{prefix}` is not declared")),
        }
    }
}

impl<R: BufRead> Xml<Guard<R>> {
    /// `path` names the document in errors.
    pub(super) fn new(guard: Guard<R>, path: &str) -> Self {
        Self {
            reader: Reader::from_reader(guard),
            names: Names { resolver: NamespaceResolver::default(), open: Vec::new(), default: Space::None },
            buffer: Vec::new(),
            text: String::new(),
            attributes: Vec::new(),
            empty: false,
            path: path.to_owned(),
            seen_root: false,
        }
    }

    pub(super) fn unpacked(&mut self) -> u64 {
        self.reader.get_mut().unpacked()
    }

    fn depth(&self) -> usize {
        self.names.open.len()
    }

    /// The next thing of interest; comments and processing instructions are passed over.
    pub(super) fn step(&mut self) -> Result<Step, ReadError> {
        if std::mem::take(&mut self.empty) {
            return self.placed(Step::Close);
        }
        loop {
            self.buffer.clear();
            self.reader.get_mut().start_token();
            let event = match self.reader.read_event_into(&mut self.buffer) {
                Ok(event) => event,
                Err(error) => return Err(self.failed(error)),
            };
            let step = match event {
                Event::Start(ref start) | Event::Empty(ref start) => {
                    self.empty = matches!(event, Event::Empty(_));
                    match open(&mut self.names, start, &mut self.attributes, &mut self.text) {
                        Ok(tag) => Step::Open(tag),
                        Err(reason) => return Err(self.invalid(&reason)),
                    }
                }
                Event::End(_) => Step::Close,
                Event::Eof => Step::End,
                Event::DocType(_) => return Err(self.invalid("it has a DTD, which 3MF forbids")),
                Event::Text(data) => {
                    self.text.clear();
                    self.text.push_str(&data.xml10_content());
                    Step::Text
                }
                Event::CData(data) => {
                    self.text.clear();
                    self.text.push_str(&data.xml10_content());
                    Step::Text
                }
                Event::GeneralRef(reference) => {
                    self.text.clear();
                    match character(&reference) {
                        Some(c) => self.text.push(c),
                        None => return Err(self.invalid("it names an entity that XML does not define")),
                    }
                    Step::Text
                }
                Event::Decl(_) | Event::PI(_) | Event::Comment(_) => continue,
            };
            return self.placed(step);
        }
    }

    /// Checks that a step fits where the document stands. An opening element has entered its names already.
    fn placed(&mut self, step: Step) -> Result<Step, ReadError> {
        let depth = self.depth();
        match step {
            Step::Open(_) if depth == 1 && self.seen_root => return Err(self.invalid("it has two root elements")),
            Step::Open(_) if depth > MAX_DEPTH => return Err(self.invalid("its elements nest too deeply")),
            Step::Open(_) => self.seen_root = true,
            Step::Close => self.names.leave(),
            Step::End if depth > 0 => return Err(self.invalid("it ends within an element")),
            Step::End if !self.seen_root => return Err(self.invalid("it holds no XML")),
            Step::Text if depth == 0 && !self.text.trim().is_empty() => {
                return Err(self.invalid("it has text outside the root element"));
            }
            _ => {}
        }
        Ok(step)
    }

    /// Passes over the open element and all in it.
    pub(super) fn skip(&mut self) -> Result<(), ReadError> {
        let outside = self.depth() - 1;
        while self.depth() > outside {
            self.step()?;
        }
        Ok(())
    }

    /// The text of the open element up to its close; elements in it are passed over.
    pub(super) fn text_inside(&mut self) -> Result<String, ReadError> {
        let outside = self.depth() - 1;
        let mut text = String::new();
        while self.depth() > outside {
            let inside = self.depth() == outside + 1;
            if self.step()? == Step::Text && inside && text.len() < 1 << 16 {
                text.push_str(&self.text);
            }
        }
        Ok(text)
    }

    /// The value of an attribute without a prefix.
    pub(super) fn plain(&self, name: &str) -> Option<&str> {
        self.attribute(Space::None, name)
    }

    /// The value of an attribute of a namespace.
    pub(super) fn attribute(&self, space: Space, name: &str) -> Option<&str> {
        let wanted = |a: &&Attribute| a.space == space && &self.text[a.name.clone()] == name;
        self.attributes.iter().find(wanted).map(|a| &self.text[a.value.clone()])
    }

    /// The namespace that a prefix stands for here, `None` when it is not declared.
    pub(super) fn namespace(&self, prefix: &str) -> Option<String> {
        let name = format!("{prefix}:x");
        match self.names.resolver.resolve_prefix(QName(&name).prefix(), true) {
            ResolveResult::Bound(namespace) => Some(namespace.0.to_owned()),
            _ => None,
        }
    }

    /// An error in this document.
    pub(super) fn invalid(&self, reason: &str) -> ReadError {
        ReadError::threemf(format!("{}: {reason}", self.path))
    }

    fn failed(&mut self, error: quick_xml::Error) -> ReadError {
        if let Some(reason) = self.reader.get_mut().take_tripped() {
            return reason;
        }
        match error {
            quick_xml::Error::Io(io) if io.raw_os_error().is_some() => {
                ReadError::Io(std::io::Error::from_raw_os_error(io.raw_os_error().unwrap_or(0)))
            }
            quick_xml::Error::Io(io) => self.invalid(&format!("its packed data is damaged ({io})")),
            other => self.invalid(&other.to_string()),
        }
    }
}

/// Takes an opening element apart and enters its namespaces.
fn open(
    names: &mut Names,
    start: &BytesStart<'_>,
    attributes: &mut Vec<Attribute>,
    text: &mut String,
) -> Result<Tag, String> {
    names.enter(start)?;
    attributes.clear();
    text.clear();
    // The reader's own check for doubles allocates at every element; ours is below.
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|e| e.to_string())?;
        let (local, prefix) = attribute.key.decompose();
        if attribute.key.as_namespace_binding().is_some() {
            continue;
        }
        let space = match prefix {
            None => Space::None,
            prefix => names.space(prefix)?,
        };
        let name_start = text.len();
        text.push_str(local.into_inner());
        let value_start = text.len();
        if attribute.value.bytes().any(|b| matches!(b, b'&' | b'\t' | b'\r' | b'\n')) {
            let value = attribute.normalized_value(quick_xml::XmlVersion::Implicit1_0).map_err(|e| e.to_string())?;
            text.push_str(&value);
        } else {
            text.push_str(&attribute.value);
        }
        let new = Attribute { space, name: name_start..value_start, value: value_start..text.len() };
        let is_new = |a: &Attribute| text[a.name.clone()] == text[new.name.clone()] && a.space == new.space;
        if space != Space::Other && attributes.iter().any(is_new) {
            return Err(format!("duplicated attribute `{}`", &text[new.name]));
        }
        if attributes.len() == MAX_ATTRIBUTES {
            return Err(format!("an element has more than {MAX_ATTRIBUTES} attributes"));
        }
        attributes.push(new);
    }
    let (local, prefix) = start.name().decompose();
    let space = match prefix {
        None => names.default,
        prefix => names.space(prefix)?,
    };
    Ok(Tag::of(space, local.into_inner()))
}

/// What a reference stands for: a number or one of the five names that XML knows without a DTD.
fn character(reference: &BytesRef<'_>) -> Option<char> {
    if reference.is_char_ref() {
        return reference.resolve_char_ref().ok().flatten();
    }
    match reference.xml10_content().as_ref() {
        "amp" => Some('&'),
        "lt" => Some('<'),
        "gt" => Some('>'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => None,
    }
}
