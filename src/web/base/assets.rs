//! Styles and scripts, embedded in the binary. Pages name them with their version, so that browsers keep them for good.

use std::{collections::BTreeMap, sync::LazyLock};

use flate2::Compression;

use super::compressed::CompressedBody;

const ASSETS: [(&str, &str, &[u8]); 6] = [
    ("style.css", "text/css; charset=utf-8", include_bytes!("../assets/style.css")),
    ("live.js", "text/javascript; charset=utf-8", include_bytes!("../assets/live.js")),
    ("drop.js", "text/javascript; charset=utf-8", include_bytes!("../assets/drop.js")),
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
    ASSETS.into_iter().map(compressed).collect()
});

/// The address of an asset, which changes with its content.
pub(crate) fn asset_address(name: &str) -> String {
    let version = COMPRESSED.get(name).map(|(_, body)| body.version()).unwrap_or_default();
    format!("/assets/{name}?v={version}")
}

/// Content type and content of an asset.
pub(crate) fn find_asset(name: &str) -> Option<&'static (&'static str, CompressedBody)> {
    COMPRESSED.get(name)
}
