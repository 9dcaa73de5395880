//! What is sent compressed. Some bodies are compressed once, kept so, and sent again only when they changed. A page is compressed as it is
//! made: the keys of its forms cannot be guessed from the sizes of compressed texts (BREACH), because each page has new ones.

use std::io::{self, Read, Write};

use axum::{
    body::{Body, Bytes, to_bytes},
    extract::Request,
    http::{HeaderMap, HeaderValue, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use flate2::{Compression, read::GzDecoder, write::GzEncoder};

/// Whether a list in a header has an entry that begins with a word.
fn names(request: &HeaderMap, header: header::HeaderName, word: &str) -> bool {
    let texts = request.get_all(header).iter().filter_map(|value| value.to_str().ok());
    texts.flat_map(|text| text.split(',')).any(|one| one.trim().trim_start_matches("W/").starts_with(word))
}

/// Compresses the pages that are answered, where the browser can read that.
pub(crate) async fn compress_pages(request: Request, next: Next) -> Response {
    let is_read = names(request.headers(), header::ACCEPT_ENCODING, "gzip");
    let response = next.run(request).await;
    let kind = response.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    if !is_read || !kind.starts_with("text/html") {
        return response;
    }
    let (mut head, body) = response.into_parts();
    let Ok(plain) = to_bytes(body, usize::MAX).await else {
        return (StatusCode::BAD_GATEWAY, "the page was cut on its way from another node\n").into_response();
    };
    if plain.is_empty() {
        return Response::from_parts(head, Body::empty());
    }
    // Writing to memory does not fail.
    let Ok(packed) = CompressedBody::new(&plain, Compression::default()) else {
        return Response::from_parts(head, Body::from(plain));
    };
    head.headers.remove(header::CONTENT_LENGTH);
    head.headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    head.headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    Response::from_parts(head, Body::from(packed.gzip))
}

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
        let mut headers = HeaderMap::new();
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(keep));
        headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
        if let Ok(tag) = HeaderValue::from_str(&self.tag) {
            headers.insert(header::ETAG, tag);
        }
        if names(request, header::IF_NONE_MATCH, &self.tag) {
            return Ok((StatusCode::NOT_MODIFIED, headers).into_response());
        }
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
        if names(request, header::ACCEPT_ENCODING, "gzip") {
            headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
            return Ok((headers, self.gzip.clone()).into_response());
        }
        let mut plain = Vec::new();
        GzDecoder::new(&*self.gzip).read_to_end(&mut plain)?;
        Ok((headers, plain).into_response())
    }
}
