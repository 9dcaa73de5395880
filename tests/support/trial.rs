//! Tests that need something on the machine: a folder of parts, a browser, a server. Without it they are reported as
//! ignored, with the reason. An attribute of the test cannot do this, because it is decided at compile time.

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

/// The reason why a test that needs these environment variables cannot run, if one is not set.
pub fn missing_variables(needed: &[&str]) -> Option<String> {
    let unset: Vec<&str> = needed.iter().copied().filter(|name| std::env::var_os(name).is_none()).collect();
    (!unset.is_empty()).then(|| format!("needs {}", unset.join(" and ")))
}
