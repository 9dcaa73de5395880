//! The language that is current: of a request, or while a file is written.

use std::future::Future;

use crate::Language;

tokio::task_local! {
    static CURRENT: Language;
}

/// The language that is current; English outside of any scope.
pub fn current() -> Language {
    CURRENT.try_with(|language| *language).unwrap_or_default()
}

impl Language {
    /// Runs a future in this language.
    pub fn scope<F: Future>(self, work: F) -> impl Future<Output = F::Output> {
        CURRENT.scope(self, work)
    }

    /// Runs a function in this language.
    pub fn within<R>(self, work: impl FnOnce() -> R) -> R {
        CURRENT.sync_scope(self, work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scope_ends_with_its_work_and_scopes_stand_in_each_other() {
        assert_eq!(current(), Language::English);
        let inner = Language::German.within(|| (current(), Language::French.within(current), current()));
        assert_eq!(inner, (Language::German, Language::French, Language::German));
        assert_eq!(current(), Language::English);
    }
}
