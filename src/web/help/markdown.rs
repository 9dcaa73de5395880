//! Reads a chapter: its sections for contents and searches, and its HTML. Chapters are our own texts; HTML in them is shown as text all the
//! same. Pictures are left out, so that the binary stays small: their words stand in their place.

use std::sync::LazyLock;

use maud::html;
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html::push_html};

use super::book::{CHAPTERS, Chapter, link_address};

/// The chapters as pages and searches need them.
pub(super) static BOOK: LazyLock<Vec<ReadChapter>> = LazyLock::new(|| CHAPTERS.iter().map(read_chapter).collect());

/// What stands below a heading, up to the next one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Section {
    /// 1 = the chapter itself.
    pub(super) level: usize,
    /// Its heading.
    pub(super) title: String,
    /// What its address has behind `#`.
    pub(super) anchor: String,
    /// Its words, without form.
    pub(super) text: String,
}

/// A chapter that was read.
#[derive(Debug)]
pub(super) struct ReadChapter {
    /// The last step of its address.
    pub(super) name: &'static str,
    /// Its sections; the first is the chapter itself.
    pub(super) sections: Vec<Section>,
    /// It as HTML.
    pub(super) html: String,
}

impl ReadChapter {
    /// Its title.
    pub(super) fn title(&self) -> &str {
        self.sections.first().map_or(self.name, |first| &first.title)
    }
}

/// The pieces of a text.
pub(super) fn events_of(text: &str) -> Vec<Event<'_>> {
    Parser::new_ext(text, Options::ENABLE_TABLES).collect()
}

/// Reads a chapter.
pub(super) fn read_chapter(chapter: &Chapter) -> ReadChapter {
    let events = events_of(chapter.text);
    let sections = sections_of(&events);
    let html = html_of(chapter.file, events, &sections);
    ReadChapter { name: chapter.name, sections, html }
}

/// The sections of a text.
pub(super) fn sections_of(events: &[Event<'_>]) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    let mut is_heading = false;
    for event in events {
        if let Event::Start(Tag::Heading { level, .. }) = event {
            sections.push(Section { level: *level as usize, ..Section::default() });
        }
        is_heading = match event {
            Event::Start(Tag::Heading { .. }) => true,
            Event::End(TagEnd::Heading(_)) => false,
            _ => is_heading,
        };
        let Some(section) = sections.last_mut() else { continue };
        let place = if is_heading { &mut section.title } else { &mut section.text };
        match event {
            Event::Text(text) | Event::Code(text) => place.push_str(text),
            Event::SoftBreak | Event::HardBreak => place.push(' '),
            Event::End(TagEnd::Paragraph | TagEnd::Item | TagEnd::TableCell | TagEnd::CodeBlock) => place.push(' '),
            _ => {}
        }
    }
    for at in 0..sections.len() {
        let anchor = anchor_of(&sections[at].title);
        let same = sections[..at].iter().filter(|other| anchor_of(&other.title) == anchor).count();
        sections[at].anchor = if same == 0 { anchor } else { format!("{anchor}-{same}") };
    }
    sections
}

/// What the address of a heading has behind `#`, as code forges make it of the file.
fn anchor_of(title: &str) -> String {
    let kept = title.trim().chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn html_of(file: &str, events: Vec<Event<'_>>, sections: &[Section]) -> String {
    let mut headings = sections.iter();
    let (mut section, mut tables) = ("", 0);
    // Whether each link that is open leads somewhere.
    let mut links: Vec<bool> = Vec::new();
    let markup = |text: String| Event::InlineHtml(text.into());
    let mut shown: Vec<Event<'_>> = Vec::new();
    for event in events {
        match event {
            Event::Start(Tag::Heading { level, classes, attrs, .. }) => {
                let anchor = headings.next().map(|heading| {
                    section = &heading.title;
                    CowStr::from(heading.anchor.clone())
                });
                shown.push(Event::Start(Tag::Heading { level, id: anchor, classes, attrs }));
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let leads = link_address(file, &dest_url);
                links.push(leads.is_some());
                let link = |to: String| Event::Start(Tag::Link { link_type, dest_url: to.into(), title, id });
                shown.extend(leads.map(link));
            }
            Event::End(TagEnd::Link) => shown.extend(links.pop().unwrap_or(true).then_some(event)),
            Event::Start(Tag::Image { .. }) => shown.push(markup("<span class=\"soft\">Picture: ".to_owned())),
            Event::End(TagEnd::Image) => shown.push(markup("</span>".to_owned())),
            // A region that can be scrolled by keys has a name of its own.
            Event::Start(Tag::Table(_)) => {
                tables += 1;
                let label = html! { "Table " (tables) ": " (section) }.into_string();
                let region = format!("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\">");
                shown.extend([markup(region), Event::Start(Tag::Table(Vec::new()))]);
            }
            Event::End(TagEnd::Table) => shown.extend([event, markup("</div>".to_owned())]),
            Event::Start(Tag::CodeBlock(_)) => shown.push(markup("<pre tabindex=\"0\"><code>".to_owned())),
            Event::End(TagEnd::CodeBlock) => shown.push(markup("</code></pre>".to_owned())),
            Event::Html(text) | Event::InlineHtml(text) => shown.push(Event::Text(text)),
            event => shown.push(event),
        }
    }
    let mut html = String::new();
    push_html(&mut html, shown.into_iter());
    html
}
