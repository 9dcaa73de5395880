//! Reads XML as 3MF uses it: resolves namespaces, refuses DTDs, undeclared prefixes and duplicate attributes, limits
//! depth.

use std::{io::BufRead, ops::Range};

use quick_xml::{
    Reader,
    events::{BytesRef, BytesStart, Event},
    name::{NamespaceResolver, Prefix, QName, ResolveResult},
};

use super::{
    plain_lists::PlainElement,
    unpack_guard::UnpackGuard,
    xml_names::{ElementTag, XmlNamespace},
};
use crate::FileReadError;

/// Deeper XML is not a 3MF.
const MAX_DEPTH: usize = 64;
/// A 3MF element has about a dozen. Finding duplicates compares each attribute with each.
const MAX_ATTRIBUTES: usize = 64;

/// One event of the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DocumentStep {
    /// An element opens; its attributes are available until the next step.
    Open(ElementTag),
    /// The innermost open element closes.
    Close,
    /// Character data, in [`XmlReader::text`].
    Text,
    /// The document ends.
    End,
}

#[derive(Debug, Clone)]
struct XmlAttribute {
    space: XmlNamespace,
    name: Range<usize>,
    value: Range<usize>,
}

/// A reader of one document.
pub(crate) struct XmlReader<R> {
    reader: Reader<R>,
    names: NamespaceScope,
    buffer: Vec<u8>,
    /// Names and values of the open element's attributes, or character data.
    text: String,
    attributes: Vec<XmlAttribute>,
    /// The open element is empty, so the next step closes it.
    empty: bool,
    /// The last event was a tag, so that the parser expects text or another tag.
    is_after_tag: bool,
    path: String,
    seen_root: bool,
}

/// The namespaces in scope. Most elements declare none, so nothing is looked up for them.
struct NamespaceScope {
    resolver: NamespaceResolver,
    /// For each open element, whether it declared namespaces, and the default namespace outside it.
    open: Vec<(bool, XmlNamespace)>,
    default: XmlNamespace,
    /// Whether prefixes need no declaration.
    is_lenient: bool,
}

impl NamespaceScope {
    fn enter_element(&mut self, start: &BytesStart<'_>) -> Result<(), String> {
        let declares = start.attributes_raw().contains("xmlns");
        self.open.push((declares, self.default));
        if declares {
            self.resolver.push(start).map_err(|error| error.to_string())?;
            self.default = self.resolve_namespace(None)?;
        }
        Ok(())
    }

    fn leave_element(&mut self) {
        if let Some((declared, default)) = self.open.pop()
            && declared
        {
            self.resolver.pop();
            self.default = default;
        }
    }

    fn resolve_namespace(&self, prefix: Option<Prefix<'_>>) -> Result<XmlNamespace, String> {
        match self.resolver.resolve_prefix(prefix, true) {
            ResolveResult::Bound(namespace) => Ok(XmlNamespace::from_uri(namespace.0)),
            ResolveResult::Unbound => Ok(XmlNamespace::None),
            ResolveResult::Unknown(_) if self.is_lenient => Ok(XmlNamespace::Other),
            ResolveResult::Unknown(prefix) => Err(format!("the prefix `{prefix}` is not declared")),
        }
    }
}

impl<R: BufRead> XmlReader<UnpackGuard<R>> {
    /// `path` names the document in errors.
    pub(crate) fn new(guard: UnpackGuard<R>, path: &str) -> Self {
        Self {
            reader: Reader::from_reader(guard),
            names: NamespaceScope {
                resolver: NamespaceResolver::default(),
                open: Vec::new(),
                default: XmlNamespace::None,
                is_lenient: false,
            },
            buffer: Vec::new(),
            text: String::new(),
            attributes: Vec::new(),
            empty: false,
            is_after_tag: false,
            path: path.to_owned(),
            seen_root: false,
        }
    }

