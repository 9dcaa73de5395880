-- The ledger of a farm. Times are UTC, RFC 3339 with milliseconds ('2026-11-20T04:49:00.000Z'), so that they sort as text.
-- Lengths are mm. Nothing is ever deleted because it succeeded.

-- A row is a part: one solid of one dropped file, for one machine profile, with its copies.
CREATE TABLE part (
    id            INTEGER PRIMARY KEY AUTOINCREMENT,
    claim         TEXT    NOT NULL,                 -- name of the claim: unique per dropped file
    object_index  INTEGER NOT NULL DEFAULT 0,       -- which solid of the file, from 0
    profile       TEXT    NOT NULL,                 -- machine profile
    name          TEXT    NOT NULL,                 -- file name as dropped, escaped for display
    object_name   TEXT    NOT NULL DEFAULT '',      -- name of the solid inside a 3MF
    order_name    TEXT    NOT NULL DEFAULT '',      -- order or kit, '' = none
    content_hash  TEXT    NOT NULL,                 -- BLAKE3 of the file, 64 hex digits
    bytes         INTEGER NOT NULL,                 -- size of the file
    state         TEXT    NOT NULL CHECK (state IN ('claimed', 'waiting', 'batched', 'built', 'rejected')),
    reason        TEXT    NOT NULL DEFAULT '',      -- why it was rejected
    warnings      TEXT    NOT NULL DEFAULT '',      -- one per line
    copies        INTEGER NOT NULL DEFAULT 1 CHECK (copies >= 1),
    priority      INTEGER NOT NULL DEFAULT 50 CHECK (priority BETWEEN 0 AND 100),
    due_at        TEXT,                             -- UTC, NULL = none
    orientation   TEXT    NOT NULL DEFAULT 'free' CHECK (orientation IN ('free', 'upright', 'axis', 'fixed')),
    clearance_mm  REAL,                             -- its own clearance, NULL = the profile's
    unit          TEXT,                             -- unit said by the ticket, NULL = by the file or the profile
    note          TEXT    NOT NULL DEFAULT '',
    triangles     INTEGER,                          -- NULL until read
    volume_mm3    REAL,                             -- NULL until read
    size_x_mm     REAL,                             -- bounds as dropped, NULL until read
    size_y_mm     REAL,
    size_z_mm     REAL,
    claimed_at    TEXT    NOT NULL,                 -- UTC
    state_at      TEXT    NOT NULL,                 -- UTC, when the state was entered
    UNIQUE (claim, object_index)
) STRICT;
CREATE INDEX part_by_state ON part (state, profile);
CREATE INDEX part_by_hash ON part (content_hash);
CREATE INDEX part_by_order ON part (order_name) WHERE order_name <> '';

-- A row is a ticket as it was received for a part.
CREATE TABLE ticket (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    part_id     INTEGER NOT NULL REFERENCES part (id),
    source      TEXT    NOT NULL CHECK (source IN ('name', 'sidecar', 'order_list')),
    file_name   TEXT    NOT NULL,                   -- where it stood
    text        TEXT    NOT NULL,                   -- as received
    received_at TEXT    NOT NULL                    -- UTC
) STRICT;
CREATE INDEX ticket_by_part ON ticket (part_id);

-- A row is a build: the parts of a profile taken together, one build file, one height.
CREATE TABLE build (
    id                  INTEGER PRIMARY KEY AUTOINCREMENT,
    profile             TEXT    NOT NULL,
    state               TEXT    NOT NULL CHECK (state IN ('open', 'nesting', 'verified', 'published', 'printing',
                                                          'complete', 'interrupted', 'failed')),
    reason              TEXT    NOT NULL DEFAULT '',    -- why it failed, or the outcome's note
    fired_by            TEXT    NOT NULL DEFAULT '',    -- trigger: full, fill, copies, max_wait, due, at, flush
    attempts            INTEGER NOT NULL DEFAULT 0,     -- how often nesting was begun
    opened_at           TEXT    NOT NULL,               -- UTC
    nesting_at          TEXT,                           -- UTC
    verified_at         TEXT,                           -- UTC
    published_at        TEXT,                           -- UTC
    state_at            TEXT    NOT NULL,               -- UTC
    layout              TEXT,                           -- JSON, the best layout so far while open or nesting
    file_name           TEXT,                           -- name of the build file in the queue folder
    queue_id            TEXT,                           -- which queue folder it was staged in (its marker)
    file_hash           TEXT,                           -- BLAKE3 of the build file, 64 hex digits
    file_bytes          INTEGER,                        -- size of the build file
    height_mm           REAL,                           -- build height: top of the highest placement
    density             REAL,                           -- part volume / (base area x height), 0..1
    lower_bound_mm      REAL,                           -- no build of these parts can be lower
    layers              INTEGER,                        -- layers to print
    part_volume_mm3     REAL,
    copies              INTEGER,                        -- placements
    clearance_mm        REAL,                           -- asked
    clearance_proved_mm REAL,                           -- least distance found on the triangles of the written file
    cpu_secs            REAL,                           -- CPU seconds of all nesting for it
    wall_secs           REAL,                           -- wall seconds of the final nesting
    evaluations         INTEGER,
    seed                INTEGER,
    method              TEXT,                           -- nestd, paper
    version             TEXT,                           -- of nestd
    profile_snapshot    TEXT                            -- JSON, the profile as it was
) STRICT;
CREATE INDEX build_by_state ON build (state, profile);
CREATE UNIQUE INDEX one_open_build ON build (profile) WHERE state = 'open';

