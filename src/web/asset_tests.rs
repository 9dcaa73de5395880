//! How scripts, styles and scenes are sent: compressed where the browser can read that, and once.

use std::io::Read;

use axum::{
    body::{Body, Bytes, to_bytes},
    http::{HeaderMap, Request, StatusCode, header},
};
use flate2::read::GzDecoder;
use tower::ServiceExt;

use super::{TestDashboard, build_router, with_a_build};

struct Answer {
    status: StatusCode,
    headers: HeaderMap,
    body: Bytes,
}

async fn get(dashboard: &TestDashboard, path: &str, headers: &[(header::HeaderName, &str)]) -> Answer {
    let mut request = Request::get(path).header("host", "localhost:7878");
    for (name, value) in headers {
        request = request.header(name, *value);
    }
    let response = build_router(dashboard.web.clone()).oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
    let (parts, body) = response.into_parts();
    Answer { status: parts.status, headers: parts.headers, body: to_bytes(body, usize::MAX).await.unwrap() }
}

#[tokio::test]
async fn a_page_names_its_scripts_by_their_content_and_browsers_keep_them_for_good() {
    let dashboard = with_a_build("bracket.stl").await;
    let page = dashboard.get("/builds/1").await.text;
    for name in ["style.css", "live.js", "view.js", "icon.svg", "inter.woff2"] {
        let address = page.split('"').find(|text| text.starts_with(&format!("/assets/{name}?v="))).unwrap();
        let kept = get(&dashboard, address, &[]).await;
        assert!(kept.headers[header::CACHE_CONTROL].to_str().unwrap().contains("immutable"), "{address}");
        let other = get(&dashboard, &format!("/assets/{name}?v=0"), &[]).await;
        assert_eq!(other.headers[header::CACHE_CONTROL], "private, no-cache", "an address of another version");
    }
}

#[tokio::test]
async fn pages_are_sent_compressed_and_the_farm_page_is_small() {
    let dashboard = with_a_build("bracket.stl").await;
    for path in ["/", "/builds/1/pick", "/history", "/parts/7"] {
        let plain = get(&dashboard, path, &[]).await;
        let packed = get(&dashboard, path, &[(header::ACCEPT_ENCODING, "gzip, br")]).await;
        assert!(!plain.headers.contains_key(header::CONTENT_ENCODING), "{path}");
        assert_eq!(
            (packed.status, packed.headers[header::CONTENT_ENCODING].to_str().unwrap()),
            (plain.status, "gzip"),
            "{path}"
        );
        let mut unpacked = String::new();
        GzDecoder::new(&*packed.body).read_to_string(&mut unpacked).unwrap();
        assert!(unpacked.contains("</html>") && packed.body.len() < 40_000.min(unpacked.len()), "{path}");
    }
    let json = get(&dashboard, "/api/v1/farm", &[(header::ACCEPT_ENCODING, "gzip")]).await;
    assert!(!json.headers.contains_key(header::CONTENT_ENCODING), "programs that read it must not have to unpack it");
}

#[tokio::test]
async fn what_is_large_is_sent_compressed_and_not_again() {
    let dashboard = with_a_build("bracket.stl").await;
    for (path, least) in [("/assets/view.js", 3), ("/builds/1/scene", 1)] {
        let plain = get(&dashboard, path, &[]).await;
        let packed = get(&dashboard, path, &[(header::ACCEPT_ENCODING, "br, gzip;q=0.8")]).await;
        assert!(!plain.headers.contains_key(header::CONTENT_ENCODING), "{path}");
        assert_eq!(packed.headers[header::CONTENT_ENCODING], "gzip", "{path}");
        let mut unpacked = Vec::new();
        GzDecoder::new(&*packed.body).read_to_end(&mut unpacked).unwrap();
        assert!(unpacked == plain.body && packed.body.len() * least <= plain.body.len() + 100, "{path}");
        let tag = packed.headers[header::ETAG].to_str().unwrap().to_owned();
        let again = get(&dashboard, path, &[(header::IF_NONE_MATCH, &tag)]).await;
        assert_eq!((again.status, again.body.len()), (StatusCode::NOT_MODIFIED, 0), "{path}");
        let changed = get(&dashboard, path, &[(header::IF_NONE_MATCH, "\"0\"")]).await;
        assert_eq!(changed.status, StatusCode::OK, "{path}");
    }
}
