//! A file that needs more memory than there is: it is refused with its reason, and the other parts are printed.

use std::{fs, time::Instant};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, greedy};

/// Address space of the daemon, bytes.
const MEMORY: u64 = 400 << 20;

#[test]
fn a_file_whose_reading_ends_the_process_is_refused_and_the_others_are_printed() {
    let mut farm = TestFarm::new(QUICK);
    farm.start_with_memory(MEMORY);
    farm.drop_part("good.stl", &block(10.0, 12.0, 5.0));
    farm.drop_bytes("greedy.3mf", &greedy::equal_components(99_000, 200));
    let began = Instant::now();
    while farm.parts(PartState::Refused).is_empty() {
        assert!(began.elapsed().as_secs() < 400, "it is not refused\n{}", farm.log());
        farm.start_again_where_it_ended(MEMORY);
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let refused = farm.parts(PartState::Refused);
    assert_eq!((refused.len(), refused[0].name.as_str(), refused[0].file.reads), (1, "greedy.3mf", 3));
    for expected in ["ended nestd twice", "limits.read_memory_bytes", "drop it again"] {
        assert!(refused[0].refused.reason.contains(expected), "{}", refused[0].refused.reason);
    }
    farm.wait_for_parts(PartState::Waiting, 1);
    let reason = farm.folder("error").join("greedy.3mf.reason.txt");
    crate::support::wait_until("the reason lies beside it", 10.0, || reason.exists());
    assert!(fs::read_to_string(reason).unwrap().contains("limits.read_memory_bytes"));
    farm.flush();
    farm.wait_for_queued(1);
    // After a retry the file is read in a separate process at once: the daemon does not end any more.
    let pid = farm.pid();
    farm.nestd_ok(&["retry", &refused[0].id.to_string()]);
    crate::support::wait_until_or(
        "it is refused again",
        60.0,
        || farm.log(),
        || farm.parts(PartState::Refused).iter().any(|part| part.file.reads == 4),
    );
    assert!(!farm.has_ended() && farm.pid() == pid);
}