-- A row is a copy of a part that is taken into a build. The key says: a copy is in one build only.
CREATE TABLE placement (
    part_id  INTEGER NOT NULL REFERENCES part (id),
    copy     INTEGER NOT NULL CHECK (copy >= 0),    -- copy number, from 0
    build_id INTEGER NOT NULL REFERENCES build (id),
    qx REAL, qy REAL, qz REAL, qw REAL,             -- rotation, unit quaternion; NULL until verified
    tx_mm REAL, ty_mm REAL, tz_mm REAL,             -- translation after the rotation, machine frame
    PRIMARY KEY (part_id, copy)
) STRICT, WITHOUT ROWID;
CREATE INDEX placement_by_build ON placement (build_id);

-- A row is something that happened.
CREATE TABLE event (
    id       INTEGER PRIMARY KEY AUTOINCREMENT,
    at       TEXT    NOT NULL,                      -- UTC
    kind     TEXT    NOT NULL,                      -- claimed, waiting, rejected, published, ...
    profile  TEXT    NOT NULL DEFAULT '',
    part_id  INTEGER REFERENCES part (id),
    build_id INTEGER REFERENCES build (id),
    detail   TEXT    NOT NULL DEFAULT ''
) STRICT;
CREATE INDEX event_by_part ON event (part_id) WHERE part_id IS NOT NULL;
CREATE INDEX event_by_build ON event (build_id) WHERE build_id IS NOT NULL;

-- A row is what somebody told of a published build.
CREATE TABLE outcome (
    id       INTEGER PRIMARY KEY AUTOINCREMENT,
    build_id INTEGER NOT NULL REFERENCES build (id),
    outcome  TEXT    NOT NULL CHECK (outcome IN ('printing', 'complete', 'interrupted', 'failed')),
    note     TEXT    NOT NULL DEFAULT '',
    told_by  TEXT    NOT NULL DEFAULT '',           -- user@host
    told_at  TEXT    NOT NULL                       -- UTC
) STRICT;
CREATE INDEX outcome_by_build ON outcome (build_id);

-- A row is an order by hand to the daemon; the daemon answers in the row.
CREATE TABLE command (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    kind        TEXT NOT NULL CHECK (kind IN ('flush', 'pause', 'resume', 'retry', 'cancel', 'scan')),
    profile     TEXT NOT NULL DEFAULT '',
    part_id     INTEGER REFERENCES part (id),
    asked_by    TEXT NOT NULL DEFAULT '',           -- user@host
    asked_at    TEXT NOT NULL,                      -- UTC
    state       TEXT NOT NULL CHECK (state IN ('asked', 'done', 'refused')),
    answer      TEXT NOT NULL DEFAULT '',
    answered_at TEXT                                -- UTC
) STRICT;
CREATE INDEX command_asked ON command (id) WHERE state = 'asked';

-- A row is a profile that somebody has paused; no row = it runs.
CREATE TABLE pause (
    profile   TEXT PRIMARY KEY NOT NULL,
    paused_by TEXT NOT NULL DEFAULT '',
    paused_at TEXT NOT NULL                         -- UTC
) STRICT, WITHOUT ROWID;

-- The one row is the daemon that serves this ledger; an old beat means that it does not run.
CREATE TABLE daemon (
    id         INTEGER PRIMARY KEY CHECK (id = 1),
    pid        INTEGER NOT NULL,
    host       TEXT    NOT NULL,
    version    TEXT    NOT NULL,
    started_at TEXT    NOT NULL,                    -- UTC
    beat_at    TEXT    NOT NULL,                    -- UTC
    status     TEXT    NOT NULL DEFAULT ''          -- one line
) STRICT;

-- For operators with sqlite3: every build with its height, newest first.
CREATE VIEW v_build_history AS
SELECT b.id AS build, b.profile, b.state, b.published_at, round(b.height_mm, 2) AS height_mm,
       round(b.density, 4) AS density, round(b.lower_bound_mm, 2) AS lower_bound_mm, b.layers, b.copies,
       round(b.part_volume_mm3 / 1000.0, 2) AS part_volume_cm3, round(b.clearance_proved_mm, 3) AS clearance_proved_mm,
       round(b.cpu_secs, 1) AS cpu_secs, b.fired_by, b.file_name, b.reason
FROM build b WHERE b.state <> 'open' ORDER BY b.id DESC;

-- For operators with sqlite3: every part, how many of its copies are in a published build, and in which builds.
CREATE VIEW v_part_history AS
SELECT p.id AS part, p.profile, p.order_name, p.name, p.object_name, p.state, p.copies,
       (SELECT count(*) FROM placement l JOIN build b ON b.id = l.build_id
        WHERE l.part_id = p.id AND b.published_at IS NOT NULL) AS copies_built,
       (SELECT group_concat(DISTINCT l.build_id) FROM placement l WHERE l.part_id = p.id) AS builds,
       p.priority, p.due_at, p.claimed_at, p.state_at, p.reason, p.warnings
FROM part p ORDER BY p.id DESC;

-- For operators with sqlite3: builds and heights per machine and day (UTC).
CREATE VIEW v_height_by_day AS
SELECT substr(b.published_at, 1, 10) AS day, b.profile, count(*) AS builds, sum(b.copies) AS copies,
       round(sum(b.height_mm), 2) AS height_mm, round(avg(b.density), 4) AS mean_density
FROM build b WHERE b.published_at IS NOT NULL GROUP BY day, b.profile ORDER BY day DESC, b.profile;
