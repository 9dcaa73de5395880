//! The pages of the book: its contents with a search, and its chapters.

use axum::extract::Path;
use language::{Language, say};
use maud::{Markup, PreEscaped, html};
use serde::Deserialize;

use super::{
    book::chapter_address,
    markdown::{BOOK, ReadChapter, Section},
    search::{FoundSection, find_sections},
};
use crate::web::base::{
    error::{HandlerError, HandlerResult},
    page::html_page,
    query::Query,
};

/// The address of the contents.
const CONTENTS: &str = "/help";
/// Sections of the book that a search shows.
const MAX_FOUND: usize = 40;

/// What is searched.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct HelpQuestion {
    /// Words; none = the contents are asked for.
    q: String,
}

/// The contents of the book, or what a search finds in it.
pub(crate) async fn show_contents(Query(asked): Query<HelpQuestion>) -> Markup {
    let question = asked.q.trim();
    let content = html! {
        h1 { @if question.is_empty() { (say!("nav-help")) } @else { (say!("help-for", text = question)) } }
        (in_english())
        (book_search(question))
        @if question.is_empty() { (contents()) } @else { (found_list(&find_sections(question))) }
    };
    html_page(&say!("nav-help"), CONTENTS, None, &content)
}

/// A chapter.
pub(crate) async fn show_chapter(Path(name): Path<String>) -> HandlerResult<Markup> {
    let missing = || HandlerError::NotFound(say!("chapter-named", name = &name));
    let at = BOOK.iter().position(|chapter| chapter.name == name).ok_or_else(missing)?;
    let chapter = &BOOK[at];
    let (before, after) = (at.checked_sub(1).and_then(|at| BOOK.get(at)), BOOK.get(at + 1));
    let content = html! {
        p.links { a href=(CONTENTS) { (say!("contents")) } }
        (in_english())
        (book_search(""))
        details { summary { (say!("in-this-chapter")) } (section_list(chapter)) }
        article.book lang="en" { (PreEscaped(&chapter.html)) }
        p.links {
            @if let Some(before) = before { a href=(chapter_address(before.name)) { (say!("chapter-before", title = before.title())) } }
            @if let Some(after) = after { a href=(chapter_address(after.name)) { (say!("chapter-next", title = after.title())) } }
        }
    };
    Ok(html_page(chapter.title(), CONTENTS, None, &content))
}

/// Says to whoever reads another language that the book is in English.
fn in_english() -> Markup {
    html! { @if language::current() != Language::English { p.note { (say!("help-in-english")) } } }
}

/// The field that searches the book.
fn book_search(text: &str) -> Markup {
    html! {
        form.filters method="get" action=(CONTENTS) role="search" aria-label=(say!("search-book")) {
            label { (say!("words-in-book")) input type="search" name="q" value=(text) maxlength="200" placeholder=(say!("words-in-book-example")); }
            button type="submit" { (say!("search-book")) }
        }
    }
}

fn section_address(chapter: &ReadChapter, section: &Section) -> String {
    format!("{}#{}", chapter_address(chapter.name), section.anchor)
}

fn contents() -> Markup {
    html! {
        div.found lang="en" { @for chapter in BOOK.iter() {
            section aria-label=(chapter.title()) {
                h2 { a href=(chapter_address(chapter.name)) { (chapter.title()) } }
                (section_list(chapter))
            }
        } }
    }
}

/// The sections of a chapter.
fn section_list(chapter: &ReadChapter) -> Markup {
    html! {
        ul.still lang="en" { @for section in chapter.sections.iter().filter(|section| section.level > 1) {
            li { a href=(section_address(chapter, section)) { (section.title) } }
        } }
    }
}

fn found_list(found: &[FoundSection]) -> Markup {
    let left = found.len().saturating_sub(MAX_FOUND);
    html! {
        @if found.is_empty() {
            p role="status" { (say!("no-section")) }
            (contents())
        } @else {
            div.found {
                h2 { (say!("count-sections", count = found.len())) }
                ul lang="en" { @for one in found.iter().take(MAX_FOUND) { li {
                    a href=(section_address(one.chapter, one.section)) { (one.section.title) }
                    @if one.section.level > 1 { " " span.soft { (one.chapter.title()) } }
                    p { @for (piece, is_asked) in &one.snippet { @if *is_asked { mark { (piece) } } @else { (piece) } } }
                } } }
                @if left > 0 { p { (say!("more-sections", count = left)) } }
            }
        }
    }
}
