//! Styles and scripts, embedded in the binary. Pages name them with their version, so that browsers keep them for good.

use std::{collections::BTreeMap, sync::LazyLock};

use flate2::Compression;

use super::compressed::CompressedBody;
use crate::web::look::style::page_style;

/// The font of the pages: Inter (SIL Open Font License 1.1), made by `assets/font.sh`.
const FONT: &str = "inter.woff2";

const ASSETS: [(&str, &str, &[u8]); 7] = [
    (FONT, "font/woff2", include_bytes!("../assets/inter.woff2")),
    ("live.js", "text/javascript; charset=utf-8", include_bytes!("../assets/live.js")),
    ("drop.js", "text/javascript; charset=utf-8", include_bytes!("../assets/drop.js")),
    ("copy.js", "text/javascript; charset=utf-8", include_bytes!("../assets/copy.js")),
    ("start.js", "text/javascript; charset=utf-8", include_bytes!("../assets/start.js")),
    ("view.js", "text/javascript; charset=utf-8", include_bytes!("../assets/view.js")),
    ("icon.svg", "image/svg+xml", include_bytes!("../assets/icon.svg")),
];

/// Content type and content of each asset, by name.
static COMPRESSED: LazyLock<BTreeMap<&'static str, (&'static str, CompressedBody)>> = LazyLock::new(|| {
    let compressed = |(name, kind, bytes): (&'static str, &'static str, &[u8])| {
        let body = CompressedBody::new(bytes, Compression::default()).expect("writing to memory does not fail");
        (name, (kind, body))
    };
    let mut assets: BTreeMap<_, _> = ASSETS.into_iter().map(compressed).collect();
    // The style sheet names the font by its content.
    let style = page_style(&address_of(FONT, &assets[FONT].1));
    assets.extend([compressed(("style.css", "text/css; charset=utf-8", style.as_bytes()))]);
    assets
});

fn address_of(name: &str, body: &CompressedBody) -> String {
    format!("/assets/{name}?v={}", body.version())
}

/// The address of the font, which a page asks for before its style sheet has come.
pub(crate) fn font_address() -> String {
    asset_address(FONT)
}

/// The address of an asset, which changes with its content.
pub(crate) fn asset_address(name: &str) -> String {
    COMPRESSED.get(name).map(|(_, body)| address_of(name, body)).unwrap_or_default()
}

/// Content type and content of an asset.
pub(crate) fn find_asset(name: &str) -> Option<&'static (&'static str, CompressedBody)> {
    COMPRESSED.get(name)
}
