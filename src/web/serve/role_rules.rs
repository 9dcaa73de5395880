//! Which role a request needs.

use access::Role;
use axum::http::Method;

use super::page_routes;
use crate::web::doors::api_routes;

/// The least role that may send a request; `None` = whoever can connect. What is not known to need less needs the most that a program
/// may have: it is answered that it is not there.
pub(super) fn needed_role(method: &Method, path: &str) -> Option<Role> {
    if *method == Method::OPTIONS {
        return Some(Role::Read);
    }
    let of_page = page_routes::find_page(method, path).map(|route| route.role);
    let of_program = || api_routes::find_route(method, path).map(|route| Some(route.role));
    let otherwise = if method.is_safe() { Role::Read } else { Role::Operate };
    of_page.or_else(of_program).unwrap_or(Some(otherwise))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looking_needs_the_least_ordering_more_and_whatever_is_not_known_the_most() {
        use Role::{Admin, Operate, Order, Read};
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
            (Method::GET, "/people", Admin),
            (Method::HEAD, "/people", Admin),
            (Method::POST, "/people", Admin),
            (Method::POST, "/you", Read),
        ] {
            assert_eq!(needed_role(&method, path), Some(role), "{method} {path}");
        }
        for (method, path) in [(Method::GET, "/sign-in"), (Method::POST, "/sign-in/pin"), (Method::POST, "/sign-out")] {
            assert_eq!(needed_role(&method, path), None, "{path}");
        }
    }
}
