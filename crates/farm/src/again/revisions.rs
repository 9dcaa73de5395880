//! Earlier revisions of a part that a newer one replaced: they are taken out, with a copy in the error folder.

use anyhow::Result;
use ledger::{PartState, RefusalCause};

use super::part_changes;
use crate::{
    core::desks::Receiving,
    receive::{claim_completion, deferred_refusal},
};

/// Takes out the parts that a newer revision replaced.
pub(crate) async fn take_out_replaced(desk: &mut Receiving<'_>) -> Result<()> {
    for part in desk.shared.ledger.replaced_parts().await? {
        if claim_completion::is_completing(desk.completion, desk.jobs, &part)
            || part_changes::is_read_again(desk, &part)
            || part.owed.is_being_fetched()
        {
            continue;
        }
        let new = part.owed.replaced_by.map_or_else(String::new, |new| format!(", part {new},"));
        let order = match part.terms.order_name.as_str() {
            "" => String::new(),
            order => format!(" for order {order}"),
        };
        let reason = format!(
            "A newer revision{new} of the same name came{order} while this one waited, and took its place. Where both are \
             wanted, take this one back."
        );
        match part.state {
            PartState::Waiting => {
                deferred_refusal::start_refusal(desk, part, RefusalCause::Replaced, &reason, None);
            }
            _ => claim_completion::refuse_part(desk, &part, RefusalCause::Replaced, &reason).await?,
        }
    }
    Ok(())
}