    /// Takes prefixes that are not declared for those of other namespaces: slicers write their own ones so.
    pub(super) fn allow_undeclared_prefixes(&mut self) {
        self.names.is_lenient = true;
    }

    pub(super) fn unpacked_bytes(&mut self) -> u64 {
        self.reader.get_mut().unpacked_bytes()
    }

    fn depth(&self) -> usize {
        self.names.open.len()
    }

    /// Takes elements of the core that follow, as long as `element` finds one at the beginning of the text that is already unpacked. They
    /// must be empty and in the default namespace. What `element` does not find, and what it is not asked for, is in the next steps.
    pub(super) fn take_plain_elements<T>(
        &mut self,
        element: PlainElement<T>,
        mut hand_on: impl FnMut(T) -> Result<(), FileReadError>,
    ) -> Result<(), FileReadError> {
        if self.empty || !self.is_after_tag || self.names.default != XmlNamespace::Core || self.depth() >= MAX_DEPTH {
            return Ok(());
        }
        self.reader.get_mut().start_token();
        let text = match self.reader.get_mut().fill_buf() {
            Ok(text) => text,
            Err(error) => return Err(self.read_failure(error.into())),
        };
        let mut rest = text;
        while let Some((found, following)) = element(rest) {
            hand_on(found)?;
            rest = following;
        }
        let taken = text.len() - rest.len();
        self.reader.get_mut().consume(taken);
        Ok(())
    }

    /// The next relevant event; comments and processing instructions are skipped.
    pub(super) fn next_step(&mut self) -> Result<DocumentStep, FileReadError> {
        if std::mem::take(&mut self.empty) {
            return self.check_step(DocumentStep::Close);
        }
        loop {
            self.buffer.clear();
            self.reader.get_mut().start_token();
            let event = match self.reader.read_event_into(&mut self.buffer) {
                Ok(event) => event,
                Err(error) => return Err(self.read_failure(error)),
            };
            self.is_after_tag = matches!(event, Event::Start(_) | Event::Empty(_) | Event::End(_));
            let step = match event {
                Event::Start(ref start) | Event::Empty(ref start) => {
                    self.empty = matches!(event, Event::Empty(_));
                    match open_element(&mut self.names, start, &mut self.attributes, &mut self.text) {
                        Ok(tag) => DocumentStep::Open(tag),
                        Err(reason) => return Err(self.invalid_document(&reason)),
                    }
                }
                Event::End(_) => DocumentStep::Close,
                Event::Eof => DocumentStep::End,
                Event::DocType(_) => return Err(self.invalid_document("it has a DTD, which 3MF forbids")),
                Event::Text(data) => {
                    self.text.clear();
                    self.text.push_str(&data.xml10_content());
                    DocumentStep::Text
                }
                Event::CData(data) => {
                    self.text.clear();
                    self.text.push_str(&data.xml10_content());
                    DocumentStep::Text
                }
                Event::GeneralRef(reference) => {
                    self.text.clear();
                    match resolve_reference(&reference) {
                        Some(c) => self.text.push(c),
                        None => return Err(self.invalid_document("it names an entity that XML does not define")),
                    }
                    DocumentStep::Text
                }
                Event::Decl(_) | Event::PI(_) | Event::Comment(_) => continue,
            };
            return self.check_step(step);
        }
    }

    /// Checks that an event is allowed at the present place. An opening element has already entered its namespaces.
    fn check_step(&mut self, step: DocumentStep) -> Result<DocumentStep, FileReadError> {
        let depth = self.depth();
        match step {
            DocumentStep::Open(_) if depth == 1 && self.seen_root => {
                return Err(self.invalid_document("it has two root elements"));
            }
            DocumentStep::Open(_) if depth > MAX_DEPTH => {
                return Err(self.invalid_document("its elements nest too deeply"));
            }
            DocumentStep::Open(_) => self.seen_root = true,
            DocumentStep::Close => self.names.leave_element(),
            DocumentStep::End if depth > 0 => return Err(self.invalid_document("it ends within an element")),
            DocumentStep::End if !self.seen_root => return Err(self.invalid_document("it holds no XML")),
            DocumentStep::Text if depth == 0 && !self.text.trim().is_empty() => {
                return Err(self.invalid_document("it has text outside the root element"));
            }
            _ => {}
        }
        Ok(step)
    }

