-- An open build that waits is lowered further in rounds. A row is how far that has come for what waits; it goes when the build fires.
CREATE TABLE night_search (
    build_id        INTEGER PRIMARY KEY NOT NULL REFERENCES build (id),
    problem         TEXT    NOT NULL,                -- BLAKE3 of the copies and rules that it is for: others begin anew
    state           TEXT    NOT NULL CHECK (state IN ('goes-on', 'stands-still', 'used-up', 'given-up')),
    round           INTEGER NOT NULL,                -- from 0; each round has twice the CPU time of the one before
    round_cpu_secs  REAL    NOT NULL,                -- CPU seconds that this round has taken so far
    round_height_mm REAL    NOT NULL,                -- height of the layout at the begin of the round, mm
    cpu_secs        REAL    NOT NULL,                -- CPU seconds of all rounds since the last arrival
    first_height_mm REAL    NOT NULL,                -- height of the layout after the search for the last arrival, mm
    starts          INTEGER NOT NULL,                -- searches that were started since the last one that ended
    pool            TEXT    NOT NULL                 -- JSON: layouts to go on from, the lowest first
) STRICT;
