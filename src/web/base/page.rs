//! The layout that all pages share: head, navigation, footer.

use axum::http::StatusCode;
use language::say;
use maud::{DOCTYPE, Markup, html};

use super::assets::{asset_address, font_address};
use crate::web::clients::client::{KnownBy, RequestClient};
use crate::web::look::script_texts::{LIVE, script_texts, texts_of_script};

/// A whole page. `script` is an asset that is loaded in addition to the script that keeps pages up to date.
pub(crate) fn html_page(title: &str, here: &str, script: Option<&str>, content: &Markup) -> Markup {
    let link = |path: &str, name: &str| {
        html! { a href=(path) aria-current=[(here == path).then_some("page")] { (name) } }
    };
    html! {
        (DOCTYPE)
        html lang=(language::current().tag()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) " - nestd" }
                link rel="icon" href=(asset_address("icon.svg")) type="image/svg+xml";
                link rel="preload" href=(font_address()) as="font" type="font/woff2" crossorigin;
                link rel="stylesheet" href=(asset_address("style.css"));
                script type="module" src=(asset_address("live.js")) {}
                @if let Some(script) = script { script type="module" src=(asset_address(script)) {} }
                (script_texts(&[LIVE, texts_of_script(script.unwrap_or_default())]))
            }
            body {
                a.skip href="#main" { (say!("skip")) }
                header {
                    nav aria-label=(say!("pages")) {
                        span.brand { "nestd" }
                        (link("/", &say!("nav-farm"))) (link("/orders", &say!("nav-orders"))) (link("/history", &say!("nav-history")))
                        (link("/month", &say!("nav-month"))) (link("/help", &say!("nav-help")))
                        (search_field("", &say!("search-farm")))
                        (person_link())
                    }
                }
                main #main tabindex="-1" { (content) }
                footer {
                    p { span translate="no" { "nestd " (env!("CARGO_PKG_VERSION")) } (say!("footer-lengths")) " "
                        a href="/api/v1/openapi.json" { (say!("footer-json")) } " · " a href="/metrics" { (say!("footer-metrics")) } }
                }
            }
        }
    }
}

/// Who is signed in, or the way to it where others are.
fn person_link() -> Markup {
    let client = RequestClient::current();
    html! {
        @match client.as_ref().map(|client| &client.known_by) {
            // Others go on at this device with their PIN.
            Some(KnownBy::Person(person)) if person.is_shared => a href="/sign-in" translate="no" { (person.name) },
            Some(KnownBy::Person(person)) => a href="/you" translate="no" { (person.name) },
            Some(KnownBy::NoName) => a href="/sign-in" { (say!("sign-in")) },
            _ => {}
        }
    }
}

/// The field that searches the whole farm; `label` is its name for screen readers.
pub(super) fn search_field(text: &str, label: &str) -> Markup {
    html! {
        form.search method="get" action="/search" role="search" aria-label=(label) {
            input type="search" name="q" value=(text) required maxlength="200" aria-label=(label)
                placeholder=(say!("search-example")) title=(say!("search-key")) autocomplete="off";
            button type="submit" { (say!("search")) }
        }
    }
}

/// A page that shows an error.
pub(super) fn error_page(status: StatusCode, text: &str) -> Markup {
    let (title, text) = (status_title(status), language::told(text));
    let mut letters = text.chars();
    let sentence: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
    let content = html! {
        h1 { (title) }
        p #problem role="alert" { (sentence.trim_end_matches(['.', '。'])) (say!("sign-stop")) }
        p { a.button.first href="/" { (say!("to-the-farm")) } }
    };
    html_page(&title, "", None, &content)
}

/// A status in words: those of HTTP, or of the language.
fn status_title(status: StatusCode) -> String {
    language::say_word("http", status.canonical_reason().unwrap_or("Error"))
}