    /// Skips the open element and its contents.
    pub(super) fn skip_element(&mut self) -> Result<(), FileReadError> {
        let outside = self.depth() - 1;
        while self.depth() > outside {
            self.next_step()?;
        }
        Ok(())
    }

    /// The text of the open element up to its end; elements in it are skipped.
    pub(super) fn text_inside(&mut self) -> Result<String, FileReadError> {
        let outside = self.depth() - 1;
        let mut text = String::new();
        while self.depth() > outside {
            let inside = self.depth() == outside + 1;
            if self.next_step()? == DocumentStep::Text && inside && text.len() < 1 << 16 {
                text.push_str(&self.text);
            }
        }
        Ok(text)
    }

    /// The value of an attribute without a prefix.
    pub(super) fn plain_attribute(&self, name: &str) -> Option<&str> {
        self.attribute_value(XmlNamespace::None, name)
    }

    /// The value of an attribute in a namespace.
    pub(super) fn attribute_value(&self, space: XmlNamespace, name: &str) -> Option<&str> {
        let wanted = |a: &&XmlAttribute| a.space == space && &self.text[a.name.clone()] == name;
        self.attributes.iter().find(wanted).map(|a| &self.text[a.value.clone()])
    }

    /// The namespace of a prefix at this place; `None` when it is not declared.
    pub(super) fn namespace_uri(&self, prefix: &str) -> Option<String> {
        let name = format!("{prefix}:x");
        match self.names.resolver.resolve_prefix(QName(&name).prefix(), true) {
            ResolveResult::Bound(namespace) => Some(namespace.0.to_owned()),
            _ => None,
        }
    }

    /// Creates an error in this document.
    pub(super) fn invalid_document(&self, reason: &str) -> FileReadError {
        FileReadError::invalid_threemf(format!("{}: {reason}", self.path))
    }

    fn read_failure(&mut self, error: quick_xml::Error) -> FileReadError {
        if let Some(reason) = self.reader.get_mut().take_refusal() {
            return reason;
        }
        match error {
            quick_xml::Error::Io(io) if io.raw_os_error().is_some() => {
                FileReadError::Io(std::io::Error::from_raw_os_error(io.raw_os_error().unwrap_or(0)))
            }
            quick_xml::Error::Io(io) => self.invalid_document(&format!("its packed data is damaged ({io})")),
            other => self.invalid_document(&other.to_string()),
        }
    }
}

/// Parses an opening element and enters its namespaces.
fn open_element(
    names: &mut NamespaceScope,
    start: &BytesStart<'_>,
    attributes: &mut Vec<XmlAttribute>,
    text: &mut String,
) -> Result<ElementTag, String> {
    names.enter_element(start)?;
    attributes.clear();
    text.clear();
    // The reader's own check for duplicates allocates at every element; our check is below.
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|e| e.to_string())?;
        let (local, prefix) = attribute.key.decompose();
        if attribute.key.as_namespace_binding().is_some() {
            continue;
        }
        let space = match prefix {
            None => XmlNamespace::None,
            prefix => names.resolve_namespace(prefix)?,
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
        let new = XmlAttribute { space, name: name_start..value_start, value: value_start..text.len() };
        let is_new = |a: &XmlAttribute| text[a.name.clone()] == text[new.name.clone()] && a.space == new.space;
        if space != XmlNamespace::Other && attributes.iter().any(is_new) {
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
        prefix => names.resolve_namespace(prefix)?,
    };
    Ok(ElementTag::from_name(space, local.into_inner()))
}

/// Resolves a reference: a number or one of the five names that XML defines without a DTD.
fn resolve_reference(reference: &BytesRef<'_>) -> Option<char> {
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
