//! Whether another build may be made for the printers of a machine. This is a function of facts.

use crate::{
    ledger::{BuildsAhead, ProfileStatus},
    settings::MachineProfile,
};

/// Whether a printer that is in use has fewer builds ahead than may lie in its queue: in the queue folder, or made for it. A build
/// whose printer is not decided takes one place.
pub fn has_queue_room(profile: &MachineProfile, ahead: &[BuildsAhead]) -> bool {
    let depth = profile.printing.queue_depth;
    let of = |printer: &str| ahead.iter().find(|ahead| ahead.printer == printer);
    let room = profile.printers.iter().map(|printer| match of(&printer.name) {
        Some(ahead) if ahead.is_down => 0,
        ahead => depth.saturating_sub(ahead.map_or(0, |ahead| ahead.builds)),
    });
    depth == 0 || room.sum::<u32>() > of("").map_or(0, |undecided| undecided.builds)
}

/// That the open build of a machine waits for room in the queue; `None` = it does not.
pub fn held_text(profile: &MachineProfile, row: &ProfileStatus) -> Option<String> {
    let is_held = row.waiting_parts > 0 && row.paused.is_none() && !has_queue_room(profile, &row.ahead);
    is_held.then(|| {
        let depth = profile.printing.queue_depth;
        format!("the queue is full (queue_depth = {depth}): it fires when a printer takes a file, or on a flush")
    })
}

#[cfg(test)]
mod tests {
    use super::{super::trigger::tests::machine_with_triggers, *};

    #[test]
    fn there_is_room_while_a_printer_in_use_has_less_ahead_than_its_queue_may_hold() {
        let printers = "[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\n";
        let mut profile = machine_with_triggers(printers);
        let ahead =
            |printer: &str, builds: u32, is_down: bool| BuildsAhead { printer: printer.to_owned(), builds, is_down };
        let full = [ahead("left", 2, false), ahead("right", 2, false)];
        assert!(has_queue_room(&profile, &full), "any number");
        profile.printing.queue_depth = 2;
        assert!(!has_queue_room(&profile, &full));
        assert!(has_queue_room(&profile, &[]));
        assert!(has_queue_room(&profile, &full[..1]), "the right one is empty");
        assert!(
            !has_queue_room(&profile, &[ahead("left", 2, false), ahead("right", 0, true)]),
            "the right one is down"
        );
        let one = [ahead("left", 2, false), ahead("right", 1, false)];
        assert!(has_queue_room(&profile, &one));
        assert!(!has_queue_room(&profile, &[&one[..], &[ahead("", 1, false)]].concat()), "one is made");
        assert!(
            !has_queue_room(&profile, &[ahead("left", 5, false), ahead("right", 2, false)]),
            "a flush put more into it"
        );
    }
}
