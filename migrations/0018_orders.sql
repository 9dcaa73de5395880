-- Orders are what customers want. A line of an order is a part: a file by its content, the copies wanted, and everything asked with
-- them. A copy that is wanted is owed until it stands in a build whose print is not told to be bad.

-- How many of its copies are not wanted any more: cancelled, or told not to be printed again. Copies wanted = copies - this.
ALTER TABLE part ADD COLUMN cancelled_copies INTEGER NOT NULL DEFAULT 0 CHECK (cancelled_copies >= 0);
-- When copies of it that were printed badly were last put back among the waiting ones, UTC; NULL = never. They go first.
ALTER TABLE part ADD COLUMN put_back_at TEXT;
-- When its original was asked back from the archive, UTC; NULL = it is in the store. The part waits until it is there.
ALTER TABLE part ADD COLUMN fetch_at TEXT;
-- What a person must confirm before it is printed, '' = nothing.
ALTER TABLE part ADD COLUMN question TEXT NOT NULL DEFAULT '';
-- The newer revision that replaced it, NULL = none.
ALTER TABLE part ADD COLUMN replaced_by INTEGER REFERENCES part (id);
-- The due date as it was given, '' = none was given, or before this was kept: a day stays that day in every time zone.
ALTER TABLE part ADD COLUMN due_text TEXT NOT NULL DEFAULT '';
CREATE INDEX part_by_replacement ON part (replaced_by) WHERE replaced_by IS NOT NULL;
CREATE INDEX part_to_fetch ON part (id) WHERE fetch_at IS NOT NULL;
CREATE INDEX part_in_question ON part (id) WHERE question <> '';

-- A row is a copy that was printed badly, or is to be printed again for another reason: its placement counts no more, and the
-- key of `placement` lets the copy be taken into another build.
CREATE TABLE bad_placement (
    build_id INTEGER NOT NULL REFERENCES build (id),
    part_id  INTEGER NOT NULL REFERENCES part (id),
    copy     INTEGER NOT NULL CHECK (copy >= 0),    -- copy number, from 0
    qx REAL, qy REAL, qz REAL, qw REAL,             -- as in placement
    tx_mm REAL, ty_mm REAL, tz_mm REAL,
    drawn INTEGER, way_x REAL, way_y REAL, way_z REAL,
    told_by  TEXT    NOT NULL DEFAULT '',           -- user@host
    told_at  TEXT    NOT NULL,                      -- UTC
    is_owed  INTEGER NOT NULL,                      -- whether it was put back among the waiting copies
    PRIMARY KEY (build_id, part_id, copy)
) STRICT, WITHOUT ROWID;
CREATE INDEX bad_placement_by_part ON bad_placement (part_id);

-- Every copy that a build was made of, whether it counts or was told to be bad.
CREATE VIEW build_copy AS
SELECT build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, way_y, way_z, 0 AS is_bad FROM placement
UNION ALL
SELECT build_id, part_id, copy, qx, qy, qz, qw, tx_mm, ty_mm, tz_mm, drawn, way_x, way_y, way_z, 1 FROM bad_placement;

-- By how many the copies wanted of the part changed with this event; NULL = they did not, or it was before this was kept.
ALTER TABLE event ADD COLUMN wanted_change INTEGER;

-- A row is an order with a name. A part without an order is an order of its own and has no row.
CREATE TABLE customer_order (
    name      TEXT PRIMARY KEY NOT NULL,
    folded    TEXT NOT NULL,                        -- its name in lower case, to be searched without regard to case
    state     TEXT NOT NULL CHECK (state IN ('open', 'complete', 'short')),
    opened_at TEXT NOT NULL,                        -- UTC, when its first part came
    state_at  TEXT NOT NULL                         -- UTC
) STRICT, WITHOUT ROWID;
CREATE INDEX customer_order_open ON customer_order (opened_at) WHERE state = 'open';
INSERT INTO customer_order (name, folded, state, opened_at, state_at)
SELECT p.order_name, lower(p.order_name),
       CASE WHEN sum(p.state <> 'built') = 0 AND NOT EXISTS (
           SELECT 1 FROM part q CROSS JOIN placement l ON l.part_id = q.id CROSS JOIN build b ON b.id = l.build_id
           WHERE q.order_name = p.order_name AND q.order_name <> '' AND b.state <> 'complete') THEN 'complete' ELSE 'open' END,
       min(p.claimed_at), max(p.state_at)
