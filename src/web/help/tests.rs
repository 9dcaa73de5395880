//! The book as a whole: every link leads somewhere, as files and below `/help`; it stays small and plain; a search finds what is in it.

use std::{fs, path::Path};

use pulldown_cmark::{Event, Tag, TagEnd};

use super::{
    book::{CHAPTERS, chapter_address, link_address, linked_file},
    markdown::{BOOK, Section, events_of, sections_of},
    search::find_sections,
};

/// Documents that are files only: for those who come to the repository, and for developers.
const FILES: [&str; 5] = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/dependencies.md"];
/// The most words of all documents together.
const MAX_WORDS: usize = 25_000;
/// The most words of a sentence in the mean of a document.
const MAX_MEAN: f64 = 20.0;

fn read(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file))
        .unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// Each document with its text, as it stands in the repository.
fn documents() -> Vec<(&'static str, String)> {
    CHAPTERS.iter().map(|chapter| chapter.file).chain(FILES).map(|file| (file, read(file))).collect()
}

/// The links and pictures of a text.
fn links_of(text: &str) -> Vec<String> {
    let links = events_of(text).into_iter().filter_map(|event| match event {
        Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => Some(dest_url.into_string()),
        _ => None,
    });
    links.filter(|link| !link.starts_with("http")).collect()
}

fn has_anchor(sections: &[Section], anchor: &str) -> bool {
    sections.iter().any(|section| section.anchor == anchor)
}

#[test]
fn every_document_of_the_repository_belongs_to_the_book() {
    let docs = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")).unwrap();
    let names = docs.map(|entry| format!("docs/{}", entry.unwrap().file_name().to_str().unwrap()));
    let known: Vec<String> = documents().into_iter().map(|(file, _)| file.to_owned()).collect();
    let missing: Vec<String> = names.filter(|name| name.ends_with(".md") && !known.contains(name)).collect();
    assert!(missing.is_empty(), "no chapters: {missing:?}");
}

#[test]
fn every_link_between_the_files_leads_to_a_file_and_a_heading_that_are_there() {
    for (file, text) in documents() {
        for link in links_of(&text) {
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if path.is_empty() { file.to_owned() } else { linked_file(file, path) };
            assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(&target).exists(), "{file} links to {link}");
            let there = anchor.is_empty() || has_anchor(&sections_of(&events_of(&read(&target))), anchor);
            assert!(there, "{file} links to {link}: {target} has no such heading");
        }
    }
}

