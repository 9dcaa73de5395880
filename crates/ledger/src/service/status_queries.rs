//! What the status of the machines asks of the database.

/// Parts and copies that are read or wait, by machine.
pub(super) const COUNTS: &str = "SELECT p.machine, count(*) FILTER (WHERE p.state = 'claimed') AS claimed_parts, \
    count(*) FILTER (WHERE p.state = 'waiting') AS waiting_parts, \
    CAST(coalesce(sum(p.owed), 0) AS BIGINT) AS waiting_copies, \
    CAST(coalesce(sum(p.owed) FILTER (WHERE p.is_buildable), 0) AS BIGINT) AS collecting_copies, \
    CAST(coalesce(sum(p.owed) FILTER (WHERE p.is_asked), 0) AS BIGINT) AS asked_copies, \
    min(CASE p.state WHEN 'waiting' THEN p.claimed_at END) AS oldest_at, \
    min(coalesce(p.waits_since, p.claimed_at)) FILTER (WHERE p.is_buildable) AS waits_since, \
    max(CASE WHEN p.put_back_at > p.state_at THEN p.put_back_at ELSE p.state_at END) AS newest_at FROM (SELECT part.*, \
    CASE state WHEN 'waiting' THEN copies - cancelled_copies - (SELECT count(*) FROM placement l WHERE l.part_id = part.id) ELSE 0 END \
    AS owed, state = 'waiting' AND damaged_at IS NULL AND fetch_at IS NULL AND question = '' AND NOT awaits_material \
    AND replaced_by IS NULL AS is_buildable, state = 'waiting' AND NOT awaits_material AND (question <> '' OR damaged_at IS NOT NULL) \
    AS is_asked FROM part WHERE state IN ('claimed', 'waiting')) AS p GROUP BY p.machine";

/// Counts only refused parts of which copies are wanted, that can still be retried and were not cancelled; over the years, many parts
/// are refused.
pub(super) const REFUSED: &str = "SELECT p.machine, count(*) AS parts FROM part p WHERE p.state = 'refused' AND p.state_at >= $1 \
    AND p.copies > p.cancelled_copies \
    AND coalesce((SELECT e.cause FROM event e WHERE e.part_id = p.id AND e.kind = 'refused' ORDER BY e.id DESC LIMIT 1), '') \
    NOT IN ('cancelled', 'replaced') GROUP BY p.machine";

/// For each machine, the part that is due first.
pub(super) const DUE: &str = "SELECT machine, due_text, due_at FROM (\
    SELECT machine, due_text, due_at, ROW_NUMBER() OVER (PARTITION BY machine ORDER BY due_at, id) AS place \
    FROM part WHERE state = 'waiting' AND due_at IS NOT NULL) AS ranked WHERE place = 1";

/// The due dates of what can be built, each with its earliest arrival and the part or order of that.
pub(super) const DUE_ARRIVALS: &str = "SELECT machine, due_at, arrived_at, due_of FROM (\
    SELECT machine, due_at, arrived_at, due_of, \
    ROW_NUMBER() OVER (PARTITION BY machine, due_at ORDER BY arrived_at, id) AS place FROM (\
    SELECT id, machine, due_at, CASE WHEN put_back_at > state_at THEN put_back_at ELSE state_at END AS arrived_at, \
    CASE order_name WHEN '' THEN name ELSE 'order ' || order_name END AS due_of FROM part \
    WHERE state = 'waiting' AND due_at IS NOT NULL AND damaged_at IS NULL AND fetch_at IS NULL AND question = '' \
    AND NOT awaits_material AND replaced_by IS NULL) AS buildable) AS ranked WHERE place = 1 ORDER BY machine, due_at";

pub(super) const OPEN: &str = "SELECT b.machine, b.id AS build, b.height_mm, b.density, b.copies, n.state AS night, \
    n.cpu_secs AS night_cpu_secs, \
    CASE WHEN n.first_height_mm > b.height_mm THEN n.first_height_mm - b.height_mm \
    WHEN n.first_height_mm IS NOT NULL THEN 0.0 END AS night_gain_mm FROM build b LEFT JOIN night_search n ON n.build_id = b.id WHERE b.state = 'open'";

pub(super) const NESTING: &str = "SELECT machine, id AS build, state, coalesce(copies, 0) AS copies, fired_by, attempts, nesting_at \
    FROM build WHERE state IN ('nesting', 'verified') ORDER BY id";

/// The waiting parts whose material is not loaded, by machine and material.
pub(super) const AWAITED: &str = "SELECT p.machine, p.material, count(*) AS parts, CAST(sum(p.copies - p.cancelled_copies - \
    (SELECT count(*) FROM placement l WHERE l.part_id = p.id)) AS BIGINT) AS copies FROM part p \
    WHERE p.state = 'waiting' AND p.awaits_material GROUP BY p.machine, p.material ORDER BY p.machine, p.material";

/// What is loaded.
pub(super) const LOADED: &str = "SELECT machine, material, lot FROM loaded_material WHERE material <> ''";

/// Paused machines.
pub(super) const PAUSES: &str = "SELECT machine, paused_by, cause, paused_at FROM pause";
/// The newest published build of each machine. The query jumps in the index from one machine to the next, and there to
/// the newest row, so it does not read the other rows.
pub(super) const LAST: &str = "WITH RECURSIVE known (machine) AS (\
    SELECT min(machine) FROM build WHERE state NOT IN ('open', 'nesting') UNION ALL \
    SELECT (SELECT min(b.machine) FROM build b WHERE b.machine > known.machine \
    AND b.state NOT IN ('open', 'nesting')) FROM known \
    WHERE known.machine IS NOT NULL) \
    SELECT b.machine, b.id AS build, b.published_at, b.height_mm, b.density, b.copies, b.file_name FROM known \
    JOIN build b ON b.id = (SELECT n.id FROM build n WHERE n.machine = known.machine \
    AND n.state NOT IN ('open', 'nesting') AND n.published_at IS NOT NULL AND n.withdrawn_at IS NULL \
    ORDER BY coalesce(n.published_at, n.state_at) DESC, n.id DESC LIMIT 1)";
