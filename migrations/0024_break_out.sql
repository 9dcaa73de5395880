-- Breaking a build out: a row is what somebody said of a copy that stands in the cake. The last row of a copy counts; rows are only added.
CREATE TABLE pick_mark (
    id       INTEGER PRIMARY KEY AUTOINCREMENT,
    build_id INTEGER NOT NULL REFERENCES build (id),
    part_id  INTEGER NOT NULL REFERENCES part (id),
    copy     INTEGER NOT NULL CHECK (copy >= 0),    -- copy number, from 0
    mark     TEXT    NOT NULL CHECK (mark IN ('out', 'bad', 'missing', 'open')), -- open = what was said before is taken back
    told_by  TEXT    NOT NULL DEFAULT '',           -- user@host
    told_at  TEXT    NOT NULL                       -- UTC
) STRICT;
CREATE INDEX pick_mark_by_build ON pick_mark (build_id);
