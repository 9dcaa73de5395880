//! The languages, and which of them a browser asks for.

/// A language.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Language {
    /// English, the source of all others.
    #[default]
    English,
    /// German.
    German,
    /// French.
    French,
    /// Japanese.
    Japanese,
    /// English with `⟦⟧` around all that comes from a catalog: it shows what does not.
    Marked,
}

impl Language {
    /// All that people speak.
    pub const ALL: [Self; 4] = [Self::English, Self::German, Self::French, Self::Japanese];

    /// Its tag (BCP 47).
    pub fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
            Self::French => "fr",
            Self::Japanese => "ja",
            Self::Marked => "art-x-marked",
        }
    }

    /// Its own name.
    pub fn name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::German => "Deutsch",
            Self::French => "Français",
            Self::Japanese => "日本語",
            Self::Marked => "Marked",
        }
    }

    /// The language of a tag, whatever its region: `de`, `de-AT`.
    pub fn of_tag(tag: &str) -> Option<Self> {
        let tag = tag.trim().to_ascii_lowercase();
        if tag == Self::Marked.tag() {
            return Some(Self::Marked);
        }
        let primary = tag.split('-').next().unwrap_or_default();
        Self::ALL.into_iter().find(|language| language.tag() == primary)
    }

    /// The best language of an `Accept-Language` header; `None` = it names none that is known.
    pub fn accepted(header: &str) -> Option<Self> {
        let mut best = None;
        for entry in header.split(',') {
            let (tag, parameters) = entry.split_once(';').unwrap_or((entry, ""));
            let quality = parameters.split(';').find_map(|one| one.trim().strip_prefix("q="));
            let quality = quality.map_or(1.0, |text| text.trim().parse::<f32>().unwrap_or(0.0));
            let better = quality > best.map_or(0.0, |(_, quality)| quality);
            if let Some(language) = Self::of_tag(tag).filter(|_| better) {
                best = Some((language, quality));
            }
        }
        best.map(|(language, _)| language)
    }

    /// What ends a sentence.
    pub(crate) fn full_stop(self) -> &'static str {
        if self == Self::Japanese { "。" } else { "." }
    }

    /// What stands between two sentences.
    pub(crate) fn space_between_sentences(self) -> &'static str {
        if self == Self::Japanese { "" } else { " " }
    }

    /// Whether its decimal sign is a comma.
    pub(crate) fn has_decimal_comma(self) -> bool {
        matches!(self, Self::German | Self::French)
    }
}

#[cfg(test)]
mod tests {
    use super::Language::{English, French, German, Japanese, Marked};
    use super::*;

    #[test]
    fn the_best_known_language_of_a_header_is_taken() {
        for (header, expected) in [
            ("de-AT,de;q=0.9,en;q=0.8", Some(German)),
            ("nl,en;q=0.5,fr;q=0.7", Some(French)),
            ("ja", Some(Japanese)),
            ("en;q=0.3, de;q=0.3", Some(English)),
            ("DE-de; q=0.1", Some(German)),
            ("de;q=0, nl, *", None),
            ("de;q=much, fr;q=0.1", Some(French)),
            ("", None),
            ("denmark, enough", None),
            ("art-x-marked", Some(Marked)),
        ] {
            assert_eq!(Language::accepted(header), expected, "{header}");
        }
    }
}
