//! Parses the head of a 3MF model part: its root, and the metadata that stand before everything else.

use std::io::BufRead;

use super::{
    model::{CountedElement, ModelBudget, ModelMetadata},
    unpack_guard::UnpackGuard,
    xml::{DocumentStep, XmlReader},
    xml_names::{ElementTag, XmlNamespace},
};
use crate::FileReadError;

pub(super) type ModelXmlReader<R> = XmlReader<UnpackGuard<R>>;

/// Reads the metadata of a model part that stand before everything else.
pub(super) fn parse_leading_metadata<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
) -> Result<ModelMetadata, FileReadError> {
    open_model(xml)?;
    let mut metadata = ModelMetadata::default();
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Metadata) => parse_metadata(xml, budget, &mut metadata)?,
            DocumentStep::Open(_) | DocumentStep::Close | DocumentStep::End => return Ok(metadata),
            _ => {}
        }
    }
}

/// Reads to the root of a model part.
pub(super) fn open_model<R: BufRead>(xml: &mut ModelXmlReader<R>) -> Result<(), FileReadError> {
    loop {
        match xml.next_step()? {
            DocumentStep::Open(ElementTag::Model) => return Ok(()),
            DocumentStep::Open(_) | DocumentStep::End => return Err(xml.invalid_document("its root is no 3MF model")),
            _ => {}
        }
    }
}

/// Parses a `<metadata>` element; keeps names without a namespace, our own and those of Cura. Texts for people do not affect the
/// shape: of two with the same name the first one counts, and one without a name or with an undeclared prefix is
/// ignored. Our own names determine what is proved of a build, so each may appear only once.
pub(super) fn parse_metadata<R: BufRead>(
    xml: &mut ModelXmlReader<R>,
    budget: &mut ModelBudget,
    into: &mut ModelMetadata,
) -> Result<(), FileReadError> {
    let Some(name) = xml.plain_attribute("name").map(str::to_owned) else {
        budget.odd_metadata += 1;
        return xml.skip_element();
    };
    let (space, local) = match name.split_once(':') {
        None => (XmlNamespace::None, name.as_str()),
        Some((prefix, local)) => match xml.namespace_uri(prefix) {
            Some(namespace) => (XmlNamespace::from_uri(&namespace), local),
            None => {
                budget.odd_metadata += 1;
                return xml.skip_element();
            }
        },
    };
    let value = xml.text_inside()?;
    if !matches!(space, XmlNamespace::None | XmlNamespace::Nestd | XmlNamespace::Cura) {
        return Ok(());
    }
    budget.take_amount(CountedElement::MetadataBytes, (local.len() + value.len() + 64) as u64)?;
    // A valid group has each name once. The search for duplicates is bounded, so that a hostile file cannot cost much
    // time.
    if into.0.len() < 100 && into.0.iter().any(|(s, n, _)| *s == space && n == local) {
        if space == XmlNamespace::Nestd {
            return Err(xml.invalid_document(&format!("it has the metadata {name:?} twice")));
        }
        budget.odd_metadata += 1;
        return Ok(());
    }
    into.0.push((space, local.to_owned(), value));
    Ok(())
}