FROM part p WHERE p.order_name <> '' GROUP BY p.order_name;

-- Of which build it is the same cake once more, NULL = it was searched for anew.
ALTER TABLE build ADD COLUMN repeats INTEGER REFERENCES build (id);
CREATE INDEX build_by_repeat ON build (repeats) WHERE repeats IS NOT NULL;
-- When a person said that a failed print was seen to, UTC; NULL = nobody did.
ALTER TABLE build ADD COLUMN seen_at TEXT;
-- Failed prints that nobody has seen to. Those from before this was kept count as seen to.
UPDATE build SET seen_at = state_at WHERE state = 'failed' AND published_at IS NOT NULL;
CREATE INDEX build_unseen ON build (id) WHERE state = 'failed' AND published_at IS NOT NULL AND seen_at IS NULL;
-- Whether it corrects what was told before.
ALTER TABLE outcome ADD COLUMN is_correction INTEGER NOT NULL DEFAULT 0;

-- More kinds of commands, with what they say as JSON.
CREATE TABLE new_command (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    kind        TEXT NOT NULL CHECK (kind IN ('flush', 'pause', 'resume', 'retry', 'cancel', 'scan', 'edit', 'move', 'confirm')),
    profile     TEXT NOT NULL DEFAULT '',
    part_id     INTEGER REFERENCES part (id),
    argument    TEXT NOT NULL DEFAULT '',           -- JSON: copies to cancel, changes of an edit; '' = none
    asked_by    TEXT NOT NULL DEFAULT '',           -- user@host
    asked_at    TEXT NOT NULL,                      -- UTC
    state       TEXT NOT NULL CHECK (state IN ('asked', 'done', 'refused')),
    answer      TEXT NOT NULL DEFAULT '',
    answered_at TEXT                                -- UTC
) STRICT;
INSERT INTO new_command (id, kind, profile, part_id, asked_by, asked_at, state, answer, answered_at)
SELECT id, kind, profile, part_id, asked_by, asked_at, state, answer, answered_at FROM command;
DROP TABLE command;
ALTER TABLE new_command RENAME TO command;
CREATE INDEX command_asked ON command (id) WHERE state = 'asked';
CREATE INDEX command_by_part ON command (part_id) WHERE part_id IS NOT NULL;

DROP VIEW v_part_history;
-- For operators with sqlite3: every part, how many of its copies are in a published build, and in which builds.
CREATE VIEW v_part_history AS
SELECT p.id AS part, p.profile, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT group_concat(DISTINCT l.build_id) FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.claimed_at, p.state_at, p.reason, p.warnings,
       p.copies - p.cancelled_copies AS copies_wanted,
       (SELECT count(*) FROM bad_placement l WHERE l.part_id = p.id) AS copies_bad
FROM part p ORDER BY p.id DESC;

-- For operators with sqlite3: each line of each order. wanted = waiting + in_builds + printed + good, or + refused.
-- CROSS JOIN: the few copies of the part are read first, never all builds of a state.
CREATE VIEW v_order_line AS
SELECT n.order_name, n.part, n.profile, n.name, n.object_name, n.wanted,
       CASE WHEN n.state = 'rejected' THEN 0 ELSE n.wanted - n.in_builds - n.printed - n.good END AS waiting,
       n.in_builds, n.printed, n.good, n.bad, n.cancelled,
       CASE WHEN n.state = 'rejected' THEN n.wanted - n.in_builds - n.printed - n.good ELSE 0 END AS refused, n.state, n.due_at
FROM (SELECT p.order_name, p.id AS part, p.profile, p.name, p.object_name, p.state, p.due_at,
             p.copies - p.cancelled_copies AS wanted, p.cancelled_copies AS cancelled,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NULL) AS in_builds,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.published_at IS NOT NULL AND b.state <> 'complete') AS printed,
             (SELECT count(*) FROM placement l CROSS JOIN build b ON b.id = l.build_id
              WHERE l.part_id = p.id AND b.state = 'complete') AS good,
             (SELECT count(*) FROM bad_placement l WHERE l.part_id = p.id) AS bad
      FROM part p) n;
