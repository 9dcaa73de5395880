//! Bodies that are compressed once, kept so, and sent again only when they changed. Pages are not compressed: they carry the key of
//! their forms, which must not be guessed from the size of a compressed text.

use std::io::{self, Read, Write};

use axum::{
    body::Bytes,
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use flate2::{Compression, read::GzDecoder, write::GzEncoder};

/// A compressed body.
#[derive(Debug, Clone)]
pub(crate) struct CompressedBody {
    gzip: Bytes,
    /// Its entity tag: a hash of its content.
    tag: String,
}

impl CompressedBody {
    /// Compresses bytes.
    pub(crate) fn new(plain: &[u8], level: Compression) -> io::Result<Self> {
        let mut encoder = GzEncoder::new(Vec::new(), level);
        encoder.write_all(plain)?;
        let hash = blake3::hash(plain).to_hex();
        Ok(Self { gzip: Bytes::from(encoder.finish()?), tag: format!("\"{}\"", &hash[..32]) })
    }

    /// A short hash of its content, for an address that changes with it.
    pub(crate) fn version(&self) -> &str {
        &self.tag[1..13]
    }

    /// Answers a request with these headers; `kind` is the content type, `keep` the rule for caches.
    pub(crate) fn answer(&self, request: &HeaderMap, kind: &'static str, keep: &'static str) -> io::Result<Response> {
        let has = |name: header::HeaderName, word: &str| {
            let texts = request.get_all(name).iter().filter_map(|value| value.to_str().ok());
            texts.flat_map(|text| text.split(',')).any(|one| one.trim().trim_start_matches("W/").starts_with(word))
        };
        let mut headers = HeaderMap::new();
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(keep));
        headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
        if let Ok(tag) = HeaderValue::from_str(&self.tag) {
            headers.insert(header::ETAG, tag);
        }
        if has(header::IF_NONE_MATCH, &self.tag) {
            return Ok((StatusCode::NOT_MODIFIED, headers).into_response());
        }
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
        if has(header::ACCEPT_ENCODING, "gzip") {
            headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
            return Ok((headers, self.gzip.clone()).into_response());
        }
        let mut plain = Vec::new();
        GzDecoder::new(&*self.gzip).read_to_end(&mut plain)?;
        Ok((headers, plain).into_response())
    }
}
