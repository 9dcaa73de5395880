//! What forms say of published builds: judged and carried out as `farm::operate` does, also for the command line and programs. Where the
//! file of a build lies in its queue, the answer has the button that says it anyway.

use language::say;
use ledger::{InQueueError, LedgerError, OperatorWord};

use crate::web::{
    base::error::HandlerResult,
    core::{command::answer_form, form_answer::FormAnswer, state::DashboardState},
};

/// Says a word of a form. `anyway` = the button was pressed that says it anyway.
pub(crate) async fn say_word(
    web: &DashboardState,
    word: &OperatorWord,
    by: &str,
    anyway: bool,
    back: &str,
) -> HandlerResult<FormAnswer> {
    match farm::operate(&web.ledger, &web.current_settings(), word, by, anyway).await {
        Err(LedgerError::InQueue(lies @ InQueueError::LiesThere { .. })) => {
            let refused = FormAnswer::refused(vec![format!("{lies}.")], back);
            Ok(refused.or_anyway(&say!("anyway")))
        }
        answer => answer_form(answer.map(|answer| answer.sentences), back),
    }
}
