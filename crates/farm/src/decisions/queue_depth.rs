//! Whether another build may be made for the printers of a machine. This is a function of facts.

use language::say;
use ledger::{BuildsAhead, MachineStatus};
use settings::MachineProfile;

/// Whether one of the printers has fewer builds ahead than may lie in its queue: in the queue folder, or made for it. A build whose
/// printer is not decided takes one place.
pub fn has_queue_room(depth: u32, printers: &[&str], ahead: &[BuildsAhead]) -> bool {
    let room = printers.iter().map(|printer| queue_room(depth, printer, ahead));
    let undecided = ahead.iter().find(|ahead| ahead.printer.is_empty());
    depth == 0 || room.sum::<u32>() > undecided.map_or(0, |undecided| undecided.builds)
}

/// How many builds more may lie in the queue of a printer.
pub fn queue_room(depth: u32, printer: &str, ahead: &[BuildsAhead]) -> u32 {
    match ahead.iter().find(|ahead| ahead.printer == printer) {
        Some(ahead) if ahead.is_down => 0,
        ahead => depth.saturating_sub(ahead.map_or(0, |ahead| ahead.builds)),
    }
}

/// As [`has_queue_room`], for all printers of a machine.
pub fn has_machine_room(profile: &MachineProfile, ahead: &[BuildsAhead]) -> bool {
    let printers: Vec<&str> = profile.printers.iter().map(|printer| printer.name.as_str()).collect();
    has_queue_room(profile.printing.queue_depth, &printers, ahead)
}

/// Whether nothing fires on a machine, however much waits: a person paused it, or took all its printers out of use.
pub fn is_hindered(profile: &MachineProfile, row: &MachineStatus) -> bool {
    let is_down = |printer: &str| row.ahead.iter().any(|ahead| ahead.printer == printer && ahead.is_down);
    row.paused.is_some() || profile.printers.iter().all(|printer| is_down(&printer.name))
}

/// That the open build of a machine waits for room in the queue; `None` = it does not.
pub fn held_text(profile: &MachineProfile, row: &MachineStatus) -> Option<String> {
    let is_held = row.waiting_parts > 0 && !is_hindered(profile, row) && !has_machine_room(profile, &row.ahead);
    is_held.then(|| say!("held-queue-full", depth = profile.printing.queue_depth))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_while_a_printer_in_use_has_less_ahead_than_its_queue_may_hold() {
        let both = ["left", "right"];
        let ahead =
            |printer: &str, builds: u32, is_down: bool| BuildsAhead { printer: printer.to_owned(), builds, is_down };
        let full = [ahead("left", 2, false), ahead("right", 2, false)];
        assert!(has_queue_room(0, &both, &full), "any number");
        assert!(!has_queue_room(2, &both, &full));
        assert!(has_queue_room(2, &both, &[]));
        assert!(has_queue_room(2, &both, &full[..1]), "the right one is empty");
        assert!(!has_queue_room(2, &["left"], &full[..1]), "the folder of the right one is away");
        assert!(
            !has_queue_room(2, &both, &[ahead("left", 2, false), ahead("right", 0, true)]),
            "the right one is down"
        );
        let one = [ahead("left", 2, false), ahead("right", 1, false)];
        assert!(has_queue_room(2, &both, &one));
        assert!(!has_queue_room(2, &both, &[&one[..], &[ahead("", 1, false)]].concat()), "one is made");
        assert!(
            !has_queue_room(2, &both, &[ahead("left", 5, false), ahead("right", 2, false)]),
            "a flush put more into it"
        );
    }
}