#[test]
fn every_link_below_help_leads_to_a_chapter_and_a_heading_that_are_there() {
    let mut followed = 0;
    for (chapter, read) in CHAPTERS.iter().zip(BOOK.iter()) {
        for link in links_of(chapter.text) {
            let Some(address) = link_address(chapter.file, &link) else { continue };
            let (path, anchor) = address.split_once('#').unwrap_or((&address, ""));
            let target =
                BOOK.iter().find(|other| path == chapter_address(other.name)).or(path.is_empty().then_some(read));
            let target = target.unwrap_or_else(|| panic!("{}: {link} leads to {address}", chapter.file));
            assert!(anchor.is_empty() || has_anchor(&target.sections, anchor), "{}: {link}", chapter.file);
            followed += 1;
        }
        let named = read.html.split("id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect::<Vec<_>>();
        let anchors: Vec<&str> = read.sections.iter().map(|section| section.anchor.as_str()).collect();
        assert_eq!(named, anchors, "{}: its headings can be led to", chapter.file);
        assert!(!anchors.contains(&"main") && read.sections[0].level == 1, "{}", chapter.file);
        assert!(!read.html.contains("style=") && !read.html.contains("<img"), "{}", chapter.file);
    }
    assert!(followed > 25, "only {followed} links");
}

#[test]
fn what_looks_like_code_in_a_chapter_is_shown_as_text() {
    let chapter = super::book::Chapter {
        name: "x",
        file: "docs/x.md",
        text: "# A <b>title</b>\n\n<script>alert(1)</script>\n\nan <i onclick=x>i</i> [away](gone.md) ![seen](x.png)\n\n| a |\n|--:|\n| 1 |\n",
    };
    let html = super::markdown::read_chapter(&chapter).html;
    assert!(!html.contains("<script") && !html.contains("<b>") && !html.contains("<i "), "{html}");
    assert!(html.contains("away") && !html.contains("gone.md") && html.contains("Picture: seen"), "{html}");
    assert!(html.contains("<div class=\"wide\"") && !html.contains("style="), "{html}");
}

#[test]
fn a_search_finds_the_sections_with_all_words_and_headings_first() {
    let found = find_sections("  PAUSED status ");
    assert_eq!(found[0].section.title, "Status says paused");
    assert_eq!(found[0].chapter.name, "symptoms");
    let text: String = found[0].snippet.iter().map(|(piece, _)| piece.as_str()).collect();
    assert!(found[0].section.text.contains(text.trim_start_matches(".. ")), "{text}");
    for one in find_sections("queue_depth") {
        let holds = |text: &str| text.to_lowercase().contains("queue_depth");
        assert!(
            holds(&one.section.title) || one.snippet.iter().any(|(piece, is_asked)| *is_asked && holds(piece)),
            "{one:?}"
        );
    }
    assert!(find_sections("équerre").iter().any(|one| one.chapter.name == "technician"), "any script");
    assert!(find_sections("paused zyzzyva").is_empty() && find_sections(" ").is_empty());
}

#[test]
fn the_book_stays_small() {
    let words: Vec<(&str, usize)> =
        documents().iter().map(|(file, text)| (*file, text.split_whitespace().count())).collect();
    let all: usize = words.iter().map(|(_, words)| words).sum();
    assert!(all <= MAX_WORDS, "{all} words: {words:?}");
}

/// Words of each sentence in the paragraphs and lists of a text; tables, headings and examples are none.
fn sentences_of(text: &str) -> Vec<usize> {
    let (mut sentences, mut block, mut skipped) = (Vec::new(), String::new(), 0);
    let mut end_block = |block: &mut String| {
        let text = std::mem::take(block);
        let mut words = 0;
        for word in text.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)) {
            words += 1;
            let bare = word.trim_end_matches(['"', ')', '*']);
            if bare.ends_with(['.', '?', '!']) && !bare.ends_with("..") {
                sentences.push(std::mem::take(&mut words));
            }
        }
        sentences.extend(Some(words).filter(|words| *words > 0));
    };
    for event in events_of(text) {
        match event {
            Event::Start(Tag::Table(_) | Tag::Heading { .. } | Tag::CodeBlock(_) | Tag::Image { .. }) => skipped += 1,
            Event::End(TagEnd::Table | TagEnd::Heading(_) | TagEnd::CodeBlock | TagEnd::Image) => skipped -= 1,
            Event::Text(text) | Event::Code(text) if skipped == 0 => block.push_str(&text),
            Event::SoftBreak | Event::HardBreak => block.push(' '),
            Event::Start(Tag::Item) | Event::End(TagEnd::Item | TagEnd::Paragraph) => end_block(&mut block),
            _ => {}
        }
    }
    sentences
}

#[test]
fn sentences_are_short_in_the_mean_of_each_document() {
    let long: Vec<String> = (documents().iter())
        .map(|(file, text)| (file, sentences_of(text)))
        .map(|(file, sentences)| (file, sentences.iter().sum::<usize>() as f64 / sentences.len().max(1) as f64))
        .filter(|(_, mean)| *mean > MAX_MEAN)
        .map(|(file, mean)| format!("{file}: {mean:.1} words"))
        .collect();
    assert!(long.is_empty(), "{long:?}");
}

#[test]
fn sentences_are_counted_as_people_do() {
    let text = "# Not this one\n\nOne two three. Four `five six`!\nSeven\n\n- eight nine\n- ten. (Eleven twelve.)\n\n| no | table |\n|--|--|\n| a | b |\n\n    nor code\n";
    assert_eq!(sentences_of(text), [3, 3, 1, 2, 1, 2]);
}
