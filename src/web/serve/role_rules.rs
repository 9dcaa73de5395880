//! Which role a request needs.

use access::Role;
use axum::http::Method;

use crate::web::doors::api_routes;

/// The least role that may send a request. What is not known to need less needs the most.
pub(super) fn needed_role(method: &Method, path: &str) -> Role {
    if matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS) || path == "/name" {
        return Role::Read;
    }
    let steps: Vec<&str> = path.split('/').skip(1).collect();
    match steps[..] {
        ["api", ..] => api_routes::find_route(method, path).map_or(Role::Operate, |route| route.role),
        ["machines", _, "files"] | ["parts", _, "edit"] | ["orders", _, "cancel" | "edit" | "move"] => Role::Order,
        _ => Role::Operate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looking_needs_the_least_ordering_more_and_whatever_is_not_known_the_most() {
        use Role::{Operate, Order, Read};
        for (method, path, role) in [
            (Method::GET, "/", Read),
            (Method::GET, "/api/v1/orders/K", Read),
            (Method::HEAD, "/orders", Read),
            (Method::POST, "/name", Read),
            (Method::POST, "/api/v1/orders", Order),
            (Method::POST, "/api/v1/orders/K-1/lines", Order),
            (Method::DELETE, "/api/v1/orders/K/lines/7", Order),
            (Method::PUT, "/api/v1/content/00", Order),
            (Method::PATCH, "/api/v1/uploads/00", Order),
            (Method::OPTIONS, "/api/v1/uploads", Read),
            (Method::POST, "/machines/p396/files", Order),
            (Method::POST, "/machines/p396/printer", Operate),
            (Method::POST, "/orders/K/move", Order),
            (Method::POST, "/api/v1/builds/4/outcome", Operate),
            (Method::POST, "/api/v1/machines/p396/flush", Operate),
            (Method::DELETE, "/api/v1/orders", Operate),
            (Method::POST, "/api/v1/other", Operate),
            (Method::POST, "/orders/K/reprint", Operate),
            (Method::POST, "/orders/K/close", Operate),
            (Method::POST, "/api/v1/orders/K/close", Operate),
            (Method::POST, "/builds/4/told", Operate),
            (Method::POST, "/commands", Operate),
            (Method::POST, "//name", Operate),
        ] {
            assert_eq!(needed_role(&method, path), role, "{method} {path}");
        }
    }
}
