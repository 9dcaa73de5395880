//! Tests that only run where something is: a folder of parts, a browser, a server. Where it is not they are reported as ignored,
//! with the reason; the attribute that ignores a test cannot say so, for it is decided when nestd is built.

use libtest_mimic::{Completion, Trial};

/// A test; `missing` says why it cannot run here.
pub fn trial(name: &str, missing: Option<String>, test: impl FnOnce() + Send + 'static) -> Trial {
    Trial::ignorable_test(name, move || {
        let Some(why) = missing else {
            test();
            return Ok(Completion::Completed);
        };
        Ok(Completion::ignored_with(why))
    })
}

/// Why a test cannot run that needs these variables of the environment.
pub fn unset(needed: &[&str]) -> Option<String> {
    let unset: Vec<&str> = needed.iter().copied().filter(|name| std::env::var_os(name).is_none()).collect();
    (!unset.is_empty()).then(|| format!("needs {}", unset.join(" and ")))
}
