//! The layout that all pages share: head, navigation, footer.

use axum::http::StatusCode;
use maud::{DOCTYPE, Markup, html};

use super::assets::{asset_address, font_address};

/// A whole page. `script` is an asset that is loaded in addition to the script that keeps pages up to date.
pub(crate) fn html_page(title: &str, here: &str, script: Option<&str>, content: &Markup) -> Markup {
    let link = |path: &str, name: &str| {
        html! { a href=(path) aria-current=[(here == path).then_some("page")] { (name) } }
    };
    html! {
        (DOCTYPE)
        html lang="en" {
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
            }
            body {
                a.skip href="#main" { "Skip to content" }
                header {
                    nav aria-label="Pages" {
                        span.brand { "nestd" }
                        (link("/", "Farm")) (link("/orders", "Orders")) (link("/history", "History")) (link("/month", "Month")) (link("/help", "Help"))
                        (search_field("", "Search the farm"))
                    }
                }
                main #main tabindex="-1" { (content) }
                footer {
                    p { "nestd " (env!("CARGO_PKG_VERSION")) ". Lengths are mm. "
                        a href="/api/v1/openapi.json" { "JSON interface" } " · " a href="/metrics" { "Metrics" } }
                }
            }
        }
    }
}

/// The field that searches the whole farm; `label` is its name for screen readers.
pub(super) fn search_field(text: &str, label: &str) -> Markup {
    html! {
        form.search method="get" action="/search" role="search" aria-label=(label) {
            input type="search" name="q" value=(text) required maxlength="200" aria-label=(label)
                placeholder="Part, file, order, build 1182" title="Press / to search" autocomplete="off";
            button type="submit" { "Search" }
        }
    }
}

/// A page that shows an error.
pub(super) fn error_page(status: StatusCode, text: &str) -> Markup {
    let title = status.canonical_reason().unwrap_or("Error");
    let mut letters = text.chars();
    let sentence: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
    let content = html! {
        h1 { (title) }
        p #problem role="alert" { (sentence.trim_end_matches('.')) "." }
        p { a.button.first href="/" { "To the farm" } }
    };
    html_page(title, "", None, &content)
}
