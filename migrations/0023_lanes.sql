-- A final search may be cut into lanes, which several nodes search. What a node offers:
ALTER TABLE node ADD COLUMN lanes INTEGER NOT NULL DEFAULT 0;  -- lanes that it offers now

-- A row is a final search in lanes; it goes when its build leaves the state 'nesting'.
CREATE TABLE lane_search (
    id       INTEGER PRIMARY KEY NOT NULL,          -- a random number: no search is taken for another one
    build_id INTEGER NOT NULL UNIQUE REFERENCES build (id),
    problem  TEXT    NOT NULL,                      -- JSON: the instance, its meshes by BLAKE3, and the settings of the search
    plan     TEXT    NOT NULL                       -- JSON: number of lanes and rounds, evaluations, seed
) STRICT;

-- A row is one round of one lane.
CREATE TABLE lane (
    search_id INTEGER NOT NULL REFERENCES lane_search (id) ON DELETE CASCADE,
    round     INTEGER NOT NULL,                     -- from 0
    lane      INTEGER NOT NULL,                     -- from 0
    task      TEXT    NOT NULL,                     -- JSON: layout to start from, seed, evaluations
    epoch     INTEGER NOT NULL DEFAULT 0,           -- how often it was taken: what an earlier taker found is not accepted
    node      TEXT    NOT NULL DEFAULT '',          -- the node that has it, '' = none
    result    TEXT,                                 -- JSON: the layout that was found, NULL = none yet
    PRIMARY KEY (search_id, round, lane)
) STRICT;
